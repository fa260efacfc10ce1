//! Surface samples of rapier shapes.

use freshet_core::error::InvalidInput;
use freshet_core::sampling::wall_layer::WallLayer;
use freshet_core::scene::Body;
use freshet_core::solid::Solid;
use glam::Vec3;
use rapier3d::dynamics::RigidBody;
use rapier3d::geometry::{ColliderSet, Shape, ShapeType, TypedShape};

/// Why a shape could not be sampled.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SamplingError {
    /// The shape's sizes or the spacing are out of range.
    #[error(transparent)]
    Invalid(#[from] InvalidInput),
    /// There is no sampling of this shape.
    #[error("a {shape:?} cannot float in a fluid: its surface cannot be sampled; supported: Ball, Cuboid")]
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
/// ([`FluidScene::wall_layer`](freshet_core::scene::FluidScene::wall_layer)) says, one for each spacing squared of surface.
///
/// # Errors
/// A shape other than a ball or a cuboid; a shape too small for the spacing.
pub fn sample_shape(shape: &dyn Shape, layer: &WallLayer) -> Result<Vec<Vec3>, SamplingError> {
    match shape.as_typed_shape() {
        TypedShape::Ball(ball) => Ok(layer.sphere_surface(ball.radius)?),
        TypedShape::Cuboid(cuboid) => Ok(layer.box_surface(cuboid.half_extents)?),
        _ => Err(SamplingError::Unsupported { shape: shape.shape_type() }),
    }
}

/// Where a shape is solid, in its own frame.
///
/// # Errors
/// A shape other than a ball or a cuboid.
fn solid(shape: &dyn Shape) -> Result<Solid, SamplingError> {
    match shape.as_typed_shape() {
        TypedShape::Ball(ball) => Ok(Solid::ball(ball.radius, Vec3::ZERO)),
        TypedShape::Cuboid(cuboid) => Ok(Solid::block(cuboid.half_extents, Vec3::ZERO)),
        _ => Err(SamplingError::Unsupported { shape: shape.shape_type() }),
    }
}

/// The body of a fluid scene for a rapier body: samples of all its colliders that are enabled and no sensors, and where they are
/// solid, relative to its centre of mass, in the axes of its own frame.
///
/// Colliders may overlap: samples that crowd share their volume weights, and those inside another collider meet no
/// fluid. Sample again when colliders are added, moved or removed, or when the centre of mass moves in the body.
///
/// # Errors
/// What [`sample_shape`] refuses, or no collider.
pub fn body_from_rigid_body(
    name: &str,
    body: &RigidBody,
    colliders: &ColliderSet,
    layer: &WallLayer,
) -> Result<Body, SamplingError> {
    let center_of_mass = body.local_center_of_mass();
    let (mut samples, mut solids) = (Vec::new(), Vec::new());
    for collider in body.colliders().iter().filter_map(|&handle| colliders.get(handle)) {
        if collider.is_enabled() && !collider.is_sensor() {
            let pose = collider.position_wrt_parent().copied().unwrap_or_default();
            let points = sample_shape(collider.shape(), layer)?;
            samples.extend(points.into_iter().map(|point| pose * point - center_of_mass));
            let solid = solid(collider.shape())?;
            solids.push(solid.placed(pose.translation - center_of_mass, pose.rotation.normalize()));
        }
    }
    if samples.is_empty() {
        return Err(SamplingError::NoCollider { name: name.to_owned() });
    }
    Ok(Body { name: name.to_owned(), samples, solids })
}
