//! The stages of a substep, shared out in chunks among the threads.

use std::ops::Range;

use freshet_core::integrator::Integrator;
use freshet_core::near_pressure;
use freshet_core::plan::{Parameters, StageKind};
use freshet_core::pressure_solver::PressureSolver;
use freshet_core::wall_method::WallMethod;
use glam::{DVec3, Vec3};

use super::CpuSolver;
use super::answers::Load;
use crate::candidates::Candidates;
use crate::lanes::PADDING;
use crate::near_walls::NearWalls;
use crate::passes::acceleration::Maxima;
use crate::passes::body_contact::Around;
use crate::passes::density::{Compression, Second};
use crate::passes::morris1997::Viscosity;
use crate::passes::sort::Dropped;
use crate::passes::{
    acceleration, body_density, body_drag, body_friction, body_load, body_touch, continuity, density, friction,
    integrate, support, viscosity, wall_collision, wall_density, wall_force, xsph,
};
use crate::samples::SortedSamples;
use crate::simd_kernel::{dispatch, dispatch_viscous};
use crate::tasks::Tasks;
use crate::workspace::Workspace;

impl CpuSolver {
    /// Sorts the particles by cell, then id; what is dead or broken falls out.
    pub(super) fn sort(&mut self) -> Dropped {
        let parameters = &self.plan.parameters;
        let bounds = [parameters.bounds_min, parameters.bounds_max];
        let gone =
            self.sorter.sort(&self.workers, self.arch, &self.plan.grid, bounds, &mut self.particles, &mut self.scratch);
        let padded = self.particles.len + PADDING;
        let solves = self.plan.has(StageKind::DivergenceSolve);
        if solves {
            self.solve.resize(padded);
        }
        if self.plan.has(StageKind::PositionSolve) {
            self.positions.resize(padded, self.plan.parameters.pressure_solver);
        }
        if self.plan.has(StageKind::Xsph) {
            self.drift.iter_mut().for_each(|values| values.resize(padded, 0.0));
        }
        if self.plan.has(StageKind::Support) {
            self.width.resize(padded, 1.0);
        }
        let terms = Some(&mut self.pressure_term).filter(|_| !solves);
        for values in [&mut self.density].into_iter().chain(&mut self.acceleration).chain(terms) {
            values.resize(padded, 0.0);
        }
        gone
    }

    /// Widths of supports.
    pub(super) fn support_stage(&mut self) {
        let parameters = &self.plan.parameters;
        let scale = value_scale(parameters) / parameters.density_calibration;
        let samples = [&self.walls, &self.body_samples.sorted];
        let inputs = support::Inputs {
            arch: self.arch,
            grid: &self.plan.grid,
            starts: &self.sorter.starts,
            particles: &self.particles,
            samples: those_with_samples(&samples),
            fluid_factor: parameters.particle_mass / parameters.rest_density * scale,
            sample_factor: scale,
            widest: parameters.widest_support,
        };
        let tasks = Tasks::new(&self.sorter.chunks, (), &mut *self.width);
        self.workers.share_with(&mut self.workspaces, tasks, |workspace, (chunk, (), width)| {
            dispatch(parameters.kernel, support::Task { inputs, chunk, workspace, width })
        })
    }

    /// Densities, pressure terms and the lists of candidates.
    pub(super) fn density_stage(&mut self) -> Compression {
        // The number of chunks varies by a few: lists that are left over wait for the next substep.
        let lists = self.candidates.len().max(self.sorter.chunks.len());
        self.candidates.resize_with(lists, Candidates::default);
        match self.plan.parameters.density.is_carried() {
            true => self.carried_densities(),
            false => self.summed_densities(),
        }
    }

