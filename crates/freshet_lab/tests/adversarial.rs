//! Scenes made to break a solver. Each ends with finite numbers and a report, or with a typed error; no particle is removed but
//! those that start inside a wall or a body, and energy grows by no more than a twentieth.

use freshet_core::leaks::LeakWatch;
use freshet_core::plan::LeftOut;
use freshet_core::prelude::*;
use freshet_gpu::{DeviceRequest, GpuOptions, GpuSolver, open_device};
use freshet_lab::backend::Backend;
use freshet_lab::method::Method;

/// Every scene runs on both.
const BOTH: [Backend; 2] = [Backend::Cpu, Backend::Gpu];

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

/// Runs ticks by either way to find pressures and holds each report to what every scene must keep; the last reports.
fn survives(name: &str, backend: Backend, scene: &FluidScene, tick: f32, ticks: u64) -> [StepReport; 2] {
    Method::ALL.map(|method| {
        survives_by(&format!("{name}, {}", method.name()), backend, &method.on(scene.clone()), tick, ticks)
    })
}

fn survives_by(name: &str, backend: Backend, scene: &FluidScene, tick: f32, ticks: u64) -> StepReport {
    let plan = Plan::new(scene).unwrap_or_else(|error| panic!("{name}: {error}"));
    let mut watch = LeakWatch::new(&scene.wall_layer().unwrap(), &scene.boundaries);
    let floor =
        plan.boundary.positions.iter().map(|sample| sample.y).fold(0.0, f32::min) + plan.parameters.boundary_depth;
    let mut solver = backend.open(plan.clone(), None).unwrap();
    let start = energy(&plan, solver.as_mut(), floor);
    // A twentieth more than at the start; a scene that starts with none may have a hundredth of what its expected speed would be.
    let mass = plan.positions.len() as f64 * f64::from(plan.parameters.particle_mass);
    let expected = 0.5 * mass * f64::from(plan.parameters.expected_speed).powi(2);
    let most = if start < 1e-3 * expected { 0.01 * expected } else { 1.05 * start };
    let mut largest = start;
    let mut last = StepReport::default();
    for number in 0..ticks {
        last = solver.step(&StepInput { tick: number, duration: tick, ..StepInput::default() }).unwrap();
        let now = energy(&plan, solver.as_mut(), floor);
        let ids = solver.read(Field::Id).unwrap().integers().unwrap();
        watch.look(&ids, &solver.read(Field::Position).unwrap().vectors().unwrap());
        assert_eq!(watch.total(), 0, "{name} on {backend}, tick {number}: through a wall");
        assert_eq!((last.removed, last.refused), (0, 0), "{name} on {backend}, tick {number}: {last:?}");
        assert_eq!((last.inside_solids, last.beside_solids), (0, 0), "{name} on {backend}, tick {number}: {last:?}");
        assert_eq!(last.particles as usize, plan.positions.len(), "{name} on {backend}, tick {number}");
        assert!(last.max_speed.is_finite() && last.mean_compression.is_finite(), "{name} on {backend}: {last:?}");
        assert!(now <= most, "{name} on {backend}, tick {number}: {now} J after {start} J, {last:?}");
        largest = largest.max(now);
    }
    println!("{name} on {backend}: at most {largest:.6e} J after {start:.6e} J, allowed {most:.6e} J");
    last
}

/// A sixtieth of the time in which the scene falls by its own height, and so many of them.
fn fall(length: f32, gravity: f32) -> (f32, u64) {
    ((length / gravity).sqrt() / 20.0, 30)
}

#[test]
fn scales_and_densities_far_from_one() {
    for backend in BOTH {
        for (name, length, spacing) in [("1 mm", 0.02, 1e-3), ("10 m", 200.0, 10.0)] {
            let (tick, ticks) = fall(length, 9.81);
            survives(name, backend, &dam(length, spacing), tick, ticks);
        }
        for density in [1.0, 20_000.0] {
            let mut scene = dam(1.0, 0.05);
            scene.material.rest_density = density;
            survives(&format!("{density} kg/m3"), backend, &scene, 1.0 / 60.0, 20);
        }
        for gravity in [0.0, 1000.0] {
            let mut scene = dam(1.0, 0.05);
            scene.gravity = Vec3::NEG_Y * gravity;
            let (tick, ticks) = fall(1.0, gravity.max(9.81));
            for last in survives(&format!("gravity {gravity}"), backend, &scene, tick, ticks) {
                assert!(gravity > 0.0 || last.max_speed < 0.05, "without gravity it rests: {last:?}");
            }
        }
    }
}

