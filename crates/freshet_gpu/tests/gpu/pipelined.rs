//! Three calls and no waiting.

use freshet_core::prelude::*;
use freshet_gpu::{GpuSolver, TICKS_IN_FLIGHT};

use crate::common::{dam_break, device, solver, tick};

fn submit(solver: &mut GpuSolver, input: &StepInput) {
    let opened = device();
    solver.prepare(&opened.queue, input).unwrap();
    let mut encoder = opened.device.create_command_encoder(&Default::default());
    solver.encode(&mut encoder).unwrap();
    opened.queue.submit([encoder.finish()]);
}

/// Collects until nothing is in flight, by polling: the solver itself does not wait.
fn drain(solver: &mut GpuSolver, reports: &mut Vec<StepReport>) {
    while solver.ticks_in_flight() > 0 {
        std::thread::sleep(std::time::Duration::from_millis(1));
        reports.extend(solver.collect(&device().device).unwrap());
    }
}

#[test]
fn three_ticks_in_flight_never_wait_and_give_the_bits_of_lockstep() {
    let mut lockstep = solver(&dam_break(0.05));
    let wanted: Vec<StepReport> = (0..9).map(|n| lockstep.step(&tick(n, 1.0 / 120.0)).unwrap()).collect();

    let mut pipelined = solver(&dam_break(0.05));
    let mut reports = Vec::new();
    for n in 0..9 {
        submit(&mut pipelined, &tick(n, 1.0 / 120.0));
        if n % 3 == 2 {
            assert_eq!(pipelined.ticks_in_flight(), TICKS_IN_FLIGHT);
            drain(&mut pipelined, &mut reports);
        }
    }
    assert_eq!(pipelined.waits(), 0, "the pipelined mode waited");
    assert_eq!(reports, wanted);
    assert!(pipelined.snapshot().unwrap() == lockstep.snapshot().unwrap());
}

#[test]
fn a_fourth_tick_in_flight_waits_once_and_counts_it() {
    let mut solver = solver(&dam_break(0.05));
    let opened = device();
    // Commands that are held back stand for a GPU that is late: llvmpipe itself works within the submit.
    let mut held = Vec::new();
    for n in 0..4 {
        solver.prepare(&opened.queue, &tick(n, 1.0 / 60.0)).unwrap();
        let mut encoder = opened.device.create_command_encoder(&Default::default());
        solver.encode(&mut encoder).unwrap();
        held.push(encoder.finish());
        let reports = if n < 3 { solver.collect(&opened.device).unwrap() } else { Vec::new() };
        assert_eq!((reports.len(), solver.waits()), (0, 0), "three in flight do not wait");
    }
    assert!(solver.collect(&opened.device).unwrap().is_empty());
    assert_eq!((solver.ticks_in_flight(), solver.waits()), (4, 1));
    opened.queue.submit(held);
    let mut reports = Vec::new();
    drain(&mut solver, &mut reports);
    assert_eq!(reports.iter().map(|report| report.tick).collect::<Vec<_>>(), [0, 1, 2, 3]);
}

#[test]
fn several_ticks_share_an_encoder() {
    let mut lockstep = solver(&dam_break(0.05));
    for n in 0..3 {
        lockstep.step(&tick(n, 0.004 * (n + 1) as f32)).unwrap();
    }
    let mut shared = solver(&dam_break(0.05));
    let opened = device();
    let mut encoder = opened.device.create_command_encoder(&Default::default());
    for n in 0..3 {
        shared.prepare(&opened.queue, &tick(n, 0.004 * (n + 1) as f32)).unwrap();
    }
    shared.encode(&mut encoder).unwrap();
    opened.queue.submit([encoder.finish()]);
    let mut reports = Vec::new();
    drain(&mut shared, &mut reports);
    assert_eq!(reports.iter().map(|report| report.tick).collect::<Vec<_>>(), [0, 1, 2]);
    assert!(shared.snapshot().unwrap() == lockstep.snapshot().unwrap());
}

