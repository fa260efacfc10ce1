//! The solver: owns the state and runs the plan's stages.

mod answers;
mod positions;
mod redo;
mod solves;
mod stages;

use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

use freshet_core::field::{Field, FieldData};
use freshet_core::integrator::Integrator;
use freshet_core::kernel::Kernel;
use freshet_core::misplaced::Misplaced;
use freshet_core::plan::{Parameters, Plan, StageKind};
use freshet_core::pressure_solver::{DivergenceFree, PressureSolver};
use freshet_core::relaxation::relax;
use freshet_core::snapshot::{BodyPose, Exchange, Snapshot, carried_over, check_room};
use freshet_core::solver::{FluidSolver, Schedule, SolverError};
use freshet_core::step::{PassTime, StepInput, StepReport};
use freshet_core::tensile_correction::inverse_shape;
use glam::Vec3;

use self::answers::Load;
use self::positions::PositionSolve;
use self::redo::Before;
use self::solves::{PressureSolve, Solved};
use crate::candidates::Candidates;
use crate::lanes::PADDING;
use crate::near_walls::PushingWalls;
use crate::particles::Particles;
use crate::passes::acceleration::Maxima;
use crate::passes::body_contact::Drag;
use crate::passes::body_motion::{MovingBody, remember};
use crate::passes::body_sort::BodySamples;
use crate::passes::commands::Population;
use crate::passes::density::Compression;
use crate::passes::sort::{Dropped, Sorter};
use crate::passes::step_control;
use crate::samples::SortedSamples;
use crate::schedule;
use crate::tasks::Total;
use crate::workers::Workers;
use crate::workspace::Workspace;

/// Which vector instructions to use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InstructionSet {
    /// The widest this processor has.
    #[default]
    Widest,
    /// None: one value at a time. For comparison.
    Scalar,
}

/// How pressures are iterated, see [`DivergenceFree`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Iteration {
    /// Jacobi steps with Nesterov's momentum.
    #[default]
    Momentum,
    /// Relaxed Jacobi steps without (Bender & Koschier 2015), half a step at H = 2d. For comparison.
    Jacobi,
}

impl Iteration {
    /// Relaxation of [`Jacobi`](Self::Jacobi) times the largest eigenvalue of the lattice, no unit: 0.5 at H = 2d, as SPlisHSPlasH has it for
    /// every support; from 2 on it diverges.
    pub const JACOBI_RELAXATION: f32 = 1.3;

    /// Share of a Jacobi step that is taken, from that of a plan.
    fn relaxation(self, planned: f32) -> f32 {
        match self {
            Self::Momentum => planned,
            Self::Jacobi => planned / DivergenceFree::RELAXATION * Self::JACOBI_RELAXATION,
        }
    }
}

/// How the solver uses the machine.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CpuOptions {
    /// Threads of its own, 1 to 256; other numbers are refused when the solver is made. None: one for each core. Of these a tick
    /// keeps one busy for each thousand particles, and at least the caller's; between ticks they are asleep.
    pub threads: Option<usize>,
    /// Vector instructions.
    pub instruction_set: InstructionSet,
    /// How the pressures of an incompressible fluid are iterated.
    pub iteration: Iteration,
}

