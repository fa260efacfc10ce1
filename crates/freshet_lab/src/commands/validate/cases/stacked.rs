//! A crate afloat that carries another: together they lie as deep as Archimedes says, level, and stay together.

use glam::Vec3;
use rapier3d::dynamics::RigidBodyBuilder;
use rapier3d::geometry::ColliderBuilder;

use super::super::{Case, Job, Level, Study, Trace};
use crate::afloat::{DIAMETER, TICK, Tank};
use crate::drive::Account;
use crate::error::LabError;
use crate::measure::statistics::mean;
use crate::progress::Progress;
use crate::verdict::{Bound, Check};

/// The case.
pub const CASE: Case = Case {
    name: "stacked",
    about: "a crate 2 D x 2 D x 0.75 D afloat with another on it, by DFSPH, in lockstep and two ticks late: draft, heel, slip; Archimedes",
    run: |job| STUDY.run(job),
};

const STUDY: Study = Study {
    name: "stacked",
    title: "A crate afloat that carries another",
    measure: "error of the draft over D",
    bound: 0.03,
    coarse_bound: Some(0.03),
    smooth: false,
    resolutions: [6, 10, 16],
    quick: &[6],
    axes: ["time (s)", "draft / D"],
    simulate,
};

/// Breadth and height of each, over D: so flat that they float upright, `GM = 0.34 D`.
const CRATE: [f64; 2] = [2.0, 0.75];
/// Density of the lower and the upper one over the water's.
const RATIOS: [f64; 2] = [0.4, 0.2];
/// Time to simulate, s, and the quick form's.
const END: [f64; 2] = [8.0, 2.0];
/// Ticks until rapier hears of an impulse in the second run.
const LATENCY: u64 = 2;

fn simulate(job: &Job, resolution: u32, progress: &mut Progress) -> Result<Level, LabError> {
    let in_time = float(job, resolution, 0, &mut |fraction| progress.at(0.5 * fraction))?;
    let late = float(job, resolution, LATENCY, &mut |fraction| progress.at(0.5 + 0.5 * fraction))?;
    let mut checks = Vec::new();
    for (when, run) in [("in lockstep", &in_time), ("two ticks late", &late)] {
        let slip = format!("{when}: largest way of the upper one from its place on the lower, over D");
        checks.push(Check::new(format!("{when}: largest heel"), run.heel, "degrees", Bound::AtMost(2.0)));
        checks.push(Check::new(slip, run.slip, "", Bound::AtMost(0.02)));
    }
    let error = Bound::Within(-3.0, 3.0);
    checks.push(Check::new("two ticks late: error of the draft over D", late.error * 100.0, "%", error));
    let account = in_time.account.with(&late.account);
    let trace = |name: &str, run: Run| Trace { name: name.to_owned(), points: run.points };
    Ok(Level {
        resolution,
        particles: in_time.particles,
        error: in_time.error.abs(),
        traces: vec![trace("in lockstep", in_time), trace("two ticks late", late)],
        checks,
        remarks: Vec::new(),
        account,
    })
}

/// Two crates that have floated, in the second half of their time.
struct Run {
    /// Of the mean draft, over D.
    error: f64,
    /// The largest heel, degrees.
    heel: f64,
    /// The largest way of the upper one from its place on the lower, over D.
    slip: f64,
    points: Vec<(f64, f64, f64)>,
    particles: usize,
    account: Account,
}

fn float(job: &Job, resolution: u32, latency: u64, progress: &mut dyn FnMut(f64)) -> Result<Run, LabError> {
    let (tank, edge) = (Tank::for_bodies(resolution), f64::from(DIAMETER));
    let [breadth, height] = CRATE.map(|over| over * edge);
    let expected = (RATIOS[0] + RATIOS[1]) * height;
    let foot = f64::from(tank.depth) - expected;
    let half = Vec3::new(breadth as f32, height as f32, breadth as f32) / 2.0;
    let crates = [0, 1].map(|index| {
        let place = Vec3::Y * (foot + (index as f64 + 0.5) * height) as f32;
        let density = 1000.0 * RATIOS[index] as f32;
        let collider = ColliderBuilder::cuboid(half.x, half.y, half.z).density(density);
        (RigidBodyBuilder::dynamic().translation(place), collider)
    });
    let mut afloat = tank.with_bodies(job, "stacked", crates, latency)?;
    let ticks = (END[usize::from(job.quick)] / TICK).round() as u32;
    let (mut points, mut drafts, mut heel, mut slip) = (Vec::new(), Vec::new(), 0.0f64, 0.0f64);
    for tick in 1..=ticks {
        afloat.tick()?;
        let water = afloat.particles()? as f64 * f64::from(tank.spacing).powi(3);
        // The level that the water and the crate's part under it fill.
        let bottom = f64::from(afloat.body(0).translation().y) - 0.5 * height;
        let crate_area = breadth * breadth;
        let draft = (water - bottom * tank.area()) / (tank.area() - crate_area);
        points.push((f64::from(tick) * TICK, draft / edge, expected / edge));
        if 2 * tick > ticks {
            drafts.push(draft);
            let [lower, upper] = [0, 1].map(|index| afloat.body(index));
            let apart = lower.rotation().inverse() * (upper.translation() - lower.translation());
            slip = slip.max(f64::from((apart - Vec3::Y * height as f32).length()) / edge);
            heel = heel.max(f64::from((*lower.rotation() * Vec3::Y).angle_between(Vec3::Y)).to_degrees());
        }
        progress(f64::from(tick) / f64::from(ticks));
    }
    Ok(Run {
        error: (mean(drafts).unwrap_or(f64::NAN) - expected) / edge,
        heel,
        slip,
        points,
        particles: afloat.particles()?,
        account: afloat.account().clone(),
    })
}
