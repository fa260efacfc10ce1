//! Surfaces that hold fluid.

use bevy::prelude::*;
use freshet_core::geometry::MAX_HEIGHTS;
use freshet_core::scene::{BoundaryShape, FluidSide};

use super::boundary_mesh::FluidMesh;
use super::wall::{FluidFriction, FluidWallMotion};

/// A surface fluid does not pass.
///
/// [`Transform`] is its centre and orientation. Its scale must be 1, but that of a mesh and of a convex hull may be anything but
/// zero, also by its parents: it is the mesh that is drawn. It may change, move and turn ([`motion`](Self::motion)) and be despawned. It
/// is no collider: give it one beside it.
///
/// A mesh or image may load later. Until it has, the domain waits: its fluid stands still, bodies do not feel it, nothing is lost, and
/// [`FluidStats::waiting_for`](super::stats::FluidStats::waiting_for) names the boundary. One that fails to load, or is of no use,
/// is a [`FluidProblem`](super::problem::FluidProblem), and the fluid goes on without the boundary. One that is modified is sampled
/// anew; one that is removed leaves the boundary as it is.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_freshet::prelude::*;
/// fn spawn_bowl(mut commands: Commands, assets: Res<AssetServer>) {
///     commands.spawn((
///         FluidBoundary::mesh(assets.load("bowl.glb#Mesh0/Primitive0")),
///         Transform::from_xyz(0.0, 1.0, 0.0).with_scale(Vec3::splat(0.5)),
///     ));
/// }
/// ```
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component, Clone, Debug, PartialEq)]
#[require(Transform)]
pub struct FluidBoundary {
    /// Its shape.
    pub shape: FluidBoundaryShape,
    /// Faces that drag the fluid along: -x, +x, -y, +y, -z, +z; of a plane and a half-space +y counts. Along the others it
    /// slips freely. Shapes without these faces are viscous everywhere if any is true. Along a wall that moves it slips, unless there is a viscosity model or friction.
    pub viscous_faces: [bool; 6],
    /// Coulomb's friction, on all of its surface, whether it stands, moves, or has a [`velocity`](Self::velocity); none by default.
    pub friction: FluidFriction,
    /// Velocity of the surface along every viscous face, m/s, up to 1e4, in the boundary's own axes: it stays where it is and moves as a belt
    /// does. Only with [`friction`](Self::friction) or a [viscosity model](super::settings::FluidSettings::viscosity_model), without which nothing would
    /// feel it; zero where no face is viscous, for shapes without faces, and for one that moves.
    pub velocity: Vec3,
    /// What follows from a [`Transform`] that changes.
    pub motion: FluidWallMotion,
}

/// Shape of a [`FluidBoundary`].
#[derive(Clone, Debug, PartialEq, Reflect)]
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
    /// Any triangles, up to 4 Mi, scaled as the entity is.
    Mesh {
        /// The triangles; they need not be closed, nor in order.
        mesh: FluidMesh,
        /// Where the fluid is; none takes [`Outside`](FluidBoundarySide::Outside) for a mesh without holes and
        /// [`Both`](FluidBoundarySide::Both) for any other, such as a bowl or terrain.
        fluid: Option<FluidBoundarySide>,
    },
    /// The smallest convex solid around the vertices of a mesh, scaled as the entity is, with the fluid outside.
    ConvexHull {
        /// The vertices, not all in a plane; its triangles do not count. The hull has up to 4096.
        mesh: FluidMesh,
    },
    /// Ground over a rectangle around the centre, with the fluid above it (local +y), bilinear between heights on a grid. It has no
    /// sides: what gets beyond its edges falls.
    HeightField {
        /// Edge lengths along the local x and z axes, m, 1e-5 to 1e6.
        size: Vec2,
        /// Number of heights along x and z, at least 2 each, up to 1 Mi in all. The outermost lie on the edges.
        counts: UVec2,
        /// Heights along the local y axis, m, within 1e6; x runs fastest.
        heights: Vec<f32>,
    },
    /// The same with a height for each pixel of an image, rows along the local x axis, the first at the lowest z.
    HeightImage {
        /// The image, which may load later. Mean of its red, green and blue as stored, without gamma: 0 is black and 1 white.
        image: Handle<Image>,
        /// Edge lengths along the local x and z axes, m, 1e-5 to 1e6.
        size: Vec2,
        /// Height of white, m, within 1e6; black is at 0.
        height: f32,
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
    /// The model's shape; none where it has to be made of a mesh, heights or an image.
    pub(crate) fn to_model(&self) -> Option<BoundaryShape> {
        Some(match *self {
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
            Self::Mesh { .. } | Self::ConvexHull { .. } | Self::HeightField { .. } | Self::HeightImage { .. } => {
                return None;
            }
        })
    }

    /// From the model's shape; none for a container, which is a component of its own.
    pub(crate) fn from_model(shape: &BoundaryShape) -> Option<Self> {
        Some(match shape {
            &BoundaryShape::Box { half_extents } => Self::Cuboid { half_size: half_extents },
            &BoundaryShape::Plane { half_extents } => Self::Plane { half_size: half_extents.into() },
            &BoundaryShape::HalfSpace { half_extents } => Self::HalfSpace { half_size: half_extents.into() },
            &BoundaryShape::Sphere { radius, fluid } => Self::Sphere { radius, fluid: fluid.into() },
            &BoundaryShape::Cylinder { radius, half_height, fluid } => {
                Self::Cylinder { radius, half_height, fluid: fluid.into() }
            }
            &BoundaryShape::Capsule { radius, half_height, fluid } => {
                Self::Capsule { radius, half_height, fluid: fluid.into() }
            }
            &BoundaryShape::Cone { radius, half_height, fluid } => {
                Self::Cone { radius, half_height, fluid: fluid.into() }
            }
            &BoundaryShape::Cup { radius, half_height, thickness } => Self::Cup { radius, half_height, thickness },
            BoundaryShape::Mesh { mesh, fluid } => Self::Mesh { mesh: mesh.into(), fluid: fluid.map(Into::into) },
            BoundaryShape::ConvexHull { points } => {
                Self::ConvexHull { mesh: FluidMesh::Triangles { vertices: points.clone(), triangles: Vec::new() } }
            }
            BoundaryShape::HeightField { field } => Self::HeightField {
                size: field.size().into(),
                counts: field.counts().into(),
                heights: field.heights().to_vec(),
            },
            BoundaryShape::Container { .. } => return None,
        })
    }
}

