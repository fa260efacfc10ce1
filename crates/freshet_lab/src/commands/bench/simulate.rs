//! One run of the tank.

use freshet_core::plan::Plan;

use super::Configuration;
use crate::drive::{Account, Drive};
use crate::error::LabError;
use crate::measure::front::front;
use crate::progress::Progress;
use crate::scenes::tank;

/// A finished run.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// What ran.
    pub configuration: Configuration,
    /// Which of the repeats, from 1.
    pub repeat: u16,
    /// Front at every tenth of a second, m.
    pub front: Vec<f64>,
    /// Bytes a particle with its grid, from the schedule.
    pub bytes_per_particle: f64,
    /// Bytes of all buffers.
    pub bytes: u64,
    /// What it cost.
    pub account: Account,
}

/// Ticks in a tenth of a second: 60 a second, as a game asks for them.
const TICKS_PER_TENTH: u32 = 6;

/// Simulates the tank for `seconds`.
pub fn simulate(
    configuration: Configuration,
    repeat: u16,
    seconds: f64,
    progress: &mut Progress,
) -> Result<Run, LabError> {
    let plan = Plan::new(&tank::scene(configuration.particles))?;
    let spacing = plan.parameters.spacing;
    let solver = configuration.backend.open_timed(plan, configuration.threads)?;
    let mut drive = Drive::new(solver, Vec::new());
    let tick = 0.1 / f64::from(TICKS_PER_TENTH);
    let ticks = (seconds / tick).round().max(1.0) as u32;
    let mut fronts = Vec::new();
    for index in 1..=ticks {
        drive.tick(tick)?;
        if index % TICKS_PER_TENTH == 0 {
            fronts.extend(front(&drive.positions()?, spacing));
        }
        progress.at(f64::from(index) / f64::from(ticks));
    }
    let (bytes_per_particle, bytes) = {
        let schedule = drive.solver().schedule();
        (schedule.bytes_per_particle(), schedule.bytes())
    };
    Ok(Run { configuration, repeat, front: fronts, bytes_per_particle, bytes, account: drive.account().clone() })
}
