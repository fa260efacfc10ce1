//! Surface samples of rapier shapes.

use freshet_core::error::InvalidInput;
use freshet_core::geometry::{self, TriangleMesh};
use freshet_core::sampling::wall_layer::WallLayer;
use freshet_core::scene::{Body, FluidSide};
use freshet_core::solid::{Solid, SolidShape};
use glam::{Quat, Vec3};
use rapier3d::dynamics::RigidBody;
use rapier3d::geometry::{Capsule, ColliderSet, HeightField, Shape, ShapeType, TypedShape};
use rapier3d::math::Pose;

/// Why a shape could not be sampled.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SamplingError {
    /// The shape's sizes or the spacing are out of range.
    #[error(transparent)]
    Invalid(#[from] InvalidInput),
    /// There is no sampling of this shape.
    #[error(
        "a {shape:?} cannot be in a fluid: its surface cannot be sampled; supported: Ball, Cuboid, Capsule, Cylinder, Cone, \
         ConvexPolyhedron, RoundCuboid, RoundCylinder, RoundCone, RoundConvexPolyhedron, TriMesh, HeightField, Compound"
    )]
    Unsupported {
        /// Rapier's name of the shape.
        shape: ShapeType,
    },
    /// The rigid body has no collider that is enabled and solid.
    #[error("rigid body {name:?} has no enabled collider that is not a sensor; allowed: at least one")]
    NoCollider {
        /// The name given.
        name: String,
    },
}

/// Points in a shape's own frame, m, as deep inside its surface as the fluid's wall layer
/// ([`FluidScene::wall_layer`](freshet_core::scene::FluidScene::wall_layer)) says: where those of a wall of this shape lie, no two
/// nearer than half a spacing, no point of the layer farther than 0.75 spacings from one. Where the shape is thinner than twice that
/// depth they lie in its middle.
///
/// A compound has those of its parts, but for what is deeper in another part than the layer. A triangle mesh without holes is
/// solid; with holes it is a sheet with fluid on both sides, and so is a height field with removed cells. Any other height field is
/// ground, with the fluid above it.
///
/// # Errors
/// A shape that is not supported; one too small for the spacing, or with a size that is not positive; more samples than
/// [`MAX_CURVED_SAMPLES`](freshet_core::sampling::MAX_CURVED_SAMPLES).
pub fn sample_shape(shape: &dyn Shape, layer: &WallLayer) -> Result<Vec<Vec3>, SamplingError> {
    let mut parts = Vec::new();
    add_parts(shape, Pose::IDENTITY, layer, &mut parts)?;
    Ok(exposed(parts, layer).0)
}

/// The body of a fluid scene for a rapier body: samples of all its colliders that are enabled and no sensors, and where they are
/// solid, relative to its centre of mass, in the axes of its own frame.
///
/// Colliders may overlap, as the parts of a compound may: samples that crowd share their volume weights, and those deep inside
/// another collider are left out. Sample again when colliders are added, moved or removed, or when the centre of mass moves in the
/// body.
///
/// # Errors
/// What [`sample_shape`] refuses, or no collider.
pub fn body_from_rigid_body(
    name: &str,
    body: &RigidBody,
    colliders: &ColliderSet,
    layer: &WallLayer,
) -> Result<Body, SamplingError> {
    let center_of_mass = Pose::from_translation(-body.local_center_of_mass());
    let mut parts = Vec::new();
    for collider in body.colliders().iter().filter_map(|&handle| colliders.get(handle)) {
        if collider.is_enabled() && !collider.is_sensor() {
            let pose = collider.position_wrt_parent().copied().unwrap_or_default();
            add_parts(collider.shape(), center_of_mass * pose, layer, &mut parts)?;
        }
    }
    if parts.is_empty() {
        return Err(SamplingError::NoCollider { name: name.to_owned() });
    }
    let (samples, solids) = exposed(parts, layer);
    Ok(Body { name: name.to_owned(), samples, solids, ..Body::default() })
}

