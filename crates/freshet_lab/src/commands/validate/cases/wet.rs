//! A ball under water that is held: how much room it takes, and whether the water comes up to it.

use glam::Vec3;
use rapier3d::dynamics::RigidBodyBuilder;
use rapier3d::geometry::ColliderBuilder;

use super::super::{Case, Job, Level, Study, Trace};
use crate::afloat::{DIAMETER, TICK, Tank};
use crate::error::LabError;
use crate::measure::statistics::mean;
use crate::progress::Progress;
use crate::verdict::{Bound, Check};

/// The case.
pub const CASE: Case = Case {
    name: "wet",
    about: "a ball held under water, by DFSPH, in lockstep: level of the water, share of wetted samples, water next to the ball",
    run: |job| STUDY.run(job),
};

const STUDY: Study = Study {
    name: "wet",
    title: "A ball held under water: the room that it takes",
    measure: "error of the level that water and ball fill, over D",
    bound: 0.03,
    coarse_bound: Some(0.03),
    smooth: false,
    resolutions: [6, 10, 16],
    quick: &[6],
    axes: ["time (s)", "level / that of water and ball"],
    simulate,
};

/// Time to simulate, s.
const END: f64 = 2.0;
/// How thick the layer around the ball is in which particles are counted, spacings, so that its edge is between two layers of them, and most that
/// their number may differ from its volume over that of a particle, a share: as much as a gap of a fifth of a spacing makes.
const LAYER: (f64, f64) = (2.0, 0.1);

fn simulate(job: &Job, resolution: u32, progress: &mut Progress) -> Result<Level, LabError> {
    let (tank, edge) = (Tank::for_bodies(resolution), f64::from(DIAMETER));
    let (radius, spacing) = (edge / 2.0, f64::from(tank.spacing));
    let body = RigidBodyBuilder::fixed().translation(Vec3::Y * tank.depth / 2.0);
    let ball = ColliderBuilder::ball(DIAMETER / 2.0);
    let mut afloat = tank.with_bodies(job, "wet", [(body, ball)], 0)?;
    let of_ball = |radius: f64| 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    let in_layer = (of_ball(radius + LAYER.0 * spacing) - of_ball(radius)) / spacing.powi(3);
    let ticks = (END / TICK).round() as u32;
    let (mut points, mut levels, mut near, mut inside, mut driest) = (Vec::new(), Vec::new(), Vec::new(), 0, 1.0f64);
    let mut expected = f64::NAN;
    for tick in 1..=ticks {
        afloat.tick()?;
        // Particles that would have started in the ball are left out.
        expected = (afloat.particles()? as f64 * spacing.powi(3) + of_ball(radius)) / tank.area();
        if 2 * tick > ticks {
            let level = afloat.open_surface(&tank, 0.0)?;
            let centre = afloat.body(0).translation();
            let positions = afloat.positions()?;
            let within = |reach: f64| {
                positions.iter().filter(|place| f64::from(place.distance(centre)) < radius + reach * spacing).count()
            };
            points.push((f64::from(tick) * TICK, level / expected, 1.0));
            levels.push(level);
            near.push(within(LAYER.0) as f64 / in_layer);
            inside = inside.max(within(0.0));
            driest = driest.min(afloat.wetted(0));
        }
        progress.at(f64::from(tick) / f64::from(ticks));
    }
    let level = mean(levels).unwrap_or(f64::NAN);
    let filled = Bound::Within(1.0 - LAYER.1, 1.0 + LAYER.1);
    let checks = vec![
        Check::new("least share of wetted samples", driest, "", Bound::AtLeast(1.0)),
        Check::new(
            format!("particles up to {} spacings off the ball, over those that fill the layer", LAYER.0),
            mean(near).unwrap_or(f64::NAN),
            "",
            filled,
        ),
        Check::new("particles in the ball", inside as f64, "", Bound::AtMost(0.0)),
    ];
    Ok(Level {
        resolution,
        particles: afloat.particles()?,
        error: (level - expected).abs() / edge,
        traces: vec![Trace { name: "level".to_owned(), points }],
        checks,
        remarks: vec![format!("level {:.4} D, {:.4} D of water and ball", level / edge, expected / edge)],
        account: afloat.account().clone(),
    })
}
