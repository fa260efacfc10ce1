//! A cube of water at rest for a minute, half a metre deep: pressure against depth, level, speed.

use freshet_core::field::Field;
use freshet_core::plan::Plan;
use glam::Vec3;

use super::super::{Case, Job, Level, Study, Trace};
use crate::drive::Drive;
use crate::error::LabError;
use crate::measure::column::{Gap, PressureProfile, gap, surface_level};
use crate::measure::statistics::mean;
use crate::method::Method;
use crate::progress::Progress;
use crate::reference::hydrostatics;
use crate::scenes::GRAVITY;
use crate::scenes::column::{Container, DEPTH, scene_of};
use crate::verdict::{Bound, Check};

/// The case, weakly compressible.
pub const CASE: Case = Case {
    name: "hydrostatic",
    about: "a cube of water, 0.5 m, at rest between walls for a minute: pressure against depth, level and speed; exact",
    run: |job| WEAKLY_COMPRESSIBLE.run(job),
};

/// The same with the other form of the pressure force.
pub const MUELLER: Case = Case {
    name: "hydrostatic-mueller",
    about: "the same with Mueller's form of the pressure force: pressure against depth, level and speed; exact",
    run: |job| MUELLERS.run(job),
};

/// The same with densities that particles carry.
pub const CONTINUITY: Case = Case {
    name: "hydrostatic-continuity",
    about: "the same with densities that particles carry: pressure against depth, level and speed; exact",
    run: |job| CARRIED.run(job),
};

/// The same with the incompressible solver.
pub const DIVERGENCE_FREE: Case = Case {
    name: "hydrostatic-dfsph",
    about: "the same with divergence-free SPH: pressure against depth, level and speed; exact",
    run: |job| INCOMPRESSIBLE.run(job),
};

const WEAKLY_COMPRESSIBLE: Study = Study {
    name: "hydrostatic",
    title: "Water at rest, 0.5 m deep",
    measure: "RMS of the pressure, means over a support radius, over rho g D",
    bound: 0.01,
    coarse_bound: Some(0.03),
    smooth: true,
    resolutions: [8, 12, 20],
    quick: &[8, 12],
    axes: ["depth / D", "pressure / (rho g D)"],
    simulate: |job, resolution, progress| simulate(job, Method::WeaklyCompressible, resolution, progress),
};

const MUELLERS: Study = Study {
    name: "hydrostatic-mueller",
    title: "Water at rest, 0.5 m deep, Mueller's force",
    // All quick forms together have a minute.
    quick: &[8],
    simulate: |job, resolution, progress| simulate(job, Method::Mueller, resolution, progress),
    ..WEAKLY_COMPRESSIBLE
};

const CARRIED: Study = Study {
    name: "hydrostatic-continuity",
    title: "Water at rest, 0.5 m deep, densities by continuity",
    quick: &[8],
    simulate: |job, resolution, progress| simulate(job, Method::Continuity, resolution, progress),
    ..WEAKLY_COMPRESSIBLE
};

const INCOMPRESSIBLE: Study = Study {
    name: "hydrostatic-dfsph",
    title: "Water at rest, 0.5 m deep, by DFSPH",
    simulate: |job, resolution, progress| simulate(job, Method::DivergenceFree, resolution, progress),
    ..WEAKLY_COMPRESSIBLE
};

/// Time to simulate, s.
const END: f64 = 60.0;
/// That of the quick form, s.
const QUICK_END: f64 = 5.0;
/// The last part of it, over which pressures and speeds are averaged; the level has to hold at every tick of it, s.
const LATE: f64 = 2.0;
/// Duration of a tick, s.
const TICK: f64 = 1.0 / 60.0;
/// Largest mean speed at the end, m/s.
const SPEED: f64 = 0.01;
/// Largest deviation of single particles, over rho g D, times the particles of depth, %: pressures beside walls alternate from layer to layer. A guard, a fifth more
/// than was measured (4.7, 3.7 and 2.4 % at 8, 12 and 20).
const SINGLE: f64 = 57.0;

