//! A half-submerged ball that bobs: its period.

use glam::Vec3;
use rapier3d::dynamics::RigidBodyBuilder;
use rapier3d::geometry::ColliderBuilder;

use super::super::{Case, Job, Level, Study, Trace};
use crate::afloat::{Afloat, DIAMETER, TICK, Tank};
use crate::error::LabError;
use crate::measure::statistics::mean;
use crate::progress::Progress;
use crate::reference::hulme_1982;
use crate::scenes::GRAVITY;

/// The case.
pub const CASE: Case = Case {
    name: "heave",
    about: "a ball of half the water's density let go 0.1 D above where it floats, by DFSPH, two ticks late: period; Hulme 1982",
    run: |job| STUDY.run(job),
};

const STUDY: Study = Study {
    name: "heave",
    title: "A ball of half the water's density that bobs",
    measure: "error of the period",
    bound: 0.1,
    coarse_bound: Some(0.1),
    smooth: false,
    resolutions: [6, 10, 16],
    quick: &[6],
    axes: ["time (s)", "height above the mean / D"],
    simulate,
};

/// Above where it floats, over D.
const RELEASE: f64 = 0.1;
/// How long it is held there, s, until the water is calm, and how long it then bobs.
const HELD: f64 = 0.5;
const END: f64 = 1.5;
/// What turns back by less than this share of the first swing is noise.
const NOISE: f64 = 0.05;
/// Ticks until rapier hears of an impulse.
const LATENCY: u64 = 2;

fn simulate(job: &Job, resolution: u32, progress: &mut Progress) -> Result<Level, LabError> {
    let (tank, edge) = (Tank::for_bodies(resolution), f64::from(DIAMETER));
    let mut world = tank.world();
    let place = Vec3::Y * (tank.depth + RELEASE as f32 * DIAMETER);
    let body = RigidBodyBuilder::fixed().translation(place).can_sleep(false);
    let (handle, _) = world.insert(body, ColliderBuilder::ball(DIAMETER / 2.0).density(500.0));
    let mut afloat = Afloat::open(job, tank.scene("heave"), world, &[handle], LATENCY)?;
    for _ in 0..(HELD / TICK).round() as u32 {
        afloat.tick()?;
    }
    afloat.release(0);
    let ticks = (END / TICK).round() as u32;
    let mut heights = vec![(0.0, f64::from(place.y) / edge)];
    for tick in 1..=ticks {
        afloat.tick()?;
        heights.push((f64::from(tick) * TICK, f64::from(afloat.body(0).translation().y) / edge));
        progress.at(f64::from(tick) / f64::from(ticks));
    }
    let expected = hulme_1982::heave_period(edge / 2.0, GRAVITY);
    let period = period(&heights).unwrap_or(f64::NAN);
    let rest = mean(heights.iter().map(|height| height.1)).unwrap_or(f64::NAN);
    let points = heights.iter().map(|&(time, height)| (time, height - rest, f64::NAN)).collect();
    let remarks = vec![format!("period {period:.3} s, {expected:.3} s in an endless sea")];
    Ok(Level {
        resolution,
        particles: afloat.particles()?,
        error: (period / expected - 1.0).abs(),
        traces: vec![Trace { name: "height".to_owned(), points }],
        checks: Vec::new(),
        remarks,
        account: afloat.account().clone(),
    })
}

/// The time from the first lowest to the second lowest height: from which it rises by more than a twentieth of the first swing, so that noise counts
/// for nothing, each at the bottom of a parabola through three. Where it rests does not matter.
fn period(heights: &[(f64, f64)]) -> Option<f64> {
    let first = heights.first()?.1;
    let mut turns: Vec<f64> = Vec::new();
    let (mut extreme, mut falls, mut swing) = (0, true, f64::INFINITY);
    for (index, &(_, height)) in heights.iter().enumerate() {
        let beyond = if falls { heights[extreme].1 - height } else { height - heights[extreme].1 };
        if beyond > 0.0 {
            extreme = index;
        } else if falls && turns.is_empty() && -beyond > NOISE * (first - heights[extreme].1) && index > extreme {
            swing = first - heights[extreme].1;
            turns.push(bottom(heights, extreme)?);
            (extreme, falls) = (index, false);
        } else if -beyond > NOISE * swing {
            if falls {
                turns.push(bottom(heights, extreme)?);
            }
            (extreme, falls) = (index, !falls);
        }
    }
    Some(turns.get(1)? - turns.first()?)
}

/// Where a parabola through a height and its neighbours is lowest, s.
fn bottom(heights: &[(f64, f64)], lowest: usize) -> Option<f64> {
    let (before, at, after) = (heights.get(lowest.checked_sub(1)?)?, heights[lowest], heights.get(lowest + 1)?);
    let [left, right] = [before.1 - at.1, after.1 - at.1];
    let curved = left + right;
    Some(if curved > 0.0 { at.0 + 0.25 * (after.0 - before.0) * (left - right) / curved } else { at.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_period_of_a_damped_sine_is_found() {
        let heights: Vec<(f64, f64)> = (0..120)
            .map(|tick| f64::from(tick) * TICK)
            .map(|time| (time, 3.0 + (-0.3 * time).exp() * (8.0 * time).cos()))
            .collect();
        let found = period(&heights).unwrap();
        assert!((found - std::f64::consts::TAU / 8.0).abs() < 1e-2, "{found}");
    }
}
