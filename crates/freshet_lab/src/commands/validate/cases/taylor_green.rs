//! Taylor-Green vortices: how fast they decay.

use freshet_core::field::Field;
use freshet_core::plan::Plan;
use glam::Vec3;

use super::super::{Case, Job, Level, Study, Trace};
use crate::drive::Drive;
use crate::error::LabError;
use crate::measure::curve::Curve;
use crate::progress::Progress;
use crate::reference::taylor_green::{decay_rate, velocity};
use crate::scenes::vortices::{EDGE, REYNOLDS, SPEED, scene};

/// The case.
pub const CASE: Case = Case {
    name: "taylor-green",
    about: "decay of a periodic square of vortices at Re 100 against the exact solution of Taylor & Green 1937",
    run: |job| STUDY.run(job),
};

const STUDY: Study = Study {
    name: "taylor-green",
    title: "Taylor-Green vortices at Re 100",
    measure: "error of the decay rate",
    bound: 0.05,
    coarse_bound: Some(0.1),
    smooth: true,
    resolutions: [16, 32, 64],
    quick: &[16, 24],
    axes: ["t U / L", "ln(root mean square velocity / that at the start)"],
    simulate,
};

/// How long the decay is followed, in `L / U`: to 45 % of the velocity.
const END: f64 = 1.0;
/// How long the particles come to rest first, in `L / U`, from disorder. Rows of a lattice resist the shear, as sums over them change
/// while they pass each other, until it breaks up: from a lattice the vortices decayed up to four times too fast.
const REST: f64 = 0.3;
/// Duration of a tick in `L / U`.
const TICK: f64 = 0.02;

fn simulate(job: &Job, resolution: u32, progress: &mut Progress) -> Result<Level, LabError> {
    let mut plan = Plan::new(&scene(resolution))?;
    let particles = plan.positions.len();
    disarrange(&mut plan);
    let mut drive = Drive::open(job.backend, plan, job.threads.count(), Vec::new())?;
    let ticks = (REST / TICK).round() as u32;
    for tick in 1..=ticks {
        drive.tick(TICK * EDGE / SPEED)?;
        drive.set_velocities(|_| Vec3::ZERO)?;
        progress.at(REST / (REST + END) * f64::from(tick) / f64::from(ticks));
    }
    let begin = drive.time();
    drive.set_velocities(|position| {
        let [u, v] = velocity(f64::from(position.x) / EDGE, f64::from(position.y) / EDGE);
        (SPEED as f32) * Vec3::new(u as f32, v as f32, 0.0)
    })?;
    let start = root_mean_square(&drive.vectors(Field::Velocity)?);
    let mut decay: Curve = [(0.0, 0.0)].into_iter().collect();
    let ticks = (END / TICK).round() as u32;
    for tick in 1..=ticks {
        drive.tick(TICK * EDGE / SPEED)?;
        let now = root_mean_square(&drive.vectors(Field::Velocity)?);
        decay.push((drive.time() - begin) * SPEED / EDGE, (now / start).ln());
        progress.at((REST + END * f64::from(tick) / f64::from(ticks)) / (REST + END));
    }
    let wanted = decay_rate(REYNOLDS);
    let points = decay.samples().iter().map(|&(time, value)| (time, value, -wanted * time)).collect();
    let traces = vec![Trace { name: "velocity".to_owned(), points }];
    let error = (-slope(decay.samples()) / wanted - 1.0).abs();
    Ok(Level {
        resolution,
        particles,
        error,
        traces,
        checks: Vec::new(),
        remarks: Vec::new(),
        account: drive.account().clone(),
    })
}

/// Moves every particle by up to a spacing along each axis, the same way in every run: by less it finds back to its place in the
/// lattice.
fn disarrange(plan: &mut Plan) {
    let spacing = plan.parameters.spacing;
    let mut state = 1u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1u64 << 24) as f32 - 0.5
    };
    for position in &mut plan.positions {
        let way = Vec3::new(random(), random(), random());
        *position = plan.grid.periodic.wrap(*position + 2.0 * spacing * way);
    }
}

fn root_mean_square(velocities: &[Vec3]) -> f64 {
    let sum: f64 = velocities.iter().map(|velocity| velocity.as_dvec3().length_squared()).sum();
    (sum / velocities.len() as f64).sqrt()
}

/// Slope of the straight line that fits best.
fn slope(points: &[(f64, f64)]) -> f64 {
    let count = points.len() as f64;
    let mean = |value: fn(&(f64, f64)) -> f64| points.iter().map(value).sum::<f64>() / count;
    let (x, y) = (mean(|point| point.0), mean(|point| point.1));
    let products: f64 = points.iter().map(|point| (point.0 - x) * (point.1 - y)).sum();
    products / points.iter().map(|point| (point.0 - x).powi(2)).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_of_a_line_is_its_own() {
        assert!((slope(&[(0.0, 1.0), (1.0, -1.0), (3.0, -5.0)]) + 2.0).abs() < 1e-12);
    }
}
