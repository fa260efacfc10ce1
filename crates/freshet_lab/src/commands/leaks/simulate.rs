//! Runs a trial and counts what went through.

use freshet_core::field::Field;
use freshet_core::plan::Plan;
use freshet_core::sampling::wall_layer::WallLayer;
use freshet_core::scene::{Boundary, BoundaryShape, FluidSide};
use freshet_core::solver::FluidSolver;
use freshet_core::step::{BodyInput, Command, NewParticles, StepInput};
use glam::{Quat, Vec3};

use super::trials::{SPACING, Trial};
use crate::backend::Backend;
use crate::error::LabError;
use crate::method::Method;
use crate::progress::Progress;

/// Shots that fly at the same time: few enough that they rarely meet.
const SALVO: usize = 200;

/// How long they fly, s.
const FLIGHT: f64 = 0.06;

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// What happened.
    pub what: String,
    /// How fast.
    pub pace: String,
    /// Where.
    pub backend: Backend,
    /// How.
    pub method: Method,
    /// Particles.
    pub particles: usize,
    /// Those that went through a wall, or are where no fluid may be.
    pub leaks: usize,
    /// Those that the solver removed.
    pub removed: u32,
    /// How far one got into a wall, m, where that can be told.
    pub deepest: f32,
}

/// Runs a trial.
pub fn simulate(
    trial: &Trial,
    backend: Backend,
    method: Method,
    threads: Option<usize>,
    progress: &mut Progress,
) -> Result<Found, LabError> {
    let plan = Plan::new(&method.on(trial.scene.clone()))?;
    let limit = plan.parameters.boundary_depth;
    let mut solver = backend.open(plan, threads)?;
    let mut watch = Watch::new(trial, limit);
    let run = Found {
        what: trial.what.clone(),
        pace: trial.pace.clone(),
        backend,
        method,
        particles: trial.shots.max(solver.plan().positions.len()),
        leaks: 0,
        removed: 0,
        deepest: 0.0,
    };
    let removed = if trial.shots > 0 {
        fire(trial, solver.as_mut(), &mut watch, progress)?
    } else {
        flow(trial, solver.as_mut(), &mut watch, progress)?
    };
    Ok(Found { leaks: watch.leaked.len(), removed, deepest: watch.deepest, ..run })
}

/// Fluid, and perhaps a body that moves.
fn flow(
    trial: &Trial,
    solver: &mut dyn FluidSolver,
    watch: &mut Watch,
    progress: &mut Progress,
) -> Result<u32, LabError> {
    let ticks = (trial.seconds / trial.tick).ceil() as u64;
    let duration = trial.tick as f32;
    let mut removed = 0;
    for tick in 0..ticks {
        let [begin, end] = [tick, tick + 1].map(|tick| trial.pose(tick as f64 * trial.tick));
        let bodies = trial.scene.bodies.iter().map(|_| moving(begin, end, duration)).collect();
        let report = solver.step(&StepInput { tick, duration, bodies, ..StepInput::default() })?;
        removed += report.removed;
        watch.look(solver, end)?;
        progress.at((tick + 1) as f64 / ticks as f64);
    }
    Ok(removed)
}

/// Salvos of single particles.
fn fire(
    trial: &Trial,
    solver: &mut dyn FluidSolver,
    watch: &mut Watch,
    progress: &mut Progress,
) -> Result<u32, LabError> {
    let mut aim = Aim { wall: &trial.scene.boundaries[0], layer: trial.scene.wall_layer()?, state: 1 };
    let (mut tick, mut removed, mut fired) = (0, 0, 0);
    let flight = (FLIGHT / trial.tick).ceil() as u64;
    while fired < trial.shots {
        let (mut positions, mut velocities): (Vec<Vec3>, Vec<Vec3>) = Default::default();
        while positions.len() < SALVO.min(trial.shots - fired) {
            let (position, velocity) = aim.shot(trial.speed);
            // Particles in one place would throw each other away faster than they are fired.
            if positions.iter().all(|other| other.distance(position) > SPACING) {
                positions.push(position);
                velocities.push(velocity);
            }
        }
        fired += positions.len();
        let lifetime = (flight as f64 * trial.tick - 1e-4) as f32;
        let mut commands = vec![Command::Spawn(NewParticles { positions, velocities, lifetime, at: None })];
        for _ in 0..flight {
            let commands = std::mem::take(&mut commands);
            let duration = trial.tick as f32;
            let report = solver.step(&StepInput { tick, duration, commands, ..StepInput::default() })?;
            removed += report.removed;
            watch.look(solver, (Vec3::ZERO, Quat::IDENTITY))?;
            tick += 1;
        }
        progress.at(fired as f64 / trial.shots as f64);
    }
    Ok(removed)
}

impl Trial {
    fn pose(&self, time: f64) -> (Vec3, Quat) {
        self.motion.as_ref().map_or((Vec3::ZERO, Quat::IDENTITY), |motion| motion(time))
    }
}

/// A body that nothing stops, on its way between two poses in so many seconds.
fn moving((from, before): (Vec3, Quat), (to, after): (Vec3, Quat), duration: f32) -> BodyInput {
    let turn = (after * before.conjugate()).normalize();
    let turn = if turn.w < 0.0 { -turn } else { turn };
    BodyInput {
        position: from,
        rotation: before,
        linear_velocity: (to - from) / duration,
        angular_velocity: turn.to_scaled_axis() / duration,
        free: false,
        ..BodyInput::default()
    }
}