    /// Densities after the substep before.
    fn carried_densities(&mut self) -> Compression {
        let parameters = &self.plan.parameters;
        let scale = slope_scale(parameters) / parameters.gradient_calibration;
        let samples = [&self.walls, &self.body_samples.sorted];
        let inputs = continuity::Inputs {
            arch: self.arch,
            grid: &self.plan.grid,
            starts: &self.sorter.starts,
            position: &self.particles.position,
            velocity: &self.particles.velocity,
            samples: those_with_samples(&samples),
            fluid_factor: parameters.particle_mass / parameters.rest_density * scale,
            sample_factor: scale,
            // Taken: a state whose stages are found again is no later for it.
            elapsed: std::mem::take(&mut self.last_substep),
            rest_density: parameters.rest_density,
            law: parameters.pressure_law,
        };
        let results = [&mut *self.particles.excess, &mut *self.density, &mut *self.pressure_term];
        let tasks = Tasks::new(&self.sorter.chunks, &mut *self.candidates, results);
        self.workers.share_with(&mut self.workspaces, tasks, |workspace, (chunk, candidates, results)| {
            let [excess, density, pressure_term] = results;
            let task = continuity::Task { inputs, chunk, workspace, candidates, excess, density, pressure_term };
            dispatch(parameters.kernel, task)
        })
    }

    fn summed_densities(&mut self) -> Compression {
        let parameters = &self.plan.parameters;
        let scale = value_scale(parameters) / parameters.density_calibration;
        let (second, seconds) = match parameters.pressure_solver {
            PressureSolver::WeaklyCompressible
            | PressureSolver::PositionBased(_)
            | PressureSolver::PressureCorrected(_)
            | PressureSolver::PressurePoisson(_) => {
                (Second::PressureTerm(parameters.pressure_law), &mut self.pressure_term)
            }
            PressureSolver::DivergenceFree(_) => {
                let gradient = parameters.particle_mass * slope_scale(parameters);
                let calibrations = parameters.density_calibration * parameters.gradient_calibration;
                let factor = gradient * gradient / (calibrations * parameters.rest_density);
                let number_density = parameters.rest_density / parameters.particle_mass;
                let least = parameters.least_diagonal;
                (Second::InverseDiagonal { factor, number_density, least }, &mut self.solve.inverse_diagonal)
            }
        };
        let samples = [&self.walls, &self.body_samples.sorted];
        let inputs = density::Inputs {
            arch: self.arch,
            grid: &self.plan.grid,
            starts: &self.sorter.starts,
            particles: &self.particles,
            samples: those_with_samples(&samples),
            fluid_factor: parameters.particle_mass * scale,
            sample_factor: parameters.rest_density * scale,
            width: self.plan.has(StageKind::Support).then_some(&*self.width),
            second,
            rest_density: parameters.rest_density,
        };
        let results = [&mut *self.density, &mut **seconds];
        let tasks = Tasks::new(&self.sorter.chunks, &mut *self.candidates, results);
        self.workers.share_with(&mut self.workspaces, tasks, |workspace, (chunk, candidates, results)| {
            let [density, second] = results;
            dispatch(parameters.kernel, density::Task { inputs, chunk, workspace, candidates, density, second })
        })
    }

    /// Accelerations, from the candidates of the density stage.
    pub(super) fn acceleration_stage(&mut self) -> Maxima {
        let mut acceleration = std::mem::take(&mut self.acceleration);
        let by_positions = self.plan.has(StageKind::PositionSolve);
        // What pressures do to a position-based fluid is done: none are left.
        let terms = std::mem::take(if by_positions { &mut self.positions.push } else { self.pressure_terms_mut() });
        let maxima = self.accelerate(&terms, &mut acceleration, true);
        *(if by_positions { &mut self.positions.push } else { self.pressure_terms_mut() }) = terms;
        self.acceleration = acceleration;
        maxima
    }

