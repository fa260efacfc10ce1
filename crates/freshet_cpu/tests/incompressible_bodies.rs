//! Bodies in an incompressible fluid: the solve against sums over all pairs in double precision, and what must come of it.

mod common;
#[path = "common/reference.rs"]
mod reference;

use std::f32::consts::PI;

use common::solver;
use freshet_core::prelude::*;
use freshet_cpu::CpuSolver;
use glam::DVec3;
use reference::{Reference, disturbed};

fn incompressible(mut scene: FluidScene, solver: DivergenceFree) -> FluidScene {
    scene.settings.pressure_solver = PressureSolver::DivergenceFree(solver);
    scene
}

fn ball(scene: &FluidScene, radius: f32) -> Body {
    let samples = scene.wall_layer().unwrap().sphere_surface(radius).unwrap();
    let solids = vec![Solid::ball(radius, Vec3::ZERO)];
    Body { name: "ball".to_owned(), samples, solids }
}

/// A column of 0.25 m in an open box, and a body for each input.
fn column_with(bodies: usize, tolerance: f32) -> FluidScene {
    let scene = FluidScene {
        volumes: vec![Volume::block(Vec3::splat(0.125), Vec3::Y * 0.125)],
        boundaries: vec![Boundary::open_box(Vec3::new(0.25, 0.375, 0.25), Vec3::Y * 0.1875)],
        ..FluidScene::with_spacing(0.025)
    };
    let mut small = ball(&scene, 0.04);
    // The centre of mass is not that of the ball, so that the fluid turns it.
    small.samples.iter_mut().for_each(|sample| *sample += Vec3::new(0.005, 0.0, 0.01));
    small.solids.clear();
    let settings = DivergenceFree { compression: tolerance, divergence: tolerance, max_iterations: 5000 };
    let mut scene = incompressible(FluidScene { bodies: vec![small; bodies], ..scene }, settings);
    scene.settings.artificial_viscosity = 0.0;
    scene
}

/// A body that the fluid cannot move, one that it can, and one that next to nothing weighs; the first two share particles.
fn three_bodies() -> Vec<BodyInput> {
    let lopsided = Mat3::from_cols(Vec3::new(9e3, 1e3, 0.0), Vec3::new(1e3, 6e3, -5e2), Vec3::new(0.0, -5e2, 8e3));
    vec![
        BodyInput {
            position: Vec3::new(-0.05, 0.08, 0.01),
            linear_velocity: Vec3::new(0.3, 0.0, -0.1),
            angular_velocity: Vec3::new(0.0, 4.0, -2.0),
            ..BodyInput::default()
        },
        BodyInput {
            position: Vec3::new(0.045, 0.1, 0.0),
            rotation: Quat::from_rotation_x(0.7),
            linear_velocity: Vec3::new(-0.2, -0.3, 0.0),
            angular_velocity: Vec3::new(3.0, 0.0, 1.0),
            inverse_mass: 1.0 / 0.2,
            inverse_inertia: lopsided,
            acceleration: Vec3::new(0.0, -9.81, 0.0),
            ..BodyInput::default()
        },
        BodyInput {
            position: Vec3::new(0.0, 0.2, -0.05),
            inverse_mass: 1.0 / 0.005,
            inverse_inertia: 30.0 * lopsided,
            acceleration: Vec3::new(0.0, -9.81, 0.0),
            ..BodyInput::default()
        },
    ]
}

