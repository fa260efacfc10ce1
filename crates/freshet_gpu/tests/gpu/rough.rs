//! Friction of walls that move: see `crates/freshet_cpu/tests/rough.rs`.

use freshet_core::prelude::*;

use crate::common::solver;

#[path = "../../../freshet_cpu/tests/common/rough.rs"]
mod shared;
use shared::{assert_a_belt_carries, assert_a_plate_carries};

#[test]
fn a_belt_carries_a_layer_as_coulomb_says() {
    assert_a_belt_carries(&mut |scene| Box::new(solver(scene)));
}

#[test]
fn a_plate_carries_a_layer_as_coulomb_says() {
    assert_a_plate_carries(&mut |scene| Box::new(solver(scene)));
}

#[test]
fn only_plans_with_rough_bodies_have_its_passes() {
    let mut scene =
        FluidScene { volumes: vec![Volume::block(Vec3::splat(0.1), Vec3::Y * 0.3)], ..FluidScene::with_spacing(0.05) };
    let ball = BoundaryShape::Sphere { radius: 0.1, fluid: FluidSide::Outside };
    scene.bodies = vec![Body::of_shape("ball", ball, &scene.wall_layer().unwrap()).unwrap()];
    let passes = |scene: &FluidScene| {
        let solver = solver(scene);
        let schedule = solver.schedule();
        let is_of_it =
            |name: &&str| ["contact_pressure", "body_friction", "friction_load", "friction_sum"].contains(name);
        let names: Vec<&str> = schedule.passes.iter().map(|pass| pass.name).filter(is_of_it).collect();
        (names.len(), schedule.buffers.iter().any(|buffer| buffer.name == "contacts"))
    };
    assert_eq!(passes(&scene), (0, false));
    scene.bodies[0].friction = Friction::coulomb(0.5);
    assert_eq!(passes(&scene), (3, true));
    scene.settings.pressure_solver = PressureSolver::DivergenceFree(DivergenceFree::default());
    assert_eq!(passes(&scene), (4, true));
    let moved = BodyInput { inverse_mass: 0.5, ..BodyInput::default() };
    let input = StepInput { duration: 1e-3, bodies: vec![moved], ..StepInput::default() };
    let message = solver(&scene).step(&input).unwrap_err().to_string();
    assert!(message.contains("bodies[0].inverse_mass") && message.contains("of a body with friction"), "{message}");
}
