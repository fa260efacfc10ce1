//! Components are spawned, changed and despawned while the app runs.

use bevy::prelude::*;
use bevy_freshet::prelude::*;

use crate::harness::{ALL, Tank, TestApp, WATER};

#[test]
fn a_tank_of_water_is_simulated_on_both_backends_in_both_modes() {
    for (backend, mode) in ALL {
        let mut test = TestApp::new();
        let tank = Tank::spawn(&mut test, (backend, mode));
        test.tick(8);
        let stats = test.stats(tank.domain);
        assert_eq!(stats.backend, backend);
        assert_eq!(stats.particles, WATER, "{backend:?} {mode:?}");
        assert!(stats.capacity >= WATER);
        assert_eq!(stats.ticks + stats.ticks_in_flight, 8, "{backend:?} {mode:?}: {stats:?}");
        assert!(stats.ticks_in_flight <= if mode == FluidMode::Lockstep { 0 } else { 3 });
        assert!(stats.substeps > 0 && stats.max_speed > 0.0 && stats.max_speed < 5.0);
        assert!(!stats.passes.is_empty() || backend == FluidBackend::Gpu);
        assert_eq!((stats.removed, stats.retired, stats.refused), (0, 0, 0));
        let stats = test.settle(tank.domain);
        assert_eq!((stats.ticks, stats.ticks_in_flight), (9, 0));
        assert!((stats.time - 9.0 / 64.0).abs() < 1e-3, "{stats:?}");
        test.expect_no_complaints();
    }
}

#[test]
fn volumes_come_and_go_with_their_particles() {
    for choice in ALL {
        let mut test = TestApp::new();
        let tank = Tank::spawn(&mut test, choice);
        test.tick(3);
        let drop = test.spawn((
            FluidVolume::from(Sphere::new(0.15)).with_velocity(Vec3::NEG_Y),
            Transform::from_xyz(0.7, 0.7, 0.25),
            FluidInDomain(tank.domain),
        ));
        let with_drop = test.settle(tank.domain).particles;
        assert!(with_drop > WATER, "{choice:?}: {with_drop}");
        test.tick(2);
        // Fires once.
        assert_eq!(test.settle(tank.domain).particles, with_drop, "{choice:?}");
        test.despawn(tank.water);
        let stats = test.settle(tank.domain);
        assert_eq!(stats.particles, with_drop - WATER, "{choice:?}");
        assert_eq!(stats.retired, u64::from(WATER), "{choice:?}");
        test.world().entity_mut(drop).remove::<FluidVolume>();
        assert_eq!(test.settle(tank.domain).particles, 0, "{choice:?}");
        // Gone before its ids are known.
        let brief = test.spawn((
            FluidVolume::from(Sphere::new(0.15)),
            Transform::from_xyz(0.7, 0.7, 0.25),
            FluidInDomain(tank.domain),
        ));
        test.tick(1);
        test.despawn(brief);
        test.tick(3);
        assert_eq!(test.settle(tank.domain).particles, 0, "{choice:?}");
        test.expect_no_complaints();
    }
}

/// Positions in the domain's frame, as they were read last.
#[derive(Resource, Default)]
struct Positions(Vec<Vec3>);

/// Where the particles are after one more tick.
pub fn positions(test: &mut TestApp, domain: Entity) -> Vec<Vec3> {
    if test.world().get_resource::<Positions>().is_none() {
        test.world().init_resource::<Positions>();
        test.world().add_observer(|read: On<FluidReadbackComplete>, mut positions: ResMut<Positions>| {
            positions.0 = read.get(FluidField::Position).cloned().and_then(|data| data.vectors()).unwrap_or_default();
        });
    }
    test.world().entity_mut(domain).insert(FluidReadback::new([FluidField::Position]));
    test.settle(domain);
    test.world().entity_mut(domain).remove::<FluidReadback>();
    std::mem::take(&mut test.world().resource_mut::<Positions>().0)
}

/// The same, of which only the largest x is of interest: how far the water has come.
pub fn front(test: &mut TestApp, domain: Entity) -> f32 {
    let positions = positions(test, domain);
    assert_eq!(positions.len(), WATER as usize);
    positions.iter().fold(f32::NEG_INFINITY, |front, position| front.max(position.x))
}