    /// Accelerations by `terms`, `p / rho^2`, and, if asked for, by all else.
    pub(super) fn accelerate(&mut self, terms: &[f32], acceleration: &mut [Vec<f32>; 3], all: bool) -> Maxima {
        let parameters = &self.plan.parameters;
        let scale = slope_scale(parameters) / parameters.gradient_calibration;
        let samples = [&self.walls, &self.body_samples.sorted];
        let h = parameters.smoothing_length;
        let or_none = |factor: f32| if all { factor } else { 0.0 };
        let (depth, of_walls) = parameters.sticking();
        let inputs = acceleration::Inputs {
            arch: self.arch,
            grid: &self.plan.grid,
            starts: &self.sorter.starts,
            particles: &self.particles,
            samples: those_with_samples(&samples),
            density: &self.density,
            pressure_term: terms,
            force: parameters.pressure_force,
            width: self.plan.has(StageKind::Support).then_some(&*self.width),
            fluid_factor: -parameters.particle_mass * scale,
            sample_factor: -parameters.rest_density * scale,
            viscosity: or_none(2.0 * parameters.artificial_viscosity * parameters.sound_speed * h),
            physical: (all && parameters.dynamic_viscosity > 0.0).then(|| Viscosity {
                of_pairs: parameters.pair_viscosity(),
                of_walls,
                depth,
                nearest: 0.25 * parameters.spacing,
            }),
            near_pressure: or_none(
                2.0 * parameters.near_pressure / parameters.rest_density
                    * (near_pressure::NORMALISATION / parameters.pressure_kernel.normalisation()) as f32,
            ),
            tensile: self.tensile.filter(|_| all),
            softening: 0.01 * h * h,
            gravity: if all { self.gravity } else { Vec3::ZERO },
            adds: false,
            maxima: all,
            ahead: if self.plan.has(StageKind::DivergenceSolve) { self.last_substep } else { 0.0 },
        };
        let viscous = (all && parameters.has_own_viscosity_kernel()).then_some(inputs);
        let inputs = match viscous {
            Some(_) => acceleration::Inputs { physical: None, adds: true, ..inputs },
            None => inputs,
        };
        let results = acceleration.each_mut().map(Vec::as_mut_slice);
        let tasks = Tasks::new(&self.sorter.chunks, &mut *self.candidates, results);
        self.workers.share_with(&mut self.workspaces, tasks, |workspace, (chunk, candidates, mut acceleration)| {
            if let Some(inputs) = viscous {
                let acceleration: [&mut [f32]; 3] = acceleration.each_mut().map(|axis| &mut **axis);
                let task = viscosity::Task { inputs, chunk, workspace, candidates, acceleration };
                dispatch_viscous(parameters.viscosity_kernel, task);
            }
            dispatch(
                parameters.pressure_kernel,
                acceleration::Task { inputs, chunk, workspace, candidates, acceleration },
            )
        })
    }

    /// Densities and pressures of the quasi-fluid samples of bodies.
    pub(super) fn body_density_stage(&mut self) {
        share_slots(&mut self.slots, self.body_samples.sorted.len());
        let mut terms = std::mem::take(&mut self.body_samples.sorted.pressure_term);
        let mut workspaces = std::mem::take(&mut self.workspaces);
        let (samples, own) = (&self.body_samples.sorted, self.body_samples.own_densities());
        self.find_quasi_fluid(samples, own, 1.0, &self.slots, &mut workspaces, &mut terms);
        (self.body_samples.sorted.pressure_term, self.workspaces) = (terms, workspaces);
    }

    /// The same of walls; of those with images of the fluid its densities, and how far it is compressed then.
    pub(super) fn wall_density_stage(&mut self) -> Option<Compression> {
        if self.plan.parameters.wall_method == WallMethod::Ghosts {
            return self.image_density();
        }
        let WallMethod::QuasiFluid(walls) = self.plan.parameters.wall_method else { return None };
        share_slots(&mut self.wall_slots, self.walls.len());
        let mut terms = std::mem::take(&mut self.walls.pressure_term);
        let mut workspaces = std::mem::take(&mut self.workspaces);
        let own = &self.plan.boundary.own_densities;
        let weight = walls.relative_density();
        self.find_quasi_fluid(&self.walls, own, weight, &self.wall_slots, &mut workspaces, &mut terms);
        (self.walls.pressure_term, self.workspaces) = (terms, workspaces);
        None
    }

