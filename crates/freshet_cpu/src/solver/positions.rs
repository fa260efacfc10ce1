//! Stage `position_solve`: particles are moved apart, see [`freshet_core::position_based`].

use freshet_core::position_based::PositionBased;

use super::CpuSolver;
use super::stages::{kernel_scale, those_with_samples};
use crate::passes::position_solve::{Displace, Inputs, Multiply};
use crate::simd_kernel::dispatch;
use crate::tasks::Tasks;

/// What it works with, a value for each particle, padded.
#[derive(Default)]
pub(super) struct PositionSolve {
    /// How far particles are moved from where they were sorted, m.
    pub way: [Vec<f32>; 3],
    next: [Vec<f32>; 3],
    /// `dt^2 P` of an iteration; zero after the last.
    pub push: Vec<f32>,
    pushed: Vec<f32>,
}

impl PositionSolve {
    /// Makes room.
    pub fn resize(&mut self, len: usize) {
        let Self { way, next, push, pushed } = self;
        way.iter_mut().chain(next).chain([push, pushed]).for_each(|values| values.resize(len, 0.0));
    }

    /// Bytes allocated.
    pub fn bytes(&self) -> u64 {
        let Self { way, next, push, pushed } = self;
        4 * way.iter().chain(next).chain([push, pushed]).map(Vec::capacity).sum::<usize>() as u64
    }
}

impl CpuSolver {
    /// Finds how far particles have to be moved, and changes their velocities by that over the length of the last substep. They stay where they are until they
    /// are moved on.
    pub(super) fn position_solve_stage(&mut self, solver: &PositionBased) {
        let mut solve = std::mem::take(&mut self.positions);
        // Taken: what is found again is not moved again.
        let dt = std::mem::take(&mut self.last_substep);
        let live = self.particles.len;
        self.pressure_term[..live].fill(0.0);
        solve.way.iter_mut().for_each(|way| way.fill(0.0));
        if dt > 0.0 {
            for _ in 0..solver.iterations {
                self.iterate_positions(&mut solve);
            }
            let rate = 1.0 / dt;
            for term in &mut self.pressure_term[..live] {
                *term *= rate * rate;
            }
            for (velocity, way) in self.particles.velocity.iter_mut().zip(&solve.way) {
                for (v, way) in velocity[..live].iter_mut().zip(way) {
                    *v += way * rate;
                }
            }
        }
        solve.push.fill(0.0);
        self.positions = solve;
    }

    /// All particles once.
    fn iterate_positions(&mut self, solve: &mut PositionSolve) {
        let PositionSolve { way, next, push, pushed } = solve;
        let parameters = &self.plan.parameters;
        let shape = kernel_scale(parameters, 3) / parameters.density_calibration;
        let slope = kernel_scale(parameters, 5);
        let (mass, rest_density) = (parameters.particle_mass, parameters.rest_density);
        let calibrations = parameters.density_calibration * parameters.gradient_calibration;
        let force = -slope / parameters.gradient_calibration;
        let samples = [&self.walls, &self.body_samples.sorted];
        let inputs = Inputs {
            arch: self.arch,
            grid: &self.plan.grid,
            starts: &self.sorter.starts,
            particles: &self.particles,
            way,
            push,
            samples: those_with_samples(&samples),
            density: [mass / rest_density * shape, shape],
            diagonal: (mass * slope).powi(2) / (calibrations * rest_density),
            least: parameters.least_diagonal,
            softness: parameters.softness,
            relaxation: parameters.relaxation,
            force: [mass * force, rest_density * force],
            number_density: rest_density / mass,
        };
        let results = [&mut **pushed, &mut *self.pressure_term];
        let tasks = Tasks::new(&self.sorter.chunks, &mut *self.candidates, results);
        self.workers.share_with(&mut self.workspaces, tasks, |workspace, (chunk, candidates, [push, sum])| {
            dispatch(parameters.kernel, Multiply { inputs, chunk, workspace, candidates, push, sum })
        });
        let inputs = Inputs { push: pushed, ..inputs };
        let results = next.each_mut().map(Vec::as_mut_slice);
        let tasks = Tasks::new(&self.sorter.chunks, &mut *self.candidates, results);
        self.workers.share_with(&mut self.workspaces, tasks, |workspace, (chunk, candidates, way)| {
            dispatch(parameters.kernel, Displace { inputs, chunk, workspace, candidates, way })
        });
        std::mem::swap(way, next);
    }
}
