//! Bodies in an incompressible fluid: the solve against sums over all pairs in double precision, and what must come of it.

mod common;
#[path = "common/floating.rs"]
mod floating;
#[path = "common/reference.rs"]
mod reference;

use common::solver;
use floating::{Ball, assert_a_body_gets_what_the_fluid_loses, assert_substeps_are_short_enough_for_what_turns};
use floating::{assert_a_tank_takes_its_water_along, closed_tank};
use floating::{blade, block_at_ball, deep_pool, disturbed_column, substep_errors};
use freshet_core::prelude::*;

/// One substep. Particles are accelerated by the pressures that are reported, also against the bodies; bodies get the opposite as
/// impulses and move by it; and with the velocities that both have at its end nothing is compressed.
#[test]
fn a_substep_solves_for_fluid_and_bodies_together() {
    for kernel in [KernelKind::WendlandC2, KernelKind::CubicSpline] {
        let found = substep_errors(&mut solver(&disturbed_column(kernel), 2));
        assert!(found.iter().all(|&error| error < 1.0), "{kernel:?}: {found:?}");
    }
}

#[test]
fn a_body_gets_what_the_fluid_loses() {
    assert_a_body_gets_what_the_fluid_loses(&mut solver(&block_at_ball(), 2));
}

/// Released in the middle of a pool of standing water, a ball begins to move as potential theory says: `g (rho - rho_b) / (rho_b + rho/2)`,
/// the fluid around it adding half of what it displaces to its mass. The ball is six spacings wide: 0.82, 0.85, 0.93, 1.10 and 1.00 times
/// that (with half the spacing 0.90, 0.92, 0.86, 1.0 and 1.00); walls near by add some mass, too. However light or heavy, nothing
/// is thrown about.
#[test]
fn a_ball_begins_to_rise_or_sink_with_its_added_mass() {
    for ratio in [0.01, 0.1, 0.5, 2.0, 20.0f32] {
        let scene = deep_pool(0.15);
        let mut solver = solver(&scene, 2);
        let mut ball = Ball::new(0.15, 1000.0 * ratio, Vec3::Y * 0.5, scene.gravity);
        let held = BodyInput { position: ball.input.position, ..BodyInput::default() };
        for tick in 0..60 {
            let bodies = vec![held];
            solver.step(&StepInput { tick, duration: 1.0 / 60.0, bodies, commands: Vec::new() }).unwrap();
        }
        let (mut most, mut fastest, mut first) = (0, 0.0f32, 0.0);
        for tick in 0..48 {
            let report = ball.tick(&mut solver, 60 + tick, 1.0 / 240.0);
            assert_eq!((report.removed, report.unsolved), (0, 0), "{ratio}: tick {tick}");
            most = most.max(report.divergence_iterations / report.substeps);
            fastest = fastest.max(report.max_speed);
            if tick == 1 {
                first = ball.input.linear_velocity.y * 120.0;
            }
        }
        let expected = 9.81 * (1.0 - ratio) / (ratio + 0.5);
        let speed = ball.input.linear_velocity.y;
        println!(
            "{ratio}: {} of {expected} m/s2; ball {speed} m/s, water {fastest} m/s, {most} iterations",
            first / expected
        );
        assert!((0.75..1.2).contains(&(first / expected)), "{ratio}: {first} m/s2 not {expected}");
        assert!(speed * expected > 0.0 && speed.abs() < 0.2 * expected.abs(), "{ratio}: {speed} m/s");
        assert!(fastest < 3.0, "{ratio}: water at {fastest} m/s");
    }
}

/// Dropped into the pool or let go at its bottom, however light or heavy: no particle is lost, and none is much faster than the ball can
/// be by falling from there or by rising from the bottom.
#[test]
fn light_and_heavy_balls_do_not_blow_up_the_water() {
    for (ratio, height, ticks) in [(0.01, 1.3, 90), (0.01, 0.25, 120), (20.0, 1.3, 26), (20.0, 0.5, 12)] {
        let scene = deep_pool(0.15);
        let mut solver = solver(&scene, 2);
        let mut ball = Ball::new(0.15, 1000.0 * ratio, Vec3::Y * height, scene.gravity);
        let (mut fastest, mut water, mut unsolved, mut compression) = (0.0f32, 0.0f32, 0, 0.0f32);
        for tick in 0..ticks {
            let report = ball.tick(&mut solver, tick, 1.0 / 60.0);
            assert_eq!((report.removed, report.time_scale), (0, 1.0), "{ratio} from {height} m: tick {tick}");
            fastest = fastest.max(ball.input.linear_velocity.length());
            water = water.max(report.max_speed);
            unsolved += report.unsolved;
            compression = compression.max(report.mean_compression);
        }
        let at = ball.input.position;
        println!(
            "{ratio} from {height} m: at {at}, {fastest} m/s; water {water} m/s, {unsolved} unsolved, {compression}"
        );
        assert!(
            fastest < 5.0 && water < 8.0 && compression < 0.01,
            "{ratio} from {height} m: {fastest} {water} {compression}"
        );
        assert!(unsolved < 5, "{ratio} from {height} m: {unsolved}");
        let expected = if ratio < 1.0 { at.y > 0.9 } else { at.y < 0.45 };
        assert!(expected && at.y > 0.1, "{ratio} from {height} m: {at}");
    }
}

