//! Whole runs: determinism, conservation, spawning and removing, carried time, snapshots, a body.

mod common;

use common::{run, solver};
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
    // So many particles that five threads take part, with more than the fewest chunks.
    let FluidScene { volumes, boundaries, .. } = dam_break();
    let scene = FluidScene { volumes, boundaries, ..FluidScene::with_spacing(0.5 / 24.0) };
    let hashes = [1, 2, 2, 5].map(|threads| {
        let mut solver = solver(&scene, threads);
        assert!(solver.plan().positions.len() > 16_000);
        run(&mut solver, 2);
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

/// A block that crosses every end of its domain more than once arrives as it left.
#[test]
fn what_leaves_a_period_comes_back() {
    let mut scene = FluidScene { gravity: Vec3::ZERO, ..FluidScene::with_spacing(0.05) };
    let velocity = Vec3::new(3.0, -2.5, 2.0);
    scene.volumes = vec![Volume { velocity, ..Volume::block(Vec3::splat(0.15), Vec3::ZERO) }];
    scene.periodic = Periodic { x: Some((-0.4, 0.4)), y: Some((-0.2, 0.2)), z: Some((-0.3, 0.5)) };
    let mut solver = solver(&scene, 2);
    let reports = run(&mut solver, 30);
    assert!(reports.iter().all(|report| report.removed == 0));
    let (start, end) = (solver.plan().positions.clone(), solver.snapshot().unwrap());
    for (start, (end, after)) in start.iter().zip(end.positions.iter().zip(&end.velocities)) {
        assert_eq!(scene.periodic.wrap(*end), *end);
        let off = scene.periodic.nearest(*end - (*start + velocity * 0.5));
        assert!(off.length() < 1e-4 && after.distance(velocity) < 1e-4, "{off} m and {after} m/s");
    }
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

/// A jet without gravity, at 2 m/s and with 13 particles in a layer; a tick of 1/60 s takes 18 substeps.
fn jet(max_substeps: u32) -> FluidScene {
    let mut scene = FluidScene { gravity: Vec3::ZERO, ..FluidScene::with_spacing(0.05) };
    let direction = Vec3::new(1.0, 0.5, 0.0);
    scene.emitters = vec![Emitter { center: Vec3::Y, direction, radius: 0.1, speed: 2.0, lifetime: 5.0 }];
    scene.settings.max_substeps = max_substeps;
    scene
}

/// Some ticks of the scene's emitters; their reports are heard of `latency` ticks late.
fn run_late(solver: &mut CpuSolver, run: &mut SceneRun, durations: &[f32], latency: usize) -> Vec<StepReport> {
    let mut reports = Vec::<StepReport>::new();
    for (made, &duration) in durations.iter().enumerate() {
        if made > latency {
            run.hear(&reports[made - 1 - latency]);
        }
        let input = run.next(solver.plan(), duration, Vec::new());
        reports.push(solver.step(&input).unwrap());
    }
    reports[durations.len().saturating_sub(latency + 1)..].iter().for_each(|report| run.hear(report));
    reports
}

/// Every two layers that follow each other are a gap apart, and no two particles are too near; s is the jet's simulated time.
fn assert_even(solver: &mut CpuSolver, simulated: f64) {
    let (emitter, d) = (solver.plan().emitters[0].clone(), solver.plan().parameters.spacing);
    let gap = emitter.interval(d) as f32 * emitter.speed;
    assert!((gap / d - 1.0).abs() < 0.05, "{gap}");
    let positions = solver.snapshot().unwrap().positions;
    let along = |layer: &[Vec3]| {
        let sum: f32 =
            layer.iter().map(|position| (*position - emitter.center).dot(emitter.direction.normalize())).sum();
        sum / layer.len() as f32
    };
    let layers: Vec<f32> = positions.chunks(emitter.layer(d).len()).map(along).collect();
    assert!(layers.len() > 10, "{layers:?}");
    for pair in layers.windows(2) {
        // The last layers press on those ahead a little: the density is within a per cent of that at rest.
        assert!(((pair[0] - pair[1]) / gap - 1.0).abs() < 0.05, "{} and {} m of {gap} m: {layers:?}", pair[0], pair[1]);
    }
    // The first layer crossed the disc at time 0, and the flow is as far as it should be.
    assert!((layers[0] - emitter.speed * simulated as f32).abs() < 0.5 * d, "{} m after {simulated} s", layers[0]);
    // None is missing at the disc.
    assert!(layers.last().is_some_and(|last| *last < gap), "{layers:?}");
    let nearest = (0..positions.len())
        .flat_map(|a| (0..a).map(move |b| (a, b)))
        .map(|(a, b)| positions[a].distance(positions[b]))
        .fold(f32::INFINITY, f32::min);
    assert!(nearest > 0.95 * d.min(gap), "{nearest}");
}

#[test]
fn a_jet_is_even_whatever_of_the_time_is_simulated() {
    // Time is left over in long ticks and made up for in short ones, or not at all.
    let uneven: Vec<f32> = (0..160).map(|tick| [0.02, 0.001, 0.03, 0.0, 0.002, 0.005, 0.004][tick % 7]).collect();
    let overloaded = vec![1.0 / 60.0; 90];
    for (durations, max_substeps) in [(&uneven, 10), (&overloaded, 5), (&overloaded, 10_000)] {
        for latency in [0, 1, 3] {
            let mut solver = solver(&jet(max_substeps), 2);
            let reports = run_late(&mut solver, &mut SceneRun::new(), durations, latency);
            let asked: f64 = durations.iter().map(|duration| f64::from(*duration)).sum();
            let simulated: f64 = reports.iter().map(|report| report.simulated).sum();
            let short = reports.iter().filter(|report| report.time_scale < 0.99).count();
            match max_substeps {
                10 => {
                    assert!(short > 20 && reports.iter().zip(durations).any(|(r, d)| r.simulated > 1.5 * f64::from(*d)))
                }
                5 => assert!(simulated < 0.5 * asked),
                _ => assert!(short == 0 && (simulated - asked).abs() < 1e-4),
            }
            assert!(reports.iter().all(|report| report.removed + report.refused + report.retired == 0));
            assert_even(&mut solver, simulated);
        }
    }
    // Past the budget time is dropped: a substep a tick.
    let mut scene = jet(10_000);
    scene.settings.budget_milliseconds = Some(0.01);
    let mut solver = solver(&scene, 2);
    let reports = run_late(&mut solver, &mut SceneRun::new(), &[1.0 / 60.0; 500], 0);
    assert!(reports.iter().all(|report| report.time_scale < 0.2));
    assert_even(&mut solver, reports.iter().map(|report| report.simulated).sum());
}

#[test]
fn an_emitter_goes_on_in_phase_from_a_snapshot() {
    let mut ahead = 0;
    for first in 36..40 {
        let mut whole = solver(&jet(5), 2);
        let (first, rest) = (vec![1.0 / 60.0; first], [1.0 / 60.0; 40]);
        let mut run = SceneRun::new();
        let before = run_late(&mut whole, &mut run, &first, 0);
        let saved = whole.snapshot().unwrap();
        assert!(saved.carry > 0.1);
        ahead += u32::from(saved.emitted.is_some_and(|emitted| emitted > saved.time));
        let after = run_late(&mut whole, &mut run, &rest, 0);

        let mut restored = solver(&jet(5), 1);
        let saved = Snapshot::from_bytes(&saved.to_bytes().unwrap()).unwrap();
        restored.restore(&saved).unwrap();
        run_late(&mut restored, &mut SceneRun::resume(&saved), &rest, 0);
        assert!(restored.snapshot().unwrap() == whole.snapshot().unwrap());
        assert_even(&mut restored, before.iter().chain(&after).map(|report| report.simulated).sum());
    }
    assert!(ahead > 0, "no layer is on its way to the disc in any of the snapshots");
}

/// Where to, with what life: the GPU's tests measure it too, where the clock is known to the device alone. Here the clock is
/// in hand and every bit of the formula can be asked for.
#[test]
fn a_stamped_particle_is_moved_by_its_age_to_the_bit() {
    let mut solver = solver(&jet(10_000), 1);
    solver.step(&StepInput { duration: 0.25, ..StepInput::default() }).unwrap();
    let (now, from, velocity) = (solver.time(), Vec3::X, Vec3::new(0.5, 4.0, -3.0));
    let stamped = |at| {
        let particles = NewParticles { positions: vec![from], velocities: vec![velocity], lifetime: 1.0, at: Some(at) };
        Command::Spawn(particles)
    };
    let commands = [0.0, 0.5, -2.0].map(stamped).into();
    let report = solver.step(&StepInput { tick: 1, commands, ..StepInput::default() }).unwrap();
    assert_eq!((report.particles, report.retired), (2, 1), "the last one's time was over when it came");
    let state = solver.snapshot().unwrap();
    for (index, at) in [0.0, 0.5].into_iter().enumerate() {
        let age = (now - at) as f32;
        assert_eq!((state.positions[index], state.remaining_lives[index]), (from + velocity * age, 1.0 - age));
    }
    assert_eq!(state.emitted, Some(0.5));
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
        at: None,
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
        at: None,
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
    let uneven =
        NewParticles { positions: vec![Vec3::ZERO], velocities: Vec::new(), lifetime: f32::INFINITY, at: None };
    let untimely = NewParticles { lifetime: 1.0, at: Some(f64::NAN), ..NewParticles::default() };
    let cases = [
        (step(f32::NAN, Vec::new()), "duration"),
        (step(-0.1, Vec::new()), "duration"),
        (step(2.0, Vec::new()), "duration"),
        (step(0.01, vec![Command::Spawn(uneven)]), "commands[0]"),
        (step(0.01, vec![Command::Spawn(untimely)]), "commands[0].at"),
        (step(0.01, vec![Command::SetGravity(Vec3::NAN)]), "commands[0]"),
        (StepInput { bodies: vec![BodyInput::default()], ..step(0.01, Vec::new()) }, "bodies"),
        (StepInput { tick: 1 << 63, ..step(0.01, Vec::new()) }, "tick"),
        (StepInput { tick: u64::MAX, ..step(0.01, Vec::new()) }, "tick"),
    ];
    for (input, field) in &cases {
        let error = solver.step(input).unwrap_err().to_string();
        assert!(error.contains(field) && error.contains("allowed"), "{error}");
    }
    assert_eq!(hash(&mut solver), before);
}

#[test]
fn the_largest_tick_is_followed_by_none() {
    let mut solver = solver(&dam_break(), 1);
    let last = StepInput { tick: StepInput::MAX_TICK, duration: 1e-3, ..StepInput::default() };
    assert_eq!(solver.step(&last).unwrap().tick, StepInput::MAX_TICK);
    let state = solver.snapshot().unwrap();
    assert_eq!(state.tick, 1 << 63);
    solver.restore(&state).unwrap();
    let error = solver.restore(&Snapshot { tick: (1 << 63) + 1, ..state }).unwrap_err().to_string();
    assert_eq!(error, "tick: 9223372036854775809 is not allowed; allowed: 0 to 2^63");
}

#[test]
fn a_number_of_threads_out_of_range_is_refused() {
    for threads in [0, 257, usize::MAX] {
        let plan = Plan::new(&dam_break()).unwrap();
        let made = CpuSolver::new(plan, CpuOptions { threads: Some(threads), ..CpuOptions::default() });
        let Err(SolverError::Invalid(error)) = made else { panic!("{threads} threads are accepted") };
        assert_eq!((error.field.as_str(), error.value), ("threads", threads.to_string()));
        assert!(error.allowed.starts_with("1 to 256"), "{}", error.allowed);
    }
}

#[test]
fn more_particles_than_the_plan_allows_are_refused() {
    let mut scene = dam_break();
    let mut full = solver(&scene, 1);
    let state = full.snapshot().unwrap();
    let count = state.ids.len();
    scene.volumes[0] = Volume::ball(0.1, Vec3::splat(0.25));
    let mut small = solver(&scene, 1);
    let (before, most) = (hash(&mut small), small.plan().max_particles);
    let message = format!("ids: {count} particles is not allowed; allowed: at most {most}, the plan's max_particles");
    assert_eq!(small.restore(&state).unwrap_err().to_string(), message);
    assert_eq!(hash(&mut small), before);
    // Nor a plan for fewer than there are.
    let (before, schedule) = (hash(&mut full), full.schedule().clone());
    assert_eq!(full.reconfigure(small.plan().clone()).unwrap_err().to_string(), message);
    assert_eq!((hash(&mut full), full.schedule()), (before, &schedule));
    assert_eq!(full.plan().max_particles as usize, count);
}

#[test]
fn a_body_gets_what_the_fluid_loses() {
    // A free ball hit by a block without gravity: the only momentum exchanged is theirs.
    let mut scene = FluidScene { gravity: Vec3::ZERO, ..FluidScene::with_spacing(0.05) };
    scene.volumes = vec![Volume { velocity: Vec3::X, ..Volume::block(Vec3::splat(0.15), Vec3::new(-0.35, 0.02, 0.0)) }];
    let samples = scene.wall_layer().unwrap().sphere_surface(0.15).unwrap();
    scene.bodies = vec![Body { name: "ball".to_owned(), samples, ..Body::default() }];
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

#[test]
fn a_body_that_is_put_elsewhere_starts_from_there() {
    let mut scene = FluidScene { gravity: Vec3::ZERO, ..FluidScene::with_spacing(0.05) };
    scene.volumes = vec![Volume::block(Vec3::splat(0.1), Vec3::X)];
    scene.settings.expected_speed = Some(2.0);
    let samples = scene.wall_layer().unwrap().sphere_surface(0.1).unwrap();
    scene.bodies = vec![Body { name: "ball".to_owned(), samples, ..Body::default() }];
    // Two centimetres are within a body's reach: it drifts there, at 2 m/s.
    for (placed, wanted) in [(false, 0.01), (true, 0.02)] {
        let mut solver = solver(&scene, 1);
        for (tick, y) in [(0, 0.0), (1, 0.02)] {
            let body = BodyInput { position: Vec3::Y * y, placed, ..BodyInput::default() };
            solver.step(&StepInput { tick, duration: 0.005, bodies: vec![body], commands: Vec::new() }).unwrap();
        }
        let y = solver.snapshot().unwrap().poses[0].unwrap().position.y;
        assert!((y - wanted).abs() < 1e-6, "placed: {placed}: {y}");
    }
}
