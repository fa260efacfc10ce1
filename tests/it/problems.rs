//! What is wrong is said once, with component, field, value and range; the rest goes on, and nothing panics.

use bevy::prelude::*;
use bevy_freshet::prelude::*;
use bevy_rapier3d::prelude::*;

use crate::harness::{ALL, Tank, TestApp, WATER};

/// Spawns something wrong beside a tank; expects one problem about it, and that the tank goes on.
fn refuses(bundle: impl Bundle, component: &str, words: &[&str]) {
    let mut test = TestApp::new();
    let tank = Tank::spawn(&mut test, ALL[0]);
    test.tick(1);
    let wrong = test.spawn(bundle);
    test.world().entity_mut(wrong).insert(FluidInDomain(tank.domain));
    test.tick(4);
    let complaints = test.complaints();
    assert_eq!(complaints.len(), 1, "{complaints:?}");
    assert_eq!((complaints[0].entity, complaints[0].component), (wrong, component), "{complaints:?}");
    for word in words {
        assert!(complaints[0].message.contains(word), "{word} in {complaints:?}");
    }
    let stats = test.stats(tank.domain);
    assert_eq!((stats.ticks, stats.particles), (5, WATER));
}

#[test]
fn wrong_volumes_are_refused() {
    refuses(FluidVolume::from(Sphere::new(-1.0)), "FluidVolume", &["shape.radius", "-1", "allowed"]);
    refuses(FluidVolume::from(Cuboid::new(f32::NAN, 1.0, 1.0)), "FluidVolume", &["half_size", "NaN", "allowed"]);
    refuses(FluidVolume::from(Cuboid::new(0.01, 1.0, 1.0)), "FluidVolume", &["allowed"]);
    let moving = FluidVolume::from(Sphere::new(0.2)).with_velocity(Vec3::splat(f32::INFINITY));
    refuses(moving, "FluidVolume", &["velocity", "inf"]);
    let scaled = Transform::from_scale(Vec3::splat(2.0));
    refuses((FluidVolume::from(Sphere::new(0.2)), scaled), "FluidVolume", &["scale", "allowed"]);
    let nowhere = Transform::from_xyz(f32::NAN, 0.0, 0.0);
    refuses((FluidVolume::from(Sphere::new(0.2)), nowhere), "FluidVolume", &["translation"]);
    let oil = (FluidVolume::from(Sphere::new(0.2)), Fluid::oil(), Transform::from_xyz(0.0, 3.0, 0.0));
    refuses(oil, "FluidVolume", &["oil", "water"]);
}

#[test]
fn wrong_walls_and_emitters_are_refused() {
    refuses(FluidContainer::open_box(0.0, 1.0, 1.0), "FluidContainer", &["size", "0", "allowed"]);
    let open = FluidContainer { open: [true; 6], ..FluidContainer::open_box(1.0, 1.0, 1.0) };
    refuses(open, "FluidContainer", &["open"]);
    refuses(FluidBoundary::plane(-1.0, 1.0), "FluidBoundary", &["shape.half_size", "-0.5"]);
    let rough = FluidFriction { at_rest: 0.2, sliding: 0.5 };
    refuses(
        FluidBoundary::plane(1.0, 1.0).with_friction(rough),
        "FluidBoundary",
        &["friction.at_rest", "0.2", "0.5 to 10"],
    );
    let rough = FluidContainer { friction: FluidFriction::coulomb(-1.0), ..FluidContainer::open_box(1.0, 1.0, 1.0) };
    refuses(rough, "FluidContainer", &["friction.sliding", "-1", "0 to 10"]);
    let belt = |velocity| FluidBoundary::plane(1.0, 1.0).with_velocity(velocity);
    refuses(belt(Vec3::X), "FluidBoundary", &["velocity", "zero, as there is no settings.viscosity_model"]);
    refuses(belt(Vec3::INFINITY), "FluidBoundary", &["velocity", "inf", "-10000 to 10000 m/s"]);
    let far = Transform::from_xyz(0.0, 9.0, 0.0);
    let moving = FluidBoundary::plane(1.0, 1.0).with_friction(FluidFriction::coulomb(-0.5)).moving();
    refuses((moving, far), "FluidBoundary", &["friction.sliding", "-0.5", "0 to 10"]);
    refuses((belt(Vec3::X).moving(), far), "FluidBoundary", &["velocity", "zero of a wall that moves"]);
    refuses(
        (FluidBoundary::cuboid(1.0, 0.01, 1.0).moving(), far),
        "FluidBoundary",
        &["shape.half_size.y", "0.005", "allowed"],
    );
    refuses(FluidEmitter::disc(0.1, 0.0, 1.0), "FluidEmitter", &["speed", "0", "0.001 to 1000"]);
    refuses(FluidEmitter::disc(0.1, 1.0, -2.0), "FluidEmitter", &["lifetime", "-2"]);
    // Each number is allowed, and one layer would be 3e10 particles.
    refuses(FluidEmitter::disc(1e4, 1e-3, 1.0), "FluidEmitter", &["particles a second", "allowed"]);
    refuses(FluidEmitter::disc(1e3, 1e-3, 1.0), "FluidEmitter", &["radius", "across the disc"]);
}

