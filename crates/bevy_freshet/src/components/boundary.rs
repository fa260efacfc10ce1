//! Surfaces that hold fluid.

use bevy::prelude::*;

/// A surface fluid does not pass, and that does not move by itself.
///
/// [`Transform`] is its centre and orientation; its scale must be 1. It may change, move (which samples it anew, so not
/// every tick) and be despawned. It is no collider: give it one beside it.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component, Clone, Debug, PartialEq)]
#[require(Transform)]
pub struct FluidBoundary {
    /// Its shape.
    pub shape: FluidBoundaryShape,
    /// Faces that drag the fluid along: -x, +x, -y, +y, -z, +z; of a plane +y counts. Along the others it slips freely.
    pub viscous_faces: [bool; 6],
}

/// Shape of a [`FluidBoundary`].
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Clone, Debug, PartialEq)]
pub enum FluidBoundaryShape {
    /// A solid box with the fluid outside.
    Cuboid {
        /// Half its edge lengths, m, 1e-5 to 1e6.
        half_size: Vec3,
    },
    /// A rectangle with the fluid on the side of the local +y axis.
    Plane {
        /// Half its edge lengths along the local x and z axes, m, 1e-5 to 1e6.
        half_size: Vec2,
    },
}

impl FluidBoundary {
    /// A shape all of whose faces drag the fluid along.
    pub fn new(shape: FluidBoundaryShape) -> Self {
        Self { shape, viscous_faces: [true; 6] }
    }

    /// A solid box of these edge lengths, m.
    pub fn cuboid(x: f32, y: f32, z: f32) -> Self {
        Cuboid::new(x, y, z).into()
    }

    /// A rectangle of these edge lengths along its local x and z axes, m, with the fluid above it (local +y).
    pub fn plane(x: f32, z: f32) -> Self {
        Self::new(FluidBoundaryShape::Plane { half_size: Vec2::new(x, z) / 2.0 })
    }
}

impl From<Cuboid> for FluidBoundary {
    fn from(cuboid: Cuboid) -> Self {
        Self::new(FluidBoundaryShape::Cuboid { half_size: cuboid.half_size })
    }
}