/// One substep. Particles are accelerated by the pressures that are reported, also against the bodies; bodies get the opposite as
/// impulses and move by it; and with the velocities that both have at its end nothing is compressed.
#[test]
fn a_substep_solves_for_fluid_and_bodies_together() {
    for kernel in [KernelKind::WendlandC2, KernelKind::CubicSpline] {
        let mut scene = column_with(3, 1e-5);
        scene.settings.kernel = kernel;
        let plan = Plan::new(&scene).unwrap();
        let (start, bodies) = (disturbed(&plan), three_bodies());
        let mut solver = solver(&scene, 2);
        solver.restore(&Snapshot { tick: 1, ..start.clone() }).unwrap();
        let duration = 1e-3;
        let input = StepInput { tick: 1, duration, bodies: bodies.clone(), ..StepInput::default() };
        let report = solver.step(&input).unwrap();
        assert_eq!((report.substeps, report.unsolved), (1, 0), "{kernel:?}");

        let reference = Reference::new(&plan, &start.positions, &bodies);
        let dt = f64::from(duration);
        let end = solver.snapshot().unwrap();
        let velocities: Vec<DVec3> = end.velocities.iter().map(|v| v.as_dvec3()).collect();
        let pressures: Vec<f64> = end.pressures.iter().map(|&p| f64::from(p)).collect();
        assert!(pressures.iter().all(|&pressure| pressure >= 0.0));
        for (i, acceleration) in reference.accelerations(&pressures).iter().enumerate() {
            let expected = start.velocities[i].as_dvec3() + dt * (scene.gravity.as_dvec3() + *acceleration);
            let scale = 1e-4 * dt * acceleration.length().max(10.0) + 1e-6;
            assert!(velocities[i].distance(expected) < scale, "{kernel:?} {i}: {} not {expected}", velocities[i]);
        }
        let mut motions = Vec::new();
        for (index, [force, torque]) in reference.loads(&pressures).into_iter().enumerate() {
            let (body, impulse, pose) = (&bodies[index], report.bodies[index], end.poses[index].unwrap());
            assert!(force.length() > 0.1 && torque.length() > 1e-4, "{index}: {force} N, {torque} N m");
            let [linear, angular] = [impulse.linear.as_dvec3(), impulse.angular.as_dvec3()];
            assert!(linear.distance(dt * force) < 1e-4 * dt * force.length(), "{index}: {linear} not {}", dt * force);
            assert!(
                angular.distance(dt * torque) < 1e-3 * dt * torque.length(),
                "{index}: {angular} not {}",
                dt * torque
            );
            let acceleration = f64::from(body.inverse_mass) * force + body.acceleration.as_dvec3();
            let velocity = body.linear_velocity.as_dvec3() + dt * acceleration;
            let spin = body.angular_velocity.as_dvec3() + dt * (body.inverse_inertia.as_dmat3() * torque);
            let way = (pose.position - body.position).as_dvec3();
            assert!(way.distance(dt * velocity) < 1e-6, "{index}: {way} not {}", dt * velocity);
            motions.push([velocity, spin]);
        }
        // The way of the fastest in a first substep is that of its velocity.
        let fastest = start.velocities.iter().map(|v| v.length()).fold(0.0, f32::max);
        let fastest = bodies.iter().map(|body| body.linear_velocity.length()).fold(fastest, f32::max);
        let way = (fastest * duration / plan.parameters.longest_way()).min(1.0);
        let share = DivergenceFree::share(way);
        let densities = reference.densities();
        let rates = reference.rates(&velocities, &motions);
        // Without the bodies' motion it would not be solved at all.
        let standing = reference.rates(&velocities, &[[DVec3::ZERO; 2]; 3]);
        let (mut wrong, mut wrong_if_standing) = (0.0, 0.0);
        for (i, pressure) in pressures.iter().enumerate() {
            let source = f64::from(DivergenceFree::source((densities[i] - 1.0) as f32, share));
            let measure = |left: f64| if *pressure > 0.0 { left.abs() } else { left.max(0.0) } / densities.len() as f64;
            wrong += measure(source + dt * rates[i]);
            wrong_if_standing += measure(source + dt * standing[i]);
        }
        let asked = f64::from(1e-5 * way);
        println!("{kernel:?}: {wrong:e} left, {asked:e} asked for, {wrong_if_standing:e} with standing bodies");
        assert!(wrong < 1.5 * asked, "{kernel:?}: {wrong} of {asked}");
        assert!(wrong_if_standing > 30.0 * asked, "{wrong_if_standing}");
    }
}

/// A rigid ball that an engine moves in lockstep: what the fluid gives it, it has.
struct Ball {
    input: BodyInput,
    mass: f32,
}

impl Ball {
    fn new(radius: f32, density: f32, position: Vec3, gravity: Vec3) -> Self {
        let mass = density * 4.0 / 3.0 * PI * radius.powi(3);
        let inverse_inertia = Mat3::from_diagonal(Vec3::splat(1.0 / (0.4 * mass * radius * radius)));
        let input = BodyInput {
            position,
            inverse_mass: 1.0 / mass,
            inverse_inertia,
            acceleration: gravity,
            ..BodyInput::default()
        };
        Self { input, mass }
    }