#[test]
fn an_emitter_out_of_range_is_refused_until_it_is_back() {
    let mut test = TestApp::new();
    let tank = Tank::spawn(&mut test, ALL[0]);
    let far = Transform::from_xyz(0.5, 1e9, 0.25);
    let jet = test.spawn((FluidEmitter::disc(0.1, 2.0, 1.0), far, FluidInDomain(tank.domain)));
    test.tick(4);
    let complaints = test.complaints();
    assert_eq!(complaints.len(), 1, "{complaints:?}");
    assert_eq!((complaints[0].entity, complaints[0].component), (jet, "FluidEmitter"), "{complaints:?}");
    assert_eq!(test.settle(tank.domain).particles, WATER);
    test.change::<Transform>(jet, |pose| pose.translation.y = 0.8);
    test.tick(8);
    assert!(test.settle(tank.domain).particles > WATER);
    test.expect_no_complaints();
}

#[test]
fn a_wrong_domain_says_so_and_recovers() {
    for (change, word) in [
        ((|domain| domain.spacing = f32::NAN) as fn(&mut FluidDomain), "spacing"),
        (|domain| domain.max_substeps = 0, "max_substeps"),
        (|domain| domain.settings.support_ratio = 9.0, "support"),
        (|domain| domain.settings.sound_speed = Some(1.0), "sound_speed"),
        (|domain| domain.settings.kernel = FluidKernel::Viscosity, "kernel"),
        (|domain| domain.settings.fidelity = Some(FluidFidelity::Within(-0.1)), "fidelity: -0.1 is not allowed"),
        (
            |domain| {
                *domain = domain.clone().with_fidelity(FluidFidelity::Fast);
                domain.settings.xsph = 0.5;
            },
            "fidelity: fast is not allowed; allowed: none",
        ),
    ] {
        let mut test = TestApp::new();
        let tank = Tank::spawn(&mut test, ALL[0]);
        test.change(tank.domain, change);
        test.tick(3);
        let complaints = test.complaints();
        assert_eq!(complaints.len(), 1, "{word}: {complaints:?}");
        assert_eq!((complaints[0].entity, complaints[0].component), (tank.domain, "FluidDomain"));
        assert!(complaints[0].message.contains(word), "{word} in {complaints:?}");
        assert_eq!(test.stats(tank.domain).ticks, 0, "nothing can be simulated");
        test.change::<FluidDomain>(tank.domain, |domain| {
            *domain = FluidDomain::with_spacing(0.1).on(FluidBackend::Cpu)
        });
        test.tick(2);
        assert_eq!(test.settle(tank.domain).particles, WATER, "{word}");
        test.expect_no_complaints();
    }
}

