//! Another plan in the middle of a run: what it keeps, what it costs, what it refuses.

use std::time::{Duration, Instant};

use freshet_core::prelude::*;
use freshet_gpu::{DeviceRequest, GpuOptions, GpuSolver, open_device};

use crate::common::{dam_break, device, solver, tick, tick_with};

fn moved(by: f32) -> FluidScene {
    let mut scene = dam_break(0.05);
    scene.boundaries[0].center.x += by;
    scene
}

/// A solver made anew for a plan, at the state of another.
fn anew(scene: &FluidScene, from: &mut GpuSolver) -> GpuSolver {
    let mut fresh = solver(scene);
    fresh.restore(&from.snapshot().unwrap()).unwrap();
    fresh
}

#[test]
fn a_changed_plan_gives_the_bits_of_a_solver_made_for_it() {
    let walls = FluidScene { boundaries: Vec::new(), ..dam_break(0.05) };
    let body = Body { name: "ball".to_owned(), samples: vec![Vec3::ZERO, Vec3::X * 0.04], ..Body::default() };
    let mut kernel = dam_break(0.05);
    kernel.settings.kernel = KernelKind::CubicSpline;
    // A moved wall keeps the pipelines, the others do not; the last comes back to the first.
    let scenes =
        [moved(0.002), walls, kernel, FluidScene { bodies: vec![body], ..dam_break(0.05) }, moved(0.0), moved(0.003)];
    let mut solver = solver(&dam_break(0.05));
    solver.step(&tick(0, 1.0 / 120.0)).unwrap();
    for (scene, number) in scenes.iter().zip(1..) {
        let mut fresh = anew(scene, &mut solver);
        solver.reconfigure(Plan::new(scene).unwrap()).unwrap();
        assert_eq!(solver.schedule().passes, fresh.schedule().passes);
        assert_eq!(solver.shader("density"), fresh.shader("density"));
        let bodies = vec![BodyInput { position: Vec3::splat(0.3), ..Default::default() }; scene.bodies.len()];
        let input = StepInput { bodies, ..tick(number, 1.0 / 120.0) };
        assert_eq!(solver.step(&input).unwrap(), fresh.step(&input).unwrap(), "plan {number}");
        assert!(solver.snapshot().unwrap() == fresh.snapshot().unwrap(), "plan {number}");
    }
}

#[test]
fn a_moved_wall_compiles_nothing() {
    let fastest = |times: &[Duration]| times.iter().min().copied().unwrap_or_default();
    let mut solver = solver(&dam_break(0.05));
    let reconfigured: Vec<Duration> = (1..6u8)
        .map(|n| {
            let plan = Plan::new(&moved(1e-3 * f32::from(n))).unwrap();
            let begin = Instant::now();
            solver.reconfigure(plan).unwrap();
            begin.elapsed()
        })
        .collect();
    let compiled: Vec<Duration> = (0..3)
        .map(|_| {
            let plan = Plan::new(&dam_break(0.05)).unwrap();
            let begin = Instant::now();
            GpuSolver::new(&device().device, &device().queue, plan, GpuOptions::default()).unwrap();
            begin.elapsed()
        })
        .collect();
    println!("a moved wall: {reconfigured:.2?}; a new solver: {compiled:.2?}");
    // With llvmpipe some 8 ms against 400 ms: far enough apart for any machine that has other work.
    assert!(fastest(&reconfigured) * 4 < fastest(&compiled), "{reconfigured:?} against {compiled:?}");
}

#[test]
fn waits_count_on_and_reports_come_all_the_same() {
    let mut solver = solver(&dam_break(0.05));
    solver.step(&tick(0, 0.004)).unwrap();
    let opened = device();
    solver.prepare(&opened.queue, &tick(1, 0.004)).unwrap();
    let mut encoder = opened.device.create_command_encoder(&Default::default());
    solver.encode(&mut encoder).unwrap();
    opened.queue.submit([encoder.finish()]);
    let before = solver.waits();
    assert!(before > 0);
    solver.reconfigure(Plan::new(&moved(0.001)).unwrap()).unwrap();
    assert!(solver.waits() > before, "{} after {before}", solver.waits());
    let reports = solver.collect(&opened.device).unwrap();
    assert_eq!(reports.iter().map(|report| report.tick).collect::<Vec<_>>(), [1]);
    assert_eq!(solver.snapshot().unwrap().tick, 2);
}

