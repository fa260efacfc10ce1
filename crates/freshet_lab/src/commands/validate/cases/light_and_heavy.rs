//! The lightest and the heaviest ball: nothing is thrown about.

use freshet_core::field::Field;
use glam::Vec3;
use rapier3d::dynamics::RigidBodyBuilder;
use rapier3d::geometry::ColliderBuilder;

use super::super::{Case, Job, Level, Study, Trace};
use crate::afloat::{DIAMETER, TICK, Tank};
use crate::drive::Account;
use crate::error::LabError;
use crate::progress::Progress;
use crate::reference::archimedes;
use crate::verdict::{Bound, Check};

/// The case.
pub const CASE: Case = Case {
    name: "light-and-heavy",
    about: "balls of 0.01 and 20 times the water's density, let go near the surface, by DFSPH, three ticks late: heave and speeds stay bounded",
    run: |job| STUDY.run(job),
};

const STUDY: Study = Study {
    name: "light-and-heavy",
    title: "A ball of 0.01 times the water's density that bobs, and one of 20 times that sinks",
    measure: "largest heave over that at the start",
    bound: 1.0,
    coarse_bound: Some(1.0),
    smooth: false,
    resolutions: [6, 10, 16],
    quick: &[6],
    axes: ["time (s)", "height above where it rests, over that at the start"],
    simulate,
};

/// Density over the water's, and the start above where it comes to rest, over D.
const BALLS: [(f64, f64); 2] = [(0.01, 0.25), (20.0, 2.0)];
/// Time to simulate, s, and the quick form's.
const END: [f64; 2] = [20.0, 2.0];
/// Ticks until rapier hears of an impulse: the most there may be.
const LATENCY: u64 = 3;
/// Fastest particle over the speed at which a ball falls or rises through the whole depth.
const FASTEST: f64 = 3.0;

fn simulate(job: &Job, resolution: u32, progress: &mut Progress) -> Result<Level, LabError> {
    let (mut error, mut traces, mut checks) = (0.0f64, Vec::new(), Vec::new());
    let (mut account, mut particles) = (Account::default(), 0);
    for (index, (ratio, start)) in BALLS.into_iter().enumerate() {
        let tank = Tank::for_bodies(resolution);
        let edge = f64::from(DIAMETER);
        let rest = match ratio < 1.0 {
            true => f64::from(tank.depth) + (0.5 - archimedes::draft_of_ball(ratio)) * edge,
            false => 0.5 * edge,
        };
        // The light one begins above where it floats, as the heavy one above the floor.
        let place = Vec3::Y * (rest + start * edge) as f32;
        let ball = ColliderBuilder::ball(DIAMETER / 2.0).density(1000.0 * ratio as f32);
        let body = RigidBodyBuilder::dynamic().translation(place);
        let mut afloat = tank.with_bodies(job, "light and heavy", [(body, ball)], LATENCY)?;
        let ticks = (END[usize::from(job.quick)] / TICK).round() as u32;
        let (mut points, mut fastest) = (Vec::new(), 0.0f32);
        for tick in 1..=ticks {
            afloat.tick()?;
            let heave = (f64::from(afloat.body(0).translation().y) - rest) / (start * edge);
            points.push((f64::from(tick) * TICK, heave, f64::NAN));
            fastest = afloat.scalars(Field::Speed)?.into_iter().fold(fastest, f32::max);
            progress.at((index as f64 + f64::from(tick) / f64::from(ticks)) / BALLS.len() as f64);
        }
        error = points.iter().map(|point| point.1.abs()).fold(error, f64::max);
        let scale = (2.0 * crate::scenes::GRAVITY * f64::from(tank.depth)).sqrt();
        let what = format!("ratio {ratio}: fastest particle over sqrt(2 g 3 D)");
        checks.push(Check::new(what, f64::from(fastest) / scale, "", Bound::AtMost(FASTEST)));
        traces.push(Trace { name: format!("ratio {ratio}"), points });
        particles = afloat.particles()?;
        account = account.with(afloat.account());
    }
    Ok(Level { resolution, particles, error, traces, checks, remarks: Vec::new(), account })
}