/// Follows particles by their ids.
///
/// Not by core's [`LeakWatch`](freshet_core::leaks::LeakWatch), which apps count with: this is told by formulas of its own (the gates) where walls are, of
/// bodies that have samples and no shape too, and says how deep a particle got.
struct Watch<'a> {
    trial: &'a Trial,
    /// Deeper in a wall than its samples lie, a particle is through, m.
    limit: f32,
    /// Where those were before that live, by id, in the frame of the body.
    before: Vec<Option<Vec3>>,
    leaked: Vec<u32>,
    deepest: f32,
}

impl<'a> Watch<'a> {
    fn new(trial: &'a Trial, limit: f32) -> Self {
        Self { trial, limit, before: Vec::new(), leaked: Vec::new(), deepest: 0.0 }
    }

    fn look(&mut self, solver: &mut dyn FluidSolver, (place, turn): (Vec3, Quat)) -> Result<(), LabError> {
        let ids = solver.read(Field::Id)?.integers().unwrap_or_default();
        let positions = solver.read(Field::Position)?.vectors().unwrap_or_default();
        let count = ids.iter().max().map_or(0, |id| *id as usize + 1);
        let mut now = vec![None; count];
        for (&id, &position) in ids.iter().zip(&positions) {
            let local = turn.conjugate() * (position - place);
            now[id as usize] = Some(local);
            let before = self.before.get(id as usize).copied().flatten();
            let crossed = before.is_some_and(|before| self.is_crossed(before, local));
            if (crossed || self.is_inside(position)) && !self.leaked.contains(&id) {
                self.leaked.push(id);
            }
        }
        self.before = now;
        Ok(())
    }

    /// Whether a way goes through a gate, or from one side of a sheet to the other.
    fn is_crossed(&self, from: Vec3, to: Vec3) -> bool {
        let through_sheet = |wall: &Boundary| match wall.shape {
            BoundaryShape::Sphere { radius, fluid: FluidSide::Both } => {
                (from.length() < radius) != (to.length() < radius)
            }
            BoundaryShape::Plane { half_extents: [x, z] } => super::gate::Gate::Rectangle { half_extents: [x, z] }
                .is_crossed(from + self.limit * Vec3::Y, to + self.limit * Vec3::Y),
            _ => false,
        };
        self.trial.gates.iter().any(|gate| gate.is_crossed(from, to))
            || self.trial.shots > 0 && self.trial.scene.boundaries.iter().any(through_sheet)
    }

    /// Whether a particle is deeper in a wall than its samples; keeps the greatest depth.
    fn is_inside(&mut self, position: Vec3) -> bool {
        let walls = &self.trial.scene.boundaries;
        if !walls.iter().any(|wall| wall.is_on_wrong_side(position, self.deepest)) {
            return false;
        }
        // It is deeper than any before: how deep, to a hundredth of a spacing.
        let step = 0.01 * SPACING;
        while self.deepest < 2.0 * SPACING && walls.iter().any(|wall| wall.is_on_wrong_side(position, self.deepest)) {
            self.deepest += step;
        }
        walls.iter().any(|wall| wall.is_on_wrong_side(position, self.limit))
    }
}

/// Chooses where shots come from.
struct Aim<'a> {
    wall: &'a Boundary,
    layer: WallLayer,
    state: u64,
}

impl Aim<'_> {
    /// Uniform, -1 to 1.
    fn random(&mut self) -> f32 {
        self.state = self.state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.state >> 40) as f32 / (1u64 << 23) as f32 - 1.0
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.random(), self.random(), self.random())
    }

    /// Position, two to four spacings off the wall, and velocity, up to 60 degrees off its normal.
    fn shot(&mut self, speed: f32) -> (Vec3, Vec3) {
        let solids = self.wall.solids(&self.layer);
        loop {
            let from = self.vector() * 1.3;
            let nearest = solids
                .iter()
                .map(|solid| (solid.shape.distance(solid.rotation.conjugate() * (from - solid.center)), solid.rotation))
                .min_by(|(a, _), (b, _)| a.0.total_cmp(&b.0));
            let Some(((distance, normal), rotation)) = nearest else { continue };
            let behind = matches!(self.wall.shape, BoundaryShape::Plane { .. } | BoundaryShape::HeightField { .. })
                && normal.y < 0.2;
            // Beside a rectangle there is nothing to hit.
            let beside = match self.wall.shape {
                BoundaryShape::Plane { half_extents: [x, z] } | BoundaryShape::HalfSpace { half_extents: [x, z] } => {
                    from.x.abs() > x - 0.4 || from.z.abs() > z - 0.4
                }
                BoundaryShape::HeightField { .. } => from.x.abs().max(from.z.abs()) > 0.6,
                _ => false,
            };
            if !(2.0 * SPACING..4.0 * SPACING).contains(&distance)
                || behind
                || beside
                || self.wall.is_on_wrong_side(from, 0.0)
            {
                continue;
            }
            let across = self.vector().reject_from_normalized(normal).normalize_or_zero();
            let slant = (0.5 * (self.random() + 1.0)) * 60f32.to_radians();
            return (from, rotation * (across * slant.sin() - normal * slant.cos()) * speed);
        }
    }
}
