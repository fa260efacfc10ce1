//! A channel between two plates: a piece a few spacings long and wide that repeats itself.

use std::f32::consts::PI;

use freshet_core::periodic::Periodic;
use freshet_core::scene::{Boundary, BoundaryShape, FluidScene, Volume};
use freshet_core::viscosity::ViscosityModel;
use glam::{Quat, Vec3};

/// Distance of the plates, m.
pub const GAP: f64 = 1.0;
/// Largest speed, m/s.
pub const SPEED: f64 = 1.0;
/// `SPEED * GAP / nu`.
pub const REYNOLDS: f64 = 10.0;
/// Length and width in spacings: four support radii of the default, the shortest there is.
const PIECE: f32 = 8.0;
/// The same for supports up to three spacings.
const WIDE_PIECE: f32 = 12.0;

/// What moves the fluid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    /// A force along the channel, such that the fluid gets to [`SPEED`] in the middle.
    Force,
    /// The upper plate, at [`SPEED`].
    Plate,
}

/// Kinematic viscosity, m2/s.
pub fn kinematic_viscosity() -> f64 {
    SPEED * GAP / REYNOLDS
}

/// The channel with `resolution` particles from plate to plate, the lower one at y = 0.
pub fn scene(drive: Drive, resolution: u32) -> FluidScene {
    piece(drive, resolution, PIECE)
}

/// The same, half as long and wide again: for supports up to three spacings.
pub fn wide_scene(drive: Drive, resolution: u32) -> FluidScene {
    piece(drive, resolution, WIDE_PIECE)
}

fn piece(drive: Drive, resolution: u32, spacings: f32) -> FluidScene {
    let spacing = (GAP / f64::from(resolution)) as f32;
    let half = Vec3::new(spacings * spacing, GAP as f32, spacings * spacing) / 2.0;
    let plate = Boundary::new(BoundaryShape::Plane { half_extents: [half.x, half.z] }, Vec3::ZERO);
    let mut lid = Boundary { center: Vec3::Y * GAP as f32, rotation: Quat::from_rotation_x(PI), ..plate.clone() };
    let mut scene = FluidScene {
        gravity: Vec3::ZERO,
        volumes: vec![Volume::block(half, Vec3::Y * half.y)],
        periodic: Periodic { x: Some((-half.x, half.x)), y: None, z: Some((-half.z, half.z)) },
        ..FluidScene::with_spacing(spacing)
    };
    match drive {
        Drive::Force => scene.gravity.x = (8.0 * kinematic_viscosity() * SPEED / (GAP * GAP)) as f32,
        Drive::Plate => lid.velocity = Vec3::X * SPEED as f32,
    }
    scene.name = format!("channel of {resolution} spacings");
    scene.boundaries = vec![plate, lid];
    scene.material.dynamic_viscosity = kinematic_viscosity() as f32 * scene.material.rest_density;
    scene.settings.viscosity_model = Some(ViscosityModel::Morris1997);
    scene.settings.artificial_viscosity = 0.0;
    scene.settings.expected_speed = Some(SPEED as f32);
    scene
}
