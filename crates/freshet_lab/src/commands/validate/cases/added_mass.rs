//! A ball let go under water: how fast it begins to move, against potential theory.

use glam::Vec3;
use rapier3d::dynamics::RigidBodyBuilder;
use rapier3d::geometry::ColliderBuilder;

use super::super::{Case, Job, Level, Study, Trace};
use crate::afloat::{Afloat, DIAMETER, TICK, Tank};
use crate::drive::Account;
use crate::error::LabError;
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
/// How long it is held, s, until the water is still.
const HELD: f64 = 1.0;
/// How long it is watched, s: it has gone 0.02 to 0.04 D by then.
const WATCHED: f64 = 2.0 * TICK;
/// How long the one that weighs as much as water is watched, s, and how far it may go by then over D.
const NEUTRAL: (f64, f64) = (1.0, 0.02);

/// What it begins to move with over `g`: `(1 - r) / (r + 1/2)`, the water around it adding half of what it displaces to its mass.
fn first_acceleration(ratio: f64) -> f64 {
    (1.0 - ratio) / (ratio + 0.5)
}

fn simulate(job: &Job, resolution: u32, progress: &mut Progress) -> Result<Level, LabError> {
    let (mut error, mut traces, mut checks, mut remarks) = (0.0f64, Vec::new(), Vec::new(), Vec::new());
    let (mut account, mut particles) = (Account::default(), 0);
    let (edge, scale) = (f64::from(DIAMETER), (GRAVITY * f64::from(DIAMETER)).sqrt());
    for (index, ratio) in RATIOS.into_iter().enumerate() {
        let tank = Tank::for_bodies(resolution);
        let mut world = tank.world();
        let place = Vec3::Y * tank.depth / 2.0;
        let body = RigidBodyBuilder::fixed().translation(place).can_sleep(false);
        let (handle, _) = world.insert(body, ColliderBuilder::ball(DIAMETER / 2.0).density(1000.0 * ratio as f32));
        let mut afloat = Afloat::open(job, tank.scene("added mass"), world, &[handle], 0)?;
        for tick in 1..=(HELD / TICK).round() as u32 {
            afloat.tick()?;
            progress.at((index as f64 + f64::from(tick) * TICK / HELD) / RATIOS.len() as f64);
        }
        afloat.release(0);
        let start = f64::from(afloat.body(0).translation().y);
        let (expected, neutral) = (first_acceleration(ratio) * GRAVITY, ratio == 1.0);
        let watched = if neutral { NEUTRAL.0 } else { WATCHED };
        let mut points = vec![(0.0, 0.0, 0.0)];
        for tick in 1..=(watched / TICK).round() as u32 {
            afloat.tick()?;
            let (time, velocity) = (f64::from(tick) * TICK, f64::from(afloat.body(0).linvel().y));
            points.push((time, velocity / scale, expected * time / scale));
        }
        if neutral {
            let way = (f64::from(afloat.body(0).translation().y) - start) / edge;
            let what = format!("the way of one that weighs as much as water in {} s, over D", NEUTRAL.0);
            checks.push(Check::new(what, way, "", Bound::Within(-NEUTRAL.1, NEUTRAL.1)));
        } else if let Some(&(_, velocity, reference)) = points.last() {
            remarks
                .push(format!("ratio {ratio}: {:.3} times the acceleration of potential theory", velocity / reference));
            error = error.max((velocity / reference - 1.0).abs());
        }
        traces.push(Trace { name: format!("ratio {ratio}"), points });
        particles = afloat.particles()?;
        account = account.with(afloat.account());
    }
    Ok(Level { resolution, particles, error, traces, checks, remarks, account })
}
