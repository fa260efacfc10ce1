//! The stages of a substep, shared out in chunks among the threads.

use freshet_core::near_pressure;
use freshet_core::plan::Parameters;
use glam::Vec3;

use super::CpuSolver;
use crate::candidates::Candidates;
use crate::lanes::PADDING;
use crate::passes::acceleration::Maxima;
use crate::passes::density::Compression;
use crate::passes::morris1997::Viscosity;
use crate::passes::sort::Dropped;
use crate::passes::{acceleration, body_load, density, integrate};
use crate::samples::SortedSamples;
use crate::simd_kernel::dispatch;
use crate::workers::split;

impl CpuSolver {
    /// Sorts the particles by cell, then id; what is dead or broken falls out.
    pub(super) fn sort(&mut self) -> Dropped {
        let parameters = &self.plan.parameters;
        let bounds = [parameters.bounds_min, parameters.bounds_max];
        let gone =
            self.sorter.sort(&self.workers, self.arch, &self.plan.grid, bounds, &mut self.particles, &mut self.scratch);
        let padded = self.particles.len + PADDING;
        for values in [&mut self.density, &mut self.pressure_term].into_iter().chain(&mut self.acceleration) {
            values.resize(padded, 0.0);
        }
        gone
    }

    /// Densities, pressure terms and the lists of candidates.
    pub(super) fn density_stage(&mut self) -> Compression {
        let parameters = &self.plan.parameters;
        let scale = kernel_scale(parameters, 3) / parameters.density_calibration;
        let samples: Vec<&SortedSamples> =
            [&self.walls, &self.body_samples.sorted].into_iter().filter(|samples| !samples.is_empty()).collect();
        let inputs = density::Inputs {
            arch: self.arch,
            grid: &self.plan.grid,
            starts: &self.sorter.starts,
            particles: &self.particles,
            samples: &samples,
            fluid_factor: parameters.particle_mass * scale,
            sample_factor: parameters.rest_density * scale,
            law: parameters.pressure_law,
            rest_density: parameters.rest_density,
        };
        let live = self.particles.len;
        self.candidates.resize_with(self.sorter.chunks.len(), Candidates::default);
        let densities = split(&mut self.density[..live], &self.sorter.chunks);
        let terms = split(&mut self.pressure_term[..live], &self.sorter.chunks);
        let tasks: Vec<_> = self
            .sorter
            .chunks
            .iter()
            .zip(&mut self.candidates)
            .zip(densities.into_iter().zip(terms))
            .map(|((chunk, candidates), (density, pressure_term))| density::Task {
                inputs,
                chunk,
                candidates,
                density,
                pressure_term,
            })
            .collect();
        let kernel = parameters.kernel;
        let parts = self.workers.map(tasks, |task| dispatch(kernel, task));
        parts.iter().fold(Compression { largest: -1.0, sum: 0 }, |sum, part| Compression {
            largest: sum.largest.max(part.largest),
            sum: sum.sum + part.sum,
        })
    }

