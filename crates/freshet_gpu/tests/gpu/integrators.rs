//! Every integrator of the solver: each step by the rules of `freshet_core`, and pasts that stay with their particles.

use freshet_core::integrator::Past;
use freshet_core::prelude::*;
use freshet_gpu::{GpuOptions, GpuSolver};

use crate::common::{dam_break, solver, solver_with, tick, tick_with};

fn stepped() -> impl Iterator<Item = Integrator> {
    Integrator::ALL.into_iter().filter(|integrator| integrator.in_solvers().is_some())
}

fn scene(integrator: Integrator) -> FluidScene {
    let mut scene = dam_break(0.1);
    scene.settings.integrator = integrator;
    scene.settings.max_particles = Some(1000);
    scene
}

fn past_of(snapshot: &Snapshot, particle: usize, axis: usize) -> Past {
    let words = snapshot.integrator.words();
    let word = |word: usize| if word < words { snapshot.histories[words * particle + word] } else { 0.0 };
    Past { step: word(0), first: word(1 + axis), step_before: word(4), second: word(5 + axis) }
}

/// The largest error of velocities and of what is kept after substeps of different length, relative to the largest of each kind, and of
/// positions in units of the way of a substep.
fn worst(solver: &mut GpuSolver) -> f32 {
    let integrator = solver.plan().parameters.integrator;
    let mut worst: f32 = 0.0;
    for number in 0..4 {
        solver.step(&tick(number, 0.02)).unwrap();
    }
    for (number, duration) in [(4, 7e-4), (5, 7e-4), (6, 8e-4), (7, 3e-4)] {
        let before = solver.snapshot().unwrap();
        assert_eq!(before.histories.len(), integrator.words() * before.ids.len());
        let report = solver.step(&tick(number, duration)).unwrap();
        assert_eq!(report.substeps, 1, "{}", integrator.name());
        let ids = solver.read(Field::Id).unwrap().integers().unwrap();
        let accelerations = solver.read(Field::Acceleration).unwrap().sorted_by_id(&ids).vectors().unwrap();
        let after = solver.snapshot().unwrap();
        let fastest = before.velocities.iter().map(|v| v.length()).fold(0.1, f32::max);
        let hardest = accelerations.iter().map(|a| a.length()).fold(1.0, f32::max);
        for (index, acceleration) in accelerations.iter().enumerate() {
            for axis in [0, 1, 2] {
                let (a, past) = (acceleration[axis], past_of(&before, index, axis));
                let velocity = integrator.velocity(before.velocities[index][axis], a, past, duration);
                let motion = integrator.motion(velocity, a, past, duration);
                let kept = integrator.keep(a, motion, past, duration);
                let moved = after.positions[index][axis] - before.positions[index][axis];
                worst = worst.max((after.velocities[index][axis] - velocity).abs() / fastest);
                // Positions are below 1 m: what is left of a way has their rounding.
                worst = worst.max(((moved - motion * duration).abs() - 6e-8).max(0.0) / (fastest * duration));
                let (found, words) = (past_of(&after, index, axis), integrator.words());
                let scale = if integrator == Integrator::Verlet { fastest } else { hardest };
                let mut compare = |least: usize, found: f32, kept: f32, scale: f32| {
                    worst = worst.max(if words >= least { (found - kept).abs() / scale } else { 0.0 });
                };
                compare(1, found.step, kept.step, duration);
                compare(4, found.first, kept.first, scale);
                compare(8, found.step_before, kept.step_before, duration);
                compare(8, found.second, kept.second, scale);
            }
        }
    }
    worst
}

/// A few roundings, also in sums that cancel.
const TOLERANCE: f32 = 1e-5;

#[test]
fn every_step_is_by_the_rules() {
    for integrator in stepped() {
        let found = worst(&mut solver(&scene(integrator)));
        assert!(found < TOLERANCE, "{}: {found:e} off", integrator.name());
    }
}

#[test]
fn a_wrong_rule_would_be_noticed() {
    for (integrator, patch) in [
        (Integrator::Leapfrog, ("0.5 * (past.step + h) * a", "0.5 * (past.step + 1.02 * h) * a")),
        (Integrator::VelocityVerlet, ("let first = a;", "let first = 1.01 * a;")),
        (Integrator::Beeman, ("turn * share / 3.0", "turn * share / 2.0")),
        (Integrator::VelocityCorrectedBeeman, ("past.step, h) / 3.0", "past.step, h) / 2.0")),
        (Integrator::Verlet, ("set_sorted_history(first + rank, word,", "set_sorted_history(first, word,")),
    ] {
        let options = GpuOptions { patch: Some(patch), ..Default::default() };
        let found = worst(&mut solver_with(&scene(integrator), options));
        assert!(found > TOLERANCE, "{}: {patch:?} makes an error of {found:e} only", integrator.name());
    }
}

