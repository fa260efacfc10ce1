//! One run.

use std::time::{Duration, Instant};

use freshet_core::plan::Plan;

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

/// Simulates a configuration for `seconds`.
pub fn simulate(
    configuration: Configuration,
    repeat: u16,
    seconds: f64,
    progress: &mut Progress,
) -> Result<Run, LabError> {
    let start = Instant::now();
    let scene = configuration.scene;
    let plan = Plan::new(&scene.scene(configuration.particles))?;
    let (particles, parameters) = (plan.positions.len(), plan.parameters);
    let (solver, hardware) = configuration.backend.open_timed(plan, configuration.threads)?;
    let mut drive = Drive::new(solver, Vec::new());
    let tick = scene.tick();
    let ticks = (seconds / tick).round().max(1.0) as u32;
    let in_opening = (OPENING / tick).round() as u32;
    let mut fronts = Vec::new();
    let mut opening_nanoseconds = f64::NAN;
    for index in 1..=ticks {
        drive.tick(tick)?;
        if index <= in_opening {
            opening_nanoseconds = drive.account().nanoseconds_per_particle_step();
        }
        if scene == BenchScene::Tank && index % in_opening == 0 {
            fronts.extend(front(&drive.positions()?, parameters.spacing));
        }
        progress.at(f64::from(index) / f64::from(ticks));
    }
    let account = drive.account().clone();
    let schedule = drive.solver().schedule();
    Ok(Run {
        configuration,
        repeat,
        hardware,
        particles,
        front: fronts,
        bytes_per_particle: schedule.bytes_per_particle(),
        bytes: schedule.bytes(),
        operations: schedule.operations_per_particle(&parameters),
        moved_bytes: schedule.moved_bytes_per_particle(),
        opening_nanoseconds,
        elapsed: start.elapsed(),
        account,
    })
}
