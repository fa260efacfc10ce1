//! Twenty cubes afloat in 27,000 particles: what they cost over the fluid alone, by the particle.

use std::time::Instant;

use glam::Vec3;
use rapier3d::dynamics::RigidBodyBuilder;
use rapier3d::geometry::ColliderBuilder;

use super::super::{Case, Job, Level, Study, Trace};
use crate::afloat::{TICK, Tank};
use crate::error::LabError;
use crate::measure::statistics::median;
use crate::progress::Progress;
use crate::verdict::{Bound, Check};

/// The case.
pub const CASE: Case = Case {
    name: "crates",
    about: "20 cubes of half the water's density in 27,000 particles, by DFSPH, two ticks late: time of a tick, rapier's step and all, by the particle of fluid, over that of the fluid alone",
    run: |job| STUDY.run(job),
};

const STUDY: Study = Study {
    name: "crates",
    title: "20 cubes afloat in 27,000 particles: time of a tick by the particle",
    measure: "what they cost over the fluid alone",
    bound: 0.2,
    coarse_bound: Some(0.2),
    smooth: false,
    resolutions: [4, 6, 8],
    quick: &[6],
    axes: ["time (s)", "time of a tick by the particle / that of the fluid alone"],
    simulate,
};

/// Length, width and depth of the water, spacings: 27,000 particles without the cubes.
const WATER: [f32; 3] = [50.0, 45.0, 12.0];
/// m.
const SPACING: f32 = 0.05;
/// Cubes along and across.
const CUBES: [u32; 2] = [5, 4];
/// Density over the water's.
const RATIO: f32 = 0.5;
/// Time that both have to come to rest, s, and for which they are timed, in turn; and the quick form's.
const RESTS: [f64; 2] = [1.0, 0.5];
const TIMED: [f64; 2] = [2.0, 0.5];
/// Ticks until rapier hears of an impulse.
const LATENCY: u64 = 2;

fn simulate(job: &Job, resolution: u32, progress: &mut Progress) -> Result<Level, LabError> {
    let [length, width, depth] = WATER.map(|spacings| spacings * SPACING);
    let tank = Tank { floor: [length, width], depth, spacing: SPACING };
    let half = 0.5 * resolution as f32 * SPACING;
    let place = |along: u32, across: u32| {
        let [x, z] = [(along, CUBES[0], length), (across, CUBES[1], width)]
            .map(|(index, count, edge)| ((index as f32 + 0.5) / count as f32 - 0.5) * edge);
        Vec3::new(x, depth + (1.0 - 2.0 * RATIO) * half, z)
    };
    let cubes =
        (0..CUBES[0]).flat_map(|along| (0..CUBES[1]).map(move |across| (along, across))).map(|(along, across)| {
            let collider = ColliderBuilder::cuboid(half, half, half).density(1000.0 * RATIO);
            (RigidBodyBuilder::dynamic().translation(place(along, across)), collider)
        });
    let mut with = tank.with_bodies(job, "crates", cubes, LATENCY)?;
    let mut without = tank.with_bodies(job, "fluid alone", [], LATENCY)?;
    let form = usize::from(job.quick);
    let [rest, timed] = [RESTS[form], TIMED[form]].map(|time| (time / TICK).round() as u32);
    let fewer = without.particles()? as f64 / with.particles()? as f64;
    let (mut points, mut ratios) = (Vec::new(), Vec::new());
    for tick in 1..=rest + timed {
        // One after the other, so that what else the machine does falls on both.
        let [loaded, alone] = [&mut with, &mut without].map(|one| {
            let begin = Instant::now();
            one.tick().map(|_| begin.elapsed().as_secs_f64())
        });
        // Cubes take the place of a twelfth of the particles, at six spacings.
        let ratio = loaded? / alone? * fewer;
        if tick > rest {
            points.push((f64::from(tick) * TICK, ratio, 1.0));
            ratios.push(ratio);
        }
        progress.at(f64::from(tick) / f64::from(rest + timed));
    }
    let substeps = [&with, &without].map(|one| one.account().mean_substep() * 1e3);
    let checks = vec![Check::new(
        "particles of the fluid alone",
        without.particles()? as f64,
        "",
        Bound::Within(27_000.0, 27_000.0),
    )];
    Ok(Level {
        resolution,
        particles: with.particles()?,
        error: median(&ratios).unwrap_or(f64::NAN) - 1.0,
        traces: vec![Trace { name: "time".to_owned(), points }],
        checks,
        remarks: vec![format!("mean substep {:.2} ms with the cubes, {:.2} ms without", substeps[0], substeps[1])],
        account: with.account().with(without.account()),
    })
}