/// Particles too far apart to feel each other, spawned and removed while they fall, in ticks of different length and more of them than there is room
/// for at first: each goes along its own parabola.
#[test]
fn particles_fall_freely_from_the_moment_that_they_are_spawned() {
    let durations = [0.05, 0.02, 0.0, 0.07, 0.03, 0.03, 0.06];
    for integrator in stepped().filter(|of| !matches!(of, Integrator::SemiImplicitEuler | Integrator::Clavet)) {
        let mut scene = FluidScene {
            gravity: Vec3::new(0.0, -9.81, 1.0),
            volumes: vec![Volume {
                velocity: Vec3::X,
                hydrostatic: false,
                ..Volume::block(Vec3::splat(0.5), Vec3::splat(0.5))
            }],
            ..FluidScene::with_spacing(1.0)
        };
        scene.settings.integrator = integrator;
        (scene.settings.sound_speed, scene.settings.allow_compressible) = (Some(0.1), true);
        scene.settings.bounds = Some((Vec3::splat(-1000.0), Vec3::splat(1000.0)));
        scene.settings.max_particles = Some(4000);
        let mut solver = solver(&scene);
        let mut born = vec![(0.0, Vec3::splat(0.5), Vec3::X)];
        let mut time = 0.0;
        for (number, &duration) in durations.iter().enumerate() {
            let places: Vec<Vec3> = (0..300)
                .map(|k| Vec3::new(10.0 + 5.0 * (k % 10) as f32, 40.0 - 5.0 * number as f32, 4.0 * (k / 10) as f32))
                .collect();
            let velocities: Vec<Vec3> = (0..300).map(|k| Vec3::new(number as f32, 3.0, -0.01 * k as f32)).collect();
            born.extend(places.iter().zip(&velocities).map(|(&place, &velocity)| (time, place, velocity)));
            let new = NewParticles { positions: places, velocities, lifetime: f32::INFINITY, at: None };
            let mut commands = vec![Command::Spawn(new)];
            if number == 4 {
                commands.push(Command::RemoveIds { first: 1, count: 450 });
            }
            solver.step(&tick_with(number as u64, duration, commands)).unwrap();
            time += duration;
        }
        let end = solver.snapshot().unwrap();
        assert_eq!(end.ids.len(), 1 + 7 * 300 - 450);
        for (&id, &found) in end.ids.iter().zip(&end.positions) {
            let (start, place, velocity) = born[id as usize];
            let fallen = time - start;
            let expected = place + velocity * fallen + 0.5 * scene.gravity * fallen * fallen;
            // A few roundings of positions of up to 116 m.
            let error = (found - expected).length();
            assert!(error < 6e-5, "{}, particle {id}: {error} m off after {fallen} s", integrator.name());
        }
    }
}

#[test]
fn a_run_goes_on_from_a_snapshot_as_if_it_had_not_ended() {
    for integrator in [Integrator::Leapfrog, Integrator::VelocityCorrectedBeeman] {
        let scene = scene(integrator);
        let (mut whole, mut first, mut second) = (solver(&scene), solver(&scene), solver(&scene));
        for number in 0..6 {
            whole.step(&tick(number, 0.02)).unwrap();
        }
        for number in 0..3 {
            first.step(&tick(number, 0.02)).unwrap();
        }
        second.restore(&first.snapshot().unwrap()).unwrap();
        for number in 3..6 {
            second.step(&tick(number, 0.02)).unwrap();
        }
        assert!(whole.snapshot().unwrap() == second.snapshot().unwrap(), "{}", integrator.name());
    }
}

/// What an integrator keeps has memory in plans that ask for it, and no trace in others.
#[test]
fn only_plans_with_a_past_pay_for_it() {
    for integrator in stepped() {
        let solver = solver(&scene(integrator));
        let schedule = solver.schedule();
        let bytes = schedule.buffers.iter().find(|buffer| buffer.name == "histories").map_or(0, |buffer| buffer.bytes);
        assert_eq!(bytes, 8 * integrator.words() as u64 * u64::from(schedule.capacity), "{}", integrator.name());
        assert_eq!(schedule.bytes(), solver.allocated_bytes());
        for pass in ["integrate", "sort_reorder"] {
            let code = solver.shader(pass).unwrap();
            assert_eq!(code.contains("histories"), integrator.words() > 0, "{}, {pass}", integrator.name());
        }
    }
    let code = |integrator| solver(&scene(integrator)).shader("integrate").unwrap();
    let traces = ["velocity_after", "Past", "past"];
    assert!(traces.iter().all(|trace| !code(Integrator::default()).contains(trace)), "the default is what it was");
    assert!(traces.iter().all(|trace| code(Integrator::Clavet).contains(trace)));
}
