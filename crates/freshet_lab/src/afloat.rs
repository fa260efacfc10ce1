//! Rapier bodies in a tank of water, tick by tick, with reports as late as asked for.

use std::collections::VecDeque;
use std::time::Instant;

use clap::ValueEnum;
use freshet_core::field::Field;
use freshet_core::plan::Plan;
use freshet_core::run::SceneRun;
use freshet_core::scene::{Boundary, FluidScene, Volume};
use freshet_core::solver::{FluidSolver, SolverError};
use freshet_core::step::{Impulse, StepReport};
use freshet_rapier::{Coupling, RapierView, body_from_rigid_body, quasi_fluid_from_rigid_body};
use glam::{DVec3, Vec3};
use rapier3d::dynamics::{RigidBody, RigidBodyBuilder, RigidBodyHandle, RigidBodyType};
use rapier3d::geometry::ColliderBuilder;
use rapier3d::pipeline::PhysicsWorld;

use crate::commands::validate::Job;
use crate::drive::Account;
use crate::error::LabError;
use crate::measure::column::surface_level;
use crate::method::Method;
use crate::scenes::GRAVITY;

/// Duration of a tick, s.
pub const TICK: f64 = 1.0 / 60.0;
/// Diameter of the bodies, D, m.
pub const DIAMETER: f32 = 0.3;

/// How bodies are in a fluid: value of `--bodies`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum BodyMethod {
    /// One weighted layer of samples, by DFSPH.
    #[default]
    DivergenceFree,
    /// One weighted layer of samples, in a weakly compressible fluid.
    WeaklyCompressible,
    /// Three layers of quasi-fluid, in a weakly compressible fluid.
    QuasiFluid,
}

impl BodyMethod {
    /// What is added to the names of files.
    pub fn suffix(self) -> &'static str {
        match self {
            Self::DivergenceFree => "",
            Self::WeaklyCompressible => "_wcsph",
            Self::QuasiFluid => "_quasi_fluid",
        }
    }

    /// The option that asks for it, with a space before; nothing for the default.
    pub fn option(self) -> String {
        let name = self.to_possible_value().filter(|_| self != Self::default());
        name.map_or_else(String::new, |name| format!(" --bodies {}", name.get_name()))
    }
}

/// An open tank around the origin, its floor at y = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tank {
    /// Along x and z, m.
    pub floor: [f32; 2],
    /// Of the water, m.
    pub depth: f32,
    /// Of its particles, m.
    pub spacing: f32,
}

impl Tank {
    /// Four diameters wide and three deep, with so many particles to a diameter.
    pub fn for_bodies(resolution: u32) -> Self {
        Self { floor: [4.0 * DIAMETER; 2], depth: 3.0 * DIAMETER, spacing: DIAMETER / resolution as f32 }
    }

    fn height(&self) -> f32 {
        self.depth + 2.0 * DIAMETER
    }

    /// Of the floor, m2.
    pub fn area(&self) -> f64 {
        f64::from(self.floor[0]) * f64::from(self.floor[1])
    }

    /// Water in it, by DFSPH with the default settings.
    pub fn scene(&self, name: &str) -> FluidScene {
        let [x, z] = self.floor;
        Method::DivergenceFree.on(FluidScene {
            name: name.to_owned(),
            volumes: vec![Volume::block(Vec3::new(x, self.depth, z) / 2.0, Vec3::Y * self.depth / 2.0)],
            boundaries: vec![Boundary::open_box(Vec3::new(x, self.height(), z), Vec3::Y * self.height() / 2.0)],
            ..FluidScene::with_spacing(self.spacing)
        })
    }

    /// Rapier's world with floor and sides, a quarter of a metre thick.
    pub fn world(&self) -> PhysicsWorld {
        let mut world = PhysicsWorld::new();
        world.gravity = Vec3::new(0.0, -GRAVITY as f32, 0.0);
        world.integration_parameters.dt = TICK as f32;
        let ([x, z], thick) = (self.floor.map(|edge| edge / 2.0), 0.125);
        let mut wall = |half_extents: Vec3, center: Vec3| {
            let collider = ColliderBuilder::cuboid(half_extents.x, half_extents.y, half_extents.z).translation(center);
            world.insert_collider(collider, None);
        };
        wall(Vec3::new(x, thick, z), Vec3::Y * -thick);
        let (half, middle) = (self.height() / 2.0, Vec3::Y * self.height() / 2.0);
        for side in [-1.0, 1.0] {
            wall(Vec3::new(thick, half, z), middle + Vec3::X * side * (x + thick));
            wall(Vec3::new(x, half, thick), middle + Vec3::Z * side * (z + thick));
        }
        world
    }
}

