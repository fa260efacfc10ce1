//! The pressure solves of an incompressible fluid, see [`DivergenceFree`].

use freshet_core::pressure_solver::DivergenceFree;
use glam::Vec3;

use super::answers::Answers;
use super::stages::{slope_scale, those_with_samples};
use super::{CpuSolver, Iteration};
use crate::passes::projection::{self, UNIT, Values};
use crate::simd_kernel::dispatch;
use crate::tasks::Tasks;

/// What the solves work with, a value for each particle, padded.
#[derive(Default)]
pub(super) struct PressureSolve {
    /// `1/K`, from the density pass.
    pub inverse_diagonal: Vec<f32>,
    source: Vec<f32>,
    left: Vec<f32>,
    change: Vec<f32>,
    next: Vec<f32>,
    stepped: Vec<f32>,
    /// Velocities, then accelerations by the change of pressures.
    motion: [Vec<f32>; 3],
    pace: Pace,
    /// Of plans with bodies.
    pub bodies: Answers,
}

/// Nesterov's momentum, started again when a step made things worse (O'Donoghue & Candes 2015).
pub(super) struct Pace {
    t: f32,
    /// What the iteration before left.
    last: f32,
}

impl Default for Pace {
    fn default() -> Self {
        Self { t: 1.0, last: f32::INFINITY }
    }
}

impl Pace {
    /// The momentum of the next step.
    pub fn momentum(&mut self) -> f32 {
        let next = 0.5 * (1.0 + (1.0 + 4.0 * self.t * self.t).sqrt());
        let momentum = (self.t - 1.0) / next;
        self.t = next;
        momentum.max(DivergenceFree::MOMENTUM)
    }

    /// Hears what is left.
    pub fn hear(&mut self, left: f32) {
        if left > self.last {
            self.t = 1.0;
        }
        self.last = left;
    }
}

/// How a solve went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Solved {
    /// Iterations made.
    pub iterations: u32,
    /// Whether it is as exact as asked for.
    pub converged: bool,
}

impl PressureSolve {
    /// Makes room.
    pub fn resize(&mut self, len: usize) {
        self.arrays_mut().for_each(|values| values.resize(len, 0.0));
    }

    /// Bytes allocated.
    pub fn bytes(&self) -> u64 {
        let Self { inverse_diagonal, source, left, change, next, stepped, motion, pace: _, bodies: _ } = self;
        let arrays = [inverse_diagonal, source, left, change, next, stepped];
        4 * arrays.into_iter().chain(motion).map(Vec::capacity).sum::<usize>() as u64
    }

    fn arrays_mut(&mut self) -> impl Iterator<Item = &mut Vec<f32>> {
        let Self { inverse_diagonal, source, left, change, next, stepped, motion, pace: _, bodies: _ } = self;
        [inverse_diagonal, source, left, change, next, stepped].into_iter().chain(motion)
    }
}

impl CpuSolver {
    /// Stage `divergence_solve`: pressures with which velocities compress nothing over `dt` seconds; the accelerations get what
    /// they change, and so do the loads on bodies. `way` is that of the fastest particle over the longest allowed.
    pub(super) fn divergence_solve_stage(&mut self, solver: &DivergenceFree, dt: f32, way: f32) -> Solved {
        let mut solve = std::mem::take(&mut self.solve);
        let live = self.particles.len;
        let (share, rest_density) = (DivergenceFree::share(way), self.plan.parameters.rest_density);
        let most = self.plan.parameters.most_by_velocity(dt);
        for (source, density) in solve.source[..live].iter_mut().zip(&self.density) {
            *source = DivergenceFree::source(density / rest_density - 1.0, share, most);
        }
        for at in solve.bodies.pushed_out(&self.bodies) {
            let excess = self.density[at] / rest_density - 1.0;
            solve.source[at] += self.plan.parameters.pushed_out(excess, share, dt);
        }
        let velocities = self.particles.velocity.iter().zip(&self.acceleration);
        for (motion, (velocity, acceleration)) in solve.motion.iter_mut().zip(velocities) {
            for ((motion, v), a) in motion[..live].iter_mut().zip(velocity).zip(acceleration) {
                *motion = v + dt * a;
            }
        }
        solve.bodies.stiffen(&self.bodies, &mut solve.inverse_diagonal, &self.plan.parameters);
        solve.change[..live].fill(0.0);
        solve.stepped[..live].fill(0.0);
        solve.pace = Pace::default();
        let tolerance = (solver.divergence * way).max(DivergenceFree::LEAST_DIVERGENCE);
        let mut left = self.iterate(&mut solve, dt, true, true);
        let mut iterations = 1;
        while left > tolerance && iterations < solver.max_iterations {
            std::mem::swap(&mut solve.change, &mut solve.next);
            self.accelerate_by(&mut solve);
            solve.bodies.answer(&self.bodies, &solve.change);
            left = self.iterate(&mut solve, dt, true, false);
            iterations += 1;
        }
        // The first iteration is about what is there already.
        if iterations > 1 {
            for (pressure, change) in self.particles.pressure[..live].iter_mut().zip(&solve.change) {
                *pressure += change;
            }
            for (acceleration, motion) in self.acceleration.iter_mut().zip(&solve.motion) {
                for (a, change) in acceleration[..live].iter_mut().zip(motion) {
                    *a += change;
                }
            }
            for (load, change) in self.loads.iter_mut().zip(solve.bodies.loads()) {
                *load = *load + *change;
            }
        }
        solve.bodies.soften(&mut solve.inverse_diagonal);
        self.solve = solve;
        Solved { iterations, converged: left <= tolerance }
    }

