//! What holds the fluid and does not move.

use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};

use super::{Friction, REACH, check_half_extents, check_pose};
use crate::error::{InvalidInput, check_range};
use crate::geometry::{HeightField, TriangleMesh, convex_hull};
use crate::viscosity::ViscosityModel;

/// On which side of a surface the fluid is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum FluidSide {
    /// Around a solid.
    #[default]
    Outside,
    /// In a room, with nothing outside: its wall is twice as thick as its samples lie deep.
    Inside,
    /// On both, with a sheet between. Its samples lie on the surface itself, so that fluid at rest stands off by as much as they would
    /// lie deep otherwise (0.92 spacings with the default kernel and support), on either side.
    Both,
}

/// A surface that holds fluid.
///
/// Sizes are 1e-5 to 1e6 m. What turns about an axis turns about the local y axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum BoundaryShape {
    /// A hollow box with the fluid inside.
    Container {
        /// Half the inner edge lengths, m.
        half_extents: Vec3,
        /// Which faces are missing: -x, +x, -y, +y, -z, +z.
        #[serde(default)]
        open: [bool; 6],
    },
    /// A solid box with the fluid outside.
    Box {
        /// Half its edge lengths, m.
        half_extents: Vec3,
    },
    /// A rectangle with the fluid on the side the local +y axis points to.
    Plane {
        /// Half its edge lengths along the local x and z axes, m.
        half_extents: [f32; 2],
    },
    /// Solid without end below the plane of the local x and z axes. Only a rectangle of it has samples: what gets beyond its edges
    /// falls, and what would start below, however deep, is left out.
    HalfSpace {
        /// Half the edge lengths of the rectangle along the local x and z axes, m.
        half_extents: [f32; 2],
    },
    /// A sphere.
    Sphere {
        /// Radius, m; at least half a spacing.
        radius: f32,
        /// Where the fluid is.
        #[serde(default)]
        fluid: FluidSide,
    },
    /// A cylinder.
    Cylinder {
        /// Radius, m; at least half a spacing.
        radius: f32,
        /// Half its height, m; at least half a spacing.
        half_height: f32,
        /// Where the fluid is.
        #[serde(default)]
        fluid: FluidSide,
    },
    /// A cylinder that ends in half spheres.
    Capsule {
        /// Radius, m; at least half a spacing.
        radius: f32,
        /// Half the height of the cylinder between the half spheres, m.
        half_height: f32,
        /// Where the fluid is.
        #[serde(default)]
        fluid: FluidSide,
    },
    /// A cone with its tip up, its centre half way up.
    Cone {
        /// Radius of the base, m. The largest ball in it has at least the radius of half a spacing.
        radius: f32,
        /// Half its height, m.
        half_height: f32,
        /// Where the fluid is.
        #[serde(default)]
        fluid: FluidSide,
    },
    /// A cylindrical vessel without a lid, with fluid in it and around it (P 4.1.2 names a cup among its shapes).
    Cup {
        /// Radius of the room in it, m; at least half a spacing.
        radius: f32,
        /// Half the height of the room in it, about the centre, m; at least half a spacing.
        half_height: f32,
        /// How thick wall and bottom are, m. One thinner than twice the depth of the samples has them in its middle.
        thickness: f32,
    },
    /// The smallest convex solid around points, with the fluid outside.
    ConvexHull {
        /// Points, m, 4 to [`MAX_HULL_POINTS`](crate::geometry::MAX_HULL_POINTS), not all in a plane.
        points: Vec<Vec3>,
    },
    /// Any triangles.
    Mesh {
        /// The triangles.
        mesh: TriangleMesh,
        /// Where the fluid is; none takes [`FluidSide::Outside`] for a [closed](TriangleMesh::is_closed) mesh and
        /// [`FluidSide::Both`] for any other. Inside is where the surface goes round more than half a time
        /// ([`TriangleMesh::is_inside`]), so that triangles may cross, be missing here and there, or face inwards all together.
        #[serde(default)]
        fluid: Option<FluidSide>,
    },
    /// Ground with the fluid above it; solid down to twice the depth of the samples below its lowest place.
    HeightField {
        /// Its heights.
        field: HeightField,
    },
}

impl BoundaryShape {
    /// A mesh with the fluid outside if it is closed, and otherwise on both sides.
    pub fn mesh(mesh: TriangleMesh) -> Self {
        Self::Mesh { mesh, fluid: None }
    }

    /// Whether it has the six faces that [`Boundary::viscous_faces`] names.
    pub(crate) fn has_faces(&self) -> bool {
        matches!(self, Self::Container { .. } | Self::Box { .. } | Self::Plane { .. } | Self::HalfSpace { .. })
    }
}

/// Where the fluid of a mesh is.
pub(crate) fn side_of(mesh: &TriangleMesh, fluid: Option<FluidSide>) -> FluidSide {
    fluid.unwrap_or(if mesh.is_closed() { FluidSide::Outside } else { FluidSide::Both })
}

/// A boundary that does not move.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Boundary {
    /// Its shape.
    pub shape: BoundaryShape,
    /// Centre of the shape, m.
    pub center: Vec3,
    /// Its orientation.
    #[serde(default)]
    pub rotation: Quat,
    /// Faces that drag the fluid along: it sticks to them if there is a [viscosity model](super::Settings::viscosity_model), otherwise
    /// its artificial viscosity acts between it and them. Along the others it slips freely. In the order -x, +x, -y, +y, -z,
    /// +z; the only face of a plane and a half-space is +y. Shapes without these faces are viscous everywhere if any is named, and
    /// slippery if none is. All, if they are left out.
    #[serde(default = "every_face")]
    pub viscous_faces: [bool; 6],
    /// Velocity of the surface, m/s, up to 1e4, along every viscous face, in world axes: the wall stays where it is and moves as
    /// a belt does. The other faces stand. Zero unless there is [friction](Self::friction) or a [viscosity model](super::Settings::viscosity_model), without which nothing
    /// would feel it, where no face is viscous, and for shapes without faces, no vector being along all of their surface.
    #[serde(default)]
    pub velocity: Vec3,
    /// Coulomb's friction, on all of its surface, whether it stands or moves as a belt; none by default.
    #[serde(default)]
    pub friction: Friction,
}

