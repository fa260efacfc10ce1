//! Bodies in an incompressible fluid: fluid and bodies solved for as one, against sums over all pairs in double precision, and what must
//! come of it.

use std::f32::consts::PI;

use freshet_core::prelude::*;
use freshet_gpu::{GpuOptions, GpuSolver, NeighbourMemory};
use glam::DVec3;

use crate::common::{device, solver, solver_with, tick};

#[path = "../../../freshet_cpu/tests/common/reference.rs"]
mod pairs;
use pairs::{Reference, disturbed};

fn incompressible(mut scene: FluidScene, solver: DivergenceFree) -> FluidScene {
    scene.settings.pressure_solver = PressureSolver::DivergenceFree(solver);
    scene
}

fn ball(scene: &FluidScene, radius: f32) -> Body {
    let samples = scene.wall_layer().unwrap().sphere_surface(radius).unwrap();
    let solids = vec![Solid::ball(radius, Vec3::ZERO)];
    Body { name: "ball".to_owned(), samples, solids }
}

/// A column of 0.25 m in an open box, and a body for each input, the centre of mass of which is not that of the ball.
fn column_with(bodies: usize, tolerance: f32) -> FluidScene {
    let scene = FluidScene {
        volumes: vec![Volume::block(Vec3::splat(0.125), Vec3::Y * 0.125)],
        boundaries: vec![Boundary::open_box(Vec3::new(0.25, 0.375, 0.25), Vec3::Y * 0.1875)],
        ..FluidScene::with_spacing(0.025)
    };
    let mut small = ball(&scene, 0.04);
    small.samples.iter_mut().for_each(|sample| *sample += Vec3::new(0.005, 0.0, 0.01));
    small.solids.clear();
    let settings = DivergenceFree { compression: tolerance, divergence: tolerance, max_iterations: 5000 };
    let mut scene = incompressible(FluidScene { bodies: vec![small; bodies], ..scene }, settings);
    scene.settings.artificial_viscosity = 0.0;
    scene
}

/// A body that the fluid cannot move, one that it can, and one that weighs next to nothing; the first two share particles.
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

