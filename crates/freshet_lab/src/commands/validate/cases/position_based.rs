//! A cube of position-based water at rest: its pressure is that of its weight, and how far it sinks in for that is a matter of iterations and steps.

use freshet_core::field::Field;
use freshet_core::plan::Plan;
use freshet_core::position_based::PositionBased;
use freshet_core::pressure_solver::PressureSolver;

use super::super::{Case, Job, Level, Study, Trace};
use crate::drive::{Account, Drive};
use crate::error::LabError;
use crate::measure::column::PressureProfile;
use crate::measure::statistics::mean;
use crate::progress::Progress;
use crate::reference::hydrostatics;
use crate::scenes::GRAVITY;
use crate::scenes::column::{Container, DEPTH, scene_of};
use crate::verdict::{Bound, Check};

/// The case.
pub const CASE: Case = Case {
    name: "position-based",
    about: "a cube of water, 0.5 m, at rest, position-based with 4 and 32 iterations and two lengths of steps: pressure against the weight above, exact, and how far it sinks in",
    run: |job| SOFTNESS.run(job),
};

const SOFTNESS: Study = Study {
    name: "position-based",
    title: "Position-based water at rest, 0.5 m deep",
    measure: "RMS of the pressure with 32 iterations, means over a support radius, over rho g D",
    bound: 0.05,
    coarse_bound: Some(0.05),
    smooth: false,
    resolutions: [8, 12, 20],
    quick: &[8],
    axes: ["weight above / all of it", "pressure / (rho g D)"],
    simulate,
};

/// Iterations, and ticks of one substep or a few, s, that are tried: the default, more iterations, shorter steps.
const TRIED: [(u32, f64); 3] = [(4, TICK), (32, TICK), (4, TICK / 4.0)];
/// Time to simulate, s, and the last part of it, over which pressures and heights are averaged.
const END: f64 = 4.0;
const LATE: f64 = 1.0;
/// Duration of a tick, s: shorter than any limit of the substep.
pub(super) const TICK: f64 = 1.0 / 120.0;
/// Most of its depth that the default may lose, over the particles of depth: a guard (2.3, 4.3 and 9.7 % were measured at 8, 12 and 20).
const SUNK: f64 = 0.006;
/// Most that a cube with 32 iterations, or steps of a quarter, may lose of what the default does.
const SHARE: f64 = 0.34;

/// What came of a cube.
pub(super) struct Rest {
    pub pressure: PressureProfile,
    /// Share of its depth by which it has sunk in.
    pub sunk: f64,
    pub account: Account,
    pub particles: usize,
}

impl Rest {
    /// Root mean square of the pressure's error over that of the whole depth.
    pub fn error(&self) -> f64 {
        let whole = hydrostatics::pressure(1000.0, GRAVITY, DEPTH);
        self.pressure.deviation(weight_above).unwrap_or(f64::NAN) / whole
    }

    /// Its pressures, by how much of the weight is above.
    pub fn trace(&self, name: String) -> Trace {
        let whole = hydrostatics::pressure(1000.0, GRAVITY, DEPTH);
        let point =
            |(height, pressure): (f64, f64)| (1.0 - height / DEPTH, pressure / whole, weight_above(height) / whole);
        Trace { name, points: self.pressure.points().map(point).collect() }
    }

    /// A sentence about it.
    pub fn remark(&self, name: &str) -> String {
        let (lost, off) = (100.0 * self.sunk, 100.0 * self.error());
        format!("{name}: {lost:.2} % of the depth lost, pressure {off:.2} % off")
    }
}

fn weight_above(height: f64) -> f64 {
    hydrostatics::pressure(1000.0, GRAVITY, DEPTH - height)
}

/// A cube at rest by a solver in ticks of so many seconds.
pub(super) fn rest(
    job: &Job,
    resolution: u32,
    (solver, tick): (PressureSolver, f64),
    done: &mut dyn FnMut(f64),
) -> Result<Rest, LabError> {
    let mut scene = scene_of(Container::Walls, DEPTH as f32, (DEPTH / f64::from(resolution)) as f32)?;
    scene.settings.pressure_solver = solver;
    let plan = Plan::new(&scene)?;
    let (particles, support) = (plan.positions.len(), f64::from(plan.parameters.support_radius));
    let mut drive = Drive::open(job.backend, plan, job.threads.count(), Vec::new())?;
    let ticks = (END / tick).round() as u32;
    let late = ticks - (LATE / tick).round() as u32;
    let (mut pressure, mut heights) = (PressureProfile::new(DEPTH, support), Vec::new());
    for number in 1..=ticks {
        drive.tick(tick)?;
        done(f64::from(number) / f64::from(ticks));
        if number <= late {
            continue;
        }
        let (positions, pressures) = (drive.positions()?, drive.scalars(Field::Pressure)?);
        let mut order: Vec<usize> = (0..positions.len()).collect();
        order.sort_by(|&a, &b| positions[a].y.total_cmp(&positions[b].y));
        // Where it would be if nothing gave in: by how much of the weight is above.
        for (rank, &index) in order.iter().enumerate() {
            let height = DEPTH * (rank as f64 + 0.5) / positions.len() as f64;
            pressure.add(height as f32, pressures[index]);
        }
        heights.extend(positions.iter().map(|x| f64::from(x.y)));
    }
    let sunk = 1.0 - mean(heights).unwrap_or(f64::NAN) / (DEPTH / 2.0);
    Ok(Rest { pressure, sunk, account: drive.account().clone(), particles })
}

fn simulate(job: &Job, resolution: u32, progress: &mut Progress) -> Result<Level, LabError> {
    let mut found = Vec::new();
    for (index, tried) in TRIED.into_iter().enumerate() {
        let mut done = |part: f64| progress.at((index as f64 + part) / TRIED.len() as f64);
        let solver = PositionBased { iterations: tried.0, ..PositionBased::default() };
        let tried_so = (PressureSolver::PositionBased(solver), tried.1);
        found.push((tried, rest(job, resolution, tried_so, &mut done)?));
    }
    let name = |(iterations, tick): (u32, f64)| format!("{iterations} iterations, ticks of {:.1} ms", 1e3 * tick);
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
    for (tried, rest) in &found[1..] {
        let what = format!("depth lost with {}, over that by default", name(*tried));
        checks.push(Check::new(what, rest.sunk / default.sunk, "", Bound::AtMost(SHARE)));
    }
    Ok(Level {
        resolution,
        particles: default.particles,
        error: found[1].1.error(),
        traces: found.iter().map(|(tried, rest)| rest.trace(name(*tried))).collect(),
        checks,
        remarks: found.iter().map(|(tried, rest)| rest.remark(&name(*tried))).collect(),
        account: default.account.clone(),
    })
}