impl Tank {
    /// Its water with bodies in it, each of one collider, in the way that the job says; rapier hears of impulses `latency` ticks late.
    pub fn with_bodies(
        &self,
        job: &Job,
        name: &str,
        bodies: impl IntoIterator<Item = (RigidBodyBuilder, ColliderBuilder)>,
        latency: u64,
    ) -> Result<Afloat, LabError> {
        let mut world = self.world();
        // Bodies are measured as they lie, awake.
        let insert =
            |(body, collider): (RigidBodyBuilder, ColliderBuilder)| world.insert(body.can_sleep(false), collider).0;
        let handles: Vec<RigidBodyHandle> = bodies.into_iter().map(insert).collect();
        Afloat::open(job, self.scene(name), world, &handles, latency)
    }
}

/// A solver and a world, coupled.
pub struct Afloat {
    solver: Box<dyn FluidSolver>,
    /// Rapier's.
    pub world: PhysicsWorld,
    bodies: Vec<RigidBodyHandle>,
    coupling: Coupling,
    clock: SceneRun,
    late: VecDeque<StepReport>,
    latency: u64,
    ticks: u64,
    /// Samples of each body that the fluid reached in the last tick.
    wetted: Vec<u32>,
    account: Account,
}

impl Afloat {
    /// A scene with these bodies of a world in it, in the way that the job says. Rapier hears of impulses `latency` ticks late, 0 to 3; 0 is lockstep.
    pub fn open(
        job: &Job,
        mut scene: FluidScene,
        world: PhysicsWorld,
        bodies: &[RigidBodyHandle],
        latency: u64,
    ) -> Result<Self, LabError> {
        if job.bodies != BodyMethod::DivergenceFree {
            scene = Method::WeaklyCompressible.on(scene);
        }
        let sample = match job.bodies {
            BodyMethod::QuasiFluid => quasi_fluid_from_rigid_body,
            _ => body_from_rigid_body,
        };
        let layer = scene.wall_layer()?;
        for (index, &handle) in bodies.iter().enumerate() {
            let body = sample(&format!("body {index}"), &world.bodies[handle], &world.colliders, &layer);
            scene.bodies.push(body.map_err(refused)?);
        }
        let solver = job.backend.open(Plan::new(&scene)?, job.threads.count())?;
        Ok(Self {
            solver,
            world,
            bodies: bodies.to_vec(),
            coupling: Coupling::new(bodies.iter().copied(), 0),
            clock: SceneRun::new(),
            late: VecDeque::new(),
            latency: if job.lockstep { 0 } else { latency },
            ticks: 0,
            wetted: Vec::new(),
            account: Account::default(),
        })
    }

    /// A tick of both. Returns what the fluid gave to each body, in their order.
    pub fn tick(&mut self) -> Result<Vec<Impulse>, LabError> {
        let (start, tick) = (Instant::now(), self.ticks);
        self.ticks += 1;
        self.receive(tick)?;
        let bodies = self.coupling.begin_tick(tick, &RapierView::from(&self.world)).map_err(refused)?;
        let report = self.solver.step(&self.clock.next(self.solver.plan(), TICK as f32, bodies))?;
        self.clock.hear(&report);
        let (given, spent, compression) = (report.bodies.clone(), start.elapsed(), report.mean_compression);
        self.wetted.clone_from(&report.wetted);
        self.account.add(&report, spent, compression.into());
        self.late.push_back(report);
        self.receive(tick)?;
        self.coupling.apply_forecast(&mut self.world.bodies).map_err(refused)?;
        self.world.step();
        self.coupling.complete(&mut self.world.bodies).map_err(refused)?;
        Ok(given)
    }

    /// Hands over the reports that are old enough.
    fn receive(&mut self, tick: u64) -> Result<(), LabError> {
        let latency = self.latency;
        while let Some(report) = self.late.pop_front_if(|report| report.tick + latency <= tick) {
            self.coupling.receive(&report, &mut self.world.bodies).map_err(refused)?;
        }
        Ok(())
    }