/// Weakly compressible SPH on CPU cores.
pub struct CpuSolver {
    plan: Plan,
    schedule: Schedule,
    workers: Arc<Workers>,
    arch: pulp::Arch,
    iteration: Iteration,
    particles: Particles,
    scratch: Particles,
    /// Of plans that make substeps again.
    before: Before,
    sorter: Sorter,
    /// Of each chunk, from the density pass to the acceleration pass.
    candidates: Vec<Candidates>,
    /// Of each thread.
    workspaces: Vec<Workspace>,
    density: Vec<f32>,
    /// Of plans whose pressures follow from densities.
    pressure_term: Vec<f32>,
    acceleration: [Vec<f32>; 3],
    /// Of plans with XSPH.
    drift: [Vec<f32>; 3],
    /// Of plans whose supports vary, over the support radius.
    width: Vec<f32>,
    /// Of plans whose pressures are solved for.
    solve: PressureSolve,
    /// Of plans that have it: see [`acceleration`](crate::passes::acceleration::Inputs::tensile).
    tensile: Option<[f32; 2]>,
    /// Of plans that move particles apart.
    positions: PositionSolve,
    /// Length of the last substep, s; zero if there was none.
    last_substep: f32,
    /// Whose past the particles have.
    integrator: Integrator,
    walls: SortedSamples,
    /// Slots of quasi-fluid walls that are one task.
    wall_slots: Vec<Range<usize>>,
    /// Of plans whose walls are not in the sums, in which case those above are none.
    pushing_walls: PushingWalls,
    body_samples: BodySamples,
    bodies: Vec<MovingBody>,
    /// Of each body the samples that the fluid reaches.
    wetted: Vec<u32>,
    /// Slots of the bodies' samples that are one task of the load's pass.
    slots: Vec<Range<usize>>,
    /// On each of these samples, N: in the order of slots, and in the bodies' own.
    sorted_forces: Vec<Vec3>,
    forces: Vec<Vec3>,
    /// Of each chunk, of plans in which fluid sticks to bodies.
    drags: Vec<Vec<Drag>>,
    /// On each body.
    loads: Vec<Load>,
    exchanges: Vec<[Exchange; 4]>,
    poses: Vec<Option<BodyPose>>,
    gravity: Vec3,
    next_tick: u64,
    time: f64,
    carry: f32,
    emitted: Option<f64>,
    next_id: u32,
    mortal: bool,
    /// There was no tick yet.
    fresh: bool,
}

/// What is found out about a state before it is moved on.
#[derive(Clone, Copy)]
struct Found {
    compression: Compression,
    maxima: Maxima,
}

/// Sums and extremes over a tick.
#[derive(Default)]
struct Tally {
    substeps: u32,
    smallest: f32,
    mean_compression: f32,
    max_compression: f32,
    max_speed: f32,
    divergence_iterations: u32,
    density_iterations: u32,
    residual: f32,
    unsolved: u32,
    redone: u32,
    dropped: Dropped,
    times: Vec<(&'static str, Duration)>,
}

impl Tally {
    /// The iterations of a solve; remembers whether it was in vain.
    fn count(&mut self, solved: Solved) -> u32 {
        self.unsolved += u32::from(!solved.converged);
        solved.iterations
    }

    /// A substep of `dt` seconds that was made and stays.
    fn count_substep(&mut self, found: &Found, dt: f32, particles: usize) {
        self.substeps += 1;
        self.smallest = if self.substeps == 1 { dt } else { self.smallest.min(dt) };
        let mean = found.compression.sum as f64 / 1_048_576.0 / particles.max(1) as f64;
        self.mean_compression = self.mean_compression.max(mean as f32);
        self.max_compression = self.max_compression.max(found.compression.largest);
        self.max_speed = found.maxima.speed_squared.sqrt();
    }

