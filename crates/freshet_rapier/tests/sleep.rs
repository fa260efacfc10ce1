//! Bodies at rest in a fluid sleep; the fluid wakes them when it pushes otherwise.

use freshet_core::step::Impulse;
use freshet_rapier::{BodyCoupling, RapierView};
use glam::Vec3;
use rapier3d::prelude::*;

const TICK: f32 = 1.0 / 60.0;

/// Runs ticks in lockstep with a share of the body's weight carried; whether the body sleeps at the end.
fn sleeps(world: &mut PhysicsWorld, coupling: &mut BodyCoupling, ticks: std::ops::Range<u64>, share: f32) -> bool {
    let handle = coupling.handle();
    for tick in ticks {
        let weight = world.bodies[handle].mass() * 9.81 * TICK;
        coupling.begin_tick(tick, &RapierView::from(&*world)).unwrap();
        let carried = Impulse { linear: Vec3::Y * weight * share, angular: Vec3::ZERO };
        coupling.receive(tick, carried, &mut world.bodies).unwrap();
        coupling.apply_forecast(&mut world.bodies).unwrap();
        world.step();
        coupling.complete(&mut world.bodies).unwrap();
    }
    world.bodies[handle].is_sleeping()
}

fn world() -> PhysicsWorld {
    let mut world = PhysicsWorld::new();
    world.gravity = Vec3::new(0.0, -9.81, 0.0);
    world.integration_parameters.dt = TICK;
    world
}

#[test]
fn a_ball_in_a_pond_sleeps_until_the_level_falls() {
    let mut world = world();
    let (handle, _) =
        world.insert(RigidBodyBuilder::dynamic().translation(Vec3::Y), ColliderBuilder::ball(0.15).density(500.0));
    let mut coupling = BodyCoupling::new(handle, 0);
    assert!(sleeps(&mut world, &mut coupling, 0..120, 1.0), "at rest");
    let height = world.bodies[handle].translation().y;
    let input = coupling.begin_tick(120, &RapierView::from(&world)).unwrap();
    assert_eq!(
        (input.inverse_mass, input.acceleration),
        (0.0, Vec3::ZERO),
        "a sleeping body stands still in the fluid"
    );
    coupling.receive(120, input.forecast, &mut world.bodies).unwrap();
    coupling.apply_forecast(&mut world.bodies).unwrap();
    world.step();
    coupling.complete(&mut world.bodies).unwrap();
    assert!(sleeps(&mut world, &mut coupling, 121..240, 0.97), "three hundredths less does not wake it");
    assert_eq!(world.bodies[handle].translation().y, height);
    assert!(!sleeps(&mut world, &mut coupling, 240..243, 0.9), "a tenth less does");
    assert!(world.bodies[handle].linvel().y < -0.02, "and it falls");
    let ledger = coupling.ledger();
    assert!(ledger.held.linear.y > 0.0 && ledger.relative_imbalance() < 1e-6, "{ledger:?}");
}

#[test]
fn a_stone_on_the_bed_sleeps_too() {
    let mut world = world();
    world.insert(RigidBodyBuilder::fixed(), ColliderBuilder::cuboid(2.0, 0.1, 2.0));
    let stone = RigidBodyBuilder::dynamic().translation(Vec3::new(0.0, 0.2, 0.0));
    let (handle, _) = world.insert(stone, ColliderBuilder::cuboid(0.1, 0.1, 0.1).density(2000.0));
    let mut coupling = BodyCoupling::new(handle, 0);
    assert!(sleeps(&mut world, &mut coupling, 0..240, 0.5));
    assert!(!sleeps(&mut world, &mut coupling, 240..242, 0.7), "the flow lifts it");
}

#[test]
fn a_changing_push_keeps_a_body_awake() {
    let mut world = world();
    let (handle, _) =
        world.insert(RigidBodyBuilder::dynamic().translation(Vec3::Y), ColliderBuilder::ball(0.15).density(500.0));
    let mut coupling = BodyCoupling::new(handle, 0);
    for wave in 0..20 {
        let share = if wave % 2 == 0 { 1.08 } else { 0.92 };
        assert!(!sleeps(&mut world, &mut coupling, wave * 12..wave * 12 + 12, share), "wave {wave}");
    }
}