    /// A body, as rapier has it.
    pub fn body(&self, index: usize) -> &RigidBody {
        &self.world.bodies[self.bodies[index]]
    }

    /// From the next tick on rapier hears of impulses so many ticks late, 0 to 3, unless the job says in lockstep.
    pub fn set_latency(&mut self, job: &Job, latency: u64) {
        self.latency = if job.lockstep { 0 } else { latency };
    }

    /// Share of a body's samples that the fluid reached in the last tick.
    pub fn wetted(&self, index: usize) -> f64 {
        let wetted = self.wetted.get(index).copied().unwrap_or(0);
        f64::from(wetted) / self.solver.plan().bodies[index].samples.len().max(1) as f64
    }

    /// Momentum of the fluid, kg m/s.
    pub fn momentum_of_fluid(&mut self) -> Result<DVec3, LabError> {
        let mass = f64::from(self.solver.plan().parameters.particle_mass);
        let velocities = self.vectors(Field::Velocity)?;
        Ok(mass * velocities.into_iter().map(Vec3::as_dvec3).sum::<DVec3>())
    }

    /// Momentum of all bodies as rapier has them, kg m/s. What late impulses lack of theirs is not in it.
    pub fn momentum_of_bodies(&self) -> DVec3 {
        let momentum = |body: &RigidBody| f64::from(body.mass()) * body.linvel().as_dvec3();
        (0..self.bodies.len()).map(|index| momentum(self.body(index))).sum()
    }

    /// Lets go of a body that was fixed.
    pub fn release(&mut self, index: usize) {
        let PhysicsWorld { bodies, colliders, .. } = &mut self.world;
        let body = &mut bodies[self.bodies[index]];
        body.set_body_type(RigidBodyType::Dynamic, true);
        // Rapier does this in its next step; the coupling asks before that.
        body.recompute_mass_properties_from_colliders(colliders);
    }

    /// Gives all colliders of a body this density, kg/m3.
    pub fn set_density(&mut self, index: usize, density: f32) {
        let PhysicsWorld { bodies, colliders, .. } = &mut self.world;
        let body = &mut bodies[self.bodies[index]];
        for &collider in body.colliders() {
            if let Some(collider) = colliders.get_mut(collider) {
                collider.set_density(density);
            }
        }
        // Rapier does this in its next step; the coupling asks before that.
        body.recompute_mass_properties_from_colliders(colliders);
    }

    /// Simulated time, s.
    pub fn time(&self) -> f64 {
        self.account.simulated
    }

    /// What it cost so far.
    pub fn account(&self) -> &Account {
        &self.account
    }

    /// A scalar field of all particles.
    pub fn scalars(&mut self, field: Field) -> Result<Vec<f32>, LabError> {
        self.solver.read(field)?.scalars().ok_or_else(|| SolverError::NoSuchField(field.name()).into())
    }

    /// Particles there are.
    pub fn particles(&mut self) -> Result<usize, LabError> {
        Ok(self.positions()?.len())
    }

    /// Where they are, m.
    pub fn positions(&mut self) -> Result<Vec<Vec3>, LabError> {
        self.vectors(Field::Position)
    }

    fn vectors(&mut self, field: Field) -> Result<Vec<Vec3>, LabError> {
        self.solver.read(field)?.vectors().ok_or_else(|| SolverError::NoSuchField(field.name()).into())
    }

    /// Level of the water in a tank farther from the axis than `clear` m.
    pub fn open_surface(&mut self, tank: &Tank, clear: f32) -> Result<f64, LabError> {
        let positions = self.positions()?;
        let away: Vec<Vec3> = positions.into_iter().filter(|position| position.with_y(0.0).length() >= clear).collect();
        let area = tank.area() - std::f64::consts::PI * f64::from(clear * clear);
        let per_layer = (area / f64::from(tank.spacing).powi(2)).round() as usize;
        let missing = || LabError::Measure { what: "the surface level", reason: "particles are missing".to_owned() };
        surface_level(&away, per_layer, tank.spacing).ok_or_else(missing)
    }
}

fn refused(error: impl std::fmt::Display) -> LabError {
    LabError::Measure { what: "the bodies", reason: error.to_string() }
}
