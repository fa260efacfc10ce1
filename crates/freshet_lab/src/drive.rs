//! Drives a solver through a scene and keeps account of time and trouble.

use std::time::{Duration, Instant};

use freshet_core::field::{Field, FieldData};
use freshet_core::plan::Plan;
use freshet_core::run::SceneRun;
use freshet_core::solver::{FluidSolver, SolverError};
use freshet_core::step::{BodyInput, StepReport};
use glam::Vec3;

use crate::backend::Backend;
use crate::error::LabError;
use crate::measure::compression::mean_compression;

/// A solver, its clock and what it cost so far.
pub struct Drive {
    solver: Box<dyn FluidSolver>,
    clock: SceneRun,
    bodies: Vec<BodyInput>,
    account: Account,
}

/// What a run cost and whether anything went wrong.
#[derive(Clone, Debug, PartialEq)]
pub struct Account {
    /// Wall time of the stepping alone.
    pub wall: Duration,
    /// Time simulated, s.
    pub simulated: f64,
    /// Substeps made.
    pub substeps: u64,
    /// Sum over substeps of the particles moved.
    pub particle_steps: f64,
    /// Milliseconds of each pass, in the order the solver reports them.
    pub passes: Vec<(String, f64)>,
    /// Smallest substep, s.
    pub smallest_substep: f64,
    /// Time mean of the mean compression, sampled after each tick.
    pub compression: f64,
    /// Largest mean compression of any substep.
    pub worst_mean_compression: f64,
    /// Largest compression of any particle in any substep.
    pub worst_compression: f64,
    /// Smallest time covered over time asked for of any tick.
    pub time_scale: f64,
    /// Particles lost: removed or refused.
    pub lost: u64,
}

impl Default for Account {
    fn default() -> Self {
        Self {
            wall: Duration::ZERO,
            simulated: 0.0,
            substeps: 0,
            particle_steps: 0.0,
            passes: Vec::new(),
            smallest_substep: f64::INFINITY,
            compression: 0.0,
            worst_mean_compression: 0.0,
            worst_compression: f64::NEG_INFINITY,
            time_scale: f64::INFINITY,
            lost: 0,
        }
    }
}

impl Account {
    pub(crate) fn add(&mut self, report: &StepReport, wall: Duration, compression: f64) {
        let before = self.simulated;
        self.wall += wall;
        self.simulated += report.simulated;
        self.substeps += u64::from(report.substeps);
        self.particle_steps += f64::from(report.substeps) * f64::from(report.particles);
        for pass in &report.passes {
            let milliseconds = f64::from(pass.milliseconds);
            match self.passes.iter_mut().find(|known| known.0 == pass.pass) {
                Some(known) => known.1 += milliseconds,
                None => self.passes.push((pass.pass.clone(), milliseconds)),
            }
        }
        if report.substeps > 0 {
            self.smallest_substep = self.smallest_substep.min(f64::from(report.smallest_substep));
        }
        if self.simulated > 0.0 {
            self.compression = (self.compression * before + compression * report.simulated) / self.simulated;
        }
        self.worst_mean_compression = self.worst_mean_compression.max(f64::from(report.mean_compression));
        self.worst_compression = self.worst_compression.max(f64::from(report.max_compression));
        self.time_scale = self.time_scale.min(f64::from(report.time_scale));
        self.lost += u64::from(report.removed) + u64::from(report.refused);
    }

    /// Both together, the one run after the other.
    #[must_use]
    pub fn with(&self, other: &Self) -> Self {
        let simulated = self.simulated + other.simulated;
        let compressed = self.compression * self.simulated + other.compression * other.simulated;
        Self {
            wall: self.wall + other.wall,
            simulated,
            substeps: self.substeps + other.substeps,
            particle_steps: self.particle_steps + other.particle_steps,
            passes: [self.passes.as_slice(), &other.passes].concat(),
            smallest_substep: self.smallest_substep.min(other.smallest_substep),
            compression: if simulated > 0.0 { compressed / simulated } else { 0.0 },
            worst_mean_compression: self.worst_mean_compression.max(other.worst_mean_compression),
            worst_compression: self.worst_compression.max(other.worst_compression),
            time_scale: self.time_scale.min(other.time_scale),
            lost: self.lost + other.lost,
        }
    }

    /// Wall nanoseconds per particle and substep, everything included.
    pub fn nanoseconds_per_particle_step(&self) -> f64 {
        self.wall.as_secs_f64() * 1e9 / self.particle_steps
    }

    /// Nanoseconds per particle and substep of each pass that was timed.
    pub fn nanoseconds_of_passes(&self) -> impl Iterator<Item = (&str, f64)> {
        self.passes.iter().map(|(name, milliseconds)| (name.as_str(), milliseconds * 1e6 / self.particle_steps))
    }

    /// Wall seconds per simulated second.
    pub fn wall_per_simulated(&self) -> f64 {
        self.wall.as_secs_f64() / self.simulated
    }

