//! One tick against what it has to be: the kicks and rapier's step together.

use freshet_core::step::{Impulse, StepReport};
use freshet_rapier::{BodyCoupling, Coupling, CouplingError, RapierView};
use glam::{Quat, Vec3};
use rapier3d::prelude::*;

const TICK: f32 = 1.0 / 60.0;

fn world() -> PhysicsWorld {
    let mut world = PhysicsWorld::new();
    world.gravity = Vec3::new(0.0, -9.81, 0.0);
    world.integration_parameters.dt = TICK;
    world
}

fn ball(world: &mut PhysicsWorld) -> RigidBodyHandle {
    let body = RigidBodyBuilder::dynamic().translation(Vec3::Y);
    world.insert(body, ColliderBuilder::ball(0.15).density(500.0)).0
}

fn impulse(linear: Vec3) -> Impulse {
    Impulse { linear, angular: Vec3::ZERO }
}

/// A tick in lockstep.
fn lockstep(world: &mut PhysicsWorld, coupling: &mut BodyCoupling, tick: u64, given: Impulse) {
    coupling.begin_tick(tick, &RapierView::from(&*world)).unwrap();
    coupling.receive(tick, given, &mut world.bodies).unwrap();
    coupling.apply_forecast(&mut world.bodies).unwrap();
    world.step();
    coupling.complete(&mut world.bodies).unwrap();
}

#[test]
fn a_free_body_moves_as_under_steady_forces() {
    for iterations in [1, 2, 4, 9] {
        let mut world = world();
        world.integration_parameters.num_solver_iterations = iterations;
        let handle = ball(&mut world);
        let mass = world.bodies[handle].mass();
        world.bodies[handle].set_linvel(Vec3::new(0.3, 0.1, 0.0), true);
        world.bodies[handle].add_force(Vec3::Z * mass, true);
        world.bodies[handle].set_gravity_scale(0.5, true);
        let mut coupling = BodyCoupling::new(handle, 0);
        let input = coupling.begin_tick(0, &RapierView::from(&world)).unwrap();
        assert!(input.free);
        assert!((input.acceleration - Vec3::new(0.0, -4.905, 1.0)).length() < 1e-5, "gravity once: {input:?}");
        coupling.receive(0, impulse(Vec3::X * mass), &mut world.bodies).unwrap();
        coupling.apply_forecast(&mut world.bodies).unwrap();
        world.step();
        coupling.complete(&mut world.bodies).unwrap();
        let acceleration = Vec3::new(1.0 / TICK, -4.905, 1.0);
        let velocity = Vec3::new(0.3, 0.1, 0.0) + acceleration * TICK;
        let position = Vec3::Y + (Vec3::new(0.3, 0.1, 0.0) + velocity) / 2.0 * TICK;
        let body = &world.bodies[handle];
        assert!((body.linvel() - velocity).length() < 1e-5, "{iterations}: {} {velocity}", body.linvel());
        assert!((body.translation() - position).length() < 1e-6, "{iterations}: {} {position}", body.translation());
    }
}

#[test]
fn weight_and_buoyancy_hold_still() {
    let mut world = world();
    let handle = ball(&mut world);
    let weight = world.bodies[handle].mass() * 9.81 * TICK;
    let mut coupling = BodyCoupling::new(handle, 0);
    for tick in 0..20 {
        lockstep(&mut world, &mut coupling, tick, impulse(Vec3::Y * weight));
        let body = &world.bodies[handle];
        assert!(body.linvel().length() < 1e-5 && (body.translation() - Vec3::Y).length() < 1e-6, "tick {tick}");
    }
}

