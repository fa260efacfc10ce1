//! Every integrator of the solver: each step by the rules of `freshet_core`, orders against exact motions, and pasts that stay with their particles.

use freshet_core::integrator::Past;
use freshet_core::prelude::*;
use freshet_cpu::{CpuOptions, CpuSolver};

fn stepped() -> impl Iterator<Item = Integrator> {
    Integrator::ALL.into_iter().filter(|integrator| integrator.in_solvers().is_some())
}

fn solver(scene: &FluidScene) -> CpuSolver {
    CpuSolver::new(Plan::new(scene).unwrap(), CpuOptions { threads: Some(2), ..CpuOptions::default() }).unwrap()
}

/// A block of water that falls over in a box.
fn dam_break(integrator: Integrator) -> FluidScene {
    let mut scene = FluidScene {
        volumes: vec![Volume::block(Vec3::new(0.2, 0.3, 0.2), Vec3::new(0.2, 0.3, 0.2))],
        boundaries: vec![Boundary::open_box(Vec3::new(0.8, 0.8, 0.4), Vec3::new(0.4, 0.4, 0.2))],
        ..FluidScene::with_spacing(0.05)
    };
    scene.settings.integrator = integrator;
    scene.settings.max_particles = Some(1000);
    scene
}

/// What a particle keeps along an axis, as the snapshot has it.
fn past_of(snapshot: &Snapshot, particle: usize, axis: usize) -> Past {
    let words = snapshot.integrator.words();
    let word = |word: usize| if word < words { snapshot.histories[words * particle + word] } else { 0.0 };
    Past { step: word(0), first: word(1 + axis), step_before: word(4), second: word(5 + axis) }
}

/// Steps of different length, in the thick of it: each is the one that the rules say, with the accelerations that the solver found, for each
/// particle by its id.
#[test]
fn every_step_is_by_the_rules() {
    for integrator in stepped() {
        let mut solver = solver(&dam_break(integrator));
        for tick in 0..20 {
            solver.step(&StepInput { tick, duration: 0.01, ..StepInput::default() }).unwrap();
        }
        for (number, duration) in [(20, 3e-4), (21, 3e-4), (22, 3.5e-4), (23, 1e-4)] {
            let before = solver.snapshot().unwrap();
            assert_eq!(before.histories.len(), integrator.words() * before.ids.len());
            let report = solver.step(&StepInput { tick: number, duration, ..StepInput::default() }).unwrap();
            assert_eq!(report.substeps, 1, "{}", integrator.name());
            let ids = solver.read(Field::Id).unwrap().integers().unwrap();
            let accelerations = solver.read(Field::Acceleration).unwrap().sorted_by_id(&ids).vectors().unwrap();
            let after = solver.snapshot().unwrap();
            assert_eq!(before.ids, after.ids);
            for (index, (x, v)) in before.positions.iter().zip(&before.velocities).enumerate() {
                for axis in 0..3 {
                    let (a, past) = (accelerations[index][axis], past_of(&before, index, axis));
                    let velocity = integrator.velocity(v[axis], a, past, duration);
                    let motion = integrator.motion(velocity, a, past, duration);
                    let kept = integrator.keep(a, motion, past, duration);
                    let name = integrator.name();
                    assert_eq!(after.velocities[index][axis], velocity, "{name}, velocity of {index}");
                    assert_eq!(after.positions[index][axis], x[axis] + motion * duration, "{name}, {index}");
                    let found = past_of(&after, index, axis);
                    let words = integrator.words();
                    assert!(words < 1 || found.step == kept.step, "{name}: {found:?}, not {kept:?}");
                    assert!(words < 4 || found.first == kept.first, "{name}: {found:?}, not {kept:?}");
                    assert!(words < 8 || found == kept, "{name}: {found:?}, not {kept:?}");
                }
            }
        }
    }
}

