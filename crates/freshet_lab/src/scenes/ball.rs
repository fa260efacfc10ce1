//! A ball of fluid without gravity or walls, for flows that are given to it.

use freshet_core::scene::{FluidScene, Volume};
use glam::Vec3;

use crate::reference::ellipsoid;

/// Radius, m.
pub const RADIUS: f64 = 1.0;
/// Rate at which the equator is drawn in at the start, 1/s.
pub const RATE: f64 = 1.0;

/// The ball about the origin, `across` particles thick, at rest.
pub fn scene(across: u32) -> FluidScene {
    let mut scene = FluidScene {
        name: format!("ball {across} spacings thick"),
        gravity: Vec3::ZERO,
        volumes: vec![Volume::ball(RADIUS as f32, Vec3::ZERO)],
        ..FluidScene::with_spacing((2.0 * RADIUS / f64::from(across)) as f32)
    };
    scene.settings.expected_speed = Some((ellipsoid::MOST_SPEED * RATE * RADIUS) as f32);
    scene
}

/// The velocity that the fluid gets at a place, m/s: drawn in about the z axis, out along it.
pub fn velocity(position: Vec3) -> Vec3 {
    RATE as f32 * position * Vec3::new(-1.0, -1.0, 2.0)
}
