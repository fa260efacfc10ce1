//! A cube of water at rest by pressure-corrected SPH, both gradients: its pressure is that of its weight, or the gradient does not hold it.

use freshet_core::pressure_corrected::{PressureCorrected, PressureGradient};
use freshet_core::pressure_solver::PressureSolver;

use super::super::{Case, Job, Level, Study};
use super::position_based::{TICK, rest};
use crate::error::LabError;
use crate::progress::Progress;
use crate::verdict::{Bound, Check};

/// The case.
pub const CASE: Case = Case {
    name: "pressure-corrected",
    about: "a cube of water, 0.5 m, at rest, pressure-corrected with 4 and 32 iterations, two lengths of steps and both gradients: pressure against the weight above, exact, and how far it sinks in",
    run: |job| WEIGHT.run(job),
};

const WEIGHT: Study = Study {
    name: "pressure-corrected",
    title: "Pressure-corrected water at rest, 0.5 m deep",
    measure: "RMS of the pressure with 32 iterations, means over a support radius, over rho g D",
    bound: 0.05,
    coarse_bound: Some(0.05),
    smooth: false,
    resolutions: [8, 12, 20],
    quick: &[8],
    axes: ["weight above / all of it", "pressure / (rho g D)"],
    simulate,
};

/// Gradient, iterations, and ticks of one substep or a few, s, that are tried: the default, more iterations, shorter steps, the other gradient.
const TRIED: [(PressureGradient, u32, f64); 4] = [
    (PressureGradient::Sum, 4, TICK),
    (PressureGradient::Sum, 32, TICK),
    (PressureGradient::Sum, 4, TICK / 4.0),
    (PressureGradient::Difference, 4, TICK),
];
/// Most of its depth that the default may lose, over the particles of depth: a guard.
const SUNK: f64 = 0.006;
/// Most that a cube with 32 iterations, or steps of a quarter, may lose of what the default does.
const SHARE: f64 = 0.4;

fn simulate(job: &Job, resolution: u32, progress: &mut Progress) -> Result<Level, LabError> {
    let mut found = Vec::new();
    for (index, (gradient, iterations, tick)) in TRIED.into_iter().enumerate() {
        let mut done = |part: f64| progress.at((index as f64 + part) / TRIED.len() as f64);
        let solver = PressureSolver::PressureCorrected(PressureCorrected { iterations, gradient });
        let name = format!("{iterations} iterations by {}, ticks of {:.1} ms", gradient.name(), 1e3 * tick);
        found.push((name, rest(job, resolution, (solver, tick), &mut done)?));
    }
    let default = &found[0].1;
    let mut checks = vec![
        Check::new(
            "depth lost by default",
            100.0 * default.sunk,
            "%",
            Bound::AtMost(100.0 * SUNK * f64::from(resolution)),
        ),
        Check::new("RMS of the pressure by default", 100.0 * default.error(), "%", Bound::AtMost(10.0)),
    ];
    for (name, rest) in &found[1..3] {
        let what = format!("depth lost with {name}, over that by default");
        checks.push(Check::new(what, rest.sunk / default.sunk, "", Bound::AtMost(SHARE)));
    }
    Ok(Level {
        resolution,
        particles: default.particles,
        error: found[1].1.error(),
        traces: found[..3].iter().map(|(name, rest)| rest.trace(name.clone())).collect(),
        checks,
        // The difference's is no check: what it does is said.
        remarks: found.iter().map(|(name, rest)| rest.remark(name)).collect(),
        account: default.account.clone(),
    })
}