#[test]
fn few_and_many_neighbours() {
    for backend in BOTH {
        for neighbours in [16.0, 100.0] {
            let mut scene = dam(1.0, 0.05);
            scene.settings.support = Support::Neighbours(neighbours);
            survives(&format!("{neighbours} neighbours"), backend, &scene, 1.0 / 60.0, 20);
        }
    }
}

#[test]
fn a_domain_ten_kilometres_from_the_origin() {
    let mut far = dam(8.0, 0.4);
    let away = Vec3::new(10_000.0, 0.0, -10_000.0);
    far.volumes[0].center += away;
    far.boundaries[0].center += away;
    let (tick, ticks) = fall(8.0, 9.81);
    for backend in BOTH {
        survives("10 km away", backend, &far, tick, ticks);
    }
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
    for backend in BOTH {
        for last in survives("50 m/s", backend, &scene, 1e-3, 30) {
            assert!(last.max_speed < 150.0, "{backend}: {last:?}");
        }
    }
}

#[test]
fn hitches_of_a_quarter_second_and_of_five() {
    for backend in BOTH {
        for last in survives("a hitch", backend, &dam(1.0, 0.1), 0.25, 1) {
            assert!(last.simulated > 0.249, "{last:?}");
        }
    }
    for backend in BOTH {
        let mut solver = backend.open(Plan::new(&dam(1.0, 0.1)).unwrap(), None).unwrap();
        let error = solver.step(&StepInput { duration: 5.0, ..StepInput::default() }).unwrap_err();
        assert!(matches!(&error, SolverError::Invalid(invalid) if invalid.field == "duration"), "{error:?}");
        // In ticks of at most a second it is covered, and nothing was lost by the refusal.
        let report = solver.step(&StepInput { duration: 0.25, ..StepInput::default() }).unwrap();
        assert_eq!((report.removed, report.time_scale), (0, 1.0), "{report:?}");
    }
    for last in survives("five hitches of a second", Backend::Cpu, &dam(1.0, 0.1), 1.0, 5) {
        assert_eq!(last.time_scale, 1.0, "{last:?}");
    }
}

/// No fluid, one particle, two particles in one place: by both methods on both backends, and energy does not grow.
#[test]
fn nothing_one_and_two_in_the_same_place() {
    for (backend, method) in BOTH.into_iter().flat_map(|backend| Method::ALL.map(|method| (backend, method))) {
        let mut empty = FluidScene { boundaries: dam(1.0, 0.1).boundaries, ..FluidScene::with_spacing(0.1) };
        empty.settings.max_particles = Some(8);
        let plan = Plan::new(&method.on(empty)).unwrap();
        let mut solver = backend.open(plan.clone(), None).unwrap();
        let backend = format!("{}, {backend}", method.name());
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
        let mass = f64::from(plan.parameters.particle_mass);
        let most = |particles: f64| 1.05 * particles * mass * 9.81 * 0.9;
        let found = energy(&plan, solver.as_mut(), 0.0);
        assert!(found <= most(1.0), "{backend}: {found} J");
        let velocity = solver.read(Field::Velocity).unwrap().vectors().unwrap()[0];
        assert!((velocity - Vec3::NEG_Y * 0.981).length() < 1e-4, "{backend}: {velocity}");

        let place = solver.read(Field::Position).unwrap().vectors().unwrap()[0];
        let again = Command::Spawn(NewParticles { velocities: vec![velocity], ..spawn(place) });
        let input = StepInput { tick: 2, duration: 0.05, commands: vec![again], ..StepInput::default() };
        let report = solver.step(&input).unwrap();
        assert_eq!((report.particles, report.removed), (2, 0), "{backend}");
        let found = energy(&plan, solver.as_mut(), 0.0);
        assert!(found <= most(2.0), "{backend}: {found} J");
        // They have no direction to part in and fall as one.
        let after = solver.read(Field::Velocity).unwrap().vectors().unwrap();
        for velocity in after {
            assert!((velocity - Vec3::NEG_Y * (0.981 + 0.4905)).length() < 1e-3, "{backend}: {velocity}");
        }
    }
}

