//! What the coupling reads of a rapier world.

use glam::Vec3;
use rapier3d::dynamics::{ImpulseJointSet, IntegrationParameters, MultibodyJointSet, RigidBodyHandle, RigidBodySet};
use rapier3d::geometry::NarrowPhase;
use rapier3d::pipeline::PhysicsWorld;

/// The parts of a rapier world that a tick begins from.
#[derive(Clone, Copy)]
pub struct RapierView<'a> {
    /// The bodies.
    pub bodies: &'a RigidBodySet,
    /// Contacts of the last step.
    pub narrow_phase: &'a NarrowPhase,
    /// Joints that are solved by impulses.
    pub impulse_joints: &'a ImpulseJointSet,
    /// Joints in reduced coordinates.
    pub multibody_joints: &'a MultibodyJointSet,
    /// Time step, s, more than 0 and up to 1, and number of solver iterations of the coming step.
    pub parameters: &'a IntegrationParameters,
    /// Gravity of the coming step, m/s2.
    pub gravity: Vec3,
}

impl<'a> From<&'a PhysicsWorld> for RapierView<'a> {
    fn from(world: &'a PhysicsWorld) -> Self {
        Self {
            bodies: &world.bodies,
            narrow_phase: &world.narrow_phase,
            impulse_joints: &world.impulse_joints,
            multibody_joints: &world.multibody_joints,
            parameters: &world.integration_parameters,
            gravity: world.gravity,
        }
    }
}

/// Whether nothing but gravity and the fluid moves a body: it is dynamic, has all its degrees of freedom, touched
/// nothing in the last step and has no enabled joint. Only then may it be displaced when an impulse arrives late.
pub fn is_free(handle: RigidBodyHandle, world: &RapierView<'_>) -> bool {
    let Some(body) = world.bodies.get(handle) else { return false };
    body.is_dynamic()
        && body.locked_axes().is_empty()
        && world.multibody_joints.rigid_body_link(handle).is_none()
        && world.impulse_joints.attached_enabled_joints(handle).next().is_none()
        && !body
            .colliders()
            .iter()
            .any(|&collider| world.narrow_phase.contact_pairs_with(collider).any(|pair| pair.has_any_active_contact()))
}

/// Whether it touched something in the last step that no impulse moves, or has an enabled joint with such a thing.
pub(crate) fn is_anchored(handle: RigidBodyHandle, world: &RapierView<'_>) -> bool {
    let stands_fast = |other: Option<RigidBodyHandle>| {
        other.and_then(|other| world.bodies.get(other)).is_none_or(|other| !other.is_dynamic())
    };
    let Some(body) = world.bodies.get(handle) else { return false };
    let mut joined = world.impulse_joints.attached_enabled_joints(handle);
    let mut pairs = body.colliders().iter().flat_map(|&collider| world.narrow_phase.contact_pairs_with(collider));
    joined.any(|(first, second, ..)| stands_fast(Some(first)) || stands_fast(Some(second)))
        || world.multibody_joints.bodies_attached_with_enabled_joint(handle).any(|other| stands_fast(Some(other)))
        || pairs.any(|pair| {
            let mut sides =
                pair.manifolds.iter().flat_map(|manifold| [manifold.data.rigid_body1, manifold.data.rigid_body2]);
            pair.has_any_active_contact() && sides.any(stands_fast)
        })
}
