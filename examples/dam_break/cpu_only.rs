//! Without any adapter: the CPU solver alone, a summary and a plot.

use std::time::Instant;

use freshet_core::field::Field;
use freshet_core::plan::Plan;
use freshet_core::run::SceneRun;
use freshet_core::solver::FluidSolver;
use freshet_cpu::{CpuOptions, CpuSolver};
use freshet_examples::headless::{TICKS_PER_SECOND, ticks};

use crate::arguments::Arguments;
use crate::front::front;
use crate::headless::progress;
use crate::scene::Setup;
use crate::summary::{Sample, Summary};

/// Simulates and writes the summary. Balls need the app, so there are none.
pub fn run(arguments: &Arguments, setup: &Setup) -> Result<(), String> {
    arguments.make_folder()?;
    let begin = Instant::now();
    let plan = Plan::new(&setup.scene).map_err(|error| error.to_string())?;
    print!("{plan}");
    let mut solver = CpuSolver::new(plan.clone(), CpuOptions::default()).map_err(|error| error.to_string())?;
    let mut scene_run = SceneRun::new();
    let mut summary = Summary {
        backend: "cpu".to_owned(),
        adapter: "none".to_owned(),
        spacing: setup.spacing,
        least_time_scale: 1.0,
        ..Summary::default()
    };
    let ticks = ticks(arguments.seconds);
    let bar = progress(u64::from(ticks));
    for _ in 0..ticks {
        let input = scene_run.next(&plan, 1.0 / TICKS_PER_SECOND as f32, Vec::new());
        let started = Instant::now();
        let report = solver.step(&input).map_err(|error| error.to_string())?;
        scene_run.hear(&report);
        summary.solver += started.elapsed().as_secs_f64();
        summary.ticks += 1;
        summary.simulated += report.simulated;
        summary.substeps += u64::from(report.substeps);
        summary.particles = report.particles;
        summary.least_time_scale = summary.least_time_scale.min(report.time_scale);
        summary.mean_compression = summary.mean_compression.max(report.mean_compression);
        summary.max_compression = summary.max_compression.max(report.max_compression);
        summary.max_speed = summary.max_speed.max(report.max_speed);
        summary.removed += u64::from(report.removed);
        let positions = solver.read(Field::Position).map_err(|error| error.to_string())?.vectors().unwrap_or_default();
        if let Some(front) = front(&positions, setup.spacing) {
            summary.fronts.push(Sample { time: summary.simulated, front });
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    summary.wall = begin.elapsed().as_secs_f64();
    summary.write(&arguments.out)
}