/// The same with three layers of [quasi-fluid](freshet_core::sampling::quasi_fluid) samples.
///
/// # Errors
/// As [`body_from_rigid_body`].
pub fn quasi_fluid_from_rigid_body(
    name: &str,
    body: &RigidBody,
    colliders: &ColliderSet,
    layer: &WallLayer,
) -> Result<Body, SamplingError> {
    let [first, second, third] = layer.quasi_fluid();
    let sampled = |layer| body_from_rigid_body(name, body, colliders, &layer);
    Ok(Body::quasi_fluid([sampled(first)?, sampled(second)?, sampled(third)?], layer.spacing()))
}

/// A shape that is no compound.
struct Part {
    samples: Vec<Vec3>,
    solid: Solid,
}

/// Samples of all parts that are not deep inside another, and where the parts are solid.
fn exposed(parts: Vec<Part>, layer: &WallLayer) -> (Vec<Vec3>, Vec<Solid>) {
    // What lies as deep as the layer is on the layer of that part too.
    let deep = layer.depth + 0.1 * layer.spacing();
    let is_exposed = |index: usize, sample: Vec3| {
        let others = parts.iter().enumerate().filter(|&(other, _)| other != index);
        !others.map(|(_, part)| &part.solid).any(|solid| solid.contains(sample, deep))
    };
    let all =
        parts.iter().enumerate().flat_map(|(index, part)| part.samples.iter().map(move |&sample| (index, sample)));
    let samples = all.filter(|&(index, sample)| is_exposed(index, sample)).map(|(_, sample)| sample).collect();
    (samples, parts.into_iter().map(|part| part.solid).collect())
}

/// Adds a shape, or the parts of a compound.
fn add_parts(shape: &dyn Shape, pose: Pose, layer: &WallLayer, parts: &mut Vec<Part>) -> Result<(), SamplingError> {
    use SolidShape::{Box as Block, Cone, Cylinder, Mesh, Sphere};
    let around = FluidSide::Outside;
    let (samples, solid) = match shape.as_typed_shape() {
        TypedShape::Ball(ball) => (layer.sphere(ball.radius, around)?, Sphere { radius: ball.radius }),
        TypedShape::Cuboid(cuboid) => {
            let half_extents = cuboid.half_extents;
            (layer.box_surface(half_extents)?, Block { half_extents })
        }
        TypedShape::Capsule(capsule) => return add_capsule(capsule, pose, layer, parts),
        TypedShape::Cylinder(cylinder) => {
            let (radius, half_height) = (cylinder.radius, cylinder.half_height);
            (layer.cylinder(radius, half_height, around)?, Cylinder { radius, half_height })
        }
        TypedShape::Cone(cone) => {
            let (radius, half_height) = (cone.radius, cone.half_height);
            (layer.cone(radius, half_height, around)?, Cone { radius, half_height })
        }
        TypedShape::ConvexPolyhedron(hull) => {
            let mesh = mesh(hull.to_trimesh())?;
            (layer.mesh(&mesh, around)?, Mesh { mesh })
        }
        TypedShape::RoundCuboid(round) => {
            let (core, rounding) = (round.inner_shape, round.border_radius);
            let solid = rounded(Block { half_extents: core.half_extents }, rounding);
            (layer.round_mesh(&mesh(core.to_trimesh())?, rounding)?, solid)
        }
        TypedShape::RoundCylinder(round) => {
            let (radius, half_height) = (round.inner_shape.radius, round.inner_shape.half_height);
            let samples = layer.round_cylinder(radius, half_height, round.border_radius)?;
            (samples, rounded(Cylinder { radius, half_height }, round.border_radius))
        }
        TypedShape::RoundCone(round) => {
            let (radius, half_height) = (round.inner_shape.radius, round.inner_shape.half_height);
            let samples = layer.round_cone(radius, half_height, round.border_radius)?;
            (samples, rounded(Cone { radius, half_height }, round.border_radius))
        }
        TypedShape::RoundConvexPolyhedron(round) => {
            let mesh = mesh(round.inner_shape.to_trimesh())?;
            (layer.round_mesh(&mesh, round.border_radius)?, rounded(Mesh { mesh }, round.border_radius))
        }
        TypedShape::TriMesh(triangles) => {
            any_mesh(mesh((triangles.vertices().to_vec(), triangles.indices().to_vec()))?, layer)?
        }
        TypedShape::HeightField(field) => height_field(field, layer)?,
        TypedShape::Compound(compound) => {
            for (place, part) in compound.shapes() {
                add_parts(&**part, pose * *place, layer, parts)?;
            }
            return Ok(());
        }
        _ => return Err(SamplingError::Unsupported { shape: shape.shape_type() }),
    };
    add_part(samples, solid, pose, parts);
    Ok(())
}