#[test]
fn a_shortfall_is_carried_over() {
    let mut scene = dam_break(0.05);
    scene.settings.max_substeps = 3;
    let mut solver = solver(&scene);
    let first = solver.step(&tick(0, 1.0 / 60.0)).unwrap();
    assert_eq!(first.substeps, 3);
    assert!(first.time_scale < 1.0, "{first:?}");
    let carry = solver.snapshot().unwrap().carry;
    assert!((f64::from(carry) + first.simulated - 1.0 / 60.0).abs() < 1e-6);
    let second = solver.step(&tick(1, 0.0)).unwrap();
    assert!(second.simulated > 0.0 && second.substeps > 0, "what was left over is made up: {second:?}");
}

/// Ticks of a jet that leave half of their time over, then short ones that make up for it; each is told to the solver before
/// the report of the third before it is known, in which time `SceneRun` cannot know where the jet is.
#[test]
fn a_jet_is_even_though_its_emitter_hears_late_of_what_was_simulated() {
    let mut scene = FluidScene { gravity: Vec3::ZERO, ..FluidScene::with_spacing(0.05) };
    scene.emitters =
        vec![Emitter { center: Vec3::Y, direction: Vec3::X, radius: 0.1, speed: 2.0, lifetime: f32::INFINITY }];
    scene.settings.max_substeps = 10;
    scene.settings.max_particles = Some(1000);
    let (emitter, opened) = (scene.emitters[0].clone(), device());
    let mut solver = solver(&scene);
    let (mut run, mut reports, mut heard) = (SceneRun::new(), Vec::new(), 0);
    for n in 0..60 {
        if n % 3 == 0 {
            drain(&mut solver, &mut reports);
            reports[heard..].iter().for_each(|report| run.hear(report));
            heard = reports.len();
        }
        let input = run.next(solver.plan(), [0.02, 0.015, 0.02, 0.001, 0.002, 0.0][n % 6], Vec::new());
        solver.prepare(&opened.queue, &input).unwrap();
        // Some ticks share an encoder.
        if n % 3 != 1 {
            let mut encoder = opened.device.create_command_encoder(&Default::default());
            solver.encode(&mut encoder).unwrap();
            opened.queue.submit([encoder.finish()]);
        }
    }
    drain(&mut solver, &mut reports);
    assert_eq!(reports.len(), 60);
    assert!(reports.iter().filter(|report| report.time_scale < 0.7).count() > 15, "time is carried over");

    let snapshot = solver.snapshot().unwrap();
    let simulated: f64 = reports.iter().map(|report| report.simulated).sum();
    assert!((snapshot.time - simulated).abs() < 1e-9);
    let gap = emitter.interval(0.05) as f32 * emitter.speed;
    let along = |layer: &[Vec3]| layer.iter().map(|position| position.x).sum::<f32>() / layer.len() as f32;
    let layers: Vec<f32> = snapshot.positions.chunks(emitter.layer(0.05).len()).map(along).collect();
    assert!(layers.len() > 10 && layers.last().is_some_and(|last| *last < gap), "{layers:?}");
    assert!((layers[0] - emitter.speed * simulated as f32).abs() < 0.025, "{layers:?} after {simulated} s");
    for pair in layers.windows(2) {
        assert!(((pair[0] - pair[1]) / gap - 1.0).abs() < 0.05, "{layers:?}");
    }
    // What the solver says of the last layer is what was sent.
    let index = layers.len() as f64 - 1.0;
    assert!((snapshot.emitted.unwrap() - index * emitter.interval(0.05)).abs() < 1e-9);
}

#[test]
fn preparing_without_collecting_is_refused_at_eight() {
    let mut solver = solver(&dam_break(0.05));
    for n in 0..8 {
        solver.prepare(&device().queue, &tick(n, 0.001)).unwrap();
    }
    let error = solver.prepare(&device().queue, &tick(8, 0.001)).unwrap_err();
    assert!(error.to_string().contains("none collected"), "{error}");
}

#[test]
fn reading_in_between_loses_no_report() {
    let mut solver = solver(&dam_break(0.05));
    submit(&mut solver, &tick(0, 0.004));
    submit(&mut solver, &tick(1, 0.004));
    solver.snapshot().unwrap();
    solver.prepare(&device().queue, &tick(2, 0.004)).unwrap();
    assert_eq!(solver.step(&tick(3, 0.004)).unwrap().tick, 3);
    let late = solver.collect(&device().device).unwrap();
    assert_eq!(late.iter().map(|report| report.tick).collect::<Vec<_>>(), [0, 1, 2]);
    assert_eq!(solver.snapshot().unwrap().tick, 4);
}