fn every_face() -> [bool; 6] {
    [true; 6]
}

impl Boundary {
    /// A container of inner size `size` without a lid.
    pub fn open_box(size: Vec3, center: Vec3) -> Self {
        let open = [false, false, false, true, false, false];
        Self::new(BoundaryShape::Container { half_extents: size / 2.0, open }, center)
    }

    /// A container of inner size `size` with all six walls.
    pub fn closed_box(size: Vec3, center: Vec3) -> Self {
        let shape = BoundaryShape::Container { half_extents: size / 2.0, open: [false; 6] };
        Self::new(shape, center)
    }

    /// A shape that is not turned and has viscous faces only.
    pub fn new(shape: BoundaryShape, center: Vec3) -> Self {
        Self {
            shape,
            center,
            rotation: Quat::IDENTITY,
            viscous_faces: every_face(),
            velocity: Vec3::ZERO,
            friction: Friction::default(),
        }
    }

    /// The same with other faces viscous, see [`Boundary::viscous_faces`].
    pub fn with_viscous_faces(self, viscous_faces: [bool; 6]) -> Self {
        Self { viscous_faces, ..self }
    }

    /// The same with a surface that moves, see [`Boundary::velocity`].
    pub fn with_velocity(self, velocity: Vec3) -> Self {
        Self { velocity, ..self }
    }

    /// The same with friction, see [`Boundary::friction`].
    pub fn with_friction(self, friction: Friction) -> Self {
        Self { friction, ..self }
    }
}

impl Boundary {
    /// Checks every number.
    pub fn validate(&self) -> Result<(), InvalidInput> {
        match &self.shape {
            &BoundaryShape::Container { half_extents, open } => {
                check_half_extents(half_extents).map_err(|error| error.inside("shape"))?;
                if open == [true; 6] {
                    return Err(InvalidInput::new("shape.open", "six times true", "at least one false"));
                }
            }
            &BoundaryShape::Box { half_extents } => {
                check_half_extents(half_extents).map_err(|error| error.inside("shape"))?;
            }
            BoundaryShape::Plane { half_extents } | BoundaryShape::HalfSpace { half_extents } => {
                for &value in half_extents {
                    check_range("shape.half_extents", value, 1e-5, REACH, "m")?;
                }
            }
            &BoundaryShape::Sphere { radius, .. } => check_range("shape.radius", radius, 1e-5, REACH, "m")?,
            &BoundaryShape::Cylinder { radius, half_height, .. }
            | &BoundaryShape::Capsule { radius, half_height, .. }
            | &BoundaryShape::Cone { radius, half_height, .. } => {
                check_range("shape.radius", radius, 1e-5, REACH, "m")?;
                check_range("shape.half_height", half_height, 1e-5, REACH, "m")?;
            }
            &BoundaryShape::Cup { radius, half_height, thickness } => {
                check_range("shape.radius", radius, 1e-5, REACH, "m")?;
                check_range("shape.half_height", half_height, 1e-5, REACH, "m")?;
                check_range("shape.thickness", thickness, 1e-5, REACH, "m")?;
            }
            BoundaryShape::ConvexHull { points } => {
                convex_hull(points).map_err(|error| error.inside("shape"))?;
            }
            BoundaryShape::Mesh { mesh, .. } => mesh.validate().map_err(|error| error.inside("shape.mesh"))?,
            BoundaryShape::HeightField { field } => {
                field.validate().map_err(|error| error.inside("shape.field"))?;
            }
        }
        self.friction.validate().map_err(|error| error.inside("friction"))?;
        check_pose(self.center, self.rotation)
    }

    /// Its viscous faces, as [`viscous_faces`](Self::viscous_faces) counts them; none of a curved shape.
    pub(crate) fn viscous(&self) -> impl Iterator<Item = usize> {
        let is_face = |index: usize| match self.shape {
            BoundaryShape::Container { open, .. } => !open[index],
            BoundaryShape::Box { .. } => true,
            BoundaryShape::Plane { .. } | BoundaryShape::HalfSpace { .. } => index == 3,
            _ => false,
        };
        (0..6).filter(move |&index| is_face(index) && self.viscous_faces[index])
    }

    pub(super) fn check_velocity(&self, model: Option<ViscosityModel>) -> Result<(), InvalidInput> {
        for value in self.velocity.to_array() {
            check_range("velocity", value, -1e4, 1e4, "m/s")?;
        }
        if self.velocity == Vec3::ZERO {
            return Ok(());
        }
        if model.is_none() && !self.friction.is_some() {
            let allowed = "zero, as there is no settings.viscosity_model and no friction";
            return Err(InvalidInput::new("velocity", self.velocity, allowed));
        }
        if !self.shape.has_faces() && self.viscous_faces.contains(&true) {
            return Err(InvalidInput::new(
                "velocity",
                self.velocity,
                "zero, as no vector is along all of a curved surface",
            ));
        }
        let across = (self.rotation.conjugate() * self.velocity).abs();
        let least = 1e-4 * self.velocity.length();
        if self.viscous().any(|index| across[index / 2] > least) {
            return Err(InvalidInput::new("velocity", self.velocity, "a vector along every viscous face"));
        }
        Ok(())
    }
}
