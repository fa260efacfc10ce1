//! Particles as the shaders want them, for backends whose particles do not live on the GPU.

use bevy::math::Vec3;
use freshet_core::field::{Field, FieldData};
use freshet_core::solver::FluidSolver;
use freshet_gpu::layout::ParticleRecord;

/// What is drawn of one tick, in the layout of the GPU solver's buffers.
#[derive(Debug, Default)]
pub struct ParticleFrame {
    /// Distinguishes this frame from all others of its domain.
    pub version: u64,
    /// Where and who they are, and how they move.
    pub particles: Vec<ParticleRecord>,
    /// Density, kg/m3, and pressure over its square.
    pub densities: Vec<[f32; 2]>,
    /// Acceleration, m/s2, and zero.
    pub accelerations: Vec<[f32; 4]>,
}

impl ParticleFrame {
    /// Reads what is drawn from a solver. A field that is not there yet (no step made) is zero.
    pub(crate) fn read(solver: &mut impl FluidSolver, version: u64) -> Self {
        let mut vectors = |field| solver.read(field).ok().and_then(FieldData::vectors).unwrap_or_default();
        let (positions, velocities) = (vectors(Field::Position), vectors(Field::Velocity));
        let accelerations = vectors(Field::Acceleration);
        let mut scalars = |field| solver.read(field).ok().and_then(FieldData::scalars).unwrap_or_default();
        let (densities, pressures) = (scalars(Field::Density), scalars(Field::Pressure));
        let lives = scalars(Field::RemainingLife);
        let ids = solver.read(Field::Id).ok().and_then(FieldData::integers).unwrap_or_default();
        let rest_density = solver.plan().parameters.rest_density;

        let particle = |(i, &position): (usize, &Vec3)| ParticleRecord {
            position,
            id: at(&ids, i),
            velocity: at(&velocities, i),
            remaining_life: lives.get(i).copied().unwrap_or(f32::INFINITY),
        };
        let density = |i| {
            // Zero means that nobody has computed it yet.
            let density = Some(at(&densities, i)).filter(|density| *density > 0.0).unwrap_or(rest_density);
            [density, at(&pressures, i) / (density * density)]
        };
        Self {
            version,
            particles: positions.iter().enumerate().map(particle).collect(),
            densities: (0..positions.len()).map(density).collect(),
            accelerations: (0..positions.len()).map(|i| at(&accelerations, i).extend(0.0).to_array()).collect(),
        }
    }
}

fn at<T: Copy + Default>(values: &[T], index: usize) -> T {
    values.get(index).copied().unwrap_or_default()
}