    fn timed<T>(&mut self, name: &'static str, work: impl FnOnce() -> T) -> T {
        let begin = Instant::now();
        let result = work();
        let spent = begin.elapsed();
        match self.times.iter_mut().find(|(other, _)| *other == name) {
            Some((_, total)) => *total += spent,
            None => self.times.push((name, spent)),
        }
        result
    }
}

impl CpuSolver {
    /// Starts a plan with its particles.
    ///
    /// # Errors
    /// If the plan asks for what the CPU does not have, the number of threads is out of range or they cannot be made.
    pub fn new(plan: Plan, options: CpuOptions) -> Result<Self, SolverError> {
        let passes = schedule::lower(&plan)?;
        let workers = Arc::new(Workers::new(options.threads)?);
        let arch = match options.instruction_set {
            InstructionSet::Widest => pulp::Arch::new(),
            InstructionSet::Scalar => pulp::Arch::Scalar,
        };
        let mut particles = Particles::default();
        for (index, (&position, &velocity)) in plan.positions.iter().zip(&plan.velocities).enumerate() {
            particles.push(index as u32, position, velocity, f32::INFINITY);
        }
        let mut solver = Self {
            schedule: schedule::schedule(passes, Vec::new(), plan.max_particles),
            arch,
            iteration: options.iteration,
            next_id: particles.len as u32,
            particles,
            scratch: Particles::default(),
            before: Before::default(),
            sorter: Sorter::default(),
            candidates: Vec::new(),
            workspaces: workers.spaces(),
            density: Vec::new(),
            pressure_term: Vec::new(),
            acceleration: Default::default(),
            drift: Default::default(),
            width: Vec::new(),
            solve: PressureSolve::default(),
            positions: PositionSolve::default(),
            tensile: None,
            last_substep: 0.0,
            integrator: Integrator::default(),
            walls: SortedSamples::default(),
            wall_slots: Vec::new(),
            pushing_walls: PushingWalls::default(),
            body_samples: BodySamples::default(),
            workers,
            bodies: Vec::new(),
            wetted: Vec::new(),
            slots: Vec::new(),
            sorted_forces: Vec::new(),
            forces: Vec::new(),
            drags: Vec::new(),
            loads: Vec::new(),
            exchanges: Vec::new(),
            poses: Vec::new(),
            gravity: plan.parameters.gravity,
            next_tick: 0,
            time: 0.0,
            carry: 0.0,
            emitted: None,
            mortal: false,
            fresh: true,
            plan,
        };
        solver.take_plan();
        for (pressure, &start) in solver.particles.pressure.iter_mut().zip(&solver.plan.pressures) {
            *pressure = start;
        }
        for (excess, &start) in solver.particles.excess.iter_mut().zip(&solver.plan.excesses) {
            *excess = start;
        }
        relax(&mut solver)?;
        Ok(solver)
    }

    /// Simulated time, s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Number of threads.
    pub fn threads(&self) -> usize {
        self.workers.threads()
    }

    /// `p / rho^2` of each particle.
    fn pressure_terms(&self) -> &[f32] {
        if self.particles.keeps_pressures() { &self.particles.pressure } else { &self.pressure_term }
    }

    fn pressure_terms_mut(&mut self) -> &mut Vec<f32> {
        if self.plan.has(StageKind::DivergenceSolve) { &mut self.particles.pressure } else { &mut self.pressure_term }
    }

    /// What follows from the plan and is not state.
    fn take_plan(&mut self) {
        // What an earlier plan had and this one has not takes no memory.
        let boundary = &self.plan.boundary;
        self.walls = SortedSamples::default();
        self.wall_slots = Vec::new();
        self.pushing_walls = PushingWalls::of(&self.plan);
        if self.plan.sums_walls() {
            self.walls.sort(&self.plan.grid, &boundary.positions, &boundary.volumes);
            self.walls.set_viscous(&boundary.viscous);
            self.walls.set_frictions(&boundary.frictions);
            if self.plan.parameters.dynamic_viscosity > 0.0 || !boundary.velocities.is_empty() {
                self.walls.set_velocities(&boundary.velocities);
            }
        }
        self.body_samples = BodySamples::default();
        self.candidates = Vec::new();
        self.drift = Default::default();
        self.width = Vec::new();
        self.solve = PressureSolve::default();
        self.positions = PositionSolve::default();
        let parameters = &self.plan.parameters;
        let kernel = parameters.pressure_kernel().ok().filter(|_| parameters.tensile_correction > 0.0);
        self.tensile = kernel.map(|kernel| [parameters.tensile_correction, inverse_shape(&kernel, parameters.spacing)]);
        self.before = Before::default();
        let solves = self.plan.has(StageKind::DivergenceSolve);
        if solves != self.particles.keeps_pressures() {
            // Pressures are elsewhere from here on, and are not read before there are any.
            self.pressure_term = Vec::new();
            self.density.clear();
            self.particles.keep_pressures(solves);
        }
        let carries = self.plan.parameters.density.is_carried();
        if carries == self.particles.excess.is_empty() {
            self.particles.carry_densities(carries);
            // From a state that another plan left: pressures go on, and what lacked neighbours lacks them no more.
            let rest_density = self.plan.parameters.rest_density;
            for (excess, density) in self.particles.excess.iter_mut().zip(&self.density) {
                *excess = (density / rest_density - 1.0).max(0.0);
            }
        }
        if self.integrator != self.plan.parameters.integrator {
            self.integrator = self.plan.parameters.integrator;
            self.particles.begin_histories(self.integrator);
        }
        self.exchanges.resize(self.plan.bodies.len(), [Exchange::default(); 4]);
        self.workspaces = self.workers.spaces();
        self.bodies = Vec::new();
        (self.slots, self.sorted_forces, self.forces, self.drags) = Default::default();
        self.measure_memory();
    }