/// A particle alone.
fn alone(integrator: Integrator) -> FluidScene {
    let mut scene = FluidScene {
        gravity: Vec3::ZERO,
        volumes: vec![Volume {
            velocity: Vec3::X,
            hydrostatic: false,
            ..Volume::block(Vec3::splat(0.5), Vec3::splat(0.5))
        }],
        ..FluidScene::with_spacing(1.0)
    };
    scene.settings.integrator = integrator;
    scene.settings.sound_speed = Some(0.1);
    scene.settings.allow_compressible = true;
    // As long as a tick.
    (scene.settings.courant_factor, scene.settings.force_factor) = (1.0, 1.0);
    scene.settings.bounds = Some((Vec3::splat(-1000.0), Vec3::splat(1000.0)));
    scene.settings.max_particles = Some(100);
    scene
}

/// Largest error of the position under a gravity of `-cos t` that changes from tick to tick, in so many pairs of ticks, the second of each `ratio`
/// as long as the first: `x = t + cos t - 0.5`.
fn forced(integrator: Integrator, pairs: u32, ratio: f64) -> f64 {
    let mut solver = solver(&alone(integrator));
    let (mut t, mut worst) = (0.0f64, 0.0f64);
    for number in 0..2 * pairs {
        let share = if number % 2 == 0 { 1.0 } else { ratio };
        let duration = 4.0 / f64::from(pairs) * share / (1.0 + ratio);
        let commands = vec![Command::SetGravity(Vec3::X * -t.cos() as f32)];
        let input = StepInput { tick: number.into(), duration: duration as f32, commands, ..StepInput::default() };
        assert_eq!(solver.step(&input).unwrap().substeps, 1);
        t += duration;
        let x = solver.read(Field::Position).unwrap().vectors().unwrap()[0].x;
        worst = worst.max((f64::from(x) - t - t.cos() + 0.5).abs());
    }
    worst
}

/// Orders of the whole solver against an exact motion, with equal substeps and with ones that are long and short by turns. Beeman's are of third
/// order under a force that depends on time alone.
#[test]
fn positions_converge_with_the_order_of_the_integrator() {
    for integrator in stepped() {
        let least = match integrator {
            Integrator::SemiImplicitEuler | Integrator::Clavet => 0.9,
            _ => 1.9,
        };
        for ratio in [1.0, 0.4] {
            let (coarse, fine) = (forced(integrator, 20, ratio), forced(integrator, 40, ratio));
            let order = (coarse / fine).log2();
            let first = least < 1.0;
            assert!(order > least && (!first || order < 1.1), "{}, {ratio}: {order}", integrator.name());
            assert!(coarse < if first { 0.3 } else { 0.005 }, "{}, {ratio}: {coarse}", integrator.name());
        }
    }
}

/// Particles too far apart to feel each other, spawned and removed while they fall, in ticks of different length: each goes along its own parabola from the
/// moment that it is there.
#[test]
fn particles_fall_freely_from_the_moment_that_they_are_spawned() {
    let durations = [0.05, 0.02, 0.0, 0.07, 0.03, 0.03, 0.06];
    for integrator in stepped().filter(|of| !matches!(of, Integrator::SemiImplicitEuler | Integrator::Clavet)) {
        let mut scene = alone(integrator);
        scene.gravity = Vec3::new(0.0, -9.81, 1.0);
        let mut solver = solver(&scene);
        let mut born = vec![(0.0, Vec3::splat(0.5), Vec3::X)];
        let mut time = 0.0;
        for (number, &duration) in durations.iter().enumerate() {
            // From far to near, so that the sort changes their order.
            let place = Vec3::splat(40.0 - 5.0 * number as f32);
            let velocity = Vec3::new(number as f32, 3.0, -1.0);
            born.push((time, place, velocity));
            let new =
                NewParticles { positions: vec![place], velocities: vec![velocity], lifetime: f32::INFINITY, at: None };
            let mut commands = vec![Command::Spawn(new)];
            if number == 4 {
                commands.push(Command::RemoveIds { first: 1, count: 2 });
            }
            let input = StepInput { tick: number as u64, duration, commands, ..StepInput::default() };
            solver.step(&input).unwrap();
            time += duration;
        }
        let end = solver.snapshot().unwrap();
        assert_eq!(end.ids, [0, 3, 4, 5, 6, 7]);
        for (&id, &found) in end.ids.iter().zip(&end.positions) {
            let (start, place, velocity) = born[id as usize];
            let fallen = time - start;
            let expected = place + velocity * fallen + 0.5 * scene.gravity * fallen * fallen;
            // A few roundings of positions of 40 m.
            let error = (found - expected).length();
            assert!(error < 2e-5, "{}, particle {id}: {error} m off after {fallen} s", integrator.name());
        }
    }
}

