//! A standing wave: how fast what gravity pulls level swings through it, and what the lattice adds to gravity.

use std::f64::consts::TAU;

use freshet_core::kernel::Kernel;
use freshet_core::plan::Plan;
use freshet_core::scene::Support;

use super::super::{Case, Job, Level, Study, Trace};
use crate::drive::Drive;
use crate::error::LabError;
use crate::measure::curve::Curve;
use crate::measure::oscillation::Oscillation;
use crate::method::Method;
use crate::progress::Progress;
use crate::reference::standing_wave::frequency;
use crate::scenes::GRAVITY;
use crate::scenes::wave::{DEPTH, height, scene, velocity, wavenumber};
use crate::verdict::{Bound, Check};

/// The case.
pub const CASE: Case = Case {
    name: "standing-wave",
    about: "a wave on water twice as long as it is deep, ka = 0.1, by DFSPH: period against potential flow (Airy 1845)",
    run: |job| STUDY.run(job),
};

/// The same with the support at which a lattice resists shear least.
pub const WIDE: Case = Case {
    name: "standing-wave-2.15",
    about: "the same with a support of 2.15 d, at which particles under pressure resist shear least",
    run: |job| {
        Study { name: "standing-wave-2.15", title: "A standing wave, support 2.15 d", simulate: wide, ..STUDY }.run(job)
    },
};

const STUDY: Study = Study {
    name: "standing-wave",
    title: "A standing wave",
    measure: "error of the period",
    bound: 0.05,
    coarse_bound: None,
    smooth: false,
    resolutions: [12, 24, 48],
    quick: &[12],
    axes: ["time (periods of potential flow)", "height of the crest / amplitude"],
    simulate: |job, resolution, progress| simulate(job, Support::Ratio(2.0), resolution, progress),
};

/// Time to simulate, periods, and ticks in each.
const END: u32 = 3;
const TICKS: u32 = 40;
/// How far the period may be from what the lattice's shear moduli make of gravity's.
const OFF_LATTICE: f64 = 0.02;

fn wide(job: &Job, resolution: u32, progress: &mut Progress) -> Result<Level, LabError> {
    simulate(job, Support::Ratio(2.15), resolution, progress)
}

fn simulate(job: &Job, support: Support, resolution: u32, progress: &mut Progress) -> Result<Level, LabError> {
    let mut scene = Method::DivergenceFree.on(scene(resolution));
    scene.settings.support = support;
    let plan = Plan::new(&scene)?;
    let particles = plan.positions.len();
    let parameters = &plan.parameters;
    let [along, across] = Kernel::new(parameters.kernel, parameters.support_radius)
        .map_err(LabError::from)?
        .lattice_shear(parameters.spacing);
    let predicted = (1.0 + along + across).sqrt().recip();
    let mut drive = Drive::open(job.backend, plan, job.threads.count(), Vec::new())?;
    drive.set_velocities(velocity)?;
    let omega = frequency(GRAVITY, wavenumber(), DEPTH);
    let mut heights: Curve = [(0.0, 0.0)].into_iter().collect();
    let ticks = END * TICKS;
    for tick in 1..=ticks {
        drive.tick(TAU / omega / f64::from(TICKS))?;
        heights.push(drive.time() * omega / TAU, height(&drive.positions()?));
        progress.at(f64::from(tick) / f64::from(ticks));
    }
    let swing = Oscillation::of(&heights).unwrap_or(Oscillation { period: f64::NAN, kept: f64::NAN });
    let points = heights.samples().iter().map(|&(time, height)| (time, height, (TAU * time).sin())).collect();
    let off_lattice = Check {
        name: "period off that of water with the lattice's shear moduli".to_owned(),
        value: 100.0 * (swing.period / predicted - 1.0).abs(),
        bound: Bound::AtMost(100.0 * OFF_LATTICE),
        unit: "%",
    };
    Ok(Level {
        resolution,
        particles,
        error: (swing.period - 1.0).abs(),
        traces: vec![Trace { name: "height".to_owned(), points }],
        // A lattice that gives way has no moduli for long.
        checks: if along.min(across) < 0.0 { Vec::new() } else { vec![off_lattice] },
        remarks: vec![
            format!(
                "period {:.3} of that of potential flow; shear moduli {along:.3} and {across:.3} of the pressure say {predicted:.3}",
                swing.period
            ),
            format!("amplitude left after a period: {:.2}", swing.kept),
        ],
        account: drive.account().clone(),
    })
}
