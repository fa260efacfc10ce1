//! Scenes made to break a solver. Each ends with finite numbers and a report, or with a typed error; no particle is removed and
//! energy grows by no more than a twentieth.

use freshet_core::prelude::*;
use freshet_gpu::{DeviceRequest, GpuOptions, GpuSolver, open_device};
use freshet_lab::backend::Backend;

/// A tank of 1.2 x 1 x 0.5 with a block of 0.5^3 in a corner, in units of `length`.
fn dam(length: f32, spacing: f32) -> FluidScene {
    let (block, tank) = (Vec3::splat(0.5) * length, Vec3::new(1.2, 1.0, 0.5) * length);
    FluidScene {
        volumes: vec![Volume::block(block / 2.0, block / 2.0)],
        boundaries: vec![Boundary::open_box(tank, tank / 2.0)],
        ..FluidScene::with_spacing(spacing)
    }
}

/// Kinetic energy and energy of height above `floor`, J.
fn energy(plan: &Plan, solver: &mut dyn FluidSolver, floor: f32) -> f64 {
    let positions = solver.read(Field::Position).unwrap().vectors().unwrap();
    let velocities = solver.read(Field::Velocity).unwrap().vectors().unwrap();
    assert!(positions.iter().chain(&velocities).all(|vector| vector.is_finite()), "not finite");
    let parameters = &plan.parameters;
    let sum: f64 = positions
        .iter()
        .zip(&velocities)
        .map(|(position, velocity)| {
            let height = f64::from(position.y - floor) * f64::from(-parameters.gravity.y);
            0.5 * velocity.as_dvec3().length_squared() + height
        })
        .sum();
    sum * f64::from(parameters.particle_mass)
}

/// Runs ticks and holds each report to what every scene must keep.
fn survives(name: &str, backend: Backend, scene: &FluidScene, tick: f32, ticks: u64) -> StepReport {
    let plan = Plan::new(scene).unwrap_or_else(|error| panic!("{name}: {error}"));
    let floor =
        plan.boundary.positions.iter().map(|sample| sample.y).fold(0.0, f32::min) + plan.parameters.boundary_depth;
    let mut solver = backend.open(plan.clone(), None).unwrap();
    let start = energy(&plan, solver.as_mut(), floor);
    // A scene that starts with none may have a hundredth of what its expected speed would be.
    let mass = plan.positions.len() as f64 * f64::from(plan.parameters.particle_mass);
    let rounding = 0.005 * mass * f64::from(plan.parameters.expected_speed).powi(2);
    let mut last = StepReport::default();
    for number in 0..ticks {
        last = solver.step(&StepInput { tick: number, duration: tick, ..StepInput::default() }).unwrap();
        let now = energy(&plan, solver.as_mut(), floor);
        assert_eq!((last.removed, last.refused), (0, 0), "{name} on {backend}, tick {number}: {last:?}");
        assert_eq!(last.particles as usize, plan.positions.len(), "{name} on {backend}, tick {number}");
        assert!(last.max_speed.is_finite() && last.mean_compression.is_finite(), "{name} on {backend}: {last:?}");
        assert!(
            now <= 1.05 * start + rounding,
            "{name} on {backend}, tick {number}: {now} J after {start} J, {last:?}"
        );
    }
    last
}

/// A sixtieth of the time in which the scene falls by its own height, and so many of them.
fn fall(length: f32, gravity: f32) -> (f32, u64) {
    ((length / gravity).sqrt() / 20.0, 30)
}

