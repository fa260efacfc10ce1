//! `convergence`: what pressure solvers have left to do, against iterations and against time.

mod report;
mod simulate;

use clap::Args;
use freshet_cpu::Iteration;

pub use simulate::{State, simulate, states};

use crate::backend::Backend;
use crate::error::LabError;
use crate::options::{BackendChoice, CommonOptions, ThreadOption};
use crate::output::{Output, say, say_files};
use crate::progress::Progress;
use crate::verdict::{Bound, Verdict};

/// The divergence solve of DFSPH in one substep from three states: water at rest in a cube, the benchmark tank in the middle of its dam
/// break, a column eighty layers deep. Solved are they by the method (momentum) and by relaxed Jacobi steps, from the pressures of
/// the last substep (warm) and from none (cold), with more and more iterations.
///
/// The error is what the velocities still compress or part in the substep: the mean of |R| over particles, |R| counting where there is pressure or R > 0,
/// by the lab's own sum over all pairs in double precision. Time is that of the solve, the median of repeats in turn.
///
/// Bound: the method reaches a hundredth of the error that a solve begins with, or what 500 iterations of relaxed Jacobi leave if that is more, in a
/// third of the iterations of relaxed Jacobi, in each state, warm and cold; in half of them in the quick form, whose states have fewer layers of particles for pressure to get through. A warm start of water at rest has no bound: what it leaves is little, and chance. On the CPU only. Writes convergence.csv and convergence.svg.
#[derive(Args, Clone, Debug)]
pub struct ConvergenceArgs {
    /// Options every command has.
    #[command(flatten)]
    pub common: CommonOptions,
    /// Threads of the CPU solver.
    #[command(flatten)]
    pub threads: ThreadOption,
    /// Solves of each kind and number of iterations, for their times [default: 3; quick: 1].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=100))]
    pub repeats: Option<u16>,
}

/// Files of the command.
const FILES: [&str; 2] = ["convergence.csv", "convergence.svg"];

/// The share of its first error that a solve has to reach.
pub const GOAL: f64 = 0.01;
/// Most iterations over those of relaxed Jacobi; the same in the quick form.
const MOST: [f64; 2] = [1.0 / 3.0, 1.0 / 2.0];

/// How a solve is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kind {
    /// Which steps.
    pub iteration: Iteration,
    /// Whether it starts from the pressures of the last substep.
    pub warm: bool,
}

impl Kind {
    /// All four.
    pub const ALL: [Self; 4] = [
        Self { iteration: Iteration::Momentum, warm: true },
        Self { iteration: Iteration::Momentum, warm: false },
        Self { iteration: Iteration::Jacobi, warm: true },
        Self { iteration: Iteration::Jacobi, warm: false },
    ];

    /// Name, as in tables and charts.
    pub fn name(self) -> String {
        format!("{}, {}", self.steps(), self.start())
    }

    /// Name of its steps.
    pub fn steps(self) -> &'static str {
        match self.iteration {
            Iteration::Momentum => "momentum",
            Iteration::Jacobi => "Jacobi",
        }
    }

    /// Name of its start.
    pub fn start(self) -> &'static str {
        if self.warm { "warm" } else { "cold" }
    }
}

/// A solve that was ended after some iterations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Iterations made, the first of which only finds out what there is to do.
    pub iterations: u32,
    /// What it left, no unit.
    pub error: f64,
    /// What it took, ms.
    pub milliseconds: f64,
}

/// What a kind of solve leaves, by iterations.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// How it is done.
    pub kind: Kind,
    /// The error it begins with.
    pub first: f64,
    /// In the order of iterations.
    pub points: Vec<Point>,
}

impl Trace {
    /// A hundredth of its first error.
    pub fn goal(&self) -> f64 {
        GOAL * self.first
    }

    /// The smallest error that it came to.
    fn least(&self) -> f64 {
        self.points.iter().map(|point| point.error).fold(self.first, f64::min)
    }

    /// Iterations and milliseconds until no more than `error` is left, between two points in proportion to the logarithm; none if it
    /// never is.
    pub fn until(&self, error: f64) -> Option<(f64, f64)> {
        let start = Point { iterations: 1, error: self.first, milliseconds: 0.0 };
        let after = self.points.iter().position(|point| point.error <= error)?;
        let (before, after) = (after.checked_sub(1).map_or(&start, |before| &self.points[before]), &self.points[after]);
        let share = (before.error / error).ln() / (before.error / after.error.max(f64::MIN_POSITIVE)).ln();
        let between = |from: f64, to: f64| from + share.clamp(0.0, 1.0) * (to - from);
        let iterations = between(f64::from(before.iterations), f64::from(after.iterations));
        Some((iterations, between(before.milliseconds, after.milliseconds)))
    }
}

/// A state and what solves from it leave.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Of the state.
    pub name: &'static str,
    /// Whether it is water at rest.
    pub still: bool,
    /// Particles.
    pub particles: usize,
    /// Substep, s.
    pub substep: f64,
    /// Error with which the method's default settings are content.
    pub tolerance: f64,
    /// One of each kind.
    pub traces: Vec<Trace>,
}