    fn measure_memory(&mut self) {
        let real = |values: &[Vec<f32>]| 4 * values.iter().map(Vec::capacity).sum::<usize>() as u64;
        let stage = real(std::slice::from_ref(&self.density))
            + real(std::slice::from_ref(&self.pressure_term))
            + real(&self.acceleration);
        let lists = (size_of::<Candidates>() * self.candidates.capacity()) as u64;
        let candidates = lists + self.candidates.iter().map(Candidates::bytes).sum::<u64>();
        let workspaces = (size_of::<Workspace>() * self.workspaces.capacity()) as u64;
        self.schedule.buffers = vec![
            schedule::buffer("particles", self.particles.bytes(), true),
            schedule::buffer("particles_sorted", self.scratch.bytes(), true),
            schedule::buffer("stage_fields", stage, true),
            schedule::buffer("sort", self.sorter.bytes(), true),
            schedule::buffer("candidates", candidates, true),
            schedule::buffer(
                "workspaces",
                workspaces + self.workspaces.iter().map(Workspace::bytes).sum::<u64>(),
                false,
            ),
        ];
        if self.solve.bytes() > 0 {
            self.schedule.buffers.push(schedule::buffer("pressure_solve", self.solve.bytes(), true));
        }
        if self.positions.bytes() > 0 {
            self.schedule.buffers.push(schedule::buffer("position_solve", self.positions.bytes(), true));
        }
        if self.plan.has(StageKind::Xsph) {
            self.schedule.buffers.push(schedule::buffer("drift", real(&self.drift), true));
        }
        if self.plan.has(StageKind::Support) {
            self.schedule.buffers.push(schedule::buffer("width", real(std::slice::from_ref(&self.width)), true));
        }
        if self.plan.parameters.redo_substeps {
            self.schedule.buffers.push(schedule::buffer("before", self.before.bytes(), true));
        }
        if !self.plan.boundary.positions.is_empty() {
            let slots = (size_of::<Range<usize>>() * self.wall_slots.capacity()) as u64;
            let bytes = self.walls.bytes() + self.pushing_walls.bytes() + slots;
            self.schedule.buffers.push(schedule::buffer("walls", bytes, false));
        }
        if !self.plan.bodies.is_empty() {
            let states = size_of::<MovingBody>() * self.bodies.capacity()
                + size_of::<[Exchange; 4]>() * self.exchanges.capacity()
                + size_of::<Option<BodyPose>>() * self.poses.capacity()
                + size_of::<Range<usize>>() * self.slots.capacity()
                + size_of::<Vec3>() * (self.sorted_forces.capacity() + self.forces.capacity())
                + size_of::<Load>() * self.loads.capacity()
                + size_of::<Vec<Drag>>() * self.drags.capacity()
                + size_of::<Drag>() * self.drags.iter().map(Vec::capacity).sum::<usize>();
            let bytes = self.body_samples.bytes() + self.solve.bodies.bytes() + states as u64;
            self.schedule.buffers.push(schedule::buffer("bodies", bytes, false));
        }
        self.schedule.capacity = self.particles.len as u32;
    }

