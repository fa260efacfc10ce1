//! Bodies in an incompressible fluid: fluid and bodies solved for as one, against sums over all pairs in double precision, and what must
//! come of it.

use freshet_core::prelude::*;
use freshet_gpu::{GpuOptions, GpuSolver, NeighbourMemory};
use glam::DVec3;

use crate::common::{device, solver, solver_with, tick};

#[path = "../../../freshet_cpu/tests/common/floating.rs"]
mod floating;
#[path = "../../../freshet_cpu/tests/common/reference.rs"]
mod reference;
use floating::{Ball, assert_a_body_gets_what_the_fluid_loses, assert_substeps_are_short_enough_for_what_turns, ball};
use floating::{assert_a_tank_takes_its_water_along, closed_tank};
use floating::{blade, block_at_ball, deep_pool, disturbed_column, incompressible, momentum, substep_errors};

/// Of one substep.
fn errors(kernel: KernelKind, options: GpuOptions) -> [f64; 4] {
    substep_errors(&mut solver_with(&disturbed_column(kernel), options))
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

#[test]
fn a_body_gets_what_the_fluid_loses() {
    assert_a_body_gets_what_the_fluid_loses(&mut solver(&block_at_ball()));
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
    let scene = deep_pool(0.15);
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

#[test]
fn substeps_are_short_enough_for_what_turns() {
    assert_substeps_are_short_enough_for_what_turns(&mut solver(&blade()));
}

#[test]
fn a_tank_takes_its_water_along() {
    assert_a_tank_takes_its_water_along(&mut solver(&closed_tank()));
}
