//! `integrators`: how long a step each integrator bears, how exact it is, what it does to energy and to a fluid.

mod fluid;
mod oscillation;
mod printed;
mod report;

use clap::Args;

pub use fluid::{Fluid, simulate, stepped};
pub use oscillation::Found;
pub use printed::{Comparison, compare};

use crate::backend::Backend;
use crate::chart;
use crate::commands::dam_break::SHIFTED_RMS_BOUND;
use crate::error::LabError;
use crate::options::{BackendChoice, CommonOptions, ThreadOption};
use crate::output::{Output, say, say_files};
use crate::progress::Progress;
use crate::reference::integrators::KNOWN;
use crate::reference::lobovsky_2014;
use crate::verdict::{Bound, Verdict};

use oscillation::{BOUNDED, NONE};

/// All ten integrators on an oscillator, undamped and critically damped, and the eight that solvers have in a dam break.
///
/// The limit of omega h is the step up to which the spectral radius of the one-step matrix is at most 1 + 1e-9, found by bisection; runs of 100,000
/// steps 0.1 % below and above it confirm it. Orders are those of the largest error up to omega t = 4 between steps of 0.0125 and
/// 0.00625; energy is compared at omega h = 0.2. Beside them the tables 2.1 to 2.4 of Pirovano 2011, with the same runs made here, and why where they differ.
///
/// The dam break is that of Lobovsky et al. 2014 with the plan's own steps, weakly compressible, 12 particles along the column's width [full: 20]; in the full
/// form the largest stable step of each integrator is searched for, too, in the two scenes of the command stability.
///
/// Bounds: limits as derived, to 0.0006; what has none grows in the run all the same; runs below stay within a thousand amplitudes and runs above do not; orders as
/// derived, to 0.1; fronts with the best shift of the clock within 5 % of the experiment, and no particle lost. Writes integrators.csv,
/// integrators_pirovano_2011.csv, integrators_dam_break.csv and integrators.svg.
#[derive(Args, Clone, Debug)]
pub struct IntegratorsArgs {
    /// Options every command has. The dam breaks run on the CPU unless another backend is given.
    #[command(flatten)]
    pub common: CommonOptions,
    /// Threads of the CPU solver.
    #[command(flatten)]
    pub threads: ThreadOption,
}

/// Files of the command.
const FILES: [&str; 4] =
    ["integrators.csv", "integrators_pirovano_2011.csv", "integrators.svg", "integrators_dam_break.csv"];

/// How far a limit may be from the derived one, which has three digits or more.
const LIMIT_TOLERANCE: f64 = 6e-4;
/// How far an observed order may be from the derived one.
const ORDER_TOLERANCE: f64 = 0.1;

/// Runs the command.
pub fn run(args: &IntegratorsArgs) -> Result<Verdict, LabError> {
    let output = Output::new(&args.common.out)?;
    let found = Found::all();
    let comparisons = compare(&found);
    output.write(FILES[0], report::limits(&found).text())?;
    output.write(FILES[1], report::printed(&comparisons).text())?;
    chart::draw(&output, FILES[2], &report::chart(&found))?;
    say(report::table(&found));
    say(printed::table(&comparisons));
    let backends = args.common.backends(BackendChoice::Cpu);
    let mut progress = Progress::new((backends.len() * stepped().len()) as f64);
    let mut fluids = Vec::new();
    for &backend in backends {
        // A GPU driver in software gets the short form.
        let quick = args.common.quick || backend == Backend::Gpu && backend.is_processor()?;
        for integrator in stepped() {
            progress.begin(format!("dam break, {}, {backend}", integrator.name()), 1.0);
            let (experiment, resolution) = (&lobovsky_2014::SQUARE, if quick { 12 } else { 20 });
            let searches = !quick && backend == Backend::Cpu;
            let threads = args.threads.count();
            fluids.push(simulate(integrator, experiment, resolution, backend, threads, searches, &mut progress)?);
            output.write(FILES[3], fluid::csv(&fluids).text())?;
        }
    }
    drop(progress);
    say(fluid::table(&fluids));
    say_files(&output, &FILES);
    let mut verdict = verdict(&found);
    check_fluids(&fluids, &mut verdict);
    Ok(verdict)
}

/// The bounds of dam breaks.
pub fn check_fluids(fluids: &[Fluid], verdict: &mut Verdict) {
    for Fluid { integrator, run, .. } in fluids {
        let at = |what: &str| format!("dam break, {}, {}: {what}", integrator.name(), run.backend);
        let bound = Bound::Below(100.0 * SHIFTED_RMS_BOUND);
        verdict.check(at("RMS error of the front with shift"), 100.0 * run.error.rms_shifted, "%", bound);
        let lost = run.account.lost as f64 + run.escaped as f64;
        verdict.check(at("particles lost or through a wall"), lost, "", Bound::AtMost(0.0));
    }
}

/// The bounds of oscillators.
pub fn verdict(found: &[Found]) -> Verdict {
    let mut verdict = Verdict::default();
    for one in found {
        let Some(known) = KNOWN.iter().find(|known| known.integrator == one.integrator) else { continue };
        let at = |what: &str| {
            let damping = if one.damped { "critically damped" } else { "undamped" };
            format!("{}, {damping}: {what}", one.integrator.name())
        };
        let (limit, order) = (known.limits[usize::from(one.damped)], known.orders[usize::from(one.damped)]);
        let bound = match limit {
            0.0 => Bound::Below(NONE),
            limit => Bound::Within(limit - LIMIT_TOLERANCE, limit + LIMIT_TOLERANCE),
        };
        verdict.check(at("limit of omega h"), one.limit, "", bound);
        if let Some(below) = one.below {
            verdict.check(at("amplitude just below"), below, "", Bound::Below(BOUNDED));
        }
        verdict.check(at("amplitude just above"), one.above, "", Bound::AtLeast(BOUNDED));
        let within = Bound::Within(order - ORDER_TOLERANCE, order + ORDER_TOLERANCE);
        verdict.check(at("order of the position"), one.orders()[0], "", within);
    }
    verdict
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_and_orders_are_those_derived_and_others_miss_their_bounds() {
        let found = Found::all();
        let kept = verdict(&found);
        // Two oscillators, ten integrators, four checks, of which two integrators have no limit to run below.
        assert!(kept.passes() && kept.checks.len() == 2 * 10 * 4 - 2, "{kept}");
        for (index, spoil) in [
            (1, (|one| one.limit += 0.001) as fn(&mut Found)),
            (0, |one| one.limit = 0.03),
            (2, |one| one.below = Some(1e4)),
            (9, |one| one.above = 10.0),
            (3, |one| one.errors.iter_mut().for_each(|point| point.1 /= point.0)),
        ] {
            let mut spoilt = found.clone();
            spoil(&mut spoilt[index]);
            assert_eq!(verdict(&spoilt).missed().count(), 1, "{index}");
        }
    }
}
