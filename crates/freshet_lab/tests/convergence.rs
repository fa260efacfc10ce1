//! `convergence` in its short form, on one thread: errors do not depend on that, and times have no bound.

use freshet_lab::commands::convergence::{ConvergenceArgs, Kind, run, simulate, states, verdict};
use freshet_lab::error::LabError;
use freshet_lab::options::{BackendChoice, CommonOptions};
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

/// The GPU has no relaxed Jacobi steps to compare with: asked for it, the command says so and does nothing.
#[test]
fn the_gpu_is_refused_by_name() {
    for choice in [BackendChoice::Gpu, BackendChoice::Both] {
        let out = std::env::temp_dir().join(format!("freshet_lab_convergence_{}", std::process::id()));
        let common = CommonOptions { quick: true, backend: Some(choice), out: out.clone() };
        let refused = run(&ConvergenceArgs { common, threads: Default::default(), repeats: None });
        let Err(LabError::Argument { argument, reason }) = refused else { panic!("{choice:?}: {refused:?}") };
        assert!(argument == "--backend" && reason.starts_with("allowed: cpu"), "{argument}: {reason}");
        assert!(!out.exists(), "{choice:?}");
    }
}
