//! A ball of fluid without gravity or walls, for flows that are given to it.

use freshet_core::scene::{FluidScene, Volume};
use glam::{DVec3, Vec3};

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

/// What it is drawn out along.
///
/// No direction of the lattice: drawn out along z, or near it, the rows of a lattice keep to themselves. They thin out, and do not come between each other
/// where the fluid is drawn in, so that it stays wide and opens up: after 0.45 s `a^2 c` is 1.43 of what it was (12, 16, 24 or 32 spacings
/// thick, weakly compressible or not). Along this axis it is 0.98, 0.99, 1.00 and 1.00.
pub fn axis() -> DVec3 {
    DVec3::new(1.0, 2.0, 3.0).normalize()
}

/// The velocity that the fluid gets at a place, m/s: drawn in about [`axis`], out along it.
pub fn velocity(position: Vec3) -> Vec3 {
    let (x, axis) = (position.as_dvec3(), axis());
    (RATE * (3.0 * axis * axis.dot(x) - x)).as_vec3()
}