    /// A tick whose input has been checked.
    fn tick(&mut self, input: &StepInput) -> StepReport {
        let begin = Instant::now();
        let mut report = StepReport { tick: input.tick, ..StepReport::default() };
        let is_first = std::mem::take(&mut self.fresh);
        if is_first {
            let start: Vec<Vec3> = (0..self.particles.len).map(|index| self.particles.position_of(index)).collect();
            for Misplaced { index, inside } in self.plan.started_inside(&start, &input.bodies) {
                self.particles.life[index as usize] = -1.0;
                *(if inside { &mut report.inside_solids } else { &mut report.beside_solids }) += 1;
            }
        }
        let misplaced = self.plan.spawned_inside(input);
        let mut population = Population {
            particles: &mut self.particles,
            max_particles: self.plan.max_particles,
            next_id: &mut self.next_id,
            gravity: &mut self.gravity,
            emitted: &mut self.emitted,
            mortal: &mut self.mortal,
            time: self.time,
            misplaced: &misplaced,
            asked: 0,
            left_out: [0; 2],
        };
        for command in &input.commands {
            report.refused += population.carry_out(command);
        }
        let [inside, beside] = population.left_out;
        report.inside_solids += inside;
        report.beside_solids += beside;
        if self.plan.grid.periodic.any() {
            self.particles.wrap(&self.plan.grid.periodic);
        }
        self.bodies = input
            .bodies
            .iter()
            .zip(&self.plan.bodies)
            .zip(&self.exchanges)
            .map(|((body, planned), exchanges)| {
                MovingBody::begin(body, planned.reach, exchanges, input.tick, input.duration)
            })
            .collect();
        let parameters = &self.plan.parameters;
        self.poses.resize(self.plan.bodies.len(), None);
        let known = self.poses.iter().zip(&self.plan.bodies);
        for ((body, (left, planned)), given) in self.bodies.iter_mut().zip(known).zip(&input.bodies) {
            body.swollen =
                if is_first || planned.at_once { 1.0 } else { body.swollen_since(left.as_ref(), given, parameters) };
            if let Some(left) = left
                && !given.placed
            {
                body.continue_from(left, input.duration + self.carry, parameters);
            }
        }

        let asked = input.duration + self.carry;
        let mut covered = 0.0f32;
        let mut tally = Tally::default();
        let mut found = None;
        // Past the budget time slows down; past the substep limit the rest waits for the next tick.
        self.carry = loop {
            covered += match self.plan.parameters.redo_substeps {
                true => self.substep_or_redo(&mut found, asked - covered, &mut tally),
                false => self.substep(asked - covered, &mut tally),
            };
            let left = asked - covered;
            let spent = begin.elapsed().as_secs_f32() * 1e3;
            if left <= 1e-6 * asked || self.plan.budget_milliseconds.is_some_and(|budget| spent >= budget) {
                break 0.0;
            }
            if tally.substeps >= self.plan.parameters.max_substeps {
                break left.min(StepInput::MAX_DURATION);
            }
        };
        self.next_tick = input.tick + 1;
        self.time += f64::from(covered);
        for ((body, exchanges), given) in self.bodies.iter().zip(&mut self.exchanges).zip(&input.bodies) {
            remember(exchanges, input.tick, body.impulse, given.forecast);
        }
        self.poses = self.bodies.iter().map(|body| Some(body.pose())).collect();
        if tally.dropped.retired + tally.dropped.removed > 0 {
            self.particles.shrink();
            self.scratch.shrink();
            self.before.shrink();
            self.candidates.truncate(self.sorter.chunks.len());
            self.candidates.iter_mut().for_each(Candidates::shrink);
        }
        self.measure_memory();

        report.particles = self.particles.len as u32;
        report.substeps = tally.substeps;
        report.smallest_substep = tally.smallest;
        report.simulated = f64::from(covered);
        report.time_scale = if asked > 0.0 { covered / asked } else { 1.0 };
        report.mean_compression = tally.mean_compression;
        report.max_compression = tally.max_compression;
        report.max_speed = tally.max_speed;
        report.divergence_iterations = tally.divergence_iterations;
        report.density_iterations = tally.density_iterations;
        report.residual = tally.residual;
        report.unsolved = tally.unsolved;
        report.redone = tally.redone;
        report.removed = tally.dropped.removed;
        report.not_finite = tally.dropped.not_finite;
        // Those misplaced fell out with the others, at the first sort.
        report.retired = tally.dropped.retired.saturating_sub(report.inside_solids + report.beside_solids);
        report.bodies = self.bodies.iter().map(|body| body.impulse).collect();
        report.wetted.clone_from(&self.wetted);
        report.passes = tally
            .times
            .iter()
            .filter(|(name, _)| self.schedule.passes.iter().any(|pass| pass.name == *name))
            .map(|(name, time)| PassTime { pass: (*name).to_owned(), milliseconds: time.as_secs_f32() * 1e3 })
            .collect();
        report
    }