#[test]
fn scales_and_densities_far_from_one() {
    for (name, length, spacing) in [("1 mm", 0.02, 1e-3), ("10 m", 200.0, 10.0)] {
        let (tick, ticks) = fall(length, 9.81);
        survives(name, Backend::Cpu, &dam(length, spacing), tick, ticks);
    }
    for density in [1.0, 20_000.0] {
        let mut scene = dam(1.0, 0.05);
        scene.material.rest_density = density;
        survives(&format!("{density} kg/m3"), Backend::Cpu, &scene, 1.0 / 60.0, 20);
    }
    for gravity in [0.0, 1000.0] {
        let mut scene = dam(1.0, 0.05);
        scene.gravity = Vec3::NEG_Y * gravity;
        let (tick, ticks) = fall(1.0, gravity.max(9.81));
        let last = survives(&format!("gravity {gravity}"), Backend::Cpu, &scene, tick, ticks);
        assert!(gravity > 0.0 || last.max_speed < 0.05, "without gravity it rests: {last:?}");
    }
}

#[test]
fn few_and_many_neighbours() {
    for neighbours in [16.0, 100.0] {
        let mut scene = dam(1.0, 0.05);
        scene.settings.support = Support::Neighbours(neighbours);
        survives(&format!("{neighbours} neighbours"), Backend::Cpu, &scene, 1.0 / 60.0, 20);
    }
}

#[test]
fn a_domain_ten_kilometres_from_the_origin() {
    let mut far = dam(8.0, 0.4);
    let away = Vec3::new(10_000.0, 0.0, -10_000.0);
    far.volumes[0].center += away;
    far.boundaries[0].center += away;
    let (tick, ticks) = fall(8.0, 9.81);
    survives("10 km away", Backend::Cpu, &far, tick, ticks);
    // Where single precision cannot tell a sixty-fourth of the spacing it is refused.
    let mut fine = dam(1.0, 0.05);
    fine.volumes[0].center += away;
    fine.boundaries[0].center += away;
    let error = Plan::new(&fine).unwrap_err().to_string();
    assert!(error.contains("resolution") && error.contains("0.05"), "{error}");
}

#[test]
fn a_block_at_fifty_metres_a_second_against_a_plate() {
    let mut scene = dam(1.0, 0.05);
    scene.gravity = Vec3::ZERO;
    let velocity = Vec3::X * 50.0;
    scene.volumes = vec![Volume { velocity, ..Volume::block(Vec3::splat(0.2), Vec3::new(0.5, 0.5, 0.25)) }];
    scene.boundaries =
        vec![Boundary::new(BoundaryShape::Box { half_extents: Vec3::new(0.1, 1.0, 1.0) }, Vec3::new(1.0, 0.5, 0.25))];
    let last = survives("50 m/s", Backend::Cpu, &scene, 1e-3, 30);
    assert!(last.max_speed < 150.0, "{last:?}");
}

#[test]
fn hitches_of_a_quarter_second_and_of_five() {
    for backend in [Backend::Cpu, Backend::Gpu] {
        let last = survives("a hitch", backend, &dam(1.0, 0.1), 0.25, 1);
        assert!(last.simulated > 0.249, "{last:?}");
    }
    let mut solver = Backend::Cpu.open(Plan::new(&dam(1.0, 0.1)).unwrap(), None).unwrap();
    let error = solver.step(&StepInput { duration: 5.0, ..StepInput::default() }).unwrap_err();
    assert!(matches!(&error, SolverError::Invalid(invalid) if invalid.field == "duration"), "{error:?}");
    // In ticks of at most a second it is covered, and nothing was lost by the refusal.
    for tick in 0..5 {
        let report = solver.step(&StepInput { tick, duration: 1.0, ..StepInput::default() }).unwrap();
        assert_eq!((report.removed, report.time_scale), (0, 1.0), "{report:?}");
    }
}

