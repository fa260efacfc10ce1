//! `convergence` in its short form, on one thread: errors do not depend on that, and times have no bound.

use freshet_lab::commands::convergence::{Kind, simulate, states, verdict};
use freshet_lab::error::LabError;
use freshet_lab::progress::Progress;

#[test]
fn the_method_needs_fewer_iterations_than_relaxed_jacobi() -> Result<(), LabError> {
    let runs = states(true)
        .iter()
        .map(|state| simulate(state, true, 1, Some(1), &mut Progress::hidden()))
        .collect::<Result<Vec<_>, _>>()?;
    let verdict = verdict(&runs, true);
    assert!(verdict.passes(), "{verdict}");
    for run in &runs {
        // What the lab finds left falls with both kinds of steps: they solve the same system.
        for trace in &run.traces {
            let last = trace.points.last().map_or(f64::NAN, |point| point.error);
            assert!(last < 0.5 * trace.first, "{}, {}: {last} of {}", run.name, trace.kind.name(), trace.first);
        }
        assert_eq!(run.traces.len(), Kind::ALL.len());
    }
    Ok(())
}
