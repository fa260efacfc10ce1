//! Freshet as a peer among peers: the tank with default settings, or with those of a fidelity.

use freshet_core::plan::Plan;
use freshet_core::scene::FluidScene;

use super::run::{FRAME_INTERVAL, Finished, Frame, Kept, Task};
use crate::backend::Backend;
use crate::drive::Drive;
use crate::error::LabError;
use crate::progress::Progress;

/// Ticks in a frame.
const TICKS: u32 = 3;

/// Runs the tank as the scene has it.
pub fn run(task: &Task, scene: &FluidScene, backend: Backend, progress: &mut Progress) -> Result<Finished, LabError> {
    let plan = Plan::new(scene)?;
    let threads = (backend == Backend::Cpu).then_some(task.threads);
    let mut drive = Drive::new(backend.open(plan, threads)?, Vec::new());
    let mut frames = Vec::new();
    for frame in 1..=task.frames() {
        for _ in 0..TICKS {
            drive.tick(FRAME_INTERVAL / f64::from(TICKS))?;
        }
        frames.push(Frame { time: f64::from(frame) * FRAME_INTERVAL, positions: drive.positions()? });
        progress.at(f64::from(frame) / f64::from(task.frames()));
    }
    let account = drive.account();
    let kept = Some(Kept { lost: account.lost, time_scale: account.time_scale });
    Ok(Finished { wall: account.wall, steps: account.substeps, frames, kept })
}
