//! Runs of one size, in turn.

use std::time::{Duration, Instant};

use freshet_core::plan::{Parameters, Plan};

use super::{BenchScene, Configuration};
use crate::backend::Hardware;
use crate::drive::{Account, Drive};
use crate::error::LabError;
use crate::measure::front::front;
use crate::progress::Progress;

/// A finished run.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// What ran.
    pub configuration: Configuration,
    /// Which of the repeats, from 1.
    pub repeat: u16,
    /// What it ran on.
    pub hardware: Hardware,
    /// Particles the scene really has.
    pub particles: usize,
    /// Front of the tank at every tenth of a second, m.
    pub front: Vec<f64>,
    /// Bytes a particle with its grid, from the schedule.
    pub bytes_per_particle: f64,
    /// Bytes of all buffers.
    pub bytes: u64,
    /// Floating-point operations per particle and substep, counted from the schedule.
    pub operations: f64,
    /// Bytes read and written per particle and substep, counted from the schedule.
    pub moved_bytes: f64,
    /// Nanoseconds per particle and substep over the first [`OPENING`] alone.
    pub opening_nanoseconds: f64,
    /// All of it: planning, opening, stepping, reading.
    pub elapsed: Duration,
    /// What the stepping cost.
    pub account: Account,
}

/// The time over which sizes are compared, s: all of them run that long, those of the aims longer.
pub const OPENING: f64 = 0.1;

/// A configuration on its way.
struct Runner {
    configuration: Configuration,
    drive: Drive,
    hardware: Hardware,
    particles: usize,
    parameters: Parameters,
    front: Vec<f64>,
    opening_nanoseconds: f64,
    elapsed: Duration,
}

impl Runner {
    fn open(configuration: Configuration) -> Result<Self, LabError> {
        let start = Instant::now();
        let plan = Plan::new(&configuration.scene.scene(configuration.particles))?;
        let (particles, parameters) = (plan.positions.len(), plan.parameters);
        let (solver, hardware) = configuration.backend.open_timed(plan, configuration.threads)?;
        let drive = Drive::new(solver, Vec::new());
        let (front, opening_nanoseconds, elapsed) = (Vec::new(), f64::NAN, start.elapsed());
        Ok(Self { configuration, drive, hardware, particles, parameters, front, opening_nanoseconds, elapsed })
    }

    /// Makes tick `index`, from 1.
    fn tick(&mut self, index: u32) -> Result<(), LabError> {
        let start = Instant::now();
        let tick = self.configuration.scene.tick();
        let in_opening = (OPENING / tick).round() as u32;
        self.drive.tick(tick)?;
        if index <= in_opening {
            self.opening_nanoseconds = self.drive.account().nanoseconds_per_particle_step();
        }
        if self.configuration.scene == BenchScene::Tank && index.is_multiple_of(in_opening) {
            self.front.extend(front(&self.drive.positions()?, self.parameters.spacing));
        }
        self.elapsed += start.elapsed();
        Ok(())
    }

    fn finish(self, repeat: u16) -> Run {
        let schedule = self.drive.solver().schedule();
        Run {
            configuration: self.configuration,
            repeat,
            hardware: self.hardware,
            particles: self.particles,
            front: self.front,
            bytes_per_particle: schedule.bytes_per_particle(),
            bytes: schedule.bytes(),
            operations: schedule.operations_per_particle(&self.parameters),
            moved_bytes: schedule.moved_bytes_per_particle(),
            opening_nanoseconds: self.opening_nanoseconds,
            elapsed: self.elapsed,
            account: self.drive.account().clone(),
        }
    }
}

/// Simulates configurations of one scene and size for `seconds`, tick by tick in turn, forwards and backwards: a machine
/// whose pace changes from second to second treats them alike.
pub fn simulate(
    configurations: &[Configuration],
    repeat: u16,
    seconds: f64,
    progress: &mut Progress,
) -> Result<Vec<Run>, LabError> {
    let mut runners = configurations.iter().copied().map(Runner::open).collect::<Result<Vec<_>, _>>()?;
    let Some(tick) = configurations.first().map(|first| first.scene.tick()) else {
        return Ok(Vec::new());
    };
    let ticks = (seconds / tick).round().max(1.0) as u32;
    for index in 1..=ticks {
        for runner in &mut runners {
            runner.tick(index)?;
        }
        runners.reverse();
        progress.at(f64::from(index) / f64::from(ticks));
    }
    if !ticks.is_multiple_of(2) {
        runners.reverse();
    }
    Ok(runners.into_iter().map(|runner| runner.finish(repeat)).collect())
}