/// Two particles in one place within a block that falls and splashes: pressure and viscosity act on both, and neither is thrown
/// about. What is put where something is already compresses it; that work is not known, so that speeds have a bound and energy has none.
#[test]
fn two_in_the_same_place_in_a_block() {
    for backend in BOTH {
        for method in Method::ALL {
            let mut scene = method.on(dam(1.0, 0.1));
            scene.settings.max_particles = Some(200);
            let mut solver = backend.open(Plan::new(&scene).unwrap(), None).unwrap();
            let place = solver.read(Field::Position).unwrap().vectors().unwrap()[62];
            let again = NewParticles {
                positions: vec![place],
                velocities: vec![Vec3::ZERO],
                lifetime: f32::INFINITY,
                at: None,
            };
            let mut commands = vec![Command::Spawn(again)];
            for tick in 0..30 {
                let commands = std::mem::take(&mut commands);
                let report =
                    solver.step(&StepInput { tick, duration: 1.0 / 60.0, commands, ..StepInput::default() }).unwrap();
                assert_eq!((report.particles, report.removed), (126, 0), "{backend}, tick {tick}: {report:?}");
                // Twice what falls from the tank's rim; a particle too many in a place presses the others away.
                assert!(report.max_speed < 9.0, "{} on {backend}, tick {tick}: {report:?}", method.name());
            }
            let positions = solver.read(Field::Position).unwrap().vectors().unwrap();
            assert!(positions.iter().all(|position| position.is_finite()));
        }
    }
}

/// What breaks down and what flies out are both removed, and told apart. Inputs that are not finite are refused, so that they come about as in a
/// running solver: a place that overflows on the way from where it was, and speeds whose squares and differences do.
#[test]
fn what_is_not_finite_is_told_from_what_flies_out() {
    for backend in BOTH {
        for method in Method::ALL {
            let mut scene = method.on(dam(1.0, 0.1));
            scene.settings.max_particles = Some(200);
            let plan = Plan::new(&scene).unwrap();
            let high = plan.parameters.bounds_max - 0.5;
            let mut solver = backend.open(plan, None).unwrap();
            let start = solver.read(Field::Id).unwrap().len() as u32;
            let aside = Vec3::new(0.9, 0.5, 0.25);
            let spawn = |positions: Vec<Vec3>, velocities: Vec<Vec3>, at| {
                Command::Spawn(NewParticles { positions, velocities, lifetime: f32::INFINITY, at })
            };
            let step = |solver: &mut Box<dyn FluidSolver>, tick, command| {
                let input = StepInput { tick, duration: 0.05, commands: vec![command], ..StepInput::default() };
                let report = solver.step(&input).unwrap();
                assert_eq!(report.particles, start, "{} on {backend}, tick {tick}: {report:?}", method.name());
                (report.removed, report.not_finite)
            };
            let flies = spawn(vec![high], vec![Vec3::Y * 20.0], None);
            assert_eq!(step(&mut solver, 0, flies), (1, 0), "{} on {backend}", method.name());
            let overflows = spawn(vec![aside], vec![Vec3::Y * 3e38], Some(-10.0));
            assert_eq!(step(&mut solver, 1, overflows), (1, 1), "{} on {backend}", method.name());
            let meet = spawn(vec![aside, aside + 0.05 * Vec3::X], vec![Vec3::splat(3e38), Vec3::splat(-3e38)], None);
            assert_eq!(step(&mut solver, 2, meet), (2, 2), "{} on {backend}", method.name());
        }
    }
}

