//! A metre of water at rest for a minute with next to nothing that would calm it: water's own viscosity, and what the trapezoidal rule
//! damps ([`DivergenceFree`](freshet_core::pressure_solver::DivergenceFree)). Speeds are bounded where the
//! resolution is as fine as in a game; particles of a tenth of a metre are moved by the unevenness of their own layers.

use freshet_core::field::Field;
use freshet_core::plan::Plan;

use super::super::{Case, Job, Level, Study, Trace};
use crate::drive::Drive;
use crate::error::LabError;
use crate::measure::column::{PressureProfile, surface_level};
use crate::measure::statistics::mean;
use crate::method::Method;
use crate::progress::Progress;
use crate::reference::hydrostatics;
use crate::scenes::GRAVITY;
use crate::scenes::column::walled;
use crate::verdict::{Bound, Check};

/// The case. Divergence-free SPH alone is to keep it: a weakly compressible fluid without artificial viscosity rings.
pub const CASE: Case = Case {
    name: "calm-dfsph",
    about: "a column of water, 0.5 x 0.5 x 1 m, mu = 1e-3 Pa s and no artificial viscosity, divergence-free SPH: speeds after a minute, pressure, level; exact",
    run: |job| CALM.run(job),
};

const CALM: Study = Study {
    name: "calm-dfsph",
    title: "Water at rest, 1 m deep, without artificial viscosity, by DFSPH",
    measure: "mean speed at the end over sqrt(g D)",
    // A millimetre a second.
    bound: 1e-3 / 3.132,
    coarse_bound: Some(3e-3),
    smooth: true,
    resolutions: [10, 20, 40],
    quick: &[10, 20],
    axes: ["time (s)", "mean speed / sqrt(g D)"],
    simulate,
};

/// Depth of the water, m.
const DEPTH: f64 = 1.0;
/// Edge of the base over the depth.
const WIDTH: f64 = 0.5;
/// From this many particles of depth on every number has the bound that is asked for.
const FINE: u32 = 40;
/// Time to simulate, s; the quick form's second.
const END: [f64; 2] = [60.0, 20.0];
/// The last part of it, in which the fastest particle counts, and over which pressures and levels are averaged, s; the quick form's second.
const LATE: [f64; 2] = [10.0, 2.0];
/// Duration of a tick, s.
const TICK: f64 = 1.0 / 60.0;

fn simulate(job: &Job, resolution: u32, progress: &mut Progress) -> Result<Level, LabError> {
    let spacing = DEPTH / f64::from(resolution);
    let plan = Plan::new(&Method::WaterAlone.on(walled((WIDTH * DEPTH) as f32, DEPTH, spacing as f32)))?;
    let (particles, support) = (plan.positions.len(), f64::from(plan.parameters.support_radius));
    let per_layer = particles / resolution as usize;
    let mut drive = Drive::open(job.backend, plan, job.threads.count(), Vec::new())?;
    let [end, late] = [END, LATE].map(|of| of[usize::from(job.quick)]);
    let ticks = (end / TICK).round() as u32;
    let late = ticks - (late / TICK).round() as u32;
    let (mut speeds, mut late_speeds, mut fastest) = (Vec::new(), Vec::new(), 0.0f32);
    let (mut profile, mut levels) = (PressureProfile::new(DEPTH, support), Vec::new());
    let scale = (GRAVITY * DEPTH).sqrt();
    for tick in 1..=ticks {
        drive.tick(TICK)?;
        progress.at(f64::from(tick) / f64::from(ticks));
        // Sixty numbers a second say no more than six.
        if tick % 10 != 0 && tick <= late {
            continue;
        }
        let of_tick = drive.scalars(Field::Speed)?;
        let speed = mean(of_tick.iter().map(|&speed| f64::from(speed))).unwrap_or(f64::NAN);
        if tick % 10 == 0 {
            speeds.push((f64::from(tick) * TICK, speed / scale, 0.0));
        }
        if tick > late {
            late_speeds.push(speed);
            fastest = of_tick.into_iter().fold(fastest, f32::max);
            let (positions, pressures) = (drive.positions()?, drive.scalars(Field::Pressure)?);
            positions.iter().zip(&pressures).for_each(|(x, &pressure)| profile.add(x.y, pressure));
            levels.push(surface_level(&positions, per_layer, spacing as f32).unwrap_or(f64::NAN));
        }
    }
    // The lowest support radius of fluid, and what lies between its middle and the floor.
    let (height, pressure) = profile.points().next().unwrap_or((f64::NAN, f64::NAN));
    let whole = hydrostatics::pressure(1000.0, GRAVITY, DEPTH);
    let bottom = (pressure + hydrostatics::pressure(1000.0, GRAVITY, height)) / whole;
    let level = mean(levels).unwrap_or(f64::NAN);
    let remarks = vec![format!(
        "fastest {:.2} mm/s, bottom {bottom:.4} rho g D, level {:.2} %; pressures {:.3} % RMS of rho g D over the depth",
        f64::from(fastest) * 1e3,
        100.0 * level / DEPTH,
        100.0 * profile.deviation(reference).unwrap_or(f64::NAN) / whole
    )];
    // Five particles wide and ten deep, walls are a fifth of the fluid's width.
    let [fastest_bound, bottom_bound] = if resolution >= FINE { [20.0, 0.02] } else { [60.0, 0.1] };
    let checks = vec![
        Check::new("fastest particle of the last part", f64::from(fastest) * 1e3, "mm/s", Bound::AtMost(fastest_bound)),
        Check::new(
            "pressure at the bottom over rho g D",
            bottom,
            "",
            Bound::Within(1.0 - bottom_bound, 1.0 + bottom_bound),
        ),
        Check::new("surface level over the depth", 100.0 * level / DEPTH, "%", Bound::Within(99.0, 101.0)),
    ];
    Ok(Level {
        resolution,
        particles,
        error: mean(late_speeds).unwrap_or(f64::NAN) / scale,
        traces: vec![Trace { name: "mean speed".to_owned(), points: speeds }],
        checks,
        remarks,
        account: drive.account().clone(),
    })
}

/// Pressure at a height, Pa.
fn reference(height: f64) -> f64 {
    hydrostatics::pressure(1000.0, GRAVITY, DEPTH - height)
}