/// A spinning box off its origin: an impulse in world axes at the centre of mass turns it by the world's inertia.
#[test]
fn a_spinning_body_takes_torque_in_world_axes() {
    let mut world = world();
    world.gravity = Vec3::ZERO;
    let turned = RigidBodyBuilder::dynamic().rotation(Vec3::new(0.4, -0.7, 1.1)).angvel(Vec3::new(0.0, 3.0, 0.0));
    let offset = ColliderBuilder::cuboid(0.1, 0.2, 0.4).translation(Vec3::new(0.5, 0.0, 0.0)).density(500.0);
    let (handle, _) = world.insert(turned, offset);
    let body = &world.bodies[handle];
    let mut coupling = BodyCoupling::new(handle, 0);
    let input = coupling.begin_tick(0, &RapierView::from(&world)).unwrap();
    let center = *body.rotation() * Vec3::new(0.5, 0.0, 0.0);
    assert!((input.position - center).length() < 1e-6, "centre of mass");

    // Inertia of the box from its edges, by hand.
    let mass = body.mass();
    let edges = Vec3::new(0.2, 0.4, 0.8);
    let squares = edges * edges;
    let moments = mass / 12.0 * Vec3::new(squares.y + squares.z, squares.x + squares.z, squares.x + squares.y);
    let axes = glam::Mat3::from_quat(*body.rotation());
    let inverse = axes * glam::Mat3::from_diagonal(moments.recip()) * axes.transpose();
    assert!((input.inverse_inertia - inverse).abs_diff_eq(glam::Mat3::ZERO, 1e-3 * inverse.x_axis.length()));

    let torque = Impulse { linear: Vec3::ZERO, angular: Vec3::new(0.3, 0.0, 0.1) };
    coupling.receive(0, torque, &mut world.bodies).unwrap();
    coupling.apply_forecast(&mut world.bodies).unwrap();
    let half = Vec3::new(0.0, 3.0, 0.0) + inverse * torque.angular / 2.0;
    assert!((world.bodies[handle].angvel() - half).length() < 1e-4, "half before the step");
    let given = coupling.ledger().given.angular.as_vec3();
    assert!((given - torque.angular / 2.0).length() < 1e-4, "{given}");
}

/// What arrives late moves and turns the body as if it had come in time.
#[test]
fn late_impulses_displace() {
    let mut world = world();
    world.gravity = Vec3::ZERO;
    let handle = ball(&mut world);
    let mass = world.bodies[handle].mass();
    let inertia = world.bodies[handle].mass_properties().local_mprops.principal_inertia().x;
    let mut coupling = BodyCoupling::new(handle, 0);
    for tick in 0..3 {
        coupling.begin_tick(tick, &RapierView::from(&world)).unwrap();
        coupling.apply_forecast(&mut world.bodies).unwrap();
        world.step();
        coupling.complete(&mut world.bodies).unwrap();
    }
    assert_eq!(world.bodies[handle].linvel(), Vec3::ZERO);
    let late = Impulse { linear: Vec3::X * mass, angular: Vec3::Z * inertia };
    coupling.receive(0, late, &mut world.bodies).unwrap();
    let body = &world.bodies[handle];
    assert!((body.translation() - Vec3::new(2.5 * TICK, 1.0, 0.0)).length() < 1e-6);
    let turn = body.rotation().to_scaled_axis();
    assert!((turn - Vec3::Z * 2.5 * TICK).length() < 1e-5, "{turn}");
    assert_eq!(coupling.corrected_before(), 1);
}

/// A stone with half its weight carried by the fluid stays on the floor, at any lateness, without being displaced.
#[test]
fn a_stone_rests() {
    for latency in 0..=3u64 {
        let mut world = world();
        world.insert(RigidBodyBuilder::fixed(), ColliderBuilder::cuboid(2.0, 0.1, 2.0));
        let stone = RigidBodyBuilder::dynamic().translation(Vec3::new(0.0, 0.199, 0.0)).can_sleep(false);
        let (handle, _) = world.insert(stone, ColliderBuilder::cuboid(0.1, 0.1, 0.1).density(2000.0));
        let lift = impulse(Vec3::Y * world.bodies[handle].mass() * 9.81 * TICK / 2.0);
        let mut coupling = BodyCoupling::new(handle, 0);
        for tick in 0..300 {
            if latency > 0 && tick >= latency {
                coupling.receive(tick - latency, lift, &mut world.bodies).unwrap();
            }
            let input = coupling.begin_tick(tick, &RapierView::from(&world)).unwrap();
            assert!(tick < 2 || !input.free, "tick {tick}");
            if latency == 0 {
                coupling.receive(tick, lift, &mut world.bodies).unwrap();
            }
            coupling.apply_forecast(&mut world.bodies).unwrap();
            world.step();
            coupling.complete(&mut world.bodies).unwrap();
        }
        let body = &world.bodies[handle];
        assert!((body.translation().y - 0.2).abs() < 1e-3, "{latency}: {}", body.translation());
        // Rapier lets a body that is kept from sleeping creep sideways when it gets an impulse in every step: 2.6 mm/s
        // with a plain `apply_impulse` too.
        assert!(body.linvel().length() < 5e-3, "{latency}: {}", body.linvel());
        assert!(coupling.ledger().relative_imbalance() < 1e-6);
    }
}