/// Half as dense as water, it comes to rest half under it (`freshet_lab float --method divergence-free` asks more exactly, with rapier).
#[test]
fn a_ball_floats_half_under_water() {
    let scene = deep_pool(0.15);
    let mut solver = solver(&scene, 2);
    let mut ball = Ball::new(0.15, 500.0, Vec3::Y * 1.02, scene.gravity);
    let mut drafts = Vec::new();
    for tick in 0..300 {
        let report = ball.tick(&mut solver, tick, 1.0 / 60.0);
        assert_eq!((report.removed, report.unsolved), (0, 0), "tick {tick}");
        // The level that water and the ball's submerged part fill, in a pool of one square metre.
        let water = f64::from(report.particles) * 0.05f64.powi(3);
        let (radius, height) = (0.15, f64::from(ball.input.position.y));
        let under = |level: f64| (level - height + radius).clamp(0.0, 2.0 * radius);
        let submerged = |level: f64| std::f64::consts::PI * under(level).powi(2) * (radius - under(level) / 3.0);
        let level = (0..50).fold(water, |level, _| water + submerged(level));
        drafts.push(under(level) / (2.0 * radius));
    }
    let late = &drafts[150..];
    let mean = late.iter().sum::<f64>() / late.len() as f64;
    let spread = late.iter().fold(0.0f64, |most, draft| most.max((draft - mean).abs()));
    println!("draft {mean} +- {spread}, {} m/s", ball.input.linear_velocity);
    assert!((mean - 0.5).abs() < 0.05 && spread < 0.03, "{mean} +- {spread}");
}

#[test]
fn same_bits_with_any_number_of_threads_and_from_a_snapshot() {
    let run = |threads: usize, break_at: Option<u64>| {
        let scene = deep_pool(0.15);
        let mut fluid = solver(&scene, threads);
        let mut ball = Ball::new(0.15, 300.0, Vec3::new(0.02, 0.9, 0.01), scene.gravity);
        ball.input.angular_velocity = Vec3::new(1.0, 2.0, 3.0);
        let mut reports = Vec::new();
        for tick in 0..12 {
            if break_at == Some(tick) {
                let bytes = fluid.snapshot().unwrap().to_bytes().unwrap();
                fluid = solver(&scene, threads);
                fluid.restore(&Snapshot::from_bytes(&bytes).unwrap()).unwrap();
            }
            reports.push(ball.tick(&mut fluid, tick, 1.0 / 60.0).bodies);
        }
        (fluid.snapshot().unwrap(), reports)
    };
    let one = run(1, None);
    for (threads, break_at) in [(2, None), (5, None), (2, Some(6))] {
        assert_eq!(one, run(threads, break_at), "{threads} threads, {break_at:?}");
    }
}

/// Bodies beside the fluid, deep in a wall or one in another: all is finite.
#[test]
fn odd_bodies_end_with_finite_numbers() {
    let scene = deep_pool(0.15);
    let ball = scene.bodies[0].clone();
    let at = |x: f32, y: f32| BodyInput {
        inverse_mass: 0.1,
        ..BodyInput { position: Vec3::new(x, y, 0.0), ..BodyInput::default() }
    };
    for (what, bodies, inputs) in [
        ("far away", vec![ball.clone()], vec![at(50.0, 0.5)]),
        ("in the wall", vec![ball.clone()], vec![at(0.5, 0.0)]),
        ("one in another", vec![ball.clone(), ball], vec![at(0.0, 0.5), at(0.0, 0.5)]),
    ] {
        let mut solver = solver(&FluidScene { bodies, ..scene.clone() }, 2);
        for (tick, duration) in [1e-3, 0.0, 1e-12, 1e-3, 1e-2].into_iter().enumerate() {
            let input = StepInput { tick: tick as u64, duration, bodies: inputs.clone(), commands: Vec::new() };
            let report = solver.step(&input).unwrap();
            assert_eq!(report.removed, 0, "{what}");
            assert!(report.bodies.iter().all(|given| given.linear.is_finite() && given.angular.is_finite()), "{what}");
            assert!(report.max_speed < 20.0, "{what}: {}", report.max_speed);
        }
    }
}

#[test]
fn substeps_are_short_enough_for_what_turns() {
    assert_substeps_are_short_enough_for_what_turns(&mut solver(&blade(), 1));
}

#[test]
fn a_tank_takes_its_water_along() {
    assert_a_tank_takes_its_water_along(&mut solver(&closed_tank(), 2));
}
