//! A block that water presses against a wall: it stays, and feels the force of hydrostatics.

use freshet_core::scene::Volume;
use glam::Vec3;
use rapier3d::dynamics::RigidBodyBuilder;
use rapier3d::geometry::ColliderBuilder;

use super::super::{Case, Job, Level, Study, Trace};
use crate::afloat::{Afloat, DIAMETER, TICK, Tank};
use crate::error::LabError;
use crate::measure::column::level_from_centre_of_mass;
use crate::measure::statistics::mean;
use crate::progress::Progress;
use crate::scenes::GRAVITY;
use crate::verdict::{Bound, Check};

/// The case.
pub const CASE: Case = Case {
    name: "pinned",
    about: "a block between a wall and water 2 D deep, by DFSPH, two ticks late: how far and how fast it moves; force; hydrostatics",
    run: |job| STUDY.run(job),
};

const STUDY: Study = Study {
    name: "pinned",
    title: "Water 2 D deep presses a block against a wall",
    measure: "error of the force on the block",
    bound: 0.05,
    coarse_bound: Some(0.05),
    smooth: false,
    resolutions: [6, 10, 16],
    quick: &[6],
    axes: ["time (s)", "force on the block / hydrostatic"],
    simulate,
};

/// Length, depth and width of the water, and thickness and height of the block, over D.
const WATER: [f32; 3] = [2.0, 2.0, 2.0];
const BLOCK: [f32; 2] = [1.0, 3.0];
/// Its density, kg/m3: light enough for the water to move it where nothing holds it.
const DENSITY: f32 = 500.0;
/// Time to simulate, s, and the quick form's.
const END: [f64; 2] = [8.0, 2.0];
/// Ticks until rapier hears of an impulse.
const LATENCY: u64 = 2;
/// Most that it may move in the second half of that time, over D, and how fast, over `sqrt(g D)`.
const STAYS: [f64; 2] = [0.01, 0.01];

fn simulate(job: &Job, resolution: u32, progress: &mut Progress) -> Result<Level, LabError> {
    let [length, depth, width] = WATER.map(|over| over * DIAMETER);
    let [thickness, height] = BLOCK.map(|over| over * DIAMETER);
    let (edge, scale) = (f64::from(DIAMETER), (GRAVITY * f64::from(DIAMETER)).sqrt());
    let tank = Tank { floor: [length + thickness, width], depth, spacing: DIAMETER / resolution as f32 };
    let wall = -0.5 * tank.floor[0];
    let mut scene = tank.scene("pinned");
    let middle = Vec3::new(wall + thickness + 0.5 * length, 0.5 * depth, 0.0);
    scene.volumes = vec![Volume::block(Vec3::new(length, depth, width) / 2.0, middle)];
    let mut world = tank.world();
    let half = Vec3::new(thickness, height, width) / 2.0;
    let place = Vec3::new(wall + 0.5 * thickness, 0.5 * height, 0.0);
    let body = RigidBodyBuilder::dynamic().translation(place).can_sleep(false);
    let (handle, _) = world.insert(body, ColliderBuilder::cuboid(half.x, half.y, half.z).density(DENSITY));
    let mut afloat = Afloat::open(job, scene, world, &[handle], LATENCY)?;

    let hydrostatic = |level: f64| 1000.0 * GRAVITY * f64::from(width) * level * level / 2.0;
    let ticks = (END[usize::from(job.quick)] / TICK).round() as u32;
    let (mut points, mut forces, mut places, mut fastest) = (Vec::new(), Vec::new(), Vec::new(), 0.0f64);
    let mut level = f64::NAN;
    for tick in 1..=ticks {
        let given = afloat.tick()?;
        let force = given.first().map_or(f64::NAN, |given| -f64::from(given.linear.x) / TICK);
        points.push((f64::from(tick) * TICK, force / hydrostatic(f64::from(depth)), 1.0));
        if 2 * tick > ticks {
            level = level_from_centre_of_mass(&afloat.positions()?).unwrap_or(f64::NAN);
            forces.push(force / hydrostatic(level));
            places.push(afloat.body(0).translation());
            fastest = fastest.max(f64::from(afloat.body(0).linvel().length()) / scale);
        }
        progress.at(f64::from(tick) / f64::from(ticks));
    }
    let low = places.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = places.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    let checks = vec![
        Check::new("how far it moves over D", f64::from((high - low).length()) / edge, "", Bound::AtMost(STAYS[0])),
        Check::new("its speed over sqrt(g D)", fastest, "", Bound::AtMost(STAYS[1])),
        Check::new(
            "its way from the wall over D",
            f64::from(high.x - place.x) / edge,
            "",
            Bound::Within(-STAYS[0], STAYS[0]),
        ),
    ];
    Ok(Level {
        resolution,
        particles: afloat.particles()?,
        error: (mean(forces).unwrap_or(f64::NAN) - 1.0).abs(),
        traces: vec![Trace { name: "force".to_owned(), points }],
        checks,
        remarks: vec![format!("level {:.3} of 2 D", level / f64::from(depth))],
        account: afloat.account().clone(),
    })
}
