//! A half-submerged ball that bobs: its period.
//!
//! That is the time from where it is let go, at rest, to the next highest place. Linear potential flow in a round tank of the same area and depth
//! (finite elements, in time, the ball let go as here) has it at 0.767 s, and in a tank four times as wide at 0.764 s: an endless sea's period (0.756
//! s, Hulme 1982, for swings that never end) within 1.5 %. The next swing is none of an endless sea: its waves come back from the walls, with the
//! tank's own, whose periods are near: lowest to lowest is 0.780 s in this tank and 0.759 s in the wide one. And it is one of a fluid that is not
//! water: the ball has a tenth of a spacing left to go, which particles under pressure, a soft solid, hardly let it. How much of the height is left
//! at the first lowest place says so: 0.92 in potential flow.

use glam::Vec3;
use rapier3d::dynamics::RigidBodyBuilder;
use rapier3d::geometry::ColliderBuilder;

use super::super::{Case, Job, Level, Study, Trace};
use crate::afloat::{DIAMETER, TICK, Tank};
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
    let place = Vec3::Y * (tank.depth + RELEASE as f32 * DIAMETER);
    let ball = ColliderBuilder::ball(DIAMETER / 2.0).density(500.0);
    let mut afloat = tank.with_bodies(job, "heave", [(RigidBodyBuilder::fixed().translation(place), ball)], LATENCY)?;
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
    let [(_, lowest), (period, _)] = turns(&heights).unwrap_or([(f64::NAN, f64::NAN); 2]);
    let rest = mean(heights.iter().map(|height| height.1)).unwrap_or(f64::NAN);
    let points = heights.iter().map(|&(time, height)| (time, height - rest, f64::NAN)).collect();
    let remarks = vec![
        format!("period {period:.3} s, {expected:.3} s in an endless sea"),
        format!(
            "first lowest place: {:.2} of the height that it was let go from below the mean",
            (rest - lowest) / (heights[0].1 - rest)
        ),
    ];
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

/// The first lowest place, from which it rises by more than a twentieth of what it fell, so that noise counts for nothing, and the highest after
/// that, likewise: times of both, s, by a parabola through three heights, and the height at the first. Where it rests does not matter.
fn turns(heights: &[(f64, f64)]) -> Option<[(f64, f64); 2]> {
    let first = heights.first()?.1;
    let lowest = turn(heights, 0, |height| first - height, None)?;
    let swing = first - heights[lowest].1;
    let highest = turn(heights, lowest, |height| height - heights[lowest].1, Some(swing))?;
    Some([lowest, highest].map(|index| (vertex(heights, index).unwrap_or(f64::NAN), heights[index].1)))
}

/// Where `way` is longest from `start` on, before it falls by more than [`NOISE`] of itself, or of `swing` if that is given.
fn turn(heights: &[(f64, f64)], start: usize, way: impl Fn(f64) -> f64, swing: Option<f64>) -> Option<usize> {
    let mut extreme = start;
    for (index, &(_, height)) in heights.iter().enumerate().skip(start + 1) {
        let (now, most) = (way(height), way(heights[extreme].1));
        if now > most {
            extreme = index;
        } else if most > 0.0 && most - now > NOISE * swing.unwrap_or(most) {
            return Some(extreme);
        }
    }
    None
}

/// Where a parabola through a height and its neighbours turns, s.
fn vertex(heights: &[(f64, f64)], index: usize) -> Option<f64> {
    let (before, at, after) = (heights.get(index.checked_sub(1)?)?, heights[index], heights.get(index + 1)?);
    let [left, right] = [before.1 - at.1, after.1 - at.1];
    let curved = left + right;
    Some(if curved == 0.0 { at.0 } else { at.0 + 0.25 * (after.0 - before.0) * (left - right) / curved })
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
        let [(_, lowest), (found, _)] = turns(&heights).unwrap();
        assert!((found - std::f64::consts::TAU / 8.0).abs() < 1e-2, "{found}");
        assert!((lowest - 3.0 + (-0.3 * std::f64::consts::PI / 8.0).exp()).abs() < 1e-2, "{lowest}");
    }
}