    fn image_density(&mut self) -> Option<Compression> {
        let parameters = &self.plan.parameters;
        let inputs = wall_density::Inputs {
            near: NearWalls { walls: &self.pushing_walls, plan: &self.plan },
            starts: &self.sorter.starts,
            particles: &self.particles,
            kernel: parameters.kernel().ok()?,
            factor: f64::from(parameters.particle_mass / parameters.density_calibration),
            law: parameters.pressure_law,
        };
        let results = [&mut *self.density, &mut *self.pressure_term];
        let tasks = Tasks::new(&self.sorter.chunks, (), results);
        let compression = self.workers.share_with(&mut self.workspaces, tasks, |workspace, (chunk, (), results)| {
            wall_density::wall_density(&inputs, chunk, workspace, results)
        });
        Some(compression)
    }

    /// `p / rho^2` of quasi-fluid samples whose density at rest is so many times that of the fluid.
    fn find_quasi_fluid(
        &self,
        samples: &SortedSamples,
        own: &[f32],
        relative_density: f32,
        slots: &[Range<usize>],
        workspaces: &mut [Workspace],
        terms: &mut Vec<f32>,
    ) {
        let count = samples.len();
        terms.clear();
        terms.resize(count + PADDING, 0.0);
        let parameters = &self.plan.parameters;
        let scale = value_scale(parameters) / parameters.density_calibration;
        let inputs = body_density::Inputs {
            arch: self.arch,
            grid: &self.plan.grid,
            starts: &self.sorter.starts,
            particles: &self.particles,
            samples,
            own,
            factor: parameters.particle_mass * scale / relative_density,
            term_factor: 1.0 / (relative_density * relative_density),
            rest_density: parameters.rest_density,
            law: parameters.pressure_law,
        };
        let tasks = Tasks::new(slots, (), &mut terms[..count]);
        self.workers.share_with(workspaces, tasks, |workspace, (slots, (), pressure_terms)| {
            let task = body_density::Task { inputs, slots: slots.clone(), workspace, pressure_terms };
            dispatch(parameters.kernel, task);
        });
    }

    /// What sticks to bodies: adds to the accelerations, and keeps what bodies get for it.
    pub(super) fn body_drag_stage(&mut self) {
        let parameters = &self.plan.parameters;
        let scale = slope_scale(parameters) / parameters.gradient_calibration;
        let inputs = body_drag::Inputs {
            arch: self.arch,
            around: Around {
                grid: &self.plan.grid,
                starts: &self.sorter.starts,
                particles: &self.particles,
                samples: &self.body_samples,
                lists_before: 1 + usize::from(!self.walls.is_empty()),
            },
            density: &self.density,
            bodies: &self.bodies,
            factor: -parameters.sticking_to_bodies() * parameters.rest_density * scale,
            particle_mass: parameters.particle_mass,
            depth: parameters.boundary_depth,
            nearest: 0.25 * parameters.spacing,
        };
        let lists = self.drags.len().max(self.sorter.chunks.len());
        self.drags.resize_with(lists, Vec::new);
        let results = self.acceleration.each_mut().map(Vec::as_mut_slice);
        let tasks = Tasks::new(&self.sorter.chunks, (&mut *self.candidates, &mut *self.drags), results);
        self.workers.share_with(&mut self.workspaces, tasks, |workspace, (chunk, (candidates, drags), acceleration)| {
            let task = body_drag::Task { inputs, chunk, workspace, candidates, acceleration, drags };
            dispatch_viscous(parameters.viscosity_kernel, task)
        })
    }

    /// Adds the drags to the loads: one after the other in the order of particles and in double precision, whatever the number of threads.
    pub(super) fn add_drags(&mut self) {
        let drags = self.drags.iter().take(self.sorter.chunks.len());
        let mut sums = vec![[DVec3::ZERO; 2]; if drags.len() == 0 { 0 } else { self.loads.len() }];
        for drag in drags.flatten() {
            let [force, torque] = &mut sums[drag.body as usize];
            *force += drag.force.as_dvec3();
            *torque += drag.arm.as_dvec3().cross(drag.force.as_dvec3());
        }
        for (load, [force, torque]) in self.loads.iter_mut().zip(sums) {
            *load = *load + Load { force: force.as_vec3(), torque: torque.as_vec3() };
        }
    }

