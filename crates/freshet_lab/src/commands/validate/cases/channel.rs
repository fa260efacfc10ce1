//! What Poiseuille's and Couette's flow have in common: velocities across the gap at several times.

use freshet_core::field::Field;
use freshet_core::plan::Plan;
use freshet_core::scene::FluidScene;

use super::super::{Job, Level, Trace};
use crate::drive::Drive;
use crate::error::LabError;
use crate::progress::Progress;
use crate::scenes::channel::{GAP, SPEED, kinematic_viscosity};

/// Times at which velocities are compared, `nu t / L^2`: those of Morris, Fox & Zhu 1997, and the steady flow.
const TIMES: [f64; 6] = [0.0225, 0.045, 0.1125, 0.225, 0.45, 1.0];
/// Longest tick, s.
const TICK: f64 = 0.05;

/// Simulates a channel of so many spacings; `exact` is the velocity over [`SPEED`] at `y / L` and `nu t / L^2`.
///
/// The error is the root mean square over particles and times of what the velocity along the channel is off, over the root mean
/// square of the exact one. What moves across the channel counts as being off.
pub fn simulate(
    job: &Job,
    scene: &FluidScene,
    resolution: u32,
    exact: fn(f64, f64) -> f64,
    progress: &mut Progress,
) -> Result<Level, LabError> {
    let plan = Plan::new(scene)?;
    let particles = plan.positions.len();
    let mut drive = Drive::open(job.backend, plan, job.threads.count(), Vec::new())?;
    let (mut off, mut whole, mut traces) = (0.0, 0.0, Vec::new());
    for time in TIMES {
        let end = time * GAP * GAP / kinematic_viscosity();
        let ticks = ((end - drive.time()) / TICK).ceil();
        let duration = (end - drive.time()) / ticks;
        for _ in 0..ticks as u32 {
            drive.tick(duration)?;
            progress.at(drive.time() * kinematic_viscosity() / (GAP * GAP));
        }
        let mut points = Vec::with_capacity(particles);
        for (position, velocity) in drive.positions()?.iter().zip(drive.vectors(Field::Velocity)?) {
            let (y, velocity) = (f64::from(position.y) / GAP, velocity.as_dvec3() / SPEED);
            let wanted = exact(y, time);
            off += velocity.distance_squared(glam::DVec3::X * wanted);
            whole += wanted * wanted;
            points.push((velocity.x, y, wanted));
        }
        traces.push(profile(format!("nu t / L^2 = {time}"), points, resolution));
    }
    let account = drive.account().clone();
    Ok(Level {
        resolution,
        particles,
        error: f64::sqrt(off / whole),
        traces,
        checks: Vec::new(),
        remarks: Vec::new(),
        account,
    })
}

/// Mean velocity in each of as many layers as there are particles across.
fn profile(name: String, points: Vec<(f64, f64, f64)>, layers: u32) -> Trace {
    let mut sums = vec![[0.0; 4]; layers as usize];
    for (velocity, y, wanted) in points {
        let layer = ((y * f64::from(layers)) as usize).min(layers as usize - 1);
        for (sum, value) in sums[layer].iter_mut().zip([1.0, y, velocity, wanted]) {
            *sum += value;
        }
    }
    let filled = sums.into_iter().filter(|sum| sum[0] > 0.0);
    Trace {
        name,
        points: filled.map(|[count, y, velocity, wanted]| (y / count, velocity / count, wanted / count)).collect(),
    }
}