fn add_part(samples: Vec<Vec3>, shape: SolidShape, pose: Pose, parts: &mut Vec<Part>) {
    parts.push(Part {
        samples: samples.into_iter().map(|point| pose * point).collect(),
        solid: Solid { shape, center: pose.translation, rotation: pose.rotation.normalize() },
    });
}

/// Rapier's capsules lie between any two points; one between two that are the same is a ball.
fn add_capsule(capsule: &Capsule, pose: Pose, layer: &WallLayer, parts: &mut Vec<Part>) -> Result<(), SamplingError> {
    let (radius, half_height) = (capsule.radius, capsule.half_height());
    let way = (capsule.segment.b - capsule.segment.a).normalize_or(Vec3::Y);
    let place = Pose::from_parts(capsule.center(), Quat::from_rotation_arc(Vec3::Y, way));
    let (samples, solid) = if half_height < SMALLEST {
        (layer.sphere(radius, FluidSide::Outside)?, SolidShape::Sphere { radius })
    } else {
        (layer.capsule(radius, half_height, FluidSide::Outside)?, SolidShape::Capsule { radius, half_height })
    };
    add_part(samples, solid, pose * place, parts);
    Ok(())
}

/// Smallest size of a [`SolidShape`], m.
const SMALLEST: f32 = 1e-5;

fn rounded(core: SolidShape, rounding: f32) -> SolidShape {
    if rounding < SMALLEST { core } else { SolidShape::Rounded { core: Box::new(core), rounding } }
}

fn mesh((vertices, triangles): (Vec<Vec3>, Vec<[u32; 3]>)) -> Result<TriangleMesh, InvalidInput> {
    TriangleMesh::new(vertices, triangles)
}

/// A closed mesh is a solid, any other a sheet.
fn any_mesh(mesh: TriangleMesh, layer: &WallLayer) -> Result<(Vec<Vec3>, SolidShape), InvalidInput> {
    if mesh.is_closed() {
        return Ok((layer.mesh(&mesh, FluidSide::Outside)?, SolidShape::Mesh { mesh }));
    }
    let samples = layer.mesh(&mesh, FluidSide::Both)?;
    Ok((samples, SolidShape::Skin { shape: Box::new(SolidShape::Mesh { mesh }), reach: layer.depth }))
}

/// Ground, bilinear between its heights where rapier has two triangles in a cell.
fn height_field(field: &HeightField, layer: &WallLayer) -> Result<(Vec<Vec3>, SolidShape), InvalidInput> {
    let (rows, columns) = (field.heights().nrows(), field.heights().ncols());
    if field.triangles().count() < 2 * (rows - 1) * (columns - 1) {
        return any_mesh(mesh(field.to_trimesh())?, layer);
    }
    let (heights, scale) = (field.heights(), field.scale());
    let places = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
    let heights = places.map(|place| heights[place] * scale.y).collect();
    let field = geometry::HeightField::new([scale.x, scale.z], [columns as u32, rows as u32], heights)?;
    let samples = layer.height_field(&field)?;
    Ok((samples, SolidShape::Ground { field, thickness: 2.0 * layer.depth }))
}
