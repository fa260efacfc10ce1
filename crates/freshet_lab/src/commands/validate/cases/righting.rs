//! A barge with a load beside its middle: the moment that rights it, at the angle to which it heels, against hydrostatics.

use glam::Vec3;
use rapier3d::dynamics::{MassProperties, RigidBodyBuilder};
use rapier3d::geometry::ColliderBuilder;

use super::super::{Case, Job, Level, Study, Trace};
use crate::afloat::{DIAMETER, TICK, Tank};
use crate::error::LabError;
use crate::measure::statistics::mean;
use crate::progress::Progress;
use crate::verdict::{Bound, Check};

/// The case.
pub const CASE: Case = Case {
    name: "righting",
    about: "a barge 2 D x 2 D x D of half the water's density with its centre of mass off its middle, by DFSPH, two ticks late: righting moment; hydrostatics",
    run: |job| STUDY.run(job),
};

const STUDY: Study = Study {
    name: "righting",
    title: "A barge with a load beside its middle heels",
    measure: "error of the righting moment",
    bound: 0.1,
    coarse_bound: Some(0.1),
    smooth: false,
    resolutions: [6, 10, 16],
    quick: &[6],
    axes: ["time (s)", "heel (rad)"],
    simulate,
};

/// Breadth, which is also its length, and height, over D.
const BARGE: [f64; 2] = [2.0, 1.0];
/// Density over the water's.
const RATIO: f64 = 0.5;
/// Centre of mass beside the middle, over D.
const OFF_CENTRE: f64 = 0.12;
/// Time to simulate, s, and the quick form's. It begins upright, and its roll takes about 1.3 s.
const END: [f64; 2] = [8.0, 2.0];
/// Share of it at the end over which the heel is averaged, and the quick form's: a roll.
const MEASURED: [f64; 2] = [0.5, 0.65];
/// Ticks until rapier hears of an impulse.
const LATENCY: u64 = 2;

/// Righting moment of a wall-sided barge at a heel, over its weight and D: `(GM + BM tan^2 / 2) sin` (Attwood's formula for upright sides), with the
/// metacentre over the centre of buoyancy by `BM = b^2 / (12 T)`, `T` the draft, and the centre of mass at half of the height.
fn righting(heel: f64) -> f64 {
    let [breadth, height] = BARGE;
    let draft = RATIO * height;
    let to_metacentre = breadth * breadth / (12.0 * draft);
    let upright = draft / 2.0 + to_metacentre - height / 2.0;
    (upright + 0.5 * to_metacentre * heel.tan().powi(2)) * heel.sin()
}

/// The moment of the load at that heel, likewise.
fn heeling(heel: f64) -> f64 {
    OFF_CENTRE * heel.cos()
}

/// Where both are equal, rad.
fn expected_heel() -> f64 {
    let (mut low, mut high) = (0.0, 0.5);
    for _ in 0..60 {
        let heel = (low + high) / 2.0;
        if righting(heel) < heeling(heel) { low = heel } else { high = heel }
    }
    low
}

fn simulate(job: &Job, resolution: u32, progress: &mut Progress) -> Result<Level, LabError> {
    let (tank, edge) = (Tank::for_bodies(resolution), f64::from(DIAMETER));
    let [breadth, height] = BARGE.map(|over| over * edge);
    // Upright, at the depth at which it floats.
    let place = Vec3::Y * (f64::from(tank.depth) + (0.5 - RATIO) * height) as f32;
    let mass = 1000.0 * RATIO * breadth * breadth * height;
    let about = |one: f64, other: f64| (mass / 12.0 * (one * one + other * other)) as f32;
    let inertia = Vec3::new(about(height, breadth), about(breadth, breadth), about(height, breadth));
    let centre = Vec3::X * (OFF_CENTRE * edge) as f32;
    let half = Vec3::new(breadth as f32, height as f32, breadth as f32) / 2.0;
    let barge = ColliderBuilder::cuboid(half.x, half.y, half.z).mass_properties(MassProperties::new(
        centre,
        mass as f32,
        inertia,
    ));
    let body = RigidBodyBuilder::dynamic().translation(place);
    let mut afloat = tank.with_bodies(job, "righting", [(body, barge)], LATENCY)?;
    let form = usize::from(job.quick);
    let ticks = (END[form] / TICK).round() as u32;
    let expected = expected_heel();
    let (mut points, mut heels, mut across) = (Vec::new(), Vec::new(), 0.0f64);
    for tick in 1..=ticks {
        afloat.tick()?;
        let turned = afloat.body(0).rotation().to_scaled_axis();
        let heel = -f64::from(turned.z);
        points.push((f64::from(tick) * TICK, heel, expected));
        if f64::from(tick) > (1.0 - MEASURED[form]) * f64::from(ticks) {
            heels.push(heel);
            across = across.max(f64::from(turned.x).abs());
        }
        progress.at(f64::from(tick) / f64::from(ticks));
    }
    let heel = mean(heels).unwrap_or(f64::NAN);
    let remark = format!("heel {:.2} degrees, {:.2} by hydrostatics", heel.to_degrees(), expected.to_degrees());
    Ok(Level {
        resolution,
        particles: afloat.particles()?,
        error: (righting(heel) / heeling(heel) - 1.0).abs(),
        traces: vec![Trace { name: "heel".to_owned(), points }],
        checks: vec![Check::new("heel along the barge over that across", across / expected, "", Bound::AtMost(0.2))],
        remarks: vec![remark],
        account: afloat.account().clone(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_load_is_righted_where_small_angles_say() {
        // GM = 1/4 + 2/3 - 1/2 = 5/12 of D; upright sides stiffen by the square of the angle.
        let small = OFF_CENTRE * 12.0 / 5.0;
        assert!((0.9..1.0).contains(&(expected_heel() / small)), "{} {small}", expected_heel());
        assert!((righting(expected_heel()) - heeling(expected_heel())).abs() < 1e-9);
        assert!((righting(0.01) / 0.01 - 5.0 / 12.0).abs() < 1e-3);
    }
}