    /// Stage `density_solve`: moves particles apart where velocities leave them too dense. Bodies stay where they are.
    pub(super) fn density_solve_stage(&mut self, solver: &DivergenceFree, dt: f32, way: f32) -> Solved {
        let mut solve = std::mem::take(&mut self.solve);
        let live = self.particles.len;
        let (share, rest_density) = (DivergenceFree::share(way), self.plan.parameters.rest_density);
        let relaxation = self.iteration.relaxation(self.plan.parameters.relaxation) / (dt * dt);
        for at in solve.bodies.pushed_out(&self.bodies) {
            let excess = self.density[at] / rest_density - 1.0;
            solve.left[at] -= self.plan.parameters.pushed_out(excess, share, dt);
        }
        let mut sum = 0;
        let most = self.plan.parameters.most_by_velocity(dt);
        for i in 0..live {
            let excess = (self.density[i] / rest_density - 1.0).max(0.0);
            let too_much = solve.left[i] + excess - DivergenceFree::by_velocity(excess, share, most);
            solve.source[i] = too_much;
            let step = (relaxation * too_much * solve.inverse_diagonal[i]).max(0.0);
            solve.change[i] = step;
            solve.stepped[i] = step;
            sum += u64::from((too_much.clamp(0.0, 1.0) * UNIT) as u32);
        }
        let mut left = mean(sum, live);
        let mut iterations = 0;
        solve.pace = Pace::default();
        while left > solver.compression && iterations < solver.max_iterations {
            if iterations > 0 {
                std::mem::swap(&mut solve.change, &mut solve.next);
            }
            self.accelerate_by(&mut solve);
            left = self.iterate(&mut solve, dt, false, false);
            iterations += 1;
        }
        if iterations > 0 {
            let longest = DivergenceFree::LONGEST_CORRECTION * self.plan.parameters.spacing;
            let ([x, y, z], [ax, ay, az]) = (&mut self.particles.position, &solve.motion);
            for i in 0..live {
                let way = (dt * dt * Vec3::new(ax[i], ay[i], az[i])).clamp_length_max(longest);
                (x[i], y[i], z[i]) = (x[i] + way.x, y[i] + way.y, z[i] + way.z);
            }
        }
        self.solve = solve;
        Solved { iterations, converged: left <= solver.compression }
    }

    /// Accelerations by the change of pressures.
    fn accelerate_by(&mut self, solve: &mut PressureSolve) {
        let mut motion = std::mem::take(&mut solve.motion);
        self.accelerate(&solve.change, &mut motion, false);
        solve.motion = motion;
    }

    /// One iteration; returns the mean of what is left. `standing`: pressures are there already and change.
    fn iterate(&mut self, solve: &mut PressureSolve, dt: f32, standing: bool, first: bool) -> f32 {
        let parameters = &self.plan.parameters;
        let samples = [&self.walls, &self.body_samples.sorted];
        let gradient = parameters.particle_mass * slope_scale(parameters);
        let inputs = projection::Inputs {
            arch: self.arch,
            grid: &self.plan.grid,
            starts: &self.sorter.starts,
            particles: &self.particles,
            samples: those_with_samples(&samples),
            bodies: solve.bodies.motions(),
            motion: &solve.motion,
            factor: gradient / (parameters.density_calibration * parameters.rest_density),
            number_density: parameters.rest_density / parameters.particle_mass,
            time: if first { dt } else { dt * dt },
            relaxation: self.iteration.relaxation(parameters.relaxation) / (dt * dt),
            momentum: match self.iteration {
                Iteration::Momentum => solve.pace.momentum(),
                Iteration::Jacobi => 0.0,
            },
        };
        let results = [&mut *solve.source, &mut *solve.next, &mut *solve.stepped, &mut *solve.left];
        let tasks = Tasks::new(&self.sorter.chunks, &mut *self.candidates, results);
        let (inverse_diagonal, change, pressure) = (&solve.inverse_diagonal, &solve.change, &self.particles.pressure);
        let answers = &solve.bodies;
        let sum = self.workers.share_with(&mut self.workspaces, tasks, |workspace, (chunk, candidates, results)| {
            let [source, next, stepped, left] = results;
            let those = chunk.particles.clone();
            let values = Values {
                inverse_diagonal: &inverse_diagonal[those.clone()],
                pressure: standing.then(|| &pressure[those.clone()]),
                source,
                first,
                change: &change[those],
                next,
                stepped,
                left,
            };
            // Positions are corrected about bodies that stand still.
            let touches = if standing { answers.touches_of(chunk) } else { &[] };
            dispatch(parameters.kernel, projection::Task { inputs, chunk, workspace, candidates, touches, values })
        });
        let mut left = mean(sum, self.particles.len);
        if standing {
            // Around a body that answers it has to be as exact as everywhere, however few they are.
            left = solve.bodies.left(&self.bodies, &solve.left, &solve.change, &self.particles.pressure).max(left);
        }
        solve.pace.hear(left);
        left
    }
}

/// The mean of so many.
pub(super) fn mean(sum: u64, count: usize) -> f32 {
    (sum as f64 / f64::from(UNIT) / count.max(1) as f64) as f32
}
