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
        assert!((stats.time - 9.0 / 64.0).abs() < 1e-3 || stats.time_scale < 1.0, "{stats:?}");
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

#[test]
fn settings_walls_and_gravity_change_while_it_runs() {
    for choice in ALL {
        let mut test = TestApp::new();
        let tank = Tank::spawn(&mut test, choice);
        test.tick(3);
        test.change::<FluidDomain>(tank.domain, |domain| domain.settings.artificial_viscosity = 0.02);
        test.tick(3);
        let wall = test.spawn((
            FluidBoundary::cuboid(0.1, 0.5, 0.5),
            Transform::from_xyz(0.8, 0.25, 0.25),
            FluidInDomain(tank.domain),
        ));
        test.tick(3);
        test.change::<Transform>(wall, |pose| pose.translation.x = 0.9);
        test.tick(3);
        test.despawn(wall);
        // Upwards: the water leaves the floor, and is faster than before.
        test.change::<FluidDomain>(tank.domain, |domain| domain.gravity = Some(Vec3::Y * 9.81));
        test.tick(30);
        let stats = test.settle(tank.domain);
        assert_eq!(stats.ticks, 43, "{choice:?}");
        assert_eq!(stats.particles, WATER, "{choice:?}");
        assert!(stats.max_speed > 2.0, "{choice:?}: it falls upwards for half a second, {stats:?}");
        test.expect_no_complaints();
    }
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