/// A snapshot has all of the past: what goes on from it is what would have been.
#[test]
fn a_run_goes_on_from_a_snapshot_as_if_it_had_not_ended() {
    for integrator in stepped() {
        let scene = dam_break(integrator);
        let tick = |tick| StepInput { tick, duration: 0.01, ..StepInput::default() };
        let (mut whole, mut first, mut second) = (solver(&scene), solver(&scene), solver(&scene));
        for number in 0..6 {
            whole.step(&tick(number)).unwrap();
        }
        for number in 0..3 {
            first.step(&tick(number)).unwrap();
        }
        let saved = Snapshot::from_bytes(&first.snapshot().unwrap().to_bytes().unwrap()).unwrap();
        second.restore(&saved).unwrap();
        for number in 3..6 {
            second.step(&tick(number)).unwrap();
        }
        assert!(whole.snapshot().unwrap() == second.snapshot().unwrap(), "{}", integrator.name());
    }
}

/// Another integrator begins anew with the same particles: what the one kept means nothing to the other.
#[test]
fn the_integrator_may_change_while_it_runs() {
    let mut solver = solver(&dam_break(Integrator::Verlet));
    let mut number = 0;
    for integrator in [Integrator::Verlet, Integrator::VelocityVerlet, Integrator::Leapfrog, Integrator::default()] {
        solver.reconfigure(Plan::new(&dam_break(integrator)).unwrap()).unwrap();
        let start = solver.snapshot().unwrap();
        assert!(start.histories.iter().all(|&value| value == 0.0), "{}", integrator.name());
        for _ in 0..3 {
            let report = solver.step(&StepInput { tick: number, duration: 0.01, ..StepInput::default() }).unwrap();
            assert_eq!(report.removed, 0);
            number += 1;
        }
        let scheduled = solver.schedule().buffers.iter().find(|buffer| buffer.name == "particles").unwrap().bytes;
        assert!(scheduled >= 4 * (8 + integrator.words() as u64) * u64::from(solver.schedule().capacity));
    }
}

/// A substep that is taken back takes the past back, too.
#[test]
fn substeps_are_made_again_with_every_integrator() {
    for integrator in stepped() {
        // Water that falls fast, with a sound so slow that substeps turn out too long when it lands.
        let mut scene = FluidScene {
            volumes: vec![Volume { velocity: Vec3::NEG_Y * 4.76, ..Volume::block(Vec3::splat(0.2), Vec3::Y * 0.4) }],
            boundaries: vec![Boundary::open_box(Vec3::new(2.0, 1.0, 2.0), Vec3::Y * 0.5)],
            ..FluidScene::with_spacing(0.05)
        };
        scene.settings.sound_speed = Some(1.5);
        scene.settings.allow_compressible = true;
        scene.settings.redo_substeps = true;
        scene.settings.integrator = integrator;
        let mut solver = solver(&scene);
        let mut redone = 0;
        for tick in 0..30 {
            let report = solver.step(&StepInput { tick, duration: 0.005, ..StepInput::default() }).unwrap();
            assert_eq!((report.removed, report.particles), (0, 512), "{}", integrator.name());
            redone += report.redone;
            // What is kept is of the substep that counts.
            let snapshot = solver.snapshot().unwrap();
            let step = past_of(&snapshot, 0, 0).step;
            let is_last = step >= report.smallest_substep && step <= 0.005;
            assert!(integrator.words() == 0 || is_last, "{}: {step} s, {report:?}", integrator.name());
        }
        assert!(redone > 0, "{}", integrator.name());
    }
}