    /// Mean substep, s.
    pub fn mean_substep(&self) -> f64 {
        self.simulated / self.substeps as f64
    }
}

impl Drive {
    /// Opens a backend for a plan; `bodies` is where the plan's bodies stand.
    pub fn open(
        backend: Backend,
        plan: Plan,
        threads: Option<usize>,
        bodies: Vec<BodyInput>,
    ) -> Result<Self, LabError> {
        Ok(Self::new(backend.open(plan, threads)?, bodies))
    }

    /// Drives a solver that is already there.
    pub fn new(solver: Box<dyn FluidSolver>, bodies: Vec<BodyInput>) -> Self {
        Self { solver, clock: SceneRun::new(), bodies, account: Account::default() }
    }

    /// One tick of `duration` seconds. The density it reads for the compression is not on the clock.
    pub fn tick(&mut self, duration: f64) -> Result<StepReport, LabError> {
        let input = self.clock.next(self.solver.plan(), duration as f32, self.bodies.clone());
        let start = Instant::now();
        let report = self.solver.step(&input)?;
        let wall = start.elapsed();
        self.clock.hear(&report);
        let rest_density = self.solver.plan().parameters.rest_density;
        let compression = mean_compression(&self.scalars(Field::Density)?, rest_density);
        self.account.add(&report, wall, compression);
        Ok(report)
    }

    /// What the run cost so far.
    pub fn account(&self) -> &Account {
        &self.account
    }

    /// The solver.
    pub fn solver(&self) -> &dyn FluidSolver {
        self.solver.as_ref()
    }

    /// Time simulated, s.
    pub fn time(&self) -> f64 {
        self.account.simulated
    }

    /// Positions of all particles, m.
    pub fn positions(&mut self) -> Result<Vec<Vec3>, LabError> {
        self.vectors(Field::Position)
    }

    /// A vector field of all particles, in the order of [`positions`](Self::positions).
    pub fn vectors(&mut self, field: Field) -> Result<Vec<Vec3>, LabError> {
        self.solver.read(field)?.vectors().ok_or_else(|| SolverError::NoSuchField(field.name()).into())
    }

    /// Gives every particle the velocity that belongs to its position.
    pub fn set_velocities(&mut self, velocity: impl Fn(Vec3) -> Vec3) -> Result<(), LabError> {
        let mut snapshot = self.solver.snapshot()?;
        snapshot.velocities = snapshot.positions.iter().map(|&position| velocity(position)).collect();
        Ok(self.solver.restore(&snapshot)?)
    }

    /// A scalar field of all particles, in the order of [`positions`](Self::positions).
    pub fn scalars(&mut self, field: Field) -> Result<Vec<f32>, LabError> {
        self.solver.read(field)?.scalars().ok_or_else(|| SolverError::NoSuchField(field.name()).into())
    }

    /// Any field.
    pub fn read(&mut self, field: Field) -> Result<FieldData, LabError> {
        Ok(self.solver.read(field)?)
    }
}

#[cfg(test)]
mod tests {
    use freshet_core::step::PassTime;

    use super::*;

    fn report(substeps: u32, simulated: f64) -> StepReport {
        StepReport {
            particles: 100,
            substeps,
            simulated,
            smallest_substep: (simulated / f64::from(substeps)) as f32,
            time_scale: 1.0,
            mean_compression: 0.01,
            max_compression: 0.02,
            passes: vec![PassTime { pass: "density".to_owned(), milliseconds: 2.0 }],
            ..StepReport::default()
        }
    }

    #[test]
    fn the_account_adds_up() {
        let mut account = Account::default();
        account.add(&report(10, 0.1), Duration::from_millis(3), 0.02);
        account.add(&report(30, 0.3), Duration::from_millis(5), 0.0);
        assert_eq!(account.substeps, 40);
        assert!((account.nanoseconds_per_particle_step() - 2_000.0).abs() < 1e-6);
        let passes: Vec<_> = account.nanoseconds_of_passes().collect();
        assert_eq!(passes.len(), 1);
        assert!((passes[0].1 - 1_000.0).abs() < 1e-6, "{passes:?}");
        assert!((account.wall_per_simulated() - 0.02).abs() < 1e-9);
        assert!((account.mean_substep() - 0.01).abs() < 1e-9);
        assert!((account.compression - 0.005).abs() < 1e-9, "weighted by time: {}", account.compression);
    }

    #[test]
    fn the_account_keeps_the_worst() {
        let mut account = Account::default();
        account.add(&report(10, 0.1), Duration::ZERO, 0.0);
        account.add(
            &StepReport { time_scale: 0.5, removed: 2, refused: 1, max_compression: 0.5, ..report(100, 0.1) },
            Duration::ZERO,
            0.0,
        );
        assert_eq!(account.time_scale, 0.5);
        assert_eq!(account.lost, 3);
        assert_eq!(account.worst_compression, 0.5);
        assert!((account.smallest_substep - 0.001).abs() < 1e-8);
    }
}