/// A stone that lies on the floor is one that nothing moves, until it is lifted; in the air it is not.
#[test]
fn what_contacts_hold_the_fluid_does_not_move_within_the_tick() {
    let mut world = world();
    world.insert(RigidBodyBuilder::fixed(), ColliderBuilder::cuboid(2.0, 0.1, 2.0));
    let stone = RigidBodyBuilder::dynamic().translation(Vec3::new(0.0, 0.205, 0.0)).can_sleep(false);
    let (handle, _) = world.insert(stone, ColliderBuilder::cuboid(0.1, 0.1, 0.1).density(2000.0));
    let weight = world.bodies[handle].mass() * 9.81 * TICK;
    let is_moved = |world: &PhysicsWorld, coupling: &BodyCoupling, tick: u64| {
        let input = coupling.clone().begin_tick(tick, &RapierView::from(world)).unwrap();
        assert_eq!(input.inverse_mass > 0.0, input.acceleration != Vec3::ZERO);
        input.inverse_mass > 0.0
    };
    let mut coupling = BodyCoupling::new(handle, 0);
    assert!(is_moved(&world, &coupling, 0), "it falls");
    (0..60).for_each(|tick| lockstep(&mut world, &mut coupling, tick, impulse(Vec3::Y * 0.5 * weight)));
    assert!(!is_moved(&world, &coupling, 60), "it lies");
    (60..63).for_each(|tick| lockstep(&mut world, &mut coupling, tick, impulse(Vec3::Y * 1.5 * weight)));
    assert!(is_moved(&world, &coupling, 63), "it is lifted");
    (63..120).for_each(|tick| lockstep(&mut world, &mut coupling, tick, impulse(Vec3::Y * 0.5 * weight)));
    assert!(!is_moved(&world, &coupling, 120), "it lies again");
    // Of this tick nothing is known yet when rapier steps.
    coupling.begin_tick(120, &RapierView::from(&world)).unwrap();
    coupling.apply_forecast(&mut world.bodies).unwrap();
    world.step();
    coupling.complete(&mut world.bodies).unwrap();
    assert!(!is_moved(&world, &coupling, 121), "late, too");
}

/// A blow against the floor is forecast again in the next ticks. The floor takes all of it, so nothing of it is taken back from the stone; what lifts
/// it lifts it late.
#[test]
fn what_the_floor_has_taken_is_not_taken_back() {
    for latency in 1..=3u64 {
        let mut world = world();
        world.insert(RigidBodyBuilder::fixed(), ColliderBuilder::cuboid(2.0, 0.1, 2.0));
        let stone = RigidBodyBuilder::dynamic().translation(Vec3::new(0.0, 0.2, 0.0)).can_sleep(false);
        let (handle, _) = world.insert(stone, ColliderBuilder::cuboid(0.1, 0.1, 0.1).density(2000.0));
        let weight = world.bodies[handle].mass() * 9.81 * TICK;
        let load = |tick: u64| match tick {
            60 => -5.0,
            200.. => 2.0,
            _ => 0.5,
        };
        let mut coupling = BodyCoupling::new(handle, 0);
        for tick in 0..220u64 {
            if let Some(known) = tick.checked_sub(latency) {
                let given = impulse(Vec3::Y * weight * load(known));
                coupling.receive(known, given, &mut world.bodies).unwrap();
            }
            let input = coupling.begin_tick(tick, &RapierView::from(&world)).unwrap();
            assert!(!(30..60).contains(&tick) || input.corrected_before == tick, "{latency}, tick {tick}: {input:?}");
            coupling.apply_forecast(&mut world.bodies).unwrap();
            world.step();
            coupling.complete(&mut world.bodies).unwrap();
            let speed = world.bodies[handle].linvel().length();
            // Taken back, the blow would give it 0.9 m/s; rapier's floor yields a little to it.
            let most = if (60..80).contains(&tick) { 0.1 } else { 5e-3 };
            assert!(!(30..=200).contains(&tick) || speed < most, "{latency}, tick {tick}: {speed} m/s");
        }
        // The lift of the weight less the weight, but for the ticks in which nothing was known of it.
        let (speed, ticks) = (world.bodies[handle].linvel().y, (20 - latency) as f32);
        assert!((speed - 9.81 * TICK * ticks).abs() < 0.1 * speed, "{latency}: {speed} m/s");
        assert!(coupling.ledger().relative_imbalance() < 1e-6);
    }
}

