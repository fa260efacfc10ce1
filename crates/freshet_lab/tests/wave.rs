//! A dam breaks over a light ball on the ground, presses it against the wall and throws it about: contacts, which the solver
//! does not see, keep putting the ball elsewhere than the fluid has made room for it.

use std::collections::VecDeque;

use freshet_core::prelude::*;
use freshet_lab::backend::Backend;
use freshet_lab::method::Method;
use freshet_rapier::{Coupling, RapierView, body_from_rigid_body};
use rapier3d::dynamics::RigidBodyBuilder;
use rapier3d::geometry::ColliderBuilder;
use rapier3d::pipeline::PhysicsWorld;

const TICK: f32 = 1.0 / 60.0;
const TANK: Vec3 = Vec3::new(1.6, 1.2, 0.6);
const RADIUS: f32 = 0.15;

/// Largest speed of a particle and of the ball in a second, m/s.
fn fastest(method: Method, spacing: f32, latency: u64, at: Vec3) -> (f32, f32) {
    let mut world = PhysicsWorld::new();
    world.gravity = Vec3::new(0.0, -9.81, 0.0);
    world.integration_parameters.dt = TICK;
    let (ball, _) = world.insert(
        RigidBodyBuilder::dynamic().translation(at).can_sleep(false),
        ColliderBuilder::ball(RADIUS).density(400.0),
    );
    let half = TANK / 2.0;
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let mut center = half;
            center[axis] += side * (half[axis] + 0.5);
            let mut size = half + 1.0;
            size[axis] = 0.5;
            // No lid.
            if (axis, side) != (1, 1.0) {
                world.insert_collider(ColliderBuilder::cuboid(size.x, size.y, size.z).translation(center), None);
            }
        }
    }
    let scene = FluidScene {
        volumes: vec![Volume::block(Vec3::new(0.3, 0.4, 0.3), Vec3::new(0.3, 0.4, 0.3))],
        boundaries: vec![Boundary::open_box(TANK, half)],
        ..FluidScene::with_spacing(spacing)
    };
    let mut scene = method.on(scene);
    let layer = scene.wall_layer().unwrap();
    scene.bodies.push(body_from_rigid_body("ball", &world.bodies[ball], &world.colliders, &layer).unwrap());
    let mut solver = Backend::Cpu.open(Plan::new(&scene).unwrap(), None).unwrap();
    let mut coupling = Coupling::new([ball], 0);
    let mut late: VecDeque<StepReport> = VecDeque::new();
    let (mut water, mut body) = (0f32, 0f32);
    for tick in 0..60 {
        for phase in 0..2 {
            while let Some(report) = late.pop_front_if(|report| report.tick + latency <= tick) {
                coupling.receive(&report, &mut world.bodies).unwrap();
            }
            if phase == 0 {
                let bodies = coupling.begin_tick(tick, &RapierView::from(&world)).unwrap();
                let report = solver.step(&StepInput { tick, duration: TICK, bodies, ..StepInput::default() }).unwrap();
                // Removed are those that are not finite.
                water = if report.removed > 0 { f32::INFINITY } else { water.max(report.max_speed) };
                late.push_back(report);
            }
        }
        coupling.apply_forecast(&mut world.bodies).unwrap();
        world.step();
        coupling.complete(&mut world.bodies).unwrap();
        body = body.max(world.bodies[ball].linvel().length());
    }
    (water, body)
}

#[test]
fn a_ball_hit_by_a_wave_does_not_blow_up_the_fluid() {
    let mut wrong = Vec::new();
    for method in Method::ALL {
        for spacing in [0.1, 0.06] {
            for latency in [0, 2, 3] {
                for x in [1.1, 1.3, 1.445] {
                    let (water, ball) = fastest(method, spacing, latency, Vec3::new(x, RADIUS + 0.01, 0.3));
                    let row = format!(
                        "{}, d = {spacing} m, {latency} ticks late, from x = {x}: water {water:.1} m/s, ball {ball:.1} m/s",
                        method.name()
                    );
                    println!("{row}");
                    // The wave arrives with 4 m/s. Three ticks late, rapier's ball takes three ticks of its blow at once.
                    if !(water < 16.0 && ball < 10.0) {
                        wrong.push(row);
                    }
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