#[test]
fn what_could_belong_to_two_domains_is_refused() {
    let mut test = TestApp::new();
    let tank = Tank::spawn(&mut test, ALL[0]);
    Tank::spawn(&mut test, ALL[0]);
    let homeless = test.spawn(FluidVolume::from(Sphere::new(0.2)));
    test.tick(3);
    let complaints = test.complaints();
    assert_eq!(complaints.len(), 1, "{complaints:?}");
    assert_eq!((complaints[0].entity, complaints[0].component), (homeless, "FluidVolume"));
    assert!(complaints[0].message.contains("FluidInDomain"));
    assert_eq!(test.stats(tank.domain).particles, WATER);
}

#[test]
fn a_compressible_fluid_is_allowed_on_request_and_the_statistics_say_so() {
    let mut test = TestApp::new();
    let tank = Tank::spawn(&mut test, ALL[0]);
    test.change::<FluidDomain>(tank.domain, |domain| {
        domain.settings.sound_speed = Some(5.0);
        domain.settings.allow_compressible = true;
    });
    test.tick(2);
    let notes = test.stats(tank.domain).notes.join("\n");
    assert!(notes.contains("compressible"), "{notes}");
    test.expect_no_complaints();
}

#[test]
fn a_volume_that_starts_in_a_wall_says_how_much_of_it_is_left_out_and_why() {
    for choice in ALL {
        let mut test = TestApp::new();
        let tank = Tank::spawn(&mut test, choice);
        // Two of four layers are in it: 2 x 5 x 2 particles of the block of 5 x 4 x 5.
        let member = FluidInDomain(tank.domain);
        let step = test.spawn((FluidBoundary::cuboid(0.2, 0.4, 0.5), Transform::from_xyz(0.1, 0.0, 0.25), member));
        test.tick(3);
        let complaints = test.complaints();
        assert_eq!(complaints.len(), 1, "{choice:?}: {complaints:?}");
        assert_eq!((complaints[0].entity, complaints[0].component), (tank.water, "FluidVolume"), "{complaints:?}");
        let beginning = "20 of 100 particles are left out: 20 have their centre inside the FluidBoundary of entity";
        for words in [beginning, &step.to_string()] {
            assert!(complaints[0].message.contains(words), "{words} in {complaints:?}");
        }
        let stats = test.settle(tank.domain);
        assert_eq!((stats.particles, stats.inside_solids), (WATER - 20, 0), "{choice:?}");
        test.expect_no_complaints();
    }
}

#[test]
fn a_volume_that_starts_in_a_body_says_how_much_of_it_is_left_out_and_why() {
    for choice in ALL {
        let mut test = TestApp::new();
        let tank = Tank::spawn(&mut test, choice);
        test.spawn((
            RigidBody::Fixed,
            Collider::ball(0.15),
            FluidBody::default(),
            FluidInDomain(tank.domain),
            Transform::from_xyz(0.25, 0.2, 0.25),
        ));
        test.tick(6);
        let stats = test.settle(tank.domain);
        let left_out = stats.inside_solids + stats.beside_solids;
        assert!(stats.inside_solids > 0, "{choice:?}: {stats:?}");
        assert_eq!(u64::from(stats.particles) + left_out, u64::from(WATER), "{choice:?}");
        let complaints = test.complaints();
        assert_eq!(complaints.len(), 1, "{choice:?}: {complaints:?}");
        assert_eq!((complaints[0].entity, complaints[0].component), (tank.domain, "FluidDomain"), "{complaints:?}");
        let message = &complaints[0].message;
        assert!(message.starts_with(&format!("{left_out} particles of its volumes are left out")), "{message}");
        assert!(message.contains("inside a wall or a body"), "{message}");
        // It is said once.
        test.tick(10);
        test.expect_no_complaints();
    }
}