    /// One substep of at most `remaining` seconds; returns its length.
    fn substep(&mut self, remaining: f32, tally: &mut Tally) -> f32 {
        let found = self.find(tally);
        let dt = self.length(&found, remaining, tally);
        self.advance(&found, dt, tally);
        tally.count_substep(&found, dt, self.particles.len);
        dt
    }

    /// Densities, accelerations and loads of the state as it is.
    fn find(&mut self, tally: &mut Tally) -> Found {
        let gone = tally.timed("sort", || self.sort());
        tally.dropped = tally.dropped.and(gone);
        if self.plan.has(StageKind::BodySort) {
            let solves = self.plan.has(StageKind::DivergenceSolve);
            tally.timed("body_sort", || {
                self.body_samples.update(&self.plan.grid, &self.plan.bodies, &self.bodies);
                if solves || self.plan.has(StageKind::BodyDrag) || self.plan.has(StageKind::BodyFriction) {
                    self.body_samples.find_arms(&self.bodies);
                }
            });
        }
        if self.plan.has(StageKind::Support) {
            tally.timed("support", || self.support_stage());
        }
        let mut compression = tally.timed("density", || self.density_stage());
        if self.plan.has(StageKind::PositionSolve)
            && let Some((solved, residual)) = tally.timed("position_solve", || self.position_solve_stage())
        {
            let iterations = tally.count(solved);
            tally.density_iterations += iterations;
            tally.residual = tally.residual.max(residual);
        }
        if self.plan.has(StageKind::BodyDensity) {
            tally.timed("body_density", || self.body_density_stage());
        }
        if self.plan.has(StageKind::WallDensity) {
            let with_images = tally.timed("wall_density", || self.wall_density_stage());
            compression = with_images.unwrap_or(compression);
        }
        let mut maxima = tally.timed("acceleration", || self.acceleration_stage());
        if self.plan.has(StageKind::WallForce) {
            maxima = maxima.and(tally.timed("wall_force", || self.wall_force_stage()));
        }
        if self.plan.has(StageKind::BodyDrag) {
            tally.timed("body_drag", || self.body_drag_stage());
        }
        self.loads.clear();
        if self.plan.has(StageKind::BodyLoad) {
            tally.timed("body_load", || match self.plan.has(StageKind::DivergenceSolve) {
                false => self.body_load_stage(),
                true => self.body_touch_stage(),
            });
            if self.plan.has(StageKind::BodyDrag) {
                self.add_drags();
            }
            if tally.substeps == 0 || self.bodies.iter().any(|body| body.swollen < 1.0) {
                let (grid, starts) = (&self.plan.grid, &self.sorter.starts);
                let count = || self.body_samples.count_wetted(grid, starts, &self.particles, &mut self.wetted);
                tally.timed("body_load", count);
            }
        }
        Found { compression, maxima }
    }

    /// The length of a substep from a state, s.
    fn length(&self, found: &Found, remaining: f32, tally: &mut Tally) -> f32 {
        tally.timed("step_control", || {
            let bodies = (&*self.plan.bodies, &*self.bodies);
            let limit = step_control::limit(&self.plan.parameters, &found.maxima, bodies, self.gravity);
            Parameters::equal_substep(remaining, limit)
        })
    }

