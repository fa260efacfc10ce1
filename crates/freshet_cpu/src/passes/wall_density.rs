//! Stage `wall_density` of walls behind which the fluid has images, see [`ghosts`](freshet_core::wall_method::ghosts): what these add to densities, and the
//! pressures that follow. That of quasi-fluid walls is in [`body_density`](super::body_density).

use freshet_core::equation_of_state::PressureLaw;
use freshet_core::kernel::Kernel;

use super::density::{Compression, compression, pressure_terms};
use crate::near_walls::{NearWalls, each_particle};
use crate::particles::Particles;
use crate::workers::Chunk;
use crate::workspace::Workspace;

/// What a chunk needs.
#[derive(Clone, Copy)]
pub struct Inputs<'a> {
    /// The walls.
    pub near: NearWalls<'a>,
    /// First particle of each cell.
    pub starts: &'a [u32],
    /// Sorted particles.
    pub particles: &'a Particles,
    /// The kernel.
    pub kernel: Kernel,
    /// `m/S`.
    pub factor: f64,
    /// Pressure from density.
    pub law: PressureLaw,
}

/// Adds images to the densities of a chunk's particles, and finds their pressures.
pub fn wall_density(
    inputs: &Inputs<'_>,
    chunk: &Chunk,
    workspace: &mut Workspace,
    [density, terms]: [&mut [f32]; 2],
) -> Compression {
    let (grid, rest_density) = (&inputs.near.plan.grid, inputs.near.plan.parameters.rest_density);
    for (i, density) in chunk.particles.clone().zip(&mut *density) {
        let at = inputs.particles.position_of(i);
        let Some(around) = inputs.near.around(at) else { continue };
        let mut sum = 0.0;
        for image in inputs.near.images(&around, &mut workspace.near_walls).iter() {
            each_particle(grid, inputs.starts, inputs.particles, at + image.way, |_, _, squared| {
                sum += inputs.kernel.value(f64::from(squared).sqrt());
            });
        }
        *density += (inputs.factor * sum) as f32;
    }
    pressure_terms(rest_density, inputs.law, density, terms);
    compression(rest_density, density)
}