#[test]
fn settings_walls_and_gravity_change_while_it_runs() {
    for choice in ALL {
        let mut test = TestApp::new();
        let tank = Tank::spawn(&mut test, choice);
        test.tick(2);
        test.change::<FluidDomain>(tank.domain, |domain| domain.settings.artificial_viscosity = 0.02);
        test.tick(1);
        // The column is 0.5 m wide; without a wall it reaches the end of the tank, at 1 m, in half a second.
        let wall = test.spawn((
            FluidBoundary::cuboid(0.1, 1.0, 0.5),
            Transform::from_xyz(0.6, 0.5, 0.25),
            FluidInDomain(tank.domain),
        ));
        test.tick(31);
        let held = front(&mut test, tank.domain);
        assert!(held < 0.55, "{choice:?}: the wall's face is at 0.55 m, the water at {held}");
        test.change::<Transform>(wall, |pose| pose.translation.x = 0.8);
        test.tick(31);
        let held = front(&mut test, tank.domain);
        assert!(held > 0.6 && held < 0.75, "{choice:?}: the wall's face is at 0.75 m, the water at {held}");
        test.despawn(wall);
        test.tick(31);
        let free = front(&mut test, tank.domain);
        assert!(free > 0.85 && free < 1.0, "{choice:?}: there is no wall, the water is at {free}");
        // Upwards: the water leaves the floor, and is faster than before.
        test.change::<FluidDomain>(tank.domain, |domain| domain.gravity = Some(Vec3::Y * 9.81));
        test.tick(31);
        let stats = test.settle(tank.domain);
        assert_eq!(stats.ticks, 131, "{choice:?}");
        assert_eq!(stats.particles, WATER, "{choice:?}");
        assert!(stats.max_speed > 2.0, "{choice:?}: it falls upwards for half a second, {stats:?}");
        let lowest = positions(&mut test, tank.domain).iter().fold(f32::INFINITY, |low, position| low.min(position.y));
        assert!(lowest > 0.5, "{choice:?}: it falls upwards for half a second, the lowest is at {lowest}");
        test.expect_no_complaints();
    }
}

#[test]
fn walls_become_slippery_while_it_runs() {
    for choice in [ALL[0], ALL[2]] {
        // How far it has come with walls that drag all the time, that become slippery, and that always were.
        let [dragged, released, free] = [(true, true), (true, false), (false, false)].map(|(start, end)| {
            let mut test = TestApp::new();
            let tank = Tank::spawn(&mut test, choice);
            // So viscous that the floor matters, and nothing reaches the end of the tank.
            test.change::<FluidDomain>(tank.domain, |domain| domain.settings.artificial_viscosity = 1.0);
            test.change::<FluidContainer>(tank.tank, |tank| tank.viscous_faces = [start; 6]);
            test.tick(6);
            test.change::<FluidContainer>(tank.tank, |tank| tank.viscous_faces = [end; 6]);
            test.tick(9);
            let positions = positions(&mut test, tank.domain);
            test.expect_no_complaints();
            positions.iter().map(|position| f64::from(position.x)).sum::<f64>() / positions.len() as f64
        });
        println!("{choice:?}: {dragged} {released} {free}");
        // A tenth of a spacing, where rounding makes less than a thousandth.
        assert!(released > dragged + 0.01 && free > released, "{choice:?}: {dragged} {released} {free}");
    }
}

/// How far a block slides in a second and a half of ticks, started at 1 m/s along a floor with this friction, m.
fn slide(choice: (FluidBackend, FluidMode), friction: f32) -> f32 {
    let mut test = TestApp::new();
    let domain = test.spawn(FluidDomain::with_spacing(0.1).on(choice.0).in_mode(choice.1));
    let floor = FluidBoundary { viscous_faces: [false; 6], ..FluidBoundary::plane(8.0, 8.0) };
    test.spawn(floor.with_friction(FluidFriction::coulomb(friction)));
    // One layer: all of it presses on the floor.
    let layer = FluidVolume::from(Cuboid::new(1.0, 0.1, 1.0)).with_velocity(Vec3::X);
    test.spawn((layer, Transform::from_xyz(0.0, 0.05, 0.0)));
    test.tick(16);
    let positions = positions(&mut test, domain);
    test.expect_no_complaints();
    positions.iter().map(|position| position.x).sum::<f32>() / positions.len() as f32
}

#[test]
fn friction_of_a_boundary_slows_what_slides_on_it() {
    for choice in [ALL[0], ALL[2]] {
        let [free, rough] = [0.0, 0.5].map(|friction| slide(choice, friction));
        println!("{choice:?}: {free} {rough}");
        // 17 ticks at 1 m/s; with 0.5 it stops within 1 / (2 * 0.5 * 9.81) = 0.1 m while it presses, and further where it bounces.
        assert!((free - 17.0 / 64.0).abs() < 0.01, "{choice:?}: {free}");
        assert!(rough < 0.8 * free, "{choice:?}: {rough} of {free}");
    }
}