    /// Accelerations, from the candidates of the density stage.
    pub(super) fn acceleration_stage(&mut self) -> Maxima {
        let parameters = &self.plan.parameters;
        let scale = kernel_scale(parameters, 5) / parameters.gradient_calibration;
        let samples: Vec<&SortedSamples> =
            [&self.walls, &self.body_samples.sorted].into_iter().filter(|samples| !samples.is_empty()).collect();
        let h = parameters.smoothing_length;
        let inputs = acceleration::Inputs {
            arch: self.arch,
            grid: &self.plan.grid,
            starts: &self.sorter.starts,
            particles: &self.particles,
            samples: &samples,
            density: &self.density,
            pressure_term: &self.pressure_term,
            fluid_factor: -parameters.particle_mass * scale,
            sample_factor: -parameters.rest_density * scale,
            viscosity: 2.0 * parameters.artificial_viscosity * parameters.sound_speed * h,
            physical: (parameters.dynamic_viscosity > 0.0).then(|| Viscosity {
                of_pairs: 2.0 * parameters.dynamic_viscosity * parameters.gradient_calibration
                    / parameters.viscous_calibration,
                of_walls: parameters.dynamic_viscosity,
                depth: parameters.boundary_depth,
                nearest: 0.25 * parameters.spacing,
            }),
            near_pressure: 2.0 * parameters.near_pressure / parameters.rest_density
                * (near_pressure::NORMALISATION / parameters.kernel.normalisation()) as f32,
            softening: 0.01 * h * h,
            gravity: self.gravity,
        };
        let live = self.particles.len;
        let [x, y, z] = &mut self.acceleration;
        let [x, y, z] = [x, y, z].map(|values| split(&mut values[..live], &self.sorter.chunks).into_iter());
        let tasks: Vec<_> = self
            .sorter
            .chunks
            .iter()
            .zip(&self.candidates)
            .zip(x.zip(y).zip(z))
            .map(|((chunk, candidates), ((x, y), z))| acceleration::Task {
                inputs,
                chunk,
                candidates,
                acceleration: [x, y, z],
            })
            .collect();
        let kernel = parameters.kernel;
        let parts = self.workers.map(tasks, |task| dispatch(kernel, task));
        parts.iter().fold(Maxima::default(), |largest, part| Maxima {
            speed_squared: largest.speed_squared.max(part.speed_squared),
            acceleration_squared: largest.acceleration_squared.max(part.acceleration_squared),
        })
    }

    /// Force (N) and torque about the centre of mass (N m) of the fluid on each body.
    pub(super) fn body_load_stage(&mut self) -> Vec<(Vec3, Vec3)> {
        let parameters = &self.plan.parameters;
        let samples = &self.body_samples.sorted;
        let scale = kernel_scale(parameters, 5) / parameters.gradient_calibration;
        let factor = parameters.particle_mass * parameters.rest_density * scale;
        let count = samples.len();
        let tasks: Vec<_> = (0..count)
            .step_by(64)
            .map(|first| body_load::Task {
                arch: self.arch,
                grid: &self.plan.grid,
                starts: &self.sorter.starts,
                particles: &self.particles,
                pressure_term: &self.pressure_term,
                samples,
                slots: (first, (first + 64).min(count)),
                factor,
            })
            .collect();
        let kernel = parameters.kernel;
        let mut forces = vec![Vec3::ZERO; count];
        let parts = self.workers.map(tasks, |task| dispatch(kernel, task));
        for (&source, force) in samples.source.iter().zip(parts.into_iter().flatten()) {
            forces[source as usize] = force;
        }
        // Summed in the samples' own order and in double precision: independent of threads and sorting.
        let mut first = 0;
        let mut loads = Vec::with_capacity(self.bodies.len());
        for (planned, body) in self.plan.bodies.iter().zip(&self.bodies) {
            let range = first..first + planned.samples.len();
            first = range.end;
            let (mut force, mut torque) = (glam::DVec3::ZERO, glam::DVec3::ZERO);
            for (on_sample, at) in forces[range.clone()].iter().zip(&self.body_samples.positions()[range]) {
                force += on_sample.as_dvec3();
                torque += (*at - body.position).cross(*on_sample).as_dvec3();
            }
            loads.push((force.as_vec3(), torque.as_vec3()));
        }
        loads
    }

    /// Moves all particles over `dt` seconds.
    pub(super) fn integrate_stage(&mut self, dt: f32) {
        let (chunks, periodic) = (&self.sorter.chunks, &self.plan.grid.periodic);
        let (particles, accelerations) = (&mut self.particles, &self.acceleration);
        integrate::integrate(&self.workers, chunks, particles, accelerations, periodic, self.mortal, dt);
    }
}

/// `A / H^power`, the constant of a kernel's value (3) or of its derivative over r (5).
fn kernel_scale(parameters: &Parameters, power: i32) -> f32 {
    (parameters.kernel.normalisation() / f64::from(parameters.support_radius).powi(power)) as f32
}