#[test]
fn more_particles_than_the_plan_allows_are_refused() {
    let mut full = solver(&dam_break(0.05));
    let state = full.snapshot().unwrap();
    let mut scene = dam_break(0.05);
    scene.volumes[0] = Volume::ball(0.1, Vec3::splat(0.25));
    let mut small = solver(&scene);
    let most = small.plan().max_particles;
    let message =
        format!("ids: {} particles is not allowed; allowed: at most {most}, the plan's max_particles", state.ids.len());
    let before = small.snapshot().unwrap();
    assert_eq!(small.restore(&state).unwrap_err().to_string(), message);
    assert!(small.snapshot().unwrap() == before);
    // Nor a plan for fewer than there are.
    assert_eq!(full.reconfigure(small.plan().clone()).unwrap_err().to_string(), message);
    assert!(full.snapshot().unwrap() == state);
    assert_eq!(full.step(&tick(0, 0.004)).unwrap().particles as usize, state.ids.len());
}

#[test]
fn ticks_have_numbers_below_two_to_the_63() {
    let mut solver = solver(&dam_break(0.05));
    let state = solver.snapshot().unwrap();
    for number in [1 << 63, u64::MAX] {
        let wanted = format!("tick: {number} is not allowed; allowed: 0 to 2^63 - 1");
        assert_eq!(solver.step(&tick(number, 0.001)).unwrap_err().to_string(), wanted);
        assert_eq!(solver.prepare(&device().queue, &tick(number, 0.001)).unwrap_err().to_string(), wanted);
    }
    assert!(solver.snapshot().unwrap() == state);
    assert_eq!(solver.step(&tick(StepInput::MAX_TICK, 0.001)).unwrap().tick, StepInput::MAX_TICK);
    let last = solver.snapshot().unwrap();
    assert_eq!(last.tick, 1 << 63);
    solver.restore(&last).unwrap();
    let error = solver.restore(&Snapshot { tick: u64::MAX, ..last }).unwrap_err().to_string();
    assert!(error.contains("0 to 2^63"), "{error}");
}

#[test]
fn a_tick_that_was_prepared_is_made_before_the_plan_changes() {
    let input = tick_with(0, 0.004, vec![Command::RemoveIds { first: 0, count: 10 }]);
    let mut solver = solver(&dam_break(0.05));
    solver.prepare(&device().queue, &input).unwrap();
    solver.reconfigure(Plan::new(&moved(0.002)).unwrap()).unwrap();
    let reports = solver.collect(&device().device).unwrap();
    assert_eq!(reports.iter().map(|report| (report.tick, report.particles)).collect::<Vec<_>>(), [(0, 990)]);

    let mut stepped = crate::common::solver(&dam_break(0.05));
    stepped.step(&input).unwrap();
    assert!(solver.snapshot().unwrap() == stepped.snapshot().unwrap());
}

#[test]
fn a_device_that_is_lost_is_an_error_whatever_is_asked() {
    let opened = open_device(DeviceRequest::default()).unwrap();
    let plan = Plan::new(&dam_break(0.05)).unwrap();
    let mut solver = GpuSolver::new(&opened.device, &opened.queue, plan.clone(), GpuOptions::default()).unwrap();
    solver.step(&tick(0, 0.004)).unwrap();
    opened.device.destroy();
    let errors = [
        solver.step(&tick(1, 0.004)).map(|_| ()),
        solver.read(Field::Density).map(|_| ()),
        solver.snapshot().map(|_| ()),
        solver.reconfigure(plan),
    ];
    for error in errors {
        assert!(matches!(error, Err(SolverError::Device(_))), "{error:?}");
    }
}