#[test]
fn a_belt_carries_viscous_fluid_in_its_own_direction() {
    for choice in [ALL[0], ALL[2]] {
        let mut test = TestApp::new();
        let mut domain = FluidDomain::with_spacing(0.1).on(choice.0).in_mode(choice.1);
        domain.settings.viscosity_model = Some(FluidViscosityModel::Morris1997);
        let domain = test.spawn(domain);
        let honey = Fluid { dynamic_viscosity: 50.0, ..Fluid::water() };
        test.spawn((FluidVolume::from(Cuboid::new(0.6, 0.3, 0.6)), honey, Transform::from_xyz(0.0, 0.15, 0.0)));
        // Turned by a quarter: its own x is the world's -z.
        let turned = Transform::from_rotation(Quat::from_rotation_y(0.5 * std::f32::consts::PI));
        test.spawn((FluidBoundary::plane(8.0, 8.0).with_velocity(Vec3::X), turned));
        test.tick(24);
        let positions = positions(&mut test, domain);
        let mean = positions.iter().sum::<Vec3>() / positions.len() as f32;
        println!("{choice:?}: {mean}");
        assert!(mean.z < -0.05 && mean.z > -0.4 && mean.x.abs() < 0.02, "{choice:?}: {mean}");
        test.expect_no_complaints();
    }
}

#[test]
fn a_scene_with_friction_and_belts_is_spawned_as_it_is_and_planned_the_same() {
    use freshet_core::prelude::{
        Boundary, BoundaryShape, DensityForm, FluidScene, Friction, Integrator, PressureForce, ViscosityModel, Volume,
    };
    let turned = Quat::from_rotation_y(0.4);
    let plane = Boundary::new(BoundaryShape::Plane { half_extents: [2.0, 2.0] }, Vec3::NEG_Y);
    let mut scene = FluidScene {
        volumes: vec![Volume::block(Vec3::splat(0.2), Vec3::ZERO)],
        boundaries: vec![
            Boundary { rotation: turned, ..plane.with_velocity(turned * Vec3::X) },
            Boundary::open_box(Vec3::ONE, Vec3::ZERO).with_friction(Friction { at_rest: 0.5, sliding: 0.25 }),
        ],
        ..FluidScene::with_spacing(0.1)
    };
    scene.settings.viscosity_model = Some(ViscosityModel::Morris1997);
    scene.settings.integrator = Integrator::VelocityVerlet;
    scene.settings.pressure_force = PressureForce::Mueller;
    scene.settings.density = DensityForm::Adapted;
    let mut test = TestApp::new();
    let domain =
        test.world().commands().spawn_fluid_scene(&scene, |domain| domain.backend = FluidBackend::Cpu).unwrap();
    test.tick(3);
    test.expect_no_complaints();
    assert_eq!(test.stats(domain).ticks + test.stats(domain).ticks_in_flight, 3);
    let world = test.world();
    let wall = world.query::<&FluidBoundary>().single(world).unwrap();
    assert!(wall.velocity.abs_diff_eq(Vec3::X, 1e-6), "in its own axes: {}", wall.velocity);
    let tank = world.query::<&FluidContainer>().single(world).unwrap();
    assert_eq!(tank.friction, FluidFriction { at_rest: 0.5, sliding: 0.25 });
    let settings = &world.get::<FluidDomain>(domain).unwrap().settings;
    assert_eq!(settings.viscosity_model, Some(FluidViscosityModel::Morris1997));
    assert_eq!(settings.integrator, FluidIntegrator::VelocityVerlet);
    assert_eq!(settings.pressure_force, FluidPressureForce::Mueller);
    assert_eq!(settings.density, FluidDensityForm::Adapted);
}

#[test]
fn a_fluid_moves_to_another_backend_with_its_state() {
    for mode in [FluidMode::Lockstep, FluidMode::Pipelined] {
        let mut test = TestApp::new();
        let tank = Tank::spawn(&mut test, (FluidBackend::Cpu, mode));
        test.tick(10);
        let before = test.settle(tank.domain);
        test.change::<FluidDomain>(tank.domain, |domain| domain.backend = FluidBackend::Gpu);
        let on_gpu = test.settle(tank.domain);
        assert_eq!((on_gpu.backend, on_gpu.ticks, on_gpu.particles), (FluidBackend::Gpu, before.ticks + 1, WATER));
        // It goes on falling where it was; a restart would begin at rest.
        assert!(on_gpu.max_speed > 0.5 * before.max_speed, "{before:?} {on_gpu:?}");
        test.change::<FluidDomain>(tank.domain, |domain| domain.backend = FluidBackend::Cpu);
        let on_cpu = test.settle(tank.domain);
        assert_eq!((on_cpu.backend, on_cpu.ticks, on_cpu.particles), (FluidBackend::Cpu, before.ticks + 2, WATER));
        test.expect_no_complaints();
    }
}