    /// Force (N) and torque about the centre of mass (N m) of the fluid on each body, in the order of the bodies.
    pub(super) fn body_load_stage(&mut self) {
        let count = self.body_samples.sorted.len();
        share_slots(&mut self.slots, count);
        let parameters = &self.plan.parameters;
        let samples = &self.body_samples.sorted;
        let scale = slope_scale(parameters) / parameters.gradient_calibration;
        let factor = parameters.particle_mass * parameters.rest_density * scale;
        self.sorted_forces.resize(count, Vec3::ZERO);
        self.forces.resize(count, Vec3::ZERO);
        let (arch, grid) = (self.arch, &self.plan.grid);
        let (starts, particles, pressure_term) = (&self.sorter.starts, &self.particles, &self.pressure_term);
        let tasks = Tasks::new(&self.slots, (), &mut *self.sorted_forces);
        self.workers.share_with(&mut self.workspaces, tasks, |workspace, (slots, (), forces)| {
            let slots = slots.clone();
            dispatch(
                parameters.pressure_kernel,
                body_load::Task {
                    arch,
                    grid,
                    starts,
                    particles,
                    pressure_term,
                    samples,
                    slots,
                    workspace,
                    forces,
                    factor,
                },
            );
        });
        for (&source, &force) in samples.source.iter().zip(&self.sorted_forces) {
            self.forces[source as usize] = force;
        }
        // Summed in the samples' own order and in double precision: independent of threads and sorting.
        let mut first = 0;
        self.loads.clear();
        for (planned, body) in self.plan.bodies.iter().zip(&self.bodies) {
            let range = first..first + planned.samples.len();
            first = range.end;
            let (mut force, mut torque) = (DVec3::ZERO, DVec3::ZERO);
            for (on_sample, at) in self.forces[range.clone()].iter().zip(&self.body_samples.positions()[range]) {
                force += on_sample.as_dvec3();
                torque += (*at - body.position).cross(*on_sample).as_dvec3();
            }
            self.loads.push(Load { force: force.as_vec3(), torque: torque.as_vec3() });
        }
    }

    /// Adds what walls push by themselves; the largest of the accelerations beside them.
    pub(super) fn wall_force_stage(&mut self) -> Maxima {
        let near = NearWalls { walls: &self.pushing_walls, plan: &self.plan };
        let parameters = &self.plan.parameters;
        let with_images = parameters.wall_method == WallMethod::Ghosts;
        let images = parameters.kernel().ok().filter(|_| with_images).map(|kernel| wall_force::Pairs {
            starts: &self.sorter.starts,
            density: &self.density,
            pressure_term: &self.pressure_term,
            kernel,
            factor: -f64::from(parameters.particle_mass / parameters.gradient_calibration),
            viscosity: 2.0 * parameters.artificial_viscosity * parameters.sound_speed * parameters.smoothing_length,
            physical: parameters.pair_viscosity(),
            softening: 0.01 * parameters.smoothing_length * parameters.smoothing_length,
        });
        let inputs = wall_force::Inputs { near, particles: &self.particles, images };
        let results = self.acceleration.each_mut().map(Vec::as_mut_slice);
        let tasks = Tasks::new(&self.sorter.chunks, (), results);
        self.workers.share_with(&mut self.workspaces, tasks, |workspace, (chunk, (), acceleration)| {
            wall_force::wall_force(&inputs, chunk, workspace, acceleration)
        })
    }

    /// Puts back what got into walls in the last `dt` seconds.
    pub(super) fn wall_collision_stage(&mut self, dt: f32) {
        let Some(collision) = self.plan.parameters.wall_method.collision() else { return };
        let near = NearWalls { walls: &self.pushing_walls, plan: &self.plan };
        let [positions, velocities] = [&mut self.particles.position, &mut self.particles.velocity];
        let moved = [positions, velocities].map(|values| values.each_mut().map(Vec::as_mut_slice));
        let tasks = Tasks::new(&self.sorter.chunks, (), moved);
        self.workers.share_with(&mut self.workspaces, tasks, |workspace, (_, (), moved)| {
            wall_collision::wall_collision(near, collision, workspace, moved, dt);
        });
    }

