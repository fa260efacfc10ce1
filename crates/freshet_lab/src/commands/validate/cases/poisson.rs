//! A cube of water at rest with pressures by a Poisson equation: its pressure is that of its weight, and iterations that end early leave it soft.

use freshet_core::pressure_poisson::PressurePoisson;
use freshet_core::pressure_solver::PressureSolver;

use super::super::{Case, Job, Level, Study};
use super::position_based::{TICK, rest};
use crate::error::LabError;
use crate::progress::Progress;
use crate::verdict::{Bound, Check};

/// The case.
pub const CASE: Case = Case {
    name: "poisson",
    about: "a cube of water, 0.5 m, at rest, pressures by a Poisson equation (MPS) with two tolerances and two lengths of steps: pressure against the weight above, exact, and how far it sinks in",
    run: |job| WEIGHT.run(job),
};

const WEIGHT: Study = Study {
    name: "poisson",
    title: "Water at rest by a pressure Poisson equation, 0.5 m deep",
    measure: "RMS of the pressure by default, means over a support radius, over rho g D",
    bound: 0.1,
    coarse_bound: Some(0.1),
    smooth: false,
    resolutions: [8, 12, 20],
    quick: &[8],
    axes: ["weight above / all of it", "pressure / (rho g D)"],
    simulate,
};

/// Tolerance, most iterations, and ticks of one substep or a few, s, that are tried: the default, a finer one, shorter steps.
const TRIED: [(f32, u32, f64); 3] = [(0.02, 60, TICK), (0.002, 300, TICK), (0.02, 60, TICK / 4.0)];
/// Most of its depth that a cube may lose, %: a guard.
const SUNK: f64 = 2.0;

fn simulate(job: &Job, resolution: u32, progress: &mut Progress) -> Result<Level, LabError> {
    let mut found = Vec::new();
    for (index, (tolerance, max_iterations, tick)) in TRIED.into_iter().enumerate() {
        let mut done = |part: f64| progress.at((index as f64 + part) / TRIED.len() as f64);
        let solver = PressureSolver::PressurePoisson(PressurePoisson { tolerance, max_iterations });
        let name = format!("to {tolerance}, at most {max_iterations} iterations, ticks of {:.1} ms", 1e3 * tick);
        found.push((name, rest(job, resolution, (solver, tick), &mut done)?));
    }
    let mut checks = Vec::new();
    for (name, rest) in &found {
        checks.push(Check::new(format!("depth lost, {name}"), 100.0 * rest.sunk, "%", Bound::AtMost(SUNK)));
        checks.push(Check::new(format!("RMS of the pressure, {name}"), 100.0 * rest.error(), "%", Bound::AtMost(10.0)));
    }
    let default = &found[0].1;
    Ok(Level {
        resolution,
        particles: default.particles,
        error: default.error(),
        traces: found.iter().map(|(name, rest)| rest.trace(name.clone())).collect(),
        checks,
        remarks: found.iter().map(|(name, rest)| rest.remark(name)).collect(),
        account: default.account.clone(),
    })
}