/// No fluid, one particle, two particles in one place: on both backends.
#[test]
fn nothing_one_and_two_in_the_same_place() {
    for backend in [Backend::Cpu, Backend::Gpu] {
        let mut empty = FluidScene { boundaries: dam(1.0, 0.1).boundaries, ..FluidScene::with_spacing(0.1) };
        empty.settings.max_particles = Some(8);
        let mut solver = backend.open(Plan::new(&empty).unwrap(), None).unwrap();
        let report = solver.step(&StepInput { duration: 0.01, ..StepInput::default() }).unwrap();
        assert_eq!((report.particles, report.removed, report.max_speed), (0, 0, 0.0), "{backend}");

        let spawn = |position: Vec3| NewParticles {
            positions: vec![position],
            velocities: vec![Vec3::ZERO],
            lifetime: f32::INFINITY,
            at: None,
        };
        let one = Command::Spawn(spawn(Vec3::new(0.6, 0.9, 0.25)));
        let input = StepInput { tick: 1, duration: 0.1, commands: vec![one], ..StepInput::default() };
        let report = solver.step(&input).unwrap();
        // Alone it falls freely: v = g t.
        assert_eq!((report.particles, report.removed), (1, 0), "{backend}");
        let velocity = solver.read(Field::Velocity).unwrap().vectors().unwrap()[0];
        assert!((velocity - Vec3::NEG_Y * 0.981).length() < 1e-4, "{backend}: {velocity}");

        let place = solver.read(Field::Position).unwrap().vectors().unwrap()[0];
        let again = Command::Spawn(NewParticles { velocities: vec![velocity], ..spawn(place) });
        let input = StepInput { tick: 2, duration: 0.05, commands: vec![again], ..StepInput::default() };
        let report = solver.step(&input).unwrap();
        assert_eq!((report.particles, report.removed), (2, 0), "{backend}");
        // They have no direction to part in and fall as one.
        let after = solver.read(Field::Velocity).unwrap().vectors().unwrap();
        for velocity in after {
            assert!((velocity - Vec3::NEG_Y * (0.981 + 0.4905)).length() < 1e-3, "{backend}: {velocity}");
        }
    }
}

/// A tick's commands are carried out before its sort makes room, so of 5,000 spawned in a tick those beyond the pool's room are
/// refused and counted; nothing else may come of it.
#[test]
fn a_hundred_thousand_commands() {
    let mut scene = dam(1.0, 0.1);
    scene.settings.max_particles = Some(2000);
    let plan = Plan::new(&scene).unwrap();
    let start = plan.positions.len() as u32;
    let mut solver = Backend::Cpu.open(plan, None).unwrap();
    for tick in 0..10u64 {
        let mut commands = Vec::new();
        for i in 0..5_000u16 {
            let place = Vec3::new(0.8, 0.5, 0.25) + 0.01 * Vec3::splat(f32::from(i % 30));
            commands.push(Command::Spawn(NewParticles {
                positions: vec![place],
                velocities: vec![Vec3::ZERO],
                lifetime: f32::INFINITY,
                at: None,
            }));
            commands.push(Command::RemoveInBox { min: place - 1e-3, max: place + 1e-3 });
        }
        let report = solver.step(&StepInput { tick, duration: 1e-3, commands, ..StepInput::default() }).unwrap();
        let room = 2000 - start;
        assert_eq!((report.refused, report.retired), (5_000 - room, room), "tick {tick}: {report:?}");
        assert_eq!((report.removed, report.particles), (0, start), "tick {tick}: {report:?}");
    }
}

/// Five million particles need 160 MB in one binding; WebGPU promises 128 MiB.
#[test]
fn millions_of_particles_on_a_device_that_cannot_hold_them() {
    let spacing = 0.01;
    let block = Vec3::splat(171.0 * spacing);
    let scene =
        FluidScene { volumes: vec![Volume::block(block / 2.0, Vec3::ZERO)], ..FluidScene::with_spacing(spacing) };
    let plan = Plan::new(&scene).unwrap();
    assert!(plan.positions.len() == 171 * 171 * 171, "{}", plan.positions.len());
    let opened = open_device(DeviceRequest::default()).unwrap();
    let error = GpuSolver::new(&opened.device, &opened.queue, plan, GpuOptions::default()).err().unwrap();
    let SolverError::WeakAdapter { limit, offered, needed, .. } = &error else { panic!("{error:?}") };
    assert!(limit.contains("storage_buffer") && needed > offered, "{error}");
}