    /// Takes what the friction of walls takes in `dt` seconds.
    pub(super) fn friction_stage(&mut self, dt: f32) {
        let parameters = &self.plan.parameters;
        if let WallMethod::SpringDamper(spring) = parameters.wall_method {
            let near = NearWalls { walls: &self.pushing_walls, plan: &self.plan };
            let (particles, spring) = (&self.particles, (spring, parameters.wall_strength));
            let results = self.acceleration.each_mut().map(Vec::as_mut_slice);
            let tasks = Tasks::new(&self.sorter.chunks, (), results);
            self.workers.share_with(&mut self.workspaces, tasks, |workspace, (chunk, (), acceleration)| {
                friction::of_springs(near, spring, particles, (chunk, workspace), acceleration, dt);
            });
            return;
        }
        let scale = slope_scale(parameters) / parameters.gradient_calibration;
        let inputs = friction::Inputs {
            arch: self.arch,
            grid: &self.plan.grid,
            starts: &self.sorter.starts,
            particles: &self.particles,
            walls: &self.walls,
            kinds_of_samples: those_with_samples(&[&self.walls, &self.body_samples.sorted]).len(),
            pressure_term: if self.particles.keeps_pressures() {
                &self.particles.pressure
            } else {
                &self.pressure_term
            },
            factor: -parameters.rest_density * scale,
            dt,
        };
        let results = self.acceleration.each_mut().map(Vec::as_mut_slice);
        let tasks = Tasks::new(&self.sorter.chunks, &mut *self.candidates, results);
        self.workers.share_with(&mut self.workspaces, tasks, |workspace, (chunk, candidates, acceleration)| {
            dispatch(parameters.pressure_kernel, friction::Task { inputs, chunk, workspace, candidates, acceleration })
        })
    }

    /// Takes what the friction of bodies takes in `dt` seconds, and keeps what bodies get for it.
    pub(super) fn body_friction_stage(&mut self, dt: f32) {
        let parameters = &self.plan.parameters;
        let scale = slope_scale(parameters) / parameters.gradient_calibration;
        let inputs = body_friction::Inputs {
            arch: self.arch,
            around: Around {
                grid: &self.plan.grid,
                starts: &self.sorter.starts,
                particles: &self.particles,
                samples: &self.body_samples,
                lists_before: 1 + usize::from(!self.walls.is_empty()),
            },
            planned: &self.plan.bodies,
            bodies: &self.bodies,
            pressure_term: if self.particles.keeps_pressures() {
                &self.particles.pressure
            } else {
                &self.pressure_term
            },
            factor: -parameters.rest_density * scale,
            particle_mass: parameters.particle_mass,
            dt,
        };
        let lists = self.drags.len().max(self.sorter.chunks.len());
        self.drags.resize_with(lists, Vec::new);
        let results = self.acceleration.each_mut().map(Vec::as_mut_slice);
        let tasks = Tasks::new(&self.sorter.chunks, (&mut *self.candidates, &mut *self.drags), results);
        self.workers.share_with(&mut self.workspaces, tasks, |workspace, (chunk, (candidates, drags), acceleration)| {
            let task = body_friction::Task { inputs, chunk, workspace, candidates, acceleration, drags };
            dispatch(parameters.pressure_kernel, task)
        })
    }

    /// Velocities after the substep, and what particles move with besides.
    pub(super) fn xsph_stage(&mut self, dt: f32) {
        let (chunks, particles, acceleration) = (&self.sorter.chunks, &mut self.particles, &self.acceleration);
        match self.plan.parameters.integrator {
            Integrator::SemiImplicitEuler => integrate::accelerate(&self.workers, chunks, particles, acceleration, dt),
            other => integrate::accelerate_by(other, &self.workers, chunks, particles, acceleration, dt),
        }
        let parameters = &self.plan.parameters;
        let scale = value_scale(parameters) / parameters.density_calibration;
        let inputs = xsph::Inputs {
            arch: self.arch,
            grid: &self.plan.grid,
            starts: &self.sorter.starts,
            particles: &self.particles,
            density: &self.density,
            kinds_of_samples: those_with_samples(&[&self.walls, &self.body_samples.sorted]).len(),
            factor: 2.0 * parameters.xsph * parameters.particle_mass * scale,
        };
        let results = self.drift.each_mut().map(Vec::as_mut_slice);
        let tasks = Tasks::new(chunks, &mut *self.candidates, results);
        self.workers.share_with(&mut self.workspaces, tasks, |workspace, (chunk, candidates, drift)| {
            dispatch(parameters.kernel, xsph::Task { inputs, chunk, workspace, candidates, drift })
        })
    }

