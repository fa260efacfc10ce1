//! Whole runs: determinism, conservation, spawning and removing, carried time, snapshots, a body.

use freshet_core::prelude::*;
use freshet_cpu::{CpuOptions, CpuSolver};
use glam::DVec3;

fn dam_break() -> FluidScene {
    FluidScene {
        volumes: vec![Volume::block(Vec3::new(0.25, 0.3, 0.25), Vec3::new(0.25, 0.3, 0.25))],
        boundaries: vec![Boundary::open_box(Vec3::new(1.0, 1.0, 0.5), Vec3::new(0.5, 0.5, 0.25))],
        ..FluidScene::with_spacing(0.05)
    }
}

fn solver(scene: &FluidScene, threads: usize) -> CpuSolver {
    CpuSolver::new(Plan::new(scene).unwrap(), CpuOptions { threads: Some(threads), ..CpuOptions::default() }).unwrap()
}

fn run(solver: &mut CpuSolver, ticks: u64) -> Vec<StepReport> {
    let start = solver.snapshot().unwrap();
    let mut scene = SceneRun::at(start.tick, start.time);
    (0..ticks)
        .map(|_| {
            let input = scene.next(solver.plan(), 1.0 / 60.0, Vec::new());
            solver.step(&input).unwrap()
        })
        .collect()
}