    /// Solves for pressures, if the plan does, and moves everything over `dt` seconds.
    fn advance(&mut self, found: &Found, dt: f32, tally: &mut Tally) {
        let mut lead = 0.0;
        if let PressureSolver::DivergenceFree(solver) = self.plan.parameters.pressure_solver
            && dt >= DivergenceFree::SHORTEST
        {
            self.solve.bodies.begin(&self.bodies, &self.loads, dt);
            let speed = found.maxima.speed_squared.sqrt().max(self.solve.bodies.speed(&self.bodies));
            let way = (speed * dt / self.plan.parameters.longest_way()).min(1.0);
            let solved = tally.timed("divergence_solve", || self.divergence_solve_stage(&solver, dt, way));
            let iterations = tally.count(solved);
            tally.divergence_iterations += iterations;
            self.final_velocities(dt, tally);
            let solved = tally.timed("density_solve", || self.density_solve_stage(&solver, dt, way));
            let iterations = tally.count(solved);
            tally.density_iterations += iterations;
            lead = DivergenceFree::lead(way, self.last_substep, dt);
            self.last_substep = dt;
        } else {
            self.final_velocities(dt, tally);
            let parameters = &self.plan.parameters;
            if parameters.density.is_carried() || self.plan.has(StageKind::PositionSolve) {
                self.last_substep = dt;
            }
        }
        tally.timed("body_motion", || {
            for (body, load) in self.bodies.iter_mut().zip(&self.loads) {
                body.advance(load.force, load.torque, dt);
            }
            let planned = self.plan.bodies.iter().zip(&self.wetted);
            for (body, (planned, &wetted)) in self.bodies.iter_mut().zip(planned) {
                if body.swollen < 1.0 {
                    body.swollen = planned.swell(body.swollen, wetted > 0, dt, &self.plan.parameters);
                }
            }
        });
        tally.timed("integrate", || self.integrate_stage(dt, lead));
        if self.plan.has(StageKind::WallCollision) {
            tally.timed("wall_collision", || self.wall_collision_stage(dt));
        }
    }

    /// Stages `friction`, `body_friction` and `xsph`, if the plan has them.
    fn final_velocities(&mut self, dt: f32, tally: &mut Tally) {
        if self.plan.has(StageKind::Friction) {
            tally.timed("friction", || self.friction_stage(dt));
        }
        if self.plan.has(StageKind::BodyFriction) {
            tally.timed("body_friction", || {
                self.body_friction_stage(dt);
                self.add_drags();
            });
        }
        if self.plan.has(StageKind::Xsph) {
            tally.timed("xsph", || self.xsph_stage(dt));
        }
    }
}

impl FluidSolver for CpuSolver {
    fn plan(&self) -> &Plan {
        &self.plan
    }

    fn schedule(&self) -> &Schedule {
        &self.schedule
    }

    fn step(&mut self, input: &StepInput) -> Result<StepReport, SolverError> {
        self.plan.check_input(input)?;
        let workers = Arc::clone(&self.workers);
        Ok(workers.enter(self.particles.len, || self.tick(input)))
    }

    fn read(&mut self, field: Field) -> Result<FieldData, SolverError> {
        if !self.plan.fields.contains(&field) {
            return Err(SolverError::NoSuchField(field.name()));
        }
        let live = self.particles.len;
        if field.origin() == freshet_core::field::FieldOrigin::Stage && self.density.len() < live + PADDING {
            return Err(SolverError::NoSuchField("before the first tick: density, pressure, acceleration"));
        }
        let particles = &self.particles;
        Ok(match field {
            Field::Id => FieldData::Integer(particles.id.clone()),
            Field::Position => FieldData::Vector((0..live).map(|i| particles.position_of(i)).collect()),
            Field::Velocity => FieldData::Vector((0..live).map(|i| particles.velocity_of(i)).collect()),
            Field::Density => FieldData::Scalar(self.density[..live].to_vec()),
            Field::Pressure => {
                let terms = self.pressure_terms();
                FieldData::Scalar((0..live).map(|i| terms[i] * self.density[i] * self.density[i]).collect())
            }
            Field::Acceleration => FieldData::Vector(
                (0..live)
                    .map(|i| Vec3::new(self.acceleration[0][i], self.acceleration[1][i], self.acceleration[2][i]))
                    .collect(),
            ),
            Field::Speed => FieldData::Scalar((0..live).map(|i| particles.velocity_of(i).length()).collect()),
            Field::RemainingLife => FieldData::Scalar(particles.life[..live].to_vec()),
        })
    }

