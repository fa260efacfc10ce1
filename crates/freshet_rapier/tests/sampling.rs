//! Samples of rapier shapes.

use freshet_core::prelude::FluidScene;
use freshet_core::sampling::wall_layer::WallLayer;
use freshet_rapier::{SamplingError, body_from_rigid_body, sample_shape};
use glam::Vec3;
use rapier3d::prelude::*;

const SPACING: f32 = 0.05;

fn layer() -> WallLayer {
    FluidScene::with_spacing(SPACING).wall_layer().unwrap()
}

#[test]
fn a_balls_samples_lie_the_layers_depth_inside() {
    let samples = sample_shape(&*SharedShape::ball(0.15), &layer()).unwrap();
    for sample in &samples {
        assert!((0.15 - sample.length() - layer().depth).abs() < 1e-5, "{sample}");
    }
    let area = 4.0 * std::f32::consts::PI * 0.15 * 0.15;
    let share = area / samples.len() as f32 / (SPACING * SPACING);
    assert!((0.9..1.1).contains(&share), "{share} of a spacing squared each");
}

#[test]
fn a_cuboids_samples_lie_the_layers_depth_inside() {
    let half = Vec3::new(0.1, 0.2, 0.15);
    for sample in sample_shape(&*SharedShape::cuboid(half.x, half.y, half.z), &layer()).unwrap() {
        let depth = (half - sample.abs()).min_element();
        assert!((depth - layer().depth).abs() < 1e-5, "{sample}");
    }
}

#[test]
fn samples_are_about_the_centre_of_mass() {
    let mut world = PhysicsWorld::new();
    let turned = RigidBodyBuilder::dynamic().translation(Vec3::ONE).rotation(Vec3::new(0.2, 0.3, 0.4));
    let offset = ColliderBuilder::cuboid(0.1, 0.2, 0.15).translation(Vec3::X).rotation(Vec3::Z * 0.5).density(500.0);
    let (handle, _) = world.insert(turned, offset);
    let body = body_from_rigid_body("box", &world.bodies[handle], &world.colliders, &layer()).unwrap();
    let mean = body.samples.iter().sum::<Vec3>() / body.samples.len() as f32;
    assert!(mean.length() < 1e-5, "{mean}");
    let back = glam::Quat::from_rotation_z(-0.5);
    for sample in &body.samples {
        let depth = (Vec3::new(0.1, 0.2, 0.15) - (back * *sample).abs()).min_element();
        assert!((depth - layer().depth).abs() < 1e-5, "{sample}");
    }
    // What is solid lies as they do.
    let [ref solid] = body.solids[..] else { panic!("{:?}", body.solids) };
    let (inside, outside) = (Vec3::new(0.09, 0.19, 0.14), Vec3::new(0.11, 0.19, 0.14));
    let turn = back.conjugate();
    assert!(solid.contains(turn * inside, 0.0) && !solid.contains(turn * outside, 0.0), "{solid:?}");
}

#[test]
fn two_balls_have_the_samples_of_both() {
    let mut world = PhysicsWorld::new();
    let (handle, _) = world.insert(RigidBodyBuilder::dynamic(), ColliderBuilder::ball(0.15).translation(Vec3::X * 0.3));
    world.insert_collider(ColliderBuilder::ball(0.15).translation(Vec3::X * -0.3), Some(handle));
    world.insert_collider(ColliderBuilder::capsule_y(1.0, 1.0).sensor(true), Some(handle));
    let one = sample_shape(&*SharedShape::ball(0.15), &layer()).unwrap().len();
    world.bodies[handle].recompute_mass_properties_from_colliders(&world.colliders);
    let body = body_from_rigid_body("dumbbell", &world.bodies[handle], &world.colliders, &layer()).unwrap();
    assert_eq!(body.samples.len(), 2 * one, "and none of the sensor");
    assert_eq!(body.solids.len(), 2, "and none of the sensor");
    for x in [-0.44, -0.16, 0.16, 0.44] {
        let point = Vec3::X * x;
        assert!(body.solids.iter().any(|solid| solid.contains(point, 0.0)), "{x}");
    }
    for x in [-0.46, -0.14, 0.0, 0.14, 0.46] {
        assert!(!body.solids.iter().any(|solid| solid.contains(Vec3::X * x, 0.0)), "{x}");
    }
}

#[test]
fn what_cannot_be_sampled_says_so() {
    let error = sample_shape(&*SharedShape::capsule_y(0.1, 0.1), &layer()).unwrap_err();
    assert_eq!(error, SamplingError::Unsupported { shape: ShapeType::Capsule });
    let text = error.to_string();
    assert!(text.contains("Capsule") && text.contains("Ball, Cuboid"), "{text}");
    assert!(matches!(sample_shape(&*SharedShape::ball(0.01), &layer()), Err(SamplingError::Invalid(_))));
    let mut world = PhysicsWorld::new();
    let handle = world.insert_body(RigidBodyBuilder::dynamic());
    let error = body_from_rigid_body("ghost", &world.bodies[handle], &world.colliders, &layer()).unwrap_err();
    assert!(error.to_string().contains("ghost"), "{error}");
}
