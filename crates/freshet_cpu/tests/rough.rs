//! Friction of walls that move.

mod common;
#[path = "common/rough.rs"]
mod rough;

use common::solver;
use freshet_core::prelude::*;
use rough::{assert_a_belt_carries, assert_a_plate_carries};

#[test]
fn a_belt_carries_a_layer_as_coulomb_says() {
    assert_a_belt_carries(&mut |scene| Box::new(solver(scene, 2)));
}

#[test]
fn a_plate_carries_a_layer_as_coulomb_says() {
    assert_a_plate_carries(&mut |scene| Box::new(solver(scene, 2)));
}

#[test]
fn a_body_with_friction_is_one_that_the_fluid_does_not_move() {
    let mut scene =
        FluidScene { volumes: vec![Volume::block(Vec3::splat(0.1), Vec3::Y * 0.3)], ..FluidScene::with_spacing(0.05) };
    let ball = BoundaryShape::Sphere { radius: 0.1, fluid: FluidSide::Outside };
    let ball = Body::of_shape("ball", ball, &scene.wall_layer().unwrap()).unwrap();
    scene.bodies = vec![Body { friction: Friction::coulomb(0.5), ..ball }];
    let mut solver = solver(&scene, 1);
    let mut step = |inverse_mass: f32, inverse_inertia: f32| {
        let inverse_inertia = Mat3::IDENTITY * inverse_inertia;
        let body = BodyInput { inverse_mass, inverse_inertia, ..BodyInput::default() };
        let input = StepInput { duration: 1e-3, bodies: vec![body], ..StepInput::default() };
        solver.step(&input).map(|_| ()).map_err(|error| error.to_string())
    };
    assert_eq!(step(0.0, 0.0), Ok(()));
    for refused in [step(0.25, 0.0), step(0.0, 2.0)] {
        let message = refused.unwrap_err();
        assert!(message.contains("bodies[0].inverse_mass") && message.contains("of a body with friction"), "{message}");
    }
}