    /// The same of an incompressible fluid, by the pressures of the last substep: from who touches whom, which its solve needs too.
    pub(super) fn body_touch_stage(&mut self) {
        let parameters = &self.plan.parameters;
        let answers = &mut self.solve.bodies;
        let lists = answers.found.len().max(self.sorter.chunks.len());
        answers.found.resize_with(lists, Vec::new);
        let (arch, grid, number_density) =
            (self.arch, &self.plan.grid, parameters.rest_density / parameters.particle_mass);
        let (starts, particles, samples) = (&self.sorter.starts, &self.particles, &self.body_samples);
        let walls = !self.walls.is_empty();
        let tasks = Tasks::new(&self.sorter.chunks, (&mut *self.candidates, &mut *answers.found), ());
        self.workers.share_with(&mut self.workspaces, tasks, |workspace, (chunk, (candidates, touches), ())| {
            let task = body_touch::Task {
                arch,
                grid,
                starts,
                particles,
                samples,
                walls,
                number_density,
                chunk,
                workspace,
                candidates,
                touches,
            };
            dispatch(parameters.kernel, task);
        });
        answers.take_found(self.sorter.chunks.len(), parameters);
        self.loads.extend(answers.load_by(&self.particles.pressure, self.bodies.len()));
    }

    /// Moves all particles over `dt` seconds, with velocities that are `lead` seconds ahead.
    pub(super) fn integrate_stage(&mut self, dt: f32, lead: f32) {
        if self.plan.has(StageKind::PositionSolve) {
            for (position, way) in self.particles.position.iter_mut().zip(&self.positions.way) {
                for (x, way) in position[..self.particles.len].iter_mut().zip(way) {
                    *x += way;
                }
            }
        }
        let (workers, chunks, periodic) = (&self.workers, &self.sorter.chunks, &self.plan.grid.periodic);
        let (particles, acceleration) = (&mut self.particles, &self.acceleration);
        let drift = self.plan.has(StageKind::Xsph).then_some(&self.drift);
        match self.plan.parameters.integrator {
            Integrator::SemiImplicitEuler => {
                integrate::integrate(workers, chunks, particles, acceleration, drift, periodic, [dt, lead]);
            }
            other => integrate::integrate_by(other, workers, chunks, particles, acceleration, drift, periodic, dt),
        }
        if self.mortal {
            integrate::age(particles, dt);
        }
    }
}

/// Shares the slots of so many samples out among tasks.
fn share_slots(slots: &mut Vec<Range<usize>>, count: usize) {
    slots.clear();
    slots.extend((0..count).step_by(64).map(|first| first..(first + 64).min(count)));
}

/// Walls, bodies, both or neither.
pub(super) fn those_with_samples<'a, 'b>(all: &'b [&'a SortedSamples; 2]) -> &'b [&'a SortedSamples] {
    let [walls, bodies] = all;
    &all[usize::from(walls.is_empty())..2 - usize::from(bodies.is_empty())]
}

/// `A / H^3`, the constant of the kernel's value.
pub(super) fn value_scale(parameters: &Parameters) -> f32 {
    (parameters.kernel.normalisation() / f64::from(parameters.support_radius).powi(3)) as f32
}

/// `A / H^5`, the constant of the derivative over r of the pressure's kernel.
pub(super) fn slope_scale(parameters: &Parameters) -> f32 {
    (parameters.pressure_kernel.normalisation() / f64::from(parameters.support_radius).powi(5)) as f32
}
