//! What the tests of whole runs share.

use freshet_core::prelude::*;
use freshet_cpu::{CpuOptions, CpuSolver};

/// A scene's solver on so many threads.
pub fn solver(scene: &FluidScene, threads: usize) -> CpuSolver {
    CpuSolver::new(Plan::new(scene).unwrap(), CpuOptions { threads: Some(threads), ..CpuOptions::default() }).unwrap()
}

/// Ticks of a sixtieth of a second.
#[allow(dead_code)] // Tests with bodies have ticks of their own.
pub fn run(solver: &mut CpuSolver, ticks: u64) -> Vec<StepReport> {
    let start = solver.snapshot().unwrap();
    let mut scene = SceneRun::resume(&start);
    (0..ticks)
        .map(|_| {
            let input = scene.next(solver.plan(), 1.0 / 60.0, Vec::new());
            let report = solver.step(&input).unwrap();
            scene.hear(&report);
            report
        })
        .collect()
}