/// A gate on a hinge at its foot in low water, of whose push the hinge takes 99 %: it is free to turn, and goes on turning.
#[test]
fn what_a_hinge_nearly_holds_is_free_to_turn() {
    for latency in [0, 2] {
        let mut world = world();
        world.gravity = Vec3::ZERO;
        let (foot, _) = world.insert(RigidBodyBuilder::fixed(), ColliderBuilder::ball(0.01));
        let gate = RigidBodyBuilder::dynamic().translation(Vec3::Y * 0.5).can_sleep(false);
        let (handle, _) = world.insert(gate, ColliderBuilder::cuboid(0.02, 0.5, 0.5).mass(1.0));
        let hinge = RevoluteJointBuilder::new(Vec3::Z).local_anchor1(Vec3::ZERO).local_anchor2(Vec3::NEG_Y * 0.5);
        world.impulse_joints.insert(foot, handle, hinge.contacts_enabled(false).build(), true);
        // At a tenth of its height.
        let push = Impulse { linear: Vec3::X * TICK, angular: Vec3::Z * 0.4 * TICK };
        let mut coupling = BodyCoupling::new(handle, 0);
        for tick in 0..30u64 {
            let input = coupling.begin_tick(tick, &RapierView::from(&world)).unwrap();
            assert!(tick < 12 || input.inverse_mass > 0.0, "{latency}, tick {tick}: {}", world.bodies[handle].angvel());
            if let Some(known) = tick.checked_sub(latency) {
                coupling.receive(known, push, &mut world.bodies).unwrap();
            }
            coupling.apply_forecast(&mut world.bodies).unwrap();
            world.step();
            coupling.complete(&mut world.bodies).unwrap();
        }
        let turns = world.bodies[handle].angvel().length();
        assert!(turns > 0.1, "{latency}: {turns} rad/s");
    }
}

/// A stone on another that can move passes on what it gets: what was forecast too much is taken back.
#[test]
fn what_no_floor_holds_is_corrected() {
    let mut world = world();
    world.gravity = Vec3::ZERO;
    let mut stone = |y: f32| {
        let body = RigidBodyBuilder::dynamic().translation(Vec3::new(0.0, y, 0.0)).can_sleep(false);
        world.insert(body, ColliderBuilder::cuboid(0.1, 0.1, 0.1).density(2000.0)).0
    };
    let (upper, lower) = (stone(0.2), stone(0.0));
    let momentum = |world: &PhysicsWorld| {
        [upper, lower]
            .map(|handle| world.bodies[handle].linvel() * world.bodies[handle].mass())
            .into_iter()
            .sum::<Vec3>()
    };
    let mut coupling = Coupling::new([upper, lower], 0);
    // A blow together that comes to nothing, and one that does not.
    let blow = |tick: u64| impulse(Vec3::Y * if tick == 3 { 10.0 } else { 0.0 });
    for tick in 0..20u64 {
        if let Some(known) = tick.checked_sub(2) {
            let bodies = vec![impulse(-1.2 * blow(known).linear), blow(known)];
            let report = StepReport { tick: known, bodies, ..StepReport::default() };
            coupling.receive(&report, &mut world.bodies).unwrap();
        }
        coupling.begin_tick(tick, &RapierView::from(&world)).unwrap();
        coupling.apply_forecast(&mut world.bodies).unwrap();
        world.step();
        coupling.complete(&mut world.bodies).unwrap();
    }
    assert!((momentum(&world) + Vec3::Y * 2.0).length() < 1e-3, "{}", momentum(&world));
}

#[test]
fn locked_axes_hold_and_the_ledger_knows() {
    let mut world = world();
    let rail = RigidBodyBuilder::dynamic().translation(Vec3::Y).enabled_translations(true, false, true);
    let (handle, _) = world.insert(rail, ColliderBuilder::ball(0.15).density(500.0));
    let mut coupling = BodyCoupling::new(handle, 0);
    lockstep(&mut world, &mut coupling, 0, impulse(Vec3::new(1.0, 5.0, 0.0)));
    let input = coupling.begin_tick(1, &RapierView::from(&world)).unwrap();
    assert!(!input.free);
    let answer = input.acceleration + input.forecast.linear * input.inverse_mass / TICK;
    assert!(answer.y.abs() < 1e-4, "the rail answers the forecast: {answer}");
    let ledger = coupling.ledger();
    assert_eq!(ledger.held.linear.y, 5.0);
    assert!(ledger.imbalance().linear.length() < 1e-6);
}