fn simulate(job: &Job, method: Method, resolution: u32, progress: &mut Progress) -> Result<Level, LabError> {
    let spacing = DEPTH / f64::from(resolution);
    let plan = Plan::new(&method.on(scene_of(Container::Walls, DEPTH as f32, spacing as f32)?))?;
    let (particles, support) = (plan.positions.len(), f64::from(plan.parameters.support_radius));
    let per_layer = (resolution as usize).pow(2);
    let mut drive = Drive::open(job.backend, plan, job.threads.count(), Vec::new())?;
    let ticks = (if job.quick { QUICK_END } else { END } / TICK).round() as u32;
    let late = ticks - (LATE / TICK).round() as u32;
    let (mut inside, mut all) = (PressureProfile::new(DEPTH, support), PressureProfile::new(DEPTH, support));
    let (mut speeds, mut off_level, mut scatter) = (Vec::new(), 0.0f64, Vec::new());
    for tick in 1..=ticks {
        drive.tick(TICK)?;
        progress.at(f64::from(tick) / f64::from(ticks));
        if tick <= late {
            continue;
        }
        let (positions, pressures) = (drive.positions()?, drive.scalars(Field::Pressure)?);
        for (x, &pressure) in positions.iter().zip(&pressures) {
            all.add(x.y, pressure);
            // Where no sample of the side walls takes part in any sum.
            if f64::from(x.x.abs().max(x.z.abs())) < DEPTH / 2.0 - support {
                inside.add(x.y, pressure);
            }
            scatter.push((f64::from(pressure) - reference(f64::from(x.y))).powi(2));
        }
        speeds.extend(drive.scalars(Field::Speed)?.into_iter().map(f64::from));
        let level = surface_level(&positions, per_layer, spacing as f32).unwrap_or(f64::NAN);
        off_level = if level.is_nan() { level } else { off_level.max((level - DEPTH).abs()) };
    }
    let whole = hydrostatics::pressure(1000.0, GRAVITY, DEPTH);
    let share = |deviation: Option<f64>| deviation.unwrap_or(f64::NAN) / whole;
    let point = |(height, pressure): (f64, f64)| (1.0 - height / DEPTH, pressure / whole, reference(height) / whole);
    let speed = mean(speeds).unwrap_or(f64::NAN);
    let gaps = gaps(&drive.positions()?, per_layer);
    Ok(Level {
        resolution,
        particles,
        error: share(all.deviation(reference)),
        traces: vec![Trace { name: "pressure".to_owned(), points: all.points().map(point).collect() }],
        checks: gaps
            .into_iter()
            .flat_map(|(wall, gap)| gap_checks(wall, gap, spacing))
            .chain([
                Check::new(
                    "surface level, furthest from the right one, over d",
                    off_level / spacing,
                    "",
                    Bound::AtMost(0.5),
                ),
                Check::new("mean speed at the end", speed * 1000.0, "mm/s", Bound::AtMost(SPEED * 1000.0)),
                Check::new(
                    "pressures of single particles, RMS over rho g D",
                    100.0 * share(mean(scatter).map(f64::sqrt)),
                    "%",
                    Bound::AtMost(SINGLE / f64::from(resolution)),
                ),
            ])
            .collect(),
        remarks: vec![format!(
            "a support radius and more from the side walls {:.3} % RMS",
            100.0 * share(inside.deviation(reference)),
        )],
        account: drive.account().clone(),
    })
}

/// How far the fluid stands off the floor, and off all four sides together.
fn gaps(positions: &[Vec3], per_layer: usize) -> [(&'static str, Option<Gap>); 2] {
    let to_side = |side: Vec3| -> Vec<f64> { positions.iter().map(|x| DEPTH / 2.0 - f64::from(x.dot(side))).collect() };
    let floor: Vec<f64> = positions.iter().map(|x| f64::from(x.y)).collect();
    let sides = [Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z].map(|side| gap(&to_side(side), per_layer));
    let all: Vec<Gap> = sides.into_iter().flatten().collect();
    // Of as many each: the mean of all, and the spread about their own means.
    let of = |value: fn(&Gap) -> f64| mean(all.iter().map(value)).filter(|_| all.len() == 4);
    let sides = of(|gap| gap.mean).zip(of(|gap| gap.spread.powi(2)));
    [("floor", gap(&floor, per_layer)), ("sides", sides.map(|(mean, variance)| Gap { mean, spread: variance.sqrt() }))]
}

/// Fluid stands off a wall by half a spacing.
fn gap_checks(wall: &str, gap: Option<Gap>, spacing: f64) -> [Check; 2] {
    let Gap { mean, spread } = gap.unwrap_or(Gap { mean: f64::NAN, spread: f64::NAN });
    let name = |what: &str| format!("first layer off the {wall}, {what} over d");
    [
        Check::new(name("mean distance"), mean / spacing, "", Bound::Within(0.3, 0.7)),
        Check::new(name("standard deviation"), spread / spacing, "", Bound::AtMost(0.2)),
    ]
}

/// Pressure at a height, Pa.
fn reference(height: f64) -> f64 {
    hydrostatics::pressure(1000.0, GRAVITY, DEPTH - height)
}