    fn tick(&mut self, solver: &mut CpuSolver, tick: u64, duration: f32) -> StepReport {
        let bodies = vec![self.input];
        let report = solver.step(&StepInput { tick, duration, bodies, commands: Vec::new() }).unwrap();
        let pose = solver.snapshot().unwrap().poses[0].unwrap();
        let given = report.bodies[0];
        self.input.linear_velocity += given.linear / self.mass + report.simulated as f32 * self.input.acceleration;
        self.input.angular_velocity += self.input.inverse_inertia * given.angular;
        (self.input.position, self.input.rotation) = (pose.position, pose.rotation);
        report
    }
}

#[test]
fn a_body_gets_what_the_fluid_loses() {
    let mut scene = FluidScene { gravity: Vec3::ZERO, ..FluidScene::with_spacing(0.05) };
    scene.volumes = vec![Volume { velocity: Vec3::X, ..Volume::block(Vec3::splat(0.15), Vec3::new(-0.35, 0.02, 0.0)) }];
    scene.bodies = vec![ball(&scene, 0.15)];
    let mut solver = solver(&incompressible(scene, DivergenceFree::default()), 2);
    let mass = f64::from(solver.plan().parameters.particle_mass);
    let momentum = |solver: &mut CpuSolver| {
        solver.snapshot().unwrap().velocities.iter().map(|v| mass * v.as_dvec3()).sum::<DVec3>()
    };
    let before = momentum(&mut solver);
    let mut ball = Ball::new(0.15, 700.0, Vec3::ZERO, Vec3::ZERO);
    let mut given = DVec3::ZERO;
    for tick in 0..30 {
        given += ball.tick(&mut solver, tick, 0.01).bodies[0].linear.as_dvec3();
    }
    let lost = before - momentum(&mut solver);
    assert!(given.x > 1.0 && ball.input.linear_velocity.x > 0.1, "the block hit: {given}");
    assert!((lost - given).length() < 1e-5 * given.length(), "{lost} against {given}");
}

/// A pool of 20 spacings a side, 20 deep.
fn pool(radius: f32) -> FluidScene {
    let scene = FluidScene {
        volumes: vec![Volume::block(Vec3::splat(0.5), Vec3::Y * 0.5)],
        boundaries: vec![Boundary::open_box(Vec3::new(1.0, 1.6, 1.0), Vec3::Y * 0.8)],
        ..FluidScene::with_spacing(0.05)
    };
    let scene = FluidScene { bodies: vec![ball(&scene, radius)], ..scene };
    incompressible(scene, DivergenceFree::default())
}

/// Released in the middle of a pool of standing water, a ball begins to move as potential theory says: `g (rho - rho_b) / (rho_b + rho/2)`,
/// the fluid around it adding half of what it displaces to its mass. The ball is six spacings wide: 0.82, 0.85, 0.93, 1.10 and 1.00 times
/// that (with half the spacing 0.90, 0.92, 0.86, 1.0 and 1.00); walls near by add some mass, too. However light or heavy, nothing
/// is thrown about.
#[test]
fn a_ball_begins_to_rise_or_sink_with_its_added_mass() {
    for ratio in [0.01, 0.1, 0.5, 2.0, 20.0f32] {
        let scene = pool(0.15);
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
        let scene = pool(0.15);
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
    let scene = pool(0.15);
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
        let scene = pool(0.15);
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
    let scene = pool(0.15);
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

/// A blade that turns about its end: where it is fast is not where its centre of mass is said to be.
#[test]
fn substeps_are_short_enough_for_what_turns() {
    let mut scene = column_with(1, 1e-3);
    scene.volumes.clear();
    scene.settings.max_particles = Some(10);
    scene.bodies[0].samples = (0..20u8).map(|i| Vec3::X * 0.025 * f32::from(i)).collect();
    let (rate, reach) = (10.0, 0.025 * 19.0);
    let bodies = vec![BodyInput { angular_velocity: Vec3::Y * rate, ..BodyInput::default() }];
    let mut solver = solver(&scene, 1);
    let report = solver.step(&StepInput { duration: 1.0 / 60.0, bodies, ..StepInput::default() }).unwrap();
    let way = report.smallest_substep * rate * reach;
    assert!(way <= 1.001 * scene.settings.courant_factor * 0.025, "{way} m in a substep, {report:?}");
}
