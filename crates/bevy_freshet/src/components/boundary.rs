//! Surfaces that hold fluid.

use bevy::prelude::*;
use freshet_core::scene::{BoundaryShape, FluidSide};

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
    /// Faces that drag the fluid along: -x, +x, -y, +y, -z, +z; of a plane and a half-space +y counts. Along the others it
    /// slips freely. Shapes without these faces are viscous everywhere if any is true.
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
    /// Solid without end below the local x and z axes; only this rectangle of it holds fluid.
    HalfSpace {
        /// Half its edge lengths along the local x and z axes, m, 1e-5 to 1e6.
        half_size: Vec2,
    },
    /// A sphere.
    Sphere {
        /// Radius, m, half a spacing to 1e6.
        radius: f32,
        /// Where the fluid is.
        fluid: FluidBoundarySide,
    },
    /// A cylinder about the local y axis.
    Cylinder {
        /// Radius, m, half a spacing to 1e6.
        radius: f32,
        /// Half its height, m, half a spacing to 1e6.
        half_height: f32,
        /// Where the fluid is.
        fluid: FluidBoundarySide,
    },
    /// A cylinder about the local y axis that ends in half spheres.
    Capsule {
        /// Radius, m, half a spacing to 1e6.
        radius: f32,
        /// Half the height of the cylinder between the half spheres, m, 1e-5 to 1e6.
        half_height: f32,
        /// Where the fluid is.
        fluid: FluidBoundarySide,
    },
    /// A cone about the local y axis with its tip up, its centre half way up.
    Cone {
        /// Radius of the base, m, up to 1e6; a ball of half a spacing's radius has to fit into the cone.
        radius: f32,
        /// Half its height, m, up to 1e6.
        half_height: f32,
        /// Where the fluid is.
        fluid: FluidBoundarySide,
    },
    /// A cylindrical vessel about the local y axis without a lid, with fluid in it and around it.
    Cup {
        /// Radius of the room in it, m, half a spacing to 1e6.
        radius: f32,
        /// Half the height of the room in it, about the centre, m, half a spacing to 1e6.
        half_height: f32,
        /// How thick wall and bottom are, m, 1e-5 to 1e6.
        thickness: f32,
    },
}

/// On which side of a [`FluidBoundaryShape`] the fluid is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Clone, Debug, PartialEq)]
pub enum FluidBoundarySide {
    /// Around a solid.
    #[default]
    Outside,
    /// In a room, with nothing outside.
    Inside,
    /// On both: the surface is a sheet, from which fluid stands off by about a spacing on either side.
    Both,
}

impl From<FluidBoundarySide> for FluidSide {
    fn from(side: FluidBoundarySide) -> Self {
        match side {
            FluidBoundarySide::Outside => Self::Outside,
            FluidBoundarySide::Inside => Self::Inside,
            FluidBoundarySide::Both => Self::Both,
        }
    }
}

impl From<FluidSide> for FluidBoundarySide {
    fn from(side: FluidSide) -> Self {
        match side {
            FluidSide::Outside => Self::Outside,
            FluidSide::Inside => Self::Inside,
            FluidSide::Both => Self::Both,
        }
    }
}

impl FluidBoundaryShape {
    /// The model's shape.
    pub(crate) fn to_model(self) -> BoundaryShape {
        match self {
            Self::Cuboid { half_size } => BoundaryShape::Box { half_extents: half_size },
            Self::Plane { half_size } => BoundaryShape::Plane { half_extents: half_size.to_array() },
            Self::HalfSpace { half_size } => BoundaryShape::HalfSpace { half_extents: half_size.to_array() },
            Self::Sphere { radius, fluid } => BoundaryShape::Sphere { radius, fluid: fluid.into() },
            Self::Cylinder { radius, half_height, fluid } => {
                BoundaryShape::Cylinder { radius, half_height, fluid: fluid.into() }
            }
            Self::Capsule { radius, half_height, fluid } => {
                BoundaryShape::Capsule { radius, half_height, fluid: fluid.into() }
            }
            Self::Cone { radius, half_height, fluid } => {
                BoundaryShape::Cone { radius, half_height, fluid: fluid.into() }
            }
            Self::Cup { radius, half_height, thickness } => BoundaryShape::Cup { radius, half_height, thickness },
        }
    }

    /// From the model's shape; none for a container, which is a component of its own, and for hulls, meshes and height fields.
    pub(crate) fn from_model(shape: &BoundaryShape) -> Option<Self> {
        Some(match *shape {
            BoundaryShape::Box { half_extents } => Self::Cuboid { half_size: half_extents },
            BoundaryShape::Plane { half_extents } => Self::Plane { half_size: half_extents.into() },
            BoundaryShape::HalfSpace { half_extents } => Self::HalfSpace { half_size: half_extents.into() },
            BoundaryShape::Sphere { radius, fluid } => Self::Sphere { radius, fluid: fluid.into() },
            BoundaryShape::Cylinder { radius, half_height, fluid } => {
                Self::Cylinder { radius, half_height, fluid: fluid.into() }
            }
            BoundaryShape::Capsule { radius, half_height, fluid } => {
                Self::Capsule { radius, half_height, fluid: fluid.into() }
            }
            BoundaryShape::Cone { radius, half_height, fluid } => {
                Self::Cone { radius, half_height, fluid: fluid.into() }
            }
            BoundaryShape::Cup { radius, half_height, thickness } => Self::Cup { radius, half_height, thickness },
            BoundaryShape::Container { .. }
            | BoundaryShape::ConvexHull { .. }
            | BoundaryShape::Mesh { .. }
            | BoundaryShape::HeightField { .. } => return None,
        })
    }
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

impl From<Sphere> for FluidBoundary {
    fn from(sphere: Sphere) -> Self {
        Self::new(FluidBoundaryShape::Sphere { radius: sphere.radius, fluid: FluidBoundarySide::Outside })
    }
}

impl From<Cylinder> for FluidBoundary {
    fn from(Cylinder { radius, half_height }: Cylinder) -> Self {
        Self::new(FluidBoundaryShape::Cylinder { radius, half_height, fluid: FluidBoundarySide::Outside })
    }
}

impl From<Capsule3d> for FluidBoundary {
    fn from(Capsule3d { radius, half_length }: Capsule3d) -> Self {
        let (half_height, fluid) = (half_length, FluidBoundarySide::Outside);
        Self::new(FluidBoundaryShape::Capsule { radius, half_height, fluid })
    }
}

impl From<Cone> for FluidBoundary {
    fn from(Cone { radius, height }: Cone) -> Self {
        let (half_height, fluid) = (0.5 * height, FluidBoundarySide::Outside);
        Self::new(FluidBoundaryShape::Cone { radius, half_height, fluid })
    }
}