impl Run {
    /// Iterations of the method over those of relaxed Jacobi to the same error: a hundredth of the first one, or, where Jacobi does not come that
    /// far with all that it is given, what it came to.
    fn ratio(&self, warm: bool) -> Option<f64> {
        let of = |iteration| self.traces.iter().find(|trace| trace.kind == Kind { iteration, warm });
        let (method, jacobi) = (of(Iteration::Momentum)?, of(Iteration::Jacobi)?);
        let error = jacobi.goal().max(jacobi.least());
        Some(method.until(error)?.0 / jacobi.until(error)?.0)
    }
}

/// Runs the command.
pub fn run(args: &ConvergenceArgs) -> Result<Verdict, LabError> {
    if args.common.backends(BackendChoice::Cpu).contains(&Backend::Gpu) {
        let reason = "allowed: cpu; the GPU has no relaxed Jacobi steps".to_owned();
        return Err(LabError::Argument { argument: "--backend", reason });
    }
    let output = Output::new(&args.common.out)?;
    let quick = args.common.quick;
    let repeats = args.repeats.unwrap_or(if quick { 1 } else { 3 });
    let states = states(quick);
    let mut progress = Progress::new(states.len() as f64);
    let mut runs = Vec::new();
    for state in &states {
        progress.begin(format!("convergence, {}", state.name), 1.0);
        runs.push(simulate(state, quick, repeats, args.threads.count(), &mut progress)?);
        output.write(FILES[0], report::csv(&runs).text())?;
        crate::chart::draw(&output, FILES[1], &report::chart(&runs))?;
    }
    drop(progress);
    say(report::table(&runs));
    say_files(&output, &FILES);
    Ok(verdict(&runs, quick))
}

/// The bounds of all runs.
pub fn verdict(runs: &[Run], quick: bool) -> Verdict {
    let mut verdict = Verdict::default();
    for run in runs {
        for start in Kind::ALL.into_iter().filter(|kind| kind.iteration == Iteration::Momentum) {
            if run.still && start.warm {
                continue;
            }
            let ratio = run.ratio(start.warm).unwrap_or(f64::NAN);
            let name = format!("convergence, {}, {}: iterations over Jacobi's", run.name, start.start());
            verdict.check(name, ratio, "", Bound::AtMost(MOST[usize::from(quick)]));
        }
    }
    verdict
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trace(kind: Kind, errors: &[(u32, f64)]) -> Trace {
        let point =
            |&(iterations, error): &(u32, f64)| Point { iterations, error, milliseconds: 2.0 * f64::from(iterations) };
        Trace { kind, first: 1.0, points: errors.iter().map(point).collect() }
    }

    fn run(momentum: &[(u32, f64)], jacobi: &[(u32, f64)]) -> Run {
        let errors = |kind: Kind| if kind.iteration == Iteration::Momentum { momentum } else { jacobi };
        let traces = Kind::ALL.into_iter().map(|kind| trace(kind, errors(kind))).collect();
        Run { name: "made up", still: false, particles: 1, substep: 1e-3, tolerance: 1e-3, traces }
    }

    #[test]
    fn the_goal_is_between_two_points_in_proportion_to_the_logarithm() {
        let goal = trace(Kind::ALL[0], &[(2, 0.5), (10, 0.1), (30, 0.001)]).until(0.01);
        assert!(goal.is_some_and(|(n, ms)| (n - 20.0).abs() < 1e-9 && (ms - 40.0).abs() < 1e-9), "{goal:?}");
        let goal = trace(Kind::ALL[0], &[(3, 1e-4)]).until(0.01);
        assert!(goal.is_some_and(|(n, _)| (n - 2.0).abs() < 1e-9), "{goal:?}");
        assert_eq!(trace(Kind::ALL[0], &[(2, 0.5), (10, 0.1)]).until(0.01), None);
    }

    #[test]
    fn the_bound_can_be_missed_and_a_solve_that_never_gets_there_misses_it() {
        assert!(verdict(&[run(&[(10, 0.01)], &[(40, 0.01)])], false).passes());
        assert!(!verdict(&[run(&[(10, 0.01)], &[(20, 0.01)])], false).passes());
        // Where Jacobi ends before a hundredth, both are taken where it ended.
        assert!(verdict(&[run(&[(10, 0.5), (90, 0.01)], &[(100, 0.4)])], false).passes());
        assert!(!verdict(&[run(&[(80, 0.5), (90, 0.01)], &[(100, 0.4)])], false).passes());
        assert!(!verdict(&[run(&[(10, 0.02)], &[(100, 0.01)])], false).passes());
        let still = Run { still: true, ..run(&[(9, 0.01)], &[(10, 0.01)]) };
        assert_eq!(verdict(&[still], false).checks.len(), 1, "the cold start alone");
    }
}