#[test]
fn two_domains_live_side_by_side_and_a_new_one_starts_from_all_volumes() {
    let mut test = TestApp::new();
    let first = Tank::spawn(&mut test, ALL[1]);
    let second = Tank::spawn(&mut test, ALL[3]);
    test.tick(4);
    test.despawn(second.water);
    assert_eq!(test.settle(second.domain).particles, 0);
    assert_eq!(test.settle(first.domain).particles, WATER);
    test.expect_no_complaints();
    test.despawn(second.tank);
    test.despawn(second.domain);
    test.despawn(first.domain);
    // Despawning a domain takes the relationship along; what is left belongs to the only domain there is.
    let third = test.spawn(FluidDomain::with_spacing(0.1).on(FluidBackend::Cpu));
    test.tick(2);
    assert_eq!(test.settle(third).particles, WATER);
    test.expect_no_complaints();
}

#[test]
fn fluid_poured_into_fluid_fills_what_is_free() {
    for choice in ALL {
        let mut test = TestApp::new();
        let tank = Tank::spawn(&mut test, choice);
        test.tick(2);
        test.expect_no_complaints();
        // 5 x 8 x 5 particles, the lower half of which are where the water is.
        let more = test.spawn((
            FluidVolume::from(Cuboid::new(0.5, 0.8, 0.5)),
            Transform::from_xyz(0.25, 0.4, 0.25),
            FluidInDomain(tank.domain),
        ));
        test.tick(1);
        let complaints = test.complaints();
        assert_eq!(complaints.len(), 1, "{choice:?}: {complaints:?}");
        assert_eq!((complaints[0].entity, complaints[0].component), (more, "FluidVolume"), "{choice:?}");
        let message = &complaints[0].message;
        assert!(message.contains("of 200 particles are left out"), "{choice:?}: {message}");
        let left_out: u32 = message.split(' ').next().and_then(|count| count.parse().ok()).expect("a count");
        // In three ticks the water has fallen by a tenth of a spacing, so that some of the fifth layer may have room.
        assert!((75..=125).contains(&left_out), "{choice:?}: {message}");
        let stats = test.settle(tank.domain);
        assert_eq!(stats.particles, WATER + 200 - left_out, "{choice:?}");
        assert!(stats.max_speed < 3.0, "{choice:?}: nothing was blown apart, {stats:?}");
        test.despawn(more);
        assert_eq!(test.settle(tank.domain).particles, WATER, "{choice:?}");
        // Where fluid leaves in the same tick there is room.
        test.despawn(tank.water);
        test.spawn((
            FluidVolume::from(Cuboid::new(0.5, 0.4, 0.5)),
            Transform::from_xyz(0.25, 0.2, 0.25),
            FluidInDomain(tank.domain),
        ));
        assert_eq!(test.settle(tank.domain).particles, WATER, "{choice:?}");
        test.expect_no_complaints();
    }
}

#[test]
fn a_domain_takes_a_fidelity_changes_it_and_says_what_was_chosen() {
    for choice in ALL {
        let mut test = TestApp::new();
        let tank = Tank::spawn(&mut test, choice);
        for (fidelity, name) in [
            (FluidFidelity::Fast, "fast"),
            (FluidFidelity::Balanced, "balanced"),
            (FluidFidelity::Accurate, "accurate"),
            (FluidFidelity::within(0.5).unwrap(), "within 50 %"),
        ] {
            test.change::<FluidDomain>(tank.domain, |domain| *domain = domain.clone().with_fidelity(fidelity));
            test.tick(3);
            let stats = test.settle(tank.domain);
            assert_eq!(stats.particles, WATER, "{name} {choice:?}");
            let wanted = format!("fidelity {name}: configuration ");
            let notes: Vec<&String> = stats.notes.iter().filter(|note| note.starts_with(&wanted)).collect();
            assert_eq!(notes.len(), 1, "{choice:?}: {:?}", stats.notes);
        }
        test.expect_no_complaints();
    }
}