impl FluidBoundary {
    /// A shape all of whose faces drag the fluid along.
    pub fn new(shape: FluidBoundaryShape) -> Self {
        let (friction, motion) = (FluidFriction::default(), FluidWallMotion::default());
        Self { shape, viscous_faces: [true; 6], friction, velocity: Vec3::ZERO, motion }
    }

    /// The same with friction, see [`friction`](Self::friction).
    ///
    /// ```
    /// # use bevy_freshet::prelude::*;
    /// let slope = FluidBoundary::cuboid(2.0, 0.2, 1.0).with_friction(FluidFriction::coulomb(0.5));
    /// ```
    #[must_use]
    pub fn with_friction(self, friction: FluidFriction) -> Self {
        Self { friction, ..self }
    }

    /// The same as a belt, see [`velocity`](Self::velocity).
    #[must_use]
    pub fn with_velocity(self, velocity: Vec3) -> Self {
        Self { velocity, ..self }
    }

    /// The same as a wall that moves from the start: nothing is planned anew when it begins to.
    ///
    /// ```
    /// # use bevy::prelude::*;
    /// # use bevy_freshet::prelude::*;
    /// #[derive(Component)]
    /// struct Paddle;
    ///
    /// fn spawn_paddle(mut commands: Commands) {
    ///     commands.spawn((Paddle, FluidBoundary::cuboid(0.7, 0.05, 0.4).moving(), Transform::from_xyz(0.5, 0.4, 0.5)));
    /// }
    ///
    /// /// In `FixedUpdate`, before `FreshetSystems::Plan`.
    /// fn turn_paddle(time: Res<Time>, mut paddles: Query<&mut Transform, With<Paddle>>) {
    ///     for mut pose in &mut paddles {
    ///         pose.rotate_z(2.0 * time.delta_secs());
    ///     }
    /// }
    /// ```
    #[must_use]
    pub fn moving(self) -> Self {
        Self { motion: FluidWallMotion::Moving, ..self }
    }

    /// A solid box of these edge lengths, m.
    pub fn cuboid(x: f32, y: f32, z: f32) -> Self {
        Cuboid::new(x, y, z).into()
    }

    /// A rectangle of these edge lengths along its local x and z axes, m, with the fluid above it (local +y).
    pub fn plane(x: f32, z: f32) -> Self {
        Self::new(FluidBoundaryShape::Plane { half_size: Vec2::new(x, z) / 2.0 })
    }

    /// The triangles of a mesh, with the fluid outside of one without holes and on both sides of any other.
    pub fn mesh(mesh: impl Into<FluidMesh>) -> Self {
        Self::new(FluidBoundaryShape::Mesh { mesh: mesh.into(), fluid: None })
    }

    /// The triangles of a mesh, with the fluid on this side of them.
    pub fn mesh_with_fluid(mesh: impl Into<FluidMesh>, fluid: FluidBoundarySide) -> Self {
        Self::new(FluidBoundaryShape::Mesh { mesh: mesh.into(), fluid: Some(fluid) })
    }

    /// The convex hull of the vertices of a mesh.
    pub fn convex_hull(mesh: impl Into<FluidMesh>) -> Self {
        Self::new(FluidBoundaryShape::ConvexHull { mesh: mesh.into() })
    }

    /// Ground of these edge lengths along its local x and z axes, m, with `counts` heights along them, m; x runs fastest.
    pub fn height_field(size: Vec2, counts: UVec2, heights: Vec<f32>) -> Self {
        Self::new(FluidBoundaryShape::HeightField { size, counts, heights })
    }

    /// The same with heights from a function of x and z, m from the centre.
    ///
    /// ```
    /// # use bevy::prelude::*;
    /// # use bevy_freshet::prelude::*;
    /// let valley = FluidBoundary::height_function(Vec2::splat(4.0), UVec2::splat(33), |x, z| 0.1 * (x * x + z * z));
    /// ```
    pub fn height_function(size: Vec2, counts: UVec2, height: impl Fn(f32, f32) -> f32) -> Self {
        let count = u64::from(counts.x) * u64::from(counts.y);
        // With more it is refused, and would not fit into memory.
        let counted = if count <= MAX_HEIGHTS as u64 { counts } else { UVec2::ZERO };
        let step = size / (counts.max(UVec2::splat(2)) - 1).as_vec2();
        let place = |i: u32, j: u32| UVec2::new(i, j).as_vec2() * step - 0.5 * size;
        let places = (0..counted.y).flat_map(|j| (0..counted.x).map(move |i| (i, j)));
        let heights = places.map(|(i, j)| place(i, j)).map(|at| height(at.x, at.y)).collect();
        Self::height_field(size, counts, heights)
    }

    /// Ground of these edge lengths along its local x and z axes, m, with a height for each pixel: 0 for black, `height`, m, for
    /// white.
    pub fn height_image(image: Handle<Image>, size: Vec2, height: f32) -> Self {
        Self::new(FluidBoundaryShape::HeightImage { image, size, height })
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
