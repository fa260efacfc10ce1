//! One substep from a state, over and over.

use freshet_core::plan::Plan;
use freshet_core::pressure_solver::{DivergenceFree, PressureSolver};
use freshet_core::scene::FluidScene;
use freshet_core::snapshot::Snapshot;
use freshet_core::solver::FluidSolver;
use freshet_core::step::StepInput;
use freshet_cpu::{CpuOptions, CpuSolver};

use super::{GOAL, Kind, Point, Run, Trace};
use crate::error::LabError;
use crate::measure::density_rates::DensityRates;
use crate::measure::statistics::median;
use crate::method::Method;
use crate::progress::Progress;
use crate::scenes::column::walled;
use crate::scenes::tank;

/// A scene and when to look at it.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Name, as in tables and charts.
    pub name: &'static str,
    /// Whether it is water at rest.
    pub still: bool,
    /// Scene.
    pub scene: FluidScene,
    /// Time to simulate before, s.
    pub seconds: f64,
}

/// The three states.
pub fn states(quick: bool) -> [State; 3] {
    let (edge, spacing) = if quick { (14.0, 0.05) } else { (20.0, 0.025) };
    let state = |name, still, scene, seconds| State { name, still, scene: Method::DivergenceFree.on(scene), seconds };
    let cube = 0.5;
    [
        state("at rest", true, walled(cube, cube.into(), cube / edge), if quick { 1.0 } else { 3.0 }),
        state("dam break", false, tank::scene(if quick { 3375 } else { 8000 }), 0.3),
        state("column", true, walled(0.25, if quick { 1.0 } else { 2.0 }, spacing), 1.0),
    ]
}

/// Duration of a tick before, s.
const TICK: f64 = 1.0 / 60.0;
/// Most iterations of a solve.
const MOST_ITERATIONS: u32 = 500;
/// The same of the quick form.
const QUICK_MOST: u32 = 300;

/// A divergence that is never reached, so that what ends a solve is its number of iterations.
const EXACT: f32 = 1e-6;
/// One that every state has from the start; no scene may ask for it.
const CONTENT: f32 = 1e9;

/// Numbers of iterations that are tried, each about a fifth more than the one before.
fn tried(most: u32) -> impl Iterator<Item = u32> {
    std::iter::successors(Some(2), |&n| Some(n + 1 + n / 5)).take_while(move |&n| n <= most)
}

/// Solves from a state by all kinds, `repeats` times.
pub fn simulate(
    state: &State,
    quick: bool,
    repeats: u16,
    threads: Option<usize>,
    progress: &mut Progress,
) -> Result<Run, LabError> {
    let plan = Plan::new(&state.scene)?;
    let mut bench = Bench::new(&plan, state.seconds, threads)?;
    let mut traces = Vec::new();
    for kind in Kind::ALL {
        traces.push(Trace { kind, first: bench.first_error(kind)?, points: Vec::new() });
    }
    let most = if quick { QUICK_MOST } else { MOST_ITERATIONS };
    let total: u32 = tried(most).sum();
    let mut done = 0;
    for iterations in tried(most) {
        for (trace, kind) in traces.iter_mut().zip(Kind::ALL) {
            // A tenth of the goal and below nothing is asked for, and single precision ends somewhere.
            if trace.points.last().is_some_and(|last| last.error < 0.1 * GOAL * trace.first) {
                continue;
            }
            let mut times = Vec::new();
            let (made, milliseconds) = bench.solve(kind, iterations, EXACT)?;
            times.push(milliseconds);
            let error = bench.error(kind)?;
            for _ in 1..repeats {
                times.push(bench.solve(kind, iterations, EXACT)?.1);
            }
            let milliseconds = median(&times).unwrap_or(f64::NAN);
            if made > trace.points.last().map_or(0, |last| last.iterations) {
                trace.points.push(Point { iterations: made, error, milliseconds });
            }
        }
        done += iterations;
        progress.at(f64::from(done) / f64::from(total));
    }
    let tolerance = f64::from(DivergenceFree::default().divergence * bench.way).max(LEAST);
    Ok(Run {
        name: state.name,
        still: state.still,
        particles: bench.rates_count(),
        substep: bench.substep.into(),
        tolerance,
        traces,
    })
}

