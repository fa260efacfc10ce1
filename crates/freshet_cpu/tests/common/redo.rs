//! Scenes in which substeps turn out too long.

use freshet_core::prelude::*;

pub const SPACING: f32 = 0.05;
pub const SPEED: f32 = 5.0;

/// Two blocks of water that fly at each other, each with 5 m/s and without gravity, and meet in the middle.
pub fn collision(redo: bool) -> FluidScene {
    let block =
        |x: f32| Volume { velocity: Vec3::X * -SPEED * x.signum(), ..Volume::block(Vec3::splat(0.2), Vec3::X * x) };
    let mut scene = FluidScene {
        volumes: vec![block(-0.25), block(0.25)],
        gravity: Vec3::ZERO,
        ..FluidScene::with_spacing(SPACING)
    };
    scene.settings.pressure_solver = PressureSolver::DivergenceFree(DivergenceFree::default());
    scene.settings.expected_speed = Some(SPEED);
    scene.settings.redo_substeps = redo;
    scene
}

/// Water that falls fast onto a floor, with a sound so slow that it is supersonic, as in Pirovano's jet: 4.76 m/s at 1.5 m/s.
pub fn supersonic(redo: bool) -> FluidScene {
    let mut scene = FluidScene {
        volumes: vec![Volume { velocity: Vec3::NEG_Y * 4.76, ..Volume::block(Vec3::splat(0.2), Vec3::Y * 0.4) }],
        boundaries: vec![Boundary::open_box(Vec3::new(2.0, 1.0, 2.0), Vec3::Y * 0.5)],
        ..FluidScene::with_spacing(SPACING)
    };
    scene.settings.sound_speed = Some(1.5);
    scene.settings.allow_compressible = true;
    scene.settings.redo_substeps = redo;
    scene
}

/// A block of water that flies at a body of 20 kg.
pub fn block_on_a_body() -> (FluidScene, BodyInput) {
    let mut scene = collision(true);
    scene.volumes.truncate(1);
    let samples = scene.wall_layer().unwrap().box_surface(Vec3::new(0.1, 0.2, 0.2)).unwrap();
    scene.bodies.push(Body { name: "block".to_owned(), samples, ..Body::default() });
    let body = BodyInput {
        position: Vec3::X * 0.2,
        inverse_mass: 1.0 / 20.0,
        acceleration: Vec3::ZERO,
        ..BodyInput::default()
    };
    (scene, body)
}