/// How a substep of 1 ms from a disturbed state differs from what it should be, each over what is allowed: velocities from those that
/// the pressures reported make of them; impulses, and where bodies are, from what these do to them; what is left of the divergence,
/// in the mean of all particles; not solved at all is infinite.
fn errors(kernel: KernelKind, options: GpuOptions) -> [f64; 4] {
    let mut scene = column_with(3, 1e-5);
    scene.settings.kernel = kernel;
    let plan = Plan::new(&scene).unwrap();
    let (start, bodies) = (disturbed(&plan), three_bodies());
    let mut solver = solver_with(&scene, options);
    solver.restore(&Snapshot { tick: 1, ..start.clone() }).unwrap();
    let duration = 1e-3;
    let report = solver.step(&StepInput { bodies: bodies.clone(), ..tick(1, duration) }).unwrap();
    assert_eq!((report.substeps, report.removed), (1, 0), "{kernel:?}");
    let end = solver.snapshot().unwrap();
    if report.unsolved > 0 || end.ids.len() != start.ids.len() {
        return [f64::INFINITY; 4];
    }

    let reference = Reference::new(&plan, &start.positions, &bodies);
    let dt = f64::from(duration);
    let velocities: Vec<DVec3> = end.velocities.iter().map(|v| v.as_dvec3()).collect();
    let pressures: Vec<f64> = end.pressures.iter().map(|&p| f64::from(p)).collect();
    assert!(pressures.iter().all(|&pressure| pressure >= 0.0));
    let (mut of_fluid, mut of_impulses, mut of_poses): (f64, f64, f64) = (0.0, 0.0, 0.0);
    for (i, acceleration) in reference.accelerations(&pressures).iter().enumerate() {
        let expected = start.velocities[i].as_dvec3() + dt * (scene.gravity.as_dvec3() + *acceleration);
        let allowed = 1e-4 * dt * acceleration.length().max(10.0) + 1e-6;
        of_fluid = of_fluid.max(velocities[i].distance(expected) / allowed);
    }
    let mut motions = Vec::new();
    for (index, [force, torque]) in reference.loads(&pressures).into_iter().enumerate() {
        let (body, impulse, pose) = (&bodies[index], report.bodies[index], end.poses[index].unwrap());
        assert!(force.length() > 0.1 && torque.length() > 1e-4, "{index}: {force} N, {torque} N m");
        let [linear, angular] = [impulse.linear.as_dvec3(), impulse.angular.as_dvec3()];
        of_impulses = of_impulses.max(linear.distance(dt * force) / (1e-4 * dt * force.length()));
        of_impulses = of_impulses.max(angular.distance(dt * torque) / (1e-3 * dt * torque.length()));
        let acceleration = f64::from(body.inverse_mass) * force + body.acceleration.as_dvec3();
        let velocity = body.linear_velocity.as_dvec3() + dt * acceleration;
        let spin = body.angular_velocity.as_dvec3() + dt * (body.inverse_inertia.as_dmat3() * torque);
        let way = (pose.position - body.position).as_dvec3();
        of_poses = of_poses.max(way.distance(dt * velocity) / 1e-6);
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
    println!("{kernel:?}: {wrong:e} left, {asked:e} asked for, {wrong_if_standing:e} with standing bodies, {report:?}");
    assert!(wrong_if_standing > 30.0 * asked, "{wrong_if_standing}");
    [of_fluid, of_impulses, of_poses, wrong / (1.5 * asked)]
}

/// Particles are accelerated by the pressures that are reported, also against the bodies; bodies get the opposite as impulses and move by
/// it; and with the velocities that both have at the end nothing is compressed. And a wrong constant in any of the passes would be
/// noticed.
#[test]
fn a_substep_solves_for_fluid_and_bodies_together() {
    for (kernel, neighbours) in
        [(KernelKind::WendlandC2, NeighbourMemory::Textures), (KernelKind::CubicSpline, NeighbourMemory::Buffers)]
    {
        let found = errors(kernel, GpuOptions { neighbours, ..GpuOptions::default() });
        assert!(found.iter().all(|&error| error < 1.0), "{kernel:?}, {neighbours:?}: {found:?}");
    }
    for (from, to) in [
        ("rate -= dot(velocity, found.push)", "rate -= 0.99 * dot(velocity, found.push)"),
        ("dot(spin, found.turn)", "dot(spin, 1.02 * found.turn)"),
        ("cross(fields::answer_angular(arm.body), arm.offset)", "vec3<f32>(0.0)"),
        ("acceleration -= fields::answer_linear(arm.body)", "acceleration -= 0.98 * fields::answer_linear(arm.body)"),
        ("fields::body_force(body) + fields::answer_force(body)", "fields::body_force(body)"),
        ("fields::body_torque(body) + fields::answer_torque(body)", "fields::body_torque(body)"),
        ("return fields::change(a);", "return 0.99 * fields::change(a);"),
    ] {
        let found = errors(KernelKind::WendlandC2, GpuOptions { patch: Some((from, to)), ..GpuOptions::default() });
        assert!(found.iter().any(|&error| error > 1.0), "{from} -> {to} went unnoticed: {found:?}");
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

    fn tick(&mut self, solver: &mut GpuSolver, number: u64, duration: f32) -> StepReport {
        let report = solver.step(&StepInput { bodies: vec![self.input], ..tick(number, duration) }).unwrap();
        let state = solver.body_states().unwrap()[0];
        let given = report.bodies[0];
        self.input.linear_velocity += given.linear / self.mass + report.simulated as f32 * self.input.acceleration;
        self.input.angular_velocity += self.input.inverse_inertia * given.angular;
        (self.input.position, self.input.rotation) = (state.position, Quat::from_array(state.rotation));
        report
    }
}

/// Momentum, N s.
fn momentum(solver: &mut GpuSolver) -> DVec3 {
    let mass = f64::from(solver.plan().parameters.particle_mass);
    solver.snapshot().unwrap().velocities.iter().map(|v| mass * v.as_dvec3()).sum()
}

#[test]
fn a_body_gets_what_the_fluid_loses() {
    let mut scene = FluidScene { gravity: Vec3::ZERO, ..FluidScene::with_spacing(0.05) };
    scene.volumes = vec![Volume { velocity: Vec3::X, ..Volume::block(Vec3::splat(0.15), Vec3::new(-0.35, 0.02, 0.0)) }];
    scene.bodies = vec![ball(&scene, 0.15)];
    let mut solver = solver(&incompressible(scene, DivergenceFree::default()));
    let before = momentum(&mut solver);
    let mut ball = Ball::new(0.15, 700.0, Vec3::ZERO, Vec3::ZERO);
    let mut given = DVec3::ZERO;
    for number in 0..30 {
        given += ball.tick(&mut solver, number, 0.01).bodies[0].linear.as_dvec3();
    }
    let lost = before - momentum(&mut solver);
    assert!(given.x > 1.0 && ball.input.linear_velocity.x > 0.1, "the block hit: {given}");
    assert!((lost - given).length() < 1e-5 * given.length(), "{lost} against {given}");
}

/// A block of water thrown at a body that stands fast: angular momentum about the origin, too, in one substep. What positions are corrected
/// by counts for neither.
#[test]
fn a_fixed_body_takes_the_angular_momentum_that_the_fluid_loses() {
    let mut scene = FluidScene { gravity: Vec3::ZERO, ..FluidScene::with_spacing(0.05) };
    let velocity = Vec3::new(1.0, 0.0, 0.3);
    scene.volumes = vec![Volume { velocity, ..Volume::block(Vec3::splat(0.15), Vec3::new(-0.25, 0.58, 0.2)) }];
    let mut lopsided = ball(&scene, 0.15);
    lopsided.samples.iter_mut().for_each(|sample| *sample += Vec3::new(0.0, 0.05, 0.0));
    lopsided.solids.clear();
    scene.bodies = vec![lopsided];
    let mut solver = solver(&incompressible(scene, DivergenceFree::default()));
    let start = solver.snapshot().unwrap();
    let fixed = BodyInput { position: Vec3::new(0.02, 0.45, 0.21), ..BodyInput::default() };
    let report = solver.step(&StepInput { bodies: vec![fixed], ..tick(0, 1e-6) }).unwrap();
    let end = solver.snapshot().unwrap();
    let mass = f64::from(solver.plan().parameters.particle_mass);
    let (mut linear, mut angular) = (DVec3::ZERO, DVec3::ZERO);
    for (id, velocity) in end.ids.iter().zip(&end.velocities) {
        let before = start.ids.iter().position(|other| other == id).unwrap();
        let lost = mass * (start.velocities[before] - velocity).as_dvec3();
        linear += lost;
        angular += start.positions[before].as_dvec3().cross(lost);
    }
    let given = report.bodies[0];
    let [force, torque] = [given.linear.as_dvec3(), given.angular.as_dvec3()];
    assert!(force.length() > 1.0 && torque.length() > 0.03, "{given:?}");
    assert!((linear - force).length() < 1e-5 * force.length(), "{linear} {given:?}");
    let turn = torque + fixed.position.as_dvec3().cross(force);
    assert!((angular - turn).length() < 1e-5 * turn.length(), "{angular} {turn}");
}

/// A pool of ten spacings with two balls that share water.
fn pool() -> FluidScene {
    let scene = FluidScene {
        volumes: vec![Volume::block(Vec3::splat(0.25), Vec3::Y * 0.25)],
        boundaries: vec![Boundary::open_box(Vec3::new(0.5, 1.0, 0.5), Vec3::Y * 0.5)],
        ..FluidScene::with_spacing(0.05)
    };
    let scene = FluidScene { bodies: vec![ball(&scene, 0.1); 2], ..scene };
    incompressible(scene, DivergenceFree::default())
}

fn two_balls(number: u64, duration: f32) -> StepInput {
    let light = BodyInput { angular_velocity: Vec3::new(1.0, 2.0, 3.0), ..floating(0.1, 0.35, -0.11) };
    StepInput { bodies: vec![light, floating(0.8, 0.3, 0.11)], ..tick(number, duration) }
}

fn floating(ratio: f32, y: f32, x: f32) -> BodyInput {
    Ball::new(0.1, 1000.0 * ratio, Vec3::new(x, y, 0.01), Vec3::NEG_Y * 9.81).input
}

#[test]
fn bits_depend_neither_on_how_many_iterations_were_encoded_nor_on_memory_and_groups() {
    let scene = pool();
    let run = |options: GpuOptions, anew: bool| {
        let mut solver = solver_with(&scene, options);
        let mut reports = Vec::new();
        for number in 0..6 {
            if anew {
                // Forgets how many iterations the last tick needed.
                let state = solver.snapshot().unwrap();
                solver.restore(&state).unwrap();
            }
            let report = solver.step(&two_balls(number, 1.0 / 60.0)).unwrap();
            assert_eq!((report.removed, report.unsolved), (0, 0), "{report:?}");
            reports.push((report.substeps, report.divergence_iterations, report.density_iterations, report.bodies));
        }
        (solver.snapshot().unwrap(), reports)
    };
    let whole = run(GpuOptions::default(), false);
    assert!(whole.1.iter().any(|report| report.1 > 17 * report.0), "more than are encoded first: {:?}", whole.1);
    assert!(run(GpuOptions::default(), true) == whole, "from a snapshot each tick");
    for (workgroup_size, neighbours) in [(32, NeighbourMemory::Buffers), (256, NeighbourMemory::Textures)] {
        let other = run(GpuOptions { workgroup_size, neighbours, ..GpuOptions::default() }, false);
        assert!(other == whole, "{workgroup_size}, {neighbours:?}");
    }
}

/// In the pipelined mode a tick ends with the iterations it has, also for the bodies: they move by what the fluid gives up.
#[test]
fn a_tick_that_nobody_waits_for_ends_its_solves_with_its_bodies() {
    let mut scene = pool();
    scene.gravity = Vec3::ZERO;
    scene.boundaries.clear();
    scene.volumes[0].velocity = Vec3::X;
    scene.settings.expected_speed = Some(3.0);
    let mut solver =
        solver(&incompressible(scene, DivergenceFree { compression: 1e-6, divergence: 1e-6, max_iterations: 300 }));
    let device = device();
    let mut reports = Vec::new();
    let mut inputs = two_balls(0, 1.0 / 60.0);
    inputs.bodies.iter_mut().for_each(|body| body.acceleration = Vec3::ZERO);
    for number in 0..12 {
        solver.prepare(&device.queue, &StepInput { tick: number, ..inputs.clone() }).unwrap();
        let mut encoder = device.device.create_command_encoder(&Default::default());
        solver.encode(&mut encoder).unwrap();
        device.queue.submit([encoder.finish()]);
        reports.extend(solver.collect(&device.device).unwrap());
    }
    while solver.ticks_in_flight() > 0 {
        reports.extend(solver.collect(&device.device).unwrap());
    }
    assert_eq!(reports.len(), 12);
    assert!(reports.iter().all(|report| report.removed == 0), "{reports:?}");
    assert!(reports.iter().any(|report| report.unsolved > 0 && report.substeps > 0), "{reports:?}");
    let given: DVec3 = reports.iter().flat_map(|report| &report.bodies).map(|given| given.linear.as_dvec3()).sum();
    // Those that started in the balls have fallen out.
    let before = f64::from(reports[11].particles * 125) * 1e-3 * DVec3::X;
    let lost = before - momentum(&mut solver);
    assert!(given.length() > 1.0 && (lost - given).length() < 1e-5 * given.length(), "{lost} against {given}");
}

/// Let go in the middle of a pool of standing water, a ball begins to move as potential theory says: `g (rho - rho_b) / (rho_b + rho/2)`,
/// by the bounds of the CPU's test (`crates/freshet_cpu/tests/incompressible_bodies.rs`).
#[test]
fn a_ball_begins_to_rise_or_sink_with_its_added_mass() {
    let scene = FluidScene {
        volumes: vec![Volume::block(Vec3::splat(0.5), Vec3::Y * 0.5)],
        boundaries: vec![Boundary::open_box(Vec3::new(1.0, 1.6, 1.0), Vec3::Y * 0.8)],
        ..FluidScene::with_spacing(0.05)
    };
    let scene = FluidScene { bodies: vec![ball(&scene, 0.15)], ..scene };
    let scene = incompressible(scene, DivergenceFree::default());
    let mut solver = solver(&scene);
    let held = BodyInput { position: Vec3::Y * 0.5, ..BodyInput::default() };
    for number in 0..60 {
        solver.step(&StepInput { bodies: vec![held], ..tick(number, 1.0 / 60.0) }).unwrap();
    }
    let calm = solver.snapshot().unwrap();
    for ratio in [0.01, 0.5, 20.0f32] {
        solver.restore(&calm).unwrap();
        let mut ball = Ball::new(0.15, 1000.0 * ratio, Vec3::Y * 0.5, scene.gravity);
        for number in 0..2 {
            let report = ball.tick(&mut solver, calm.tick + number, 1.0 / 240.0);
            assert_eq!((report.removed, report.unsolved), (0, 0), "{ratio}: tick {number}");
        }
        let expected = 9.81 * (1.0 - ratio) / (ratio + 0.5);
        let begun = ball.input.linear_velocity.y * 120.0 / expected;
        println!("{ratio}: {begun} of {expected} m/s2");
        assert!((0.75..1.2).contains(&begun), "{ratio}: {begun} of {expected} m/s2");
    }
}

#[test]
fn memory_and_passes_are_those_of_the_plan() {
    let with = solver(&pool());
    let without = solver(&FluidScene { bodies: Vec::new(), ..pool() });
    let names = |solver: &GpuSolver| {
        let schedule = solver.schedule();
        assert_eq!(schedule.bytes(), solver.allocated_bytes(), "{schedule}");
        let names = schedule.passes.iter().map(|pass| pass.name).chain(schedule.buffers.iter().map(|b| b.name));
        names.collect::<Vec<_>>()
    };
    for name in ["body_touch", "divergence_bodies", "left_at_bodies", "answers"] {
        assert!(names(&with).contains(&name) && !names(&without).contains(&name), "{name}");
    }
    let solves = |solver: &GpuSolver| {
        let schedule = solver.schedule();
        schedule.buffers.iter().find(|buffer| buffer.name == "solves").map(|b| b.bytes / u64::from(schedule.capacity))
    };
    assert_eq!((solves(&with), solves(&without)), (Some(40), Some(32)));
    for pass in ["project", "pressure_change", "divergence_first", "solve_control", "step_control", "density_begin"] {
        let code = without.shader(pass).unwrap();
        let code = code.split("fn ").skip(1).collect::<String>();
        assert!(!code.contains("answers") && !code.contains("bodies"), "{pass}: {code}");
    }
    for pass in ["body_push", "body_answer"] {
        assert!(with.shader(pass).is_some() && without.shader(pass).is_none(), "{pass}");
    }
}

/// Bodies beside the fluid, deep in a wall, one in another: all is finite. And more of them than a group of the shaders has threads.
#[test]
fn odd_bodies_end_with_finite_numbers() {
    let mut scene = pool();
    let ball = scene.bodies[0].clone();
    scene.bodies = vec![Body { solids: Vec::new(), ..ball }; 70];
    let mut solver = solver(&scene);
    let at = |index: usize| {
        let free = BodyInput { inverse_mass: 0.1, inverse_inertia: Mat3::IDENTITY, ..BodyInput::default() };
        let position = match index {
            0 => Vec3::new(3.0, 0.5, 0.0),
            1 => Vec3::new(-0.25, 0.2, 0.0),
            2 | 3 => Vec3::new(0.1, 0.4, 0.0),
            69 => Vec3::new(0.05, 0.3, 0.1),
            _ => Vec3::new(0.0, 10.0 + index as f32, 0.0),
        };
        BodyInput { position, ..free }
    };
    for number in 0..4 {
        let bodies = (0..70).map(at).collect();
        let report = solver.step(&StepInput { bodies, ..tick(number, 1.0 / 120.0) }).unwrap();
        assert!(report.bodies.iter().all(|given| given.linear.is_finite() && given.angular.is_finite()), "{report:?}");
        assert_eq!(report.bodies[0].linear, Vec3::ZERO);
        assert!(number < 3 || report.bodies[69].linear.length() > 0.1, "{:?}", report.bodies[69]);
    }
    let speeds = solver.read(Field::Speed).unwrap().scalars().unwrap();
    assert!(speeds.iter().all(|speed| speed.is_finite()));
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
    let mut solver = solver(&scene);
    let report = solver.step(&StepInput { duration: 1.0 / 60.0, bodies, ..StepInput::default() }).unwrap();
    let way = report.smallest_substep * rate * reach;
    assert!(way <= 1.001 * scene.settings.courant_factor * 0.025, "{way} m in a substep, {report:?}");
}