/// FNV-1a over the bits of the state in the order of ids.
fn hash(solver: &mut CpuSolver) -> u64 {
    let state = solver.snapshot().unwrap();
    let bits = state.positions.iter().chain(&state.velocities).flat_map(|value| value.to_array().map(f32::to_bits));
    bits.flat_map(u32::to_le_bytes)
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

/// Sum of velocities, m/s.
fn total_velocity(solver: &mut CpuSolver) -> DVec3 {
    solver.read(Field::Velocity).unwrap().vectors().unwrap().iter().map(|v| v.as_dvec3()).sum()
}

#[test]
fn same_bits_from_run_to_run_and_whatever_the_number_of_threads() {
    let hashes = [1, 2, 2, 3].map(|threads| {
        let mut solver = solver(&dam_break(), threads);
        run(&mut solver, 30);
        hash(&mut solver)
    });
    assert!(hashes.iter().all(|&other| other == hashes[0]), "{hashes:x?}");
}

#[test]
fn a_snapshot_continues_with_the_same_bits() {
    let mut whole = solver(&dam_break(), 2);
    run(&mut whole, 20);
    let mut first = solver(&dam_break(), 2);
    run(&mut first, 10);
    let bytes = first.snapshot().unwrap().to_bytes().unwrap();
    let mut second = solver(&dam_break(), 1);
    second.restore(&Snapshot::from_bytes(&bytes).unwrap()).unwrap();
    run(&mut second, 10);
    assert_eq!(hash(&mut whole), hash(&mut second));
}

#[test]
fn momentum_in_free_flight_is_kept_to_rounding() {
    let mut scene = FluidScene { gravity: Vec3::ZERO, ..FluidScene::with_spacing(0.05) };
    let throw =
        |x: f32, velocity: Vec3| Volume { velocity, ..Volume::block(Vec3::splat(0.15), Vec3::new(x, 0.0, 0.0)) };
    scene.volumes = vec![throw(-0.16, Vec3::new(1.0, 0.2, 0.0)), throw(0.16, Vec3::new(-0.5, 0.0, 0.1))];
    let mut solver = solver(&scene, 2);
    let before = total_velocity(&mut solver);
    let reports = run(&mut solver, 30);
    let lost = (total_velocity(&mut solver) - before) / f64::from(reports[29].particles);
    assert!(reports.iter().map(|report| report.substeps).sum::<u32>() > 100);
    // Each substep rounds each velocity by up to 6e-8 m/s, to either side.
    assert!(lost.length() < 1e-6, "{lost} m/s a particle");
}

#[test]
fn a_dam_break_stays_inside_and_in_real_time() {
    let mut solver = solver(&dam_break(), 2);
    for report in run(&mut solver, 60) {
        assert_eq!((report.removed, report.retired, report.refused), (0, 0, 0));
        assert_eq!(report.time_scale, 1.0);
        assert!(report.mean_compression < 0.01, "{}", report.mean_compression);
        assert!((report.simulated - 1.0 / 60.0).abs() < 1e-6);
    }
    // Behind the faces is nothing, up to half a spacing.
    for position in solver.read(Field::Position).unwrap().vectors().unwrap() {
        assert!(position.min_element() > -0.025 && position.x < 1.025 && position.z < 0.525, "{position}");
    }
}

#[test]
fn an_emitter_fills_its_pool_and_its_particles_retire() {
    let emitter = Emitter { center: Vec3::Y, direction: Vec3::NEG_Y, radius: 0.1, speed: 2.0, lifetime: 0.25 };
    let layer = emitter.layer(0.05).len() as u32;
    let scene = FluidScene { emitters: vec![emitter], ..FluidScene::with_spacing(0.05) };
    let mut solver = solver(&scene, 2);
    let reports = run(&mut solver, 60);
    let most = solver.plan().max_particles;
    let alive: Vec<u32> = reports.iter().map(|report| report.particles).collect();
    assert!(reports.iter().all(|report| report.refused == 0 && report.particles <= most), "{alive:?} of {most}");
    // 0.25 s at 2 m/s are ten layers a spacing apart, give or take those on their way in and out.
    let expected = 10 * layer;
    assert!(alive[30..].iter().all(|count| count.abs_diff(expected) <= 2 * layer), "{alive:?}, not {expected}");
    let retired: u32 = reports.iter().map(|report| report.retired).sum();
    assert!(retired > 20 * layer);
}

#[test]
fn a_full_pool_refuses_and_says_so() {
    let mut scene = dam_break();
    let start = Plan::new(&scene).unwrap().positions.len() as u32;
    scene.settings.max_particles = Some(start + 50);
    let mut solver = solver(&scene, 1);
    let new = NewParticles {
        positions: (0..200).map(|i| Vec3::new(2.0 + 0.1 * i as f32, 0.0, 0.0)).collect(),
        velocities: vec![Vec3::ZERO; 200],
        lifetime: f32::INFINITY,
    };
    let input = StepInput { duration: 0.001, commands: vec![Command::Spawn(new)], ..StepInput::default() };
    let report = solver.step(&input).unwrap();
    assert_eq!((report.particles, report.refused), (start + 50, 150));
}

#[test]
fn commands_remove_by_id_and_by_box() {
    let mut solver = solver(&dam_break(), 1);
    let count = solver.plan().positions.len() as u32;
    let commands = vec![
        Command::RemoveIds { first: 10, count: 5 },
        Command::RemoveInBox { min: Vec3::new(-1.0, 0.5, -1.0), max: Vec3::splat(2.0) },
        Command::SetGravity(Vec3::ZERO),
    ];
    let report = solver.step(&StepInput { duration: 1e-4, commands, ..StepInput::default() }).unwrap();
    let above = solver.plan().positions.iter().filter(|position| position.y >= 0.5).count() as u32;
    assert!(above > 0);
    assert_eq!((report.retired, report.particles), (above + 5, count - above - 5));
    let ids = solver.read(Field::Id).unwrap().integers().unwrap();
    assert!(!ids.iter().any(|id| (10..15).contains(id)));
    assert_eq!(solver.snapshot().unwrap().gravity, Vec3::ZERO);
}

#[test]
fn what_is_not_finite_or_out_of_bounds_is_removed_and_counted() {
    let mut scene = dam_break();
    scene.settings.bounds = Some((Vec3::splat(-2.0), Vec3::splat(2.0)));
    scene.settings.max_particles = Some(10_000);
    let mut solver = solver(&scene, 2);
    let new = NewParticles {
        positions: vec![Vec3::splat(5.0), Vec3::new(0.9, 0.9, 0.2)],
        velocities: vec![Vec3::ZERO, Vec3::splat(f32::MAX)],
        lifetime: f32::INFINITY,
    };
    let before = solver.plan().positions.len() as u32;
    let commands = vec![Command::Spawn(new)];
    let report = solver.step(&StepInput { duration: 1e-3, commands, ..StepInput::default() }).unwrap();
    assert_eq!((report.removed, report.particles), (2, before));
}

#[test]
fn time_past_the_substep_limit_is_carried_and_past_the_budget_dropped() {
    let mut scene = dam_break();
    scene.settings.max_substeps = 5;
    let mut carrying = solver(&scene, 1);
    let report = carrying.step(&StepInput { duration: 0.02, ..StepInput::default() }).unwrap();
    assert_eq!(report.substeps, 5);
    assert!(report.time_scale < 0.5, "{}", report.time_scale);
    let carry = carrying.snapshot().unwrap().carry;
    assert!((f64::from(carry) + report.simulated - 0.02).abs() < 1e-6);

    scene.settings.max_substeps = 10_000;
    scene.settings.budget_milliseconds = Some(0.01);
    let mut slowed = solver(&scene, 1);
    let report = slowed.step(&StepInput { duration: 0.02, ..StepInput::default() }).unwrap();
    assert_eq!((report.substeps, slowed.snapshot().unwrap().carry), (1, 0.0));
    assert!(report.time_scale < 0.5);
}

#[test]
fn bad_input_is_refused_and_changes_nothing() {
    let mut solver = solver(&dam_break(), 1);
    let before = hash(&mut solver);
    let step = |duration: f32, commands| StepInput { duration, commands, ..StepInput::default() };
    let uneven = NewParticles { positions: vec![Vec3::ZERO], velocities: Vec::new(), lifetime: f32::INFINITY };
    let cases = [
        (step(f32::NAN, Vec::new()), "duration"),
        (step(-0.1, Vec::new()), "duration"),
        (step(2.0, Vec::new()), "duration"),
        (step(0.01, vec![Command::Spawn(uneven)]), "commands[0]"),
        (step(0.01, vec![Command::SetGravity(Vec3::NAN)]), "commands[0]"),
        (StepInput { bodies: vec![BodyInput::default()], ..step(0.01, Vec::new()) }, "bodies"),
    ];
    for (input, field) in &cases {
        let error = solver.step(input).unwrap_err().to_string();
        assert!(error.contains(field) && error.contains("allowed"), "{error}");
    }
    assert_eq!(hash(&mut solver), before);
}

#[test]
fn a_body_gets_what_the_fluid_loses() {
    // A free ball hit by a block without gravity: the only momentum exchanged is theirs.
    let mut scene = FluidScene { gravity: Vec3::ZERO, ..FluidScene::with_spacing(0.05) };
    scene.volumes = vec![Volume { velocity: Vec3::X, ..Volume::block(Vec3::splat(0.15), Vec3::new(-0.35, 0.02, 0.0)) }];
    let samples = scene.wall_layer().unwrap().sphere_surface(0.15).unwrap();
    scene.bodies = vec![Body { name: "ball".to_owned(), samples }];
    let mut solver = solver(&scene, 2);
    let mass = f64::from(solver.plan().parameters.particle_mass);
    let before = total_velocity(&mut solver) * mass;
    let (mut given, mut position, mut velocity) = (DVec3::ZERO, Vec3::ZERO, Vec3::ZERO);
    for tick in 0..30 {
        let body = BodyInput { position, linear_velocity: velocity, inverse_mass: 0.1, ..BodyInput::default() };
        let report =
            solver.step(&StepInput { tick, duration: 0.01, bodies: vec![body], commands: Vec::new() }).unwrap();
        let impulse = report.bodies[0].linear;
        given += impulse.as_dvec3();
        position += (velocity + 0.05 * impulse) * 0.01;
        velocity += 0.1 * impulse;
    }
    let lost = before - total_velocity(&mut solver) * mass;
    assert!(given.x > 1.0, "the block hit: {given}");
    assert!((lost - given).length() < 1e-4 * given.length(), "{lost} against {given}");
}