/// A tick's commands are carried out before its sort makes room, so of 5,000 spawned in a tick those beyond the pool's room are
/// refused and counted; nothing else may come of it.
#[test]
fn a_hundred_thousand_commands() {
    for (backend, method) in BOTH.into_iter().flat_map(|backend| Method::ALL.map(|method| (backend, method))) {
        let mut scene = method.on(dam(1.0, 0.1));
        scene.settings.max_particles = Some(2000);
        let plan = Plan::new(&scene).unwrap();
        let start = plan.positions.len() as u32;
        let mut solver = backend.open(plan.clone(), None).unwrap();
        let backend = format!("{}, {backend}", method.name());
        let energy_before = energy(&plan, solver.as_mut(), 0.0);
        for tick in 0..10u64 {
            let mut commands = Vec::new();
            for i in 0..5_000u16 {
                let place = Vec3::new(0.8, 0.5, 0.25) + 0.005 * Vec3::splat(f32::from(i % 30));
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
            assert_eq!((report.refused, report.retired), (5_000 - room, room), "{backend}, tick {tick}: {report:?}");
            assert_eq!((report.removed, report.particles), (0, start), "{backend}, tick {tick}: {report:?}");
        }
        // What is spawned and not removed is simulated.
        let row = || (0..3u8).map(|i| 0.1 * f32::from(i));
        let lattice = row().flat_map(|x| row().flat_map(move |y| row().map(move |z| Vec3::new(x, y, z))));
        let positions: Vec<Vec3> = lattice.map(|place| place + Vec3::new(0.8, 0.5, 0.15)).collect();
        let one = f64::from(plan.parameters.particle_mass) * 9.81;
        let spawned_energy: f64 = positions.iter().map(|place| one * f64::from(place.y)).sum();
        let spawned = NewParticles { velocities: vec![Vec3::ZERO; 27], positions, lifetime: f32::INFINITY, at: None };
        let commands = vec![Command::Spawn(spawned)];
        let report = solver.step(&StepInput { tick: 10, duration: 1e-2, commands, ..StepInput::default() }).unwrap();
        assert_eq!((report.removed, report.refused, report.particles), (0, 0, start + 27), "{backend}: {report:?}");
        assert!((0.09..1.0).contains(&report.max_speed), "{backend}: {report:?}");
        let (now, most) = (energy(&plan, solver.as_mut(), 0.0), 1.05 * (energy_before + spawned_energy));
        assert!(now <= most, "{backend}: {now} J, allowed {most} J");
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

/// Spacing of the scenes with walls and bodies in the fluid.
const D: f32 = 0.05;

/// A block of 8 x 8 x 8 particles above the floor of `dam`, and where they are.
fn block_above_the_floor() -> (Volume, Vec<Vec3>) {
    let center = Vec3::new(0.6, 0.3, 0.25);
    let row = || (0..8u8).map(|i| D * (f32::from(i) - 3.5));
    let lattice = row().flat_map(|x| row().flat_map(move |y| row().map(move |z| center + Vec3::new(x, y, z))));
    (Volume::block(Vec3::splat(0.2), center), lattice.collect())
}

/// A block of which a part is in a wall: that part is left out, and said, and all of the rest survives. Its lattice begins
/// anywhere in front of the face; left there, at a fiftieth of a spacing from it, it flew apart at 3,600 m/s.
#[test]
fn a_block_half_inside_a_wall() {
    let (block, lattice) = block_above_the_floor();
    let depth = FluidScene::with_spacing(D).wall_layer().unwrap().depth;
    for share in [0.02, 0.25, 0.5, 0.98] {
        // Four of eight layers are in front of it, the last of them by this share of the spacing.
        let face = 0.6 + (share - 0.5) * D;
        let middle = Vec3::new(face, 0.3, 0.25);
        let solid = BoundaryShape::Box { half_extents: Vec3::splat(0.5) };
        let upright = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
        let plane = Boundary::new(BoundaryShape::Plane { half_extents: [0.5, 0.5] }, middle);
        let tank = Vec3::new(face, 1.0, 0.5);
        let floor = || dam(1.0, D).boundaries.remove(0);
        for (name, boundaries, thickness) in [
            ("box", vec![floor(), Boundary::new(solid, middle + Vec3::X * 0.5)], 1.0),
            ("plane", vec![floor(), Boundary { rotation: upright, ..plane }], 2.0 * depth),
            ("container", vec![Boundary::open_box(tank, tank / 2.0)], 2.0 * depth),
        ] {
            let wall = boundaries.len() - 1;
            let scene = FluidScene { volumes: vec![block.clone()], boundaries, ..FluidScene::with_spacing(D) };
            let name = format!("{name} at {share} spacings");
            let plan = Plan::new(&scene).unwrap();
            let inside = lattice.iter().filter(|point| point.x > face && point.x < face + thickness).count() as u32;
            assert!(inside >= 64);
            assert_eq!(plan.left_out, [LeftOut { volume: 0, boundary: wall, inside, crowded: 0 }], "{name}");
            assert_eq!(plan.positions.len(), 512 - inside as usize, "{name}");
            let note = format!("{inside} have their centre inside boundaries[{wall}]");
            assert!(plan.notes.iter().any(|text| text.contains(&note)), "{name}: {:?}", plan.notes);
            survives(&name, Backend::Cpu, &scene, 1.0 / 60.0, 20);
            if share < 0.1 && name.starts_with("box") {
                survives(&name, Backend::Gpu, &scene, 1.0 / 60.0, 3);
            }
        }
    }
}

/// A block in front of a wall, nearer than any lattice that fits: it moves away, and nothing is lost, whatever other fluid there is
/// elsewhere.
#[test]
fn a_block_that_almost_touches_a_wall() {
    let (block, _) = block_above_the_floor();
    let elsewhere = Volume::block(Vec3::splat(0.1), Vec3::new(0.2, 0.1, 0.25));
    for share in [0.02, 0.15] {
        let tank = Vec3::new(0.6 + (3.5 + share) * D, 1.0, 0.5);
        let boundaries = vec![Boundary::open_box(tank, tank / 2.0)];
        let volumes = vec![block.clone(), elsewhere.clone()];
        let scene = FluidScene { volumes, boundaries, ..FluidScene::with_spacing(D) };
        let plan = Plan::new(&scene).unwrap();
        assert_eq!((plan.left_out.len(), plan.positions.len()), (0, 512 + 64), "{share}: {:?}", plan.left_out);
        survives(&format!("{share} spacings in front of a wall"), Backend::Cpu, &scene, 1.0 / 60.0, 20);
    }
}

/// What fits a tank by rounding fits it poured in as well.
#[test]
fn a_block_poured_into_a_tank_that_fits_loses_nothing() {
    let tank = Vec3::splat(12.9 * D);
    let boundaries = vec![Boundary::open_box(tank, tank / 2.0)];
    let full =
        FluidScene { volumes: vec![Volume::block(tank / 2.0, tank / 2.0)], boundaries, ..FluidScene::with_spacing(D) };
    let start = Plan::new(&full).unwrap();
    assert_eq!((start.positions.len(), start.left_out.len()), (13 * 13 * 13, 0));
    let mut empty = FluidScene { volumes: Vec::new(), ..full };
    empty.settings.max_particles = Some(13 * 13 * 13);
    let mut solver = Backend::Cpu.open(Plan::new(&empty).unwrap(), None).unwrap();
    let poured = NewParticles {
        velocities: vec![Vec3::ZERO; start.positions.len()],
        positions: start.positions,
        lifetime: f32::INFINITY,
        at: None,
    };
    let commands = vec![Command::Spawn(poured)];
    let report = solver.step(&StepInput { duration: 0.01, commands, ..StepInput::default() }).unwrap();
    assert_eq!((report.inside_solids, report.beside_solids, report.particles), (0, 0, 13 * 13 * 13), "{report:?}");
}

/// A block that sticks in walls on both sides can go neither way: the layers that are too near are left out too, and said.
#[test]
fn a_block_between_two_walls_that_has_no_room() {
    let (block, _) = block_above_the_floor();
    for share in [0.02, 0.25, 0.4] {
        let half = (3.5 + share - 1.0) * D;
        let tank = Vec3::new(2.0 * half, 1.0, 0.5);
        let boundaries = vec![Boundary::open_box(tank, Vec3::new(0.6, 0.5, 0.25))];
        let scene = FluidScene { volumes: vec![block.clone()], boundaries, ..FluidScene::with_spacing(D) };
        let plan = Plan::new(&scene).unwrap();
        assert_eq!(plan.left_out, [LeftOut { volume: 0, boundary: 0, inside: 128, crowded: 128 }], "{share}");
        survives(&format!("{share} spacings on both sides"), Backend::Cpu, &scene, 1.0 / 60.0, 20);
    }
}

/// Bodies have a place from the first tick on: what starts inside is left out then.
#[test]
fn a_block_inside_a_body() {
    let (block, lattice) = block_above_the_floor();
    let layer = FluidScene::with_spacing(D).wall_layer().unwrap();
    let (half, radius) = (Vec3::new(0.25, 0.3, 0.25), 0.2);
    let body = |samples: Vec<Vec3>, solid: Solid| Body { samples, solids: vec![solid], ..Body::default() };
    let chest = || body(layer.box_surface(half).unwrap(), Solid::block(half, Vec3::ZERO));
    let ball = || body(layer.sphere_surface(radius).unwrap(), Solid::ball(radius, Vec3::ZERO));
    let turned = Quat::from_rotation_y(0.3);
    let center = Vec3::new(0.6, 0.3, 0.25);
    let corner = center + Vec3::new(0.21, 0.17, 0.03);
    // How deep a point is in each, written down anew.
    let in_chest = |at: Vec3| move |point: Vec3| ((turned.conjugate() * (point - at)).abs() - half).max_element();
    let in_ball = |at: Vec3| move |point: Vec3| point.distance(at) - radius;
    type Depth = Box<dyn Fn(Vec3) -> f32>;
    let cases: [(&str, Body, Vec3, Depth, bool); 3] = [
        ("all in a chest", chest(), center, Box::new(in_chest(center)), true),
        ("partly in a ball", ball(), corner, Box::new(in_ball(corner)), false),
        ("all but its edges in a ball", ball(), center, Box::new(in_ball(center)), false),
    ];
    for (name, body, position, depth, all) in cases {
        for backend in BOTH {
            let scene = FluidScene { volumes: vec![block.clone()], bodies: vec![body.clone()], ..dam(1.0, D) };
            let plan = Plan::new(&scene).unwrap();
            assert_eq!((plan.positions.len(), &plan.left_out[..]), (512, &[][..]), "{name}: bodies have no place yet");
            // The hydrostatic start moves particles by a thousandth of the block's height.
            let inside = lattice.iter().filter(|&&point| depth(point) < 0.0).count() as u32;
            let beside = lattice.iter().filter(|&&point| (0.0..0.5 * D - 1e-3).contains(&depth(point))).count() as u32;
            assert_eq!(inside == 512, all, "{name}: {inside}");
            let left = plan.positions.iter().filter(|&&point| depth(point) > 0.5 * D - 1e-3);
            let start: f64 =
                left.map(|point| f64::from(point.y) * 9.81).sum::<f64>() * f64::from(plan.parameters.particle_mass);
            // It is held where it is, so that no work is done.
            let held = BodyInput { position, rotation: turned, ..BodyInput::default() };
            let mut solver = backend.open(plan.clone(), None).unwrap();
            for tick in 0..if backend == Backend::Cpu { 20 } else { 3 } {
                let input = StepInput { tick, duration: 1.0 / 60.0, bodies: vec![held], ..StepInput::default() };
                let report = solver.step(&input).unwrap();
                let now = energy(&plan, solver.as_mut(), 0.0);
                let wanted = if tick == 0 { (inside, beside) } else { (0, 0) };
                assert_eq!((report.inside_solids, report.beside_solids), wanted, "{name} on {backend}: {report:?}");
                assert_eq!((report.removed, report.retired, report.refused), (0, 0, 0), "{name} on {backend}");
                assert_eq!(report.particles, 512 - inside - beside, "{name} on {backend}: {report:?}");
                assert!(report.max_speed.is_finite() && report.bodies[0].linear.is_finite(), "{report:?}");
                assert!(now <= 1.05 * start, "{name} on {backend}, tick {tick}: {now} J after {start} J, {report:?}");
            }
        }
    }
}

/// What commands spawn inside a wall or a body has an id and is never simulated; what flows in may come out of a face.
#[test]
fn particles_spawned_inside_walls_and_bodies() {
    let layer = FluidScene::with_spacing(D).wall_layer().unwrap();
    let body = Body {
        samples: layer.sphere_surface(0.2).unwrap(),
        solids: vec![Solid::ball(0.2, Vec3::ZERO)],
        ..Body::default()
    };
    let mut scene = FluidScene { volumes: Vec::new(), bodies: vec![body], ..dam(1.0, D) };
    scene.settings.max_particles = Some(5);
    let held = BodyInput { position: Vec3::new(0.8, 0.5, 0.25), ..BodyInput::default() };
    // In the floor, free, in the body, beside it, free, in the side wall for which there is no room.
    let places = [[0.2, -0.02], [0.2, 0.5], [0.8, 0.6], [0.8, 0.71], [0.4, 0.5], [-0.03, 0.5]];
    let spawn = |places: &[[f32; 2]], at| {
        Command::Spawn(NewParticles {
            positions: places.iter().map(|&[x, y]| Vec3::new(x, y, 0.25)).collect(),
            velocities: vec![Vec3::ZERO; places.len()],
            lifetime: f32::INFINITY,
            at,
        })
    };
    for backend in BOTH {
        let mut solver = backend.open(Plan::new(&scene).unwrap(), None).unwrap();
        let mut step = |tick, commands| {
            let input = StepInput { tick, duration: 0.01, bodies: vec![held], commands };
            let report = solver.step(&input).unwrap();
            let ids = solver.read(Field::Id).unwrap().integers().unwrap();
            assert_eq!((report.removed, report.retired), (0, 0), "{backend}: {report:?}");
            ((report.inside_solids, report.beside_solids, report.refused), ids)
        };
        let (first, second) = places.split_at(2);
        let (counts, mut ids) = step(0, vec![spawn(first, None), spawn(second, None)]);
        ids.sort_unstable();
        assert_eq!((counts, ids), ((2, 1, 1), vec![1, 4]), "{backend}");
        // A jet out of the floor's face, and one in the floor.
        let (counts, mut ids) = step(1, vec![spawn(&[[0.6, 0.0]], Some(0.01)), spawn(&[[0.6, -0.01]], Some(0.01))]);
        ids.sort_unstable();
        assert_eq!((counts, ids), ((1, 0, 0), vec![1, 4, 5]), "{backend}");
    }
}

/// A state saved before the first tick is a start as well: what is inside a body is found out when it is restored.
#[test]
fn a_start_that_is_saved_and_restored() {
    let (block, _) = block_above_the_floor();
    let samples = FluidScene::with_spacing(D).wall_layer().unwrap().sphere_surface(0.15).unwrap();
    let body = Body { samples, solids: vec![Solid::ball(0.15, Vec3::ZERO)], ..Body::default() };
    let scene = FluidScene { volumes: vec![block.clone()], bodies: vec![body], ..dam(1.0, D) };
    let held = BodyInput { position: block.center, ..BodyInput::default() };
    let input = |tick| StepInput { tick, duration: 0.01, bodies: vec![held], ..StepInput::default() };
    for backend in BOTH {
        let open = || backend.open(Plan::new(&scene).unwrap(), None).unwrap();
        let (mut first, mut second, mut third) = (open(), open(), open());
        let start = first.snapshot().unwrap();
        let report = first.step(&input(0)).unwrap();
        assert!(report.inside_solids > 0 && report.beside_solids > 0, "{backend}: {report:?}");
        second.restore(&start).unwrap();
        let again = second.step(&input(0)).unwrap();
        let counts = |report: &StepReport| (report.inside_solids, report.beside_solids, report.particles);
        assert_eq!(counts(&again), counts(&report), "{backend}");
        assert_eq!(first.snapshot().unwrap().positions, second.snapshot().unwrap().positions, "{backend}");
        // Another plan before the first tick changes nothing of that, nor that it says no more what the particles are.
        let bare = Plan { positions: Vec::new(), velocities: Vec::new(), ..Plan::new(&scene).unwrap() };
        let (mut changed, mut exchanged) = (open(), backend.open(bare.clone(), None).unwrap());
        changed.reconfigure(bare).unwrap();
        exchanged.restore(&start).unwrap();
        for (what, solver) in [("reconfigured", &mut changed), ("exchanged", &mut exchanged)] {
            assert_eq!(counts(&solver.step(&input(0)).unwrap()), counts(&report), "{what}, {backend}");
            assert_eq!(solver.snapshot().unwrap().ids, first.snapshot().unwrap().ids, "{what}, {backend}");
            assert_eq!(counts(&solver.step(&input(1)).unwrap()), (0, 0, report.particles), "{what}, {backend}");
        }
        // One saved later is none.
        third.restore(&first.snapshot().unwrap()).unwrap();
        assert_eq!(counts(&third.step(&input(1)).unwrap()), (0, 0, report.particles), "{backend}");
    }
}
