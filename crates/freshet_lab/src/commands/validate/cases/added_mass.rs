//! A ball let go under water: how fast it begins to move, against potential theory.
//!
//! What is let go has to be in water that is still, and nothing may be left in the water of how it was held. Particles under pressure are a soft
//! solid: around a ball that is fixed while the water settles about it (a lattice leaves a gap of some tenths of a spacing around what was cut out of
//! it) they go on hanging on to it, by 7 % of what it displaces at D/d = 6, for as long as it is fixed. That is half as much again as the error that
//! is allowed of what a ball of half the water's density begins to move with, and says nothing about how the fluid answers. So the ball weighs as
//! much as water until it is let go, goes down with the water, and then has the density of the case. Held balls are measured apart, by the force on
//! them.
//!
//! The same solid pushes back when the ball has gone some hundredths of a spacing: what counts is the first tick.

use glam::Vec3;
use rapier3d::dynamics::RigidBodyBuilder;
use rapier3d::geometry::ColliderBuilder;

use super::super::{Case, Job, Level, Study, Trace};
use crate::afloat::{Afloat, DIAMETER, TICK, Tank};
use crate::drive::Account;
use crate::error::LabError;
use crate::measure::statistics::mean;
use crate::progress::Progress;
use crate::scenes::GRAVITY;
use crate::verdict::{Bound, Check};

/// The case.
pub const CASE: Case = Case {
    name: "added-mass",
    about: "a ball of 0.1, 0.5, 1 or 2 times the water's density let go under water, by DFSPH, in lockstep: first acceleration; potential theory",
    run: |job| STUDY.run(job),
};

const STUDY: Study = Study {
    name: "added-mass",
    title: "A ball let go in the middle of a tank 4 D wide and 3 D deep",
    measure: "largest error of the first acceleration",
    bound: 0.1,
    coarse_bound: Some(0.1),
    smooth: false,
    resolutions: [6, 10, 16],
    quick: &[6],
    axes: ["time (s)", "velocity / sqrt(g D)"],
    simulate,
};

/// Density over the water's.
const RATIOS: [f64; 4] = [0.1, 0.5, 1.0, 2.0];
/// How long the water has to come to rest around it, s, and in the quick form: the finer, the longer it takes.
const SETTLED: [f64; 2] = [2.0, 1.0];
/// How far the one that weighs as much as water may go in the next second, over D.
const STAYS: f64 = 0.02;
/// Most that the force on a ball which is held may differ from the weight of what it displaces, %.
const HELD: f64 = 10.0;

/// Added mass over what a ball displaces, in the middle of this tank: 1/2 in an endless fluid (Lamb 1932, art. 92). Around it the walls leave less
/// room to flow back, while the floor and the surface, where there is no pressure, cancel each other: from finite elements in a round tank of the
/// same area and depth, 0.5127 and 0.5130 with 120 and 200 elements along the ball, which have 0.4987 and 0.4996 in a tank ten times as large.
const ADDED_MASS: f64 = 0.513;

/// What it begins to move with over `g`.
fn first_acceleration(ratio: f64) -> f64 {
    (1.0 - ratio) / (ratio + ADDED_MASS)
}

fn simulate(job: &Job, resolution: u32, progress: &mut Progress) -> Result<Level, LabError> {
    let (mut error, mut traces, mut checks, mut remarks) = (0.0f64, Vec::new(), Vec::new(), Vec::new());
    let (mut account, mut particles) = (Account::default(), 0);
    let (edge, scale) = (f64::from(DIAMETER), (GRAVITY * f64::from(DIAMETER)).sqrt());
    let runs = RATIOS.len() + 1;
    for (index, ratio) in RATIOS.into_iter().enumerate() {
        let mut part = |fraction: f64| progress.at((index as f64 + fraction) / runs as f64);
        let (mut afloat, _) = settled(job, resolution, RigidBodyBuilder::dynamic(), &mut part)?;
        afloat.set_density(0, 1000.0 * ratio as f32);
        let start = (afloat.body(0).translation().y, afloat.body(0).linvel().y);
        let neutral = ratio == 1.0;
        let expected = first_acceleration(ratio) * GRAVITY;
        let ticks = if neutral { (1.0 / TICK).round() as u32 } else { 1 };
        let mut points = vec![(0.0, 0.0, 0.0)];
        for tick in 1..=ticks {
            afloat.tick()?;
            let (time, velocity) = (f64::from(tick) * TICK, f64::from(afloat.body(0).linvel().y - start.1));
            points.push((time, velocity / scale, expected * time / scale));
        }
        if neutral {
            let way = f64::from(afloat.body(0).translation().y - start.0) / edge;
            let what = "the way of one that weighs as much as water in a second, over D";
            checks.push(Check::new(what, way, "", Bound::Within(-STAYS, STAYS)));
            let since = f64::from(afloat.body(0).translation().y - Tank::for_bodies(resolution).depth / 2.0) / edge;
            remarks.push(format!(
                "ratio 1: {:.2} % of D since it was put there, before the water came to rest",
                100.0 * since
            ));
        } else if let Some(&(_, velocity, reference)) = points.last() {
            remarks
                .push(format!("ratio {ratio}: {:.3} times the acceleration of potential theory", velocity / reference));
            error = error.max((velocity / reference - 1.0).abs());
        }
        traces.push(Trace { name: format!("ratio {ratio}"), points });
        particles = afloat.particles()?;
        account = account.with(afloat.account());
    }
    let mut part = |fraction: f64| progress.at((RATIOS.len() as f64 + fraction) / runs as f64);
    let (afloat, force) = settled(job, resolution, RigidBodyBuilder::fixed(), &mut part)?;
    let displaced = 1000.0 * std::f64::consts::PI / 6.0 * edge.powi(3) * GRAVITY;
    checks.push(Check::new(
        "the force on one that is held, less the weight of what it displaces",
        (force / displaced - 1.0) * 100.0,
        "%",
        Bound::Within(-HELD, HELD),
    ));
    account = account.with(afloat.account());
    Ok(Level { resolution, particles, error, traces, checks, remarks, account })
}

/// A ball that weighs as much as water, and the water at rest around it; also the mean force of the fluid on it in the second half of that time, N.
fn settled(
    job: &Job,
    resolution: u32,
    body: RigidBodyBuilder,
    progress: &mut dyn FnMut(f64),
) -> Result<(Afloat, f64), LabError> {
    let tank = Tank::for_bodies(resolution);
    let body = body.translation(Vec3::Y * tank.depth / 2.0);
    let ball = ColliderBuilder::ball(DIAMETER / 2.0).density(1000.0);
    let mut afloat = tank.with_bodies(job, "added mass", [(body, ball)], 0)?;
    let ticks = (SETTLED[usize::from(job.quick)] / TICK).round() as u32;
    let mut forces = Vec::new();
    for tick in 1..=ticks {
        let given = afloat.tick()?;
        if 2 * tick > ticks {
            forces.push(given.first().map_or(f64::NAN, |given| f64::from(given.linear.y) / TICK));
        }
        progress(f64::from(tick) / f64::from(ticks));
    }
    Ok((afloat, mean(forces).unwrap_or(f64::NAN)))
}