/// See [`DivergenceFree::LEAST_DIVERGENCE`].
const LEAST: f64 = DivergenceFree::LEAST_DIVERGENCE as f64;

/// Solvers of both kinds at a state.
struct Bench {
    plan: Plan,
    solvers: [CpuSolver; 2],
    /// With the pressures of the last substep, and with none.
    starts: [Snapshot; 2],
    rates: DensityRates,
    substep: f32,
    /// Of the fastest particle over the longest allowed, in the last substep made.
    way: f32,
}

impl Bench {
    fn new(plan: &Plan, seconds: f64, threads: Option<usize>) -> Result<Self, LabError> {
        let open = |iteration| {
            let options = CpuOptions { threads, iteration, ..CpuOptions::default() };
            CpuSolver::new(plan.clone(), options)
        };
        let mut solvers = [open(Kind::ALL[0].iteration)?, open(Kind::ALL[2].iteration)?];
        let mut last = Default::default();
        for tick in 0..(seconds / TICK).round() as u64 {
            last = solvers[0].step(&StepInput { tick, duration: TICK as f32, ..StepInput::default() })?;
        }
        let warm = solvers[0].snapshot()?;
        let cold = Snapshot { pressures: vec![0.0; warm.ids.len()], last_substep: 0.0, ..warm.clone() };
        let rates = DensityRates::new(plan, &warm.positions)?;
        // A little less than the last ones, so that it is within the limits from any start.
        let substep = 0.9 * last.simulated as f32 / last.substeps.max(1) as f32;
        Ok(Self { plan: plan.clone(), solvers, starts: [warm, cold], rates, substep, way: 0.0 })
    }

    fn rates_count(&self) -> usize {
        self.starts[0].ids.len()
    }

    fn solver(&mut self, kind: Kind) -> &mut CpuSolver {
        &mut self.solvers[usize::from(kind.iteration != Kind::ALL[0].iteration)]
    }

    /// A substep with so many iterations, or fewer if it is as exact as asked for; returns those made and the solve's time, ms.
    fn solve(&mut self, kind: Kind, iterations: u32, divergence: f32) -> Result<(u32, f64), LabError> {
        let mut plan = self.plan.clone();
        let settings = DivergenceFree { divergence, compression: 0.1, max_iterations: iterations };
        plan.parameters.pressure_solver = PressureSolver::DivergenceFree(settings);
        let (start, duration) = (self.starts[usize::from(!kind.warm)].clone(), self.substep);
        let solver = self.solver(kind);
        solver.reconfigure(plan)?;
        solver.restore(&start)?;
        let report = solver.step(&StepInput { tick: start.tick, duration, ..StepInput::default() })?;
        let what = "a solve";
        if report.substeps != 1 {
            let reason = format!("{} substeps instead of one", report.substeps);
            return Err(LabError::Measure { what, reason });
        }
        self.way = (report.max_speed * duration / self.plan.parameters.longest_way()).min(1.0);
        let time = report.passes.iter().find(|pass| pass.pass == "divergence_solve");
        let time = time.ok_or_else(|| LabError::Measure { what, reason: "it was not timed".to_owned() })?;
        Ok((report.divergence_iterations, f64::from(time.milliseconds)))
    }

    /// What the last substep left.
    fn error(&mut self, kind: Kind) -> Result<f64, LabError> {
        let end = self.solver(kind).snapshot()?;
        Ok(self.rates.left(&end.velocities, &end.pressures, self.substep.into(), self.way))
    }

    /// What there is to do before anything is done.
    fn first_error(&mut self, kind: Kind) -> Result<f64, LabError> {
        self.solve(kind, 2, CONTENT)?;
        self.error(kind)
    }
}