#[test]
fn user_forces_stay_the_users() {
    let mut world = world();
    let handle = ball(&mut world);
    world.bodies[handle].add_force(Vec3::X, true);
    let mut coupling = BodyCoupling::new(handle, 0);
    lockstep(&mut world, &mut coupling, 0, impulse(Vec3::Y * 100.0));
    let body = &world.bodies[handle];
    assert_eq!((body.user_force(), body.user_torque()), (Vec3::X, Vec3::ZERO));
}

#[test]
fn forecasts_follow_the_tick_length() {
    let mut world = world();
    let handle = ball(&mut world);
    let mut coupling = BodyCoupling::new(handle, 7);
    lockstep(&mut world, &mut coupling, 7, impulse(Vec3::Y));
    world.integration_parameters.dt = TICK / 2.0;
    let input = coupling.begin_tick(8, &RapierView::from(&world)).unwrap();
    assert!((input.forecast.linear - Vec3::Y / 2.0).length() < 1e-6);
}

#[test]
fn a_kinematic_body_moves_and_takes_nothing() {
    let mut world = world();
    let (handle, _) = world.insert(RigidBodyBuilder::kinematic_position_based(), ColliderBuilder::ball(0.15));
    world.bodies[handle].set_next_kinematic_translation(Vec3::X * TICK);
    world.bodies[handle].set_next_kinematic_rotation(Quat::from_rotation_y(2.0 * TICK));
    let mut coupling = BodyCoupling::new(handle, 0);
    let input = coupling.begin_tick(0, &RapierView::from(&world)).unwrap();
    assert!(
        (input.linear_velocity - Vec3::X).length() < 1e-4 && (input.angular_velocity - 2.0 * Vec3::Y).length() < 1e-3
    );
    assert_eq!((input.inverse_mass, input.acceleration), (0.0, Vec3::ZERO));
    coupling.receive(0, impulse(Vec3::Y), &mut world.bodies).unwrap();
    coupling.apply_forecast(&mut world.bodies).unwrap();
    world.step();
    coupling.complete(&mut world.bodies).unwrap();
    assert_eq!(coupling.ledger().held.linear.y, 1.0);
}

#[test]
fn calls_out_of_order_are_refused() {
    let mut world = world();
    let handle = ball(&mut world);
    let mut coupling = BodyCoupling::new(handle, 0);
    let none = Impulse::default();
    assert!(matches!(coupling.apply_forecast(&mut world.bodies), Err(CouplingError::OutOfOrder { .. })));
    assert!(matches!(coupling.complete(&mut world.bodies), Err(CouplingError::OutOfOrder { .. })));
    assert!(matches!(coupling.receive(0, none, &mut world.bodies), Err(CouplingError::UnexpectedImpulse { .. })));
    let refused = coupling.begin_tick(1, &RapierView::from(&world));
    assert_eq!(refused, Err(CouplingError::UnexpectedTick { given: 1, expected: 0 }));
    for tick in 0..4 {
        coupling.begin_tick(tick, &RapierView::from(&world)).unwrap();
        assert!(matches!(
            coupling.begin_tick(tick, &RapierView::from(&world)),
            Err(CouplingError::OutOfOrder { call: "begin_tick", allowed: "apply_forecast" })
        ));
        coupling.apply_forecast(&mut world.bodies).unwrap();
        coupling.complete(&mut world.bodies).unwrap();
    }
    let refused = coupling.begin_tick(4, &RapierView::from(&world)).unwrap_err();
    assert_eq!(refused, CouplingError::TooFarAhead { tick: 4, corrected_before: 0, most: 3 });
    assert!(refused.to_string().contains("4 ticks ahead"), "{refused}");
    let infinite = impulse(Vec3::splat(f32::INFINITY));
    assert_eq!(coupling.receive(0, infinite, &mut world.bodies), Err(CouplingError::NotFinite { tick: 0 }));
    coupling.receive(0, none, &mut world.bodies).unwrap();
    let twice = coupling.receive(0, none, &mut world.bodies);
    assert_eq!(twice, Err(CouplingError::UnexpectedImpulse { given: 0, expected: 1 }));
    world.remove_body(handle);
    assert_eq!(
        coupling.begin_tick(4, &RapierView::from(&world)),
        Err(CouplingError::NoSuchBody(handle)),
        "a removed body is an error, not a panic"
    );
}