    fn snapshot(&mut self) -> Result<Snapshot, SolverError> {
        let mut order: Vec<usize> = (0..self.particles.len).collect();
        order.sort_unstable_by_key(|&i| self.particles.id[i]);
        Ok(Snapshot {
            tick: self.next_tick,
            time: self.time,
            carry: self.carry,
            emitted: self.emitted,
            next_id: self.next_id,
            gravity: self.gravity,
            ids: order.iter().map(|&i| self.particles.id[i]).collect(),
            positions: order.iter().map(|&i| self.particles.position_of(i)).collect(),
            velocities: order.iter().map(|&i| self.particles.velocity_of(i)).collect(),
            remaining_lives: order.iter().map(|&i| self.particles.life[i]).collect(),
            pressures: match self.particles.keeps_pressures() {
                true => order.iter().map(|&i| self.particles.pressure[i]).collect(),
                false => Vec::new(),
            },
            excesses: match self.particles.excess.is_empty() {
                true => Vec::new(),
                false => order.iter().map(|&i| self.particles.excess[i]).collect(),
            },
            last_substep: self.last_substep,
            integrator: self.integrator,
            histories: order.iter().flat_map(|&i| self.particles.history_of(i)).collect(),
            exchanges: self.exchanges.clone(),
            poses: self.poses.clone(),
        })
    }

    fn restore(&mut self, snapshot: &Snapshot) -> Result<(), SolverError> {
        snapshot.validate()?;
        check_room(snapshot.ids.len(), self.plan.max_particles)?;
        let mut particles = Particles::default();
        for i in 0..snapshot.ids.len() {
            let (position, velocity) = (snapshot.positions[i], snapshot.velocities[i]);
            particles.push(snapshot.ids[i], position, velocity, snapshot.remaining_lives[i]);
        }
        self.mortal = snapshot.remaining_lives.iter().any(|life| life.is_finite());
        particles.keep_pressures(self.plan.has(StageKind::DivergenceSolve));
        if particles.keeps_pressures() {
            particles.pressure[..snapshot.pressures.len()].copy_from_slice(&snapshot.pressures);
        }
        particles.carry_densities(self.plan.parameters.density.is_carried());
        if !particles.excess.is_empty() {
            particles.excess[..snapshot.excesses.len()].copy_from_slice(&snapshot.excesses);
        }
        self.last_substep = snapshot.substep_for(&self.plan.parameters);
        particles.begin_histories(self.integrator);
        particles.take_histories(snapshot.histories_for(self.integrator));
        self.particles = particles;
        self.density.clear();
        self.next_tick = snapshot.tick;
        self.time = snapshot.time;
        self.carry = snapshot.carry;
        self.emitted = snapshot.emitted;
        self.next_id = snapshot.next_id;
        self.gravity = snapshot.gravity;
        self.fresh = snapshot.is_start();
        self.exchanges.clone_from(&snapshot.exchanges);
        self.poses.clone_from(&snapshot.poses);
        self.exchanges.resize(self.plan.bodies.len(), [Exchange::default(); 4]);
        Ok(())
    }

    fn reconfigure(&mut self, plan: Plan) -> Result<(), SolverError> {
        let passes = schedule::lower(&plan)?;
        Kernel::new(plan.parameters.kernel, plan.parameters.support_radius)?;
        check_room(self.particles.len, plan.max_particles)?;
        let before = plan.bodies_of(&self.plan);
        self.exchanges = carried_over(&self.exchanges, &before);
        self.poses = plan.poses_from(&self.plan, &self.poses);
        if !plan.parameters.goes_on_from(&self.plan.parameters) {
            self.last_substep = 0.0;
        }
        self.schedule.passes = passes;
        self.plan = plan;
        self.take_plan();
        Ok(())
    }
}
