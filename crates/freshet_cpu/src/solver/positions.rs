//! Stage `position_solve`: particles are moved apart, see [`freshet_core::position_based`], [`freshet_core::pressure_corrected`] and [`freshet_core::pressure_poisson`].

use freshet_core::plan::Plan;
use freshet_core::pressure_corrected::{PressureCorrected, PressureGradient};
use freshet_core::pressure_poisson::PressurePoisson;
use freshet_core::pressure_solver::PressureSolver;

use pulp::Arch;

use super::CpuSolver;
use super::solves::{Pace, Solved, mean};
use super::stages::{slope_scale, those_with_samples, value_scale};
use crate::particles::Particles;
use crate::passes::position_solve::{Diagonal, Displace, DisplaceByDifference, Inputs, Multiply, Relax, Rule, Task};
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
    /// Of a Poisson equation: what steps came to before momentum, and the diagonal.
    poisson: Option<[Vec<f32>; 2]>,
}

impl PositionSolve {
    /// Makes room.
    pub fn resize(&mut self, len: usize, solver: PressureSolver) {
        if matches!(solver, PressureSolver::PressurePoisson(_)) {
            self.poisson.get_or_insert_default();
        }
        let Self { way, next, push, pushed, poisson } = self;
        let arrays = way.iter_mut().chain(next).chain([push, pushed]).chain(poisson.iter_mut().flatten());
        arrays.for_each(|values| values.resize(len, 0.0));
    }

    /// Bytes allocated.
    pub fn bytes(&self) -> u64 {
        let Self { way, next, push, pushed, poisson } = self;
        let arrays = way.iter().chain(next).chain([push, pushed]).chain(poisson.iter().flatten());
        4 * arrays.map(Vec::capacity).sum::<usize>() as u64
    }
}

impl CpuSolver {
    /// Finds how far particles have to be moved, and changes their velocities by that over the length of the last substep. They stay where they are until they
    /// are moved on.
    ///
    /// Gives how a Poisson equation's solve went, and what it left of what it began with.
    pub(super) fn position_solve_stage(&mut self) -> Option<(Solved, f32)> {
        let mut solved = None;
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
                PressureSolver::PressurePoisson(solver) => {
                    solved = Some(self.solve_poisson(&mut solve, &solver));
                    self.displace(&mut solve, PressureGradient::Sum);
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
        solved
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

    /// By how much particles push to undo what is too dense; and what that leaves over what it began with.
    fn solve_poisson(&mut self, solve: &mut PositionSolve, solver: &PressurePoisson) -> (Solved, f32) {
        let live = self.particles.len;
        let PositionSolve { way, push, pushed, poisson, .. } = solve;
        let [stepped, diagonal] = poisson.get_or_insert_default();
        push.fill(0.0);
        stepped.fill(0.0);
        let parameters = &self.plan.parameters;
        let (kernel, density, relaxation) = (parameters.kernel, &*self.density, parameters.relaxation);
        let surface = PressurePoisson::SURFACE * parameters.rest_density;
        let inverse_rest_density = 1.0 / parameters.rest_density;
        let samples = [&self.walls, &self.body_samples.sorted];
        let pieces = (self.arch, &self.plan, &*self.sorter.starts, &self.particles);
        let of_diagonal = inputs(pieces, way, push, those_with_samples(&samples));
        let tasks = Tasks::new(&self.sorter.chunks, &mut *self.candidates, &mut **diagonal);
        self.workers.share_with(&mut self.workspaces, tasks, |workspace, (chunk, candidates, diagonal)| {
            let term = Diagonal { density, surface, diagonal };
            dispatch(kernel, Task { inputs: of_diagonal, chunk, workspace, candidates, term })
        });
        let (mut pace, mut iterations, mut begun) = (Pace::default(), 0, 0.0);
        loop {
            let momentum = pace.momentum();
            let inputs = inputs(pieces, way, push, those_with_samples(&samples));
            let results = [&mut **stepped, &mut **pushed];
            let tasks = Tasks::new(&self.sorter.chunks, &mut *self.candidates, results);
            let diagonal = &*diagonal;
            let sum =
                self.workers.share_with(&mut self.workspaces, tasks, |workspace, (chunk, candidates, results)| {
                    let [stepped, next] = results;
                    let term =
                        Relax { density, inverse_rest_density, diagonal, relaxation, momentum, stepped, next, left: 0 };
                    dispatch(kernel, Task { inputs, chunk, workspace, candidates, term })
                });
            std::mem::swap(push, pushed);
            let left = mean(sum, live);
            pace.hear(left);
            iterations += 1;
            if iterations == 1 {
                begun = left;
            }
            let converged = left <= solver.tolerance * begun;
            if converged || iterations >= solver.max_iterations {
                push.copy_from_slice(stepped);
                self.pressure_term[..live].copy_from_slice(&stepped[..live]);
                let residual = if begun > 0.0 { left / begun } else { 0.0 };
                return (Solved { iterations, converged }, residual);
            }
        }
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
    let slope = parameters.particle_mass * slope_scale(parameters);
    let density =
        parameters.particle_mass / parameters.rest_density * value_scale(parameters) / parameters.density_calibration;
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
        poisson: -2.0 * slope / parameters.density_calibration,
        force: -slope / parameters.gradient_calibration,
        number_density: parameters.rest_density / parameters.particle_mass,
    }
}
