//! Stage `position_solve`: particles are moved apart, see [`freshet_core::position_based`] and [`freshet_core::pressure_corrected`].

use freshet_core::plan::Plan;
use freshet_core::pressure_corrected::{PressureCorrected, PressureGradient};
use freshet_core::pressure_solver::PressureSolver;

use pulp::Arch;

use super::CpuSolver;
use super::stages::{kernel_scale, those_with_samples};
use crate::particles::Particles;
use crate::passes::position_solve::{Displace, DisplaceByDifference, Inputs, Multiply, Rule, Task};
use crate::samples::SortedSamples;
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
    pub(super) fn position_solve_stage(&mut self) {
        let mut solve = std::mem::take(&mut self.positions);
        // Taken: what is found again is not moved again.
        let dt = std::mem::take(&mut self.last_substep);
        let live = self.particles.len;
        self.pressure_term[..live].fill(0.0);
        solve.way.iter_mut().for_each(|way| way.fill(0.0));
        if dt > 0.0 {
            let parameters = self.plan.parameters;
            match parameters.pressure_solver {
                PressureSolver::PositionBased(solver) => {
                    let (relaxation, softness) = (parameters.relaxation, parameters.softness);
                    for _ in 0..solver.iterations {
                        self.multiply(&mut solve, Rule::Jacobi { relaxation, softness });
                        self.displace(&mut solve, PressureGradient::Sum);
                    }
                }
                PressureSolver::PressureCorrected(solver) => {
                    let stiffness = PressureCorrected::stiffness(&parameters, dt);
                    for _ in 0..solver.iterations {
                        self.multiply(&mut solve, Rule::Sound(stiffness));
                        self.displace(&mut solve, solver.gradient);
                    }
                }
                PressureSolver::WeaklyCompressible | PressureSolver::DivergenceFree(_) => {}
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

    /// By how much particles push from where they are.
    fn multiply(&mut self, solve: &mut PositionSolve, rule: Rule) {
        let PositionSolve { way, push, pushed, .. } = solve;
        let samples = [&self.walls, &self.body_samples.sorted];
        let pieces = (self.arch, &self.plan, &*self.sorter.starts, &self.particles);
        let inputs = inputs(pieces, way, push, those_with_samples(&samples));
        let kernel = self.plan.parameters.kernel;
        let results = [&mut **pushed, &mut *self.pressure_term];
        let tasks = Tasks::new(&self.sorter.chunks, &mut *self.candidates, results);
        self.workers.share_with(&mut self.workspaces, tasks, |workspace, (chunk, candidates, [push, sum])| {
            let term = Multiply { rule, push, sum };
            dispatch(kernel, Task { inputs, chunk, workspace, candidates, term })
        });
        std::mem::swap(push, pushed);
    }

    /// Moves particles by that.
    fn displace(&mut self, solve: &mut PositionSolve, gradient: PressureGradient) {
        let PositionSolve { way, next, push, .. } = solve;
        let samples = [&self.walls, &self.body_samples.sorted];
        let pieces = (self.arch, &self.plan, &*self.sorter.starts, &self.particles);
        let inputs = inputs(pieces, way, push, those_with_samples(&samples));
        let kernel = self.plan.parameters.kernel;
        let results = next.each_mut().map(Vec::as_mut_slice);
        let tasks = Tasks::new(&self.sorter.chunks, &mut *self.candidates, results);
        self.workers.share_with(&mut self.workspaces, tasks, |workspace, (chunk, candidates, way)| match gradient {
            PressureGradient::Sum => {
                dispatch(kernel, Task { inputs, chunk, workspace, candidates, term: Displace { way } })
            }
            PressureGradient::Difference => {
                let term = DisplaceByDifference { way };
                dispatch(kernel, Task { inputs, chunk, workspace, candidates, term })
            }
        });
        std::mem::swap(way, next);
    }
}

/// What the passes are told.
fn inputs<'a>(
    (arch, plan, starts, particles): (Arch, &'a Plan, &'a [u32], &'a Particles),
    way: &'a [Vec<f32>; 3],
    push: &'a [f32],
    samples: &'a [&'a SortedSamples],
) -> Inputs<'a> {
    let parameters = &plan.parameters;
    let slope = parameters.particle_mass * kernel_scale(parameters, 5);
    let density = parameters.particle_mass / parameters.rest_density * kernel_scale(parameters, 3)
        / parameters.density_calibration;
    let calibrations = parameters.density_calibration * parameters.gradient_calibration;
    Inputs {
        arch,
        grid: &plan.grid,
        starts,
        particles,
        way,
        push,
        samples,
        density,
        own_density: density * parameters.kernel.shape(0.0) as f32,
        diagonal: slope.powi(2) / (calibrations * parameters.rest_density),
        least: parameters.least_diagonal,
        force: -slope / parameters.gradient_calibration,
        number_density: parameters.rest_density / parameters.particle_mass,
    }
}
