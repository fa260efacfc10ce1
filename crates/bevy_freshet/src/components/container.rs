//! A box that holds fluid.

use bevy::prelude::*;

/// A hollow box that holds fluid, and bodies: it is also a fixed rapier collider made of its walls.
///
/// [`Transform`] is the centre of the inside; its scale must be 1. It may change, move and be despawned.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component, Clone, Debug, PartialEq)]
#[require(Transform, Visibility)]
pub struct FluidContainer {
    /// Inner edge lengths, m, 2e-5 to 2e6.
    pub size: Vec3,
    /// Which faces are missing: -x, +x, -y, +y, -z, +z. At least one must be there.
    pub open: [bool; 6],
    /// Faces that drag the fluid along: -x, +x, -y, +y, -z, +z. Along the others it slips freely.
    pub viscous_faces: [bool; 6],
    /// Whether it is a rapier collider too.
    pub collider: bool,
}

impl FluidContainer {
    /// A box without a lid, of these inner edge lengths in metres.
    pub fn open_box(x: f32, y: f32, z: f32) -> Self {
        let open = [false, false, false, true, false, false];
        Self { open, ..Self::closed_box(x, y, z) }
    }

    /// A box with all six walls, of these inner edge lengths in metres.
    pub fn closed_box(x: f32, y: f32, z: f32) -> Self {
        Self { size: Vec3::new(x, y, z), open: [false; 6], viscous_faces: [true; 6], collider: true }
    }
}
