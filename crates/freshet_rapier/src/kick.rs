//! Giving momentum to a rapier body and reading back what it got.

use freshet_core::step::Impulse;
use glam::{Quat, Vec3};
use rapier3d::dynamics::{LockedAxes, RigidBody};
use rapier3d::math::Pose;

use crate::ledger::{Ledger, Momentum};

/// Gives an impulse to a body through rapier's interface and books it. A sleeping body is not moved.
pub(crate) fn kick(body: &mut RigidBody, impulse: Impulse, ledger: &mut Ledger) {
    if body.is_sleeping() || !body.is_dynamic() {
        ledger.held.add(impulse);
        return;
    }
    let (linear_velocity, angular_velocity) = (body.linvel(), body.angvel());
    body.apply_impulse(impulse.linear, false);
    body.apply_torque_impulse(impulse.angular, false);
    let inertia = world_inertia(body);
    let linear = (body.linvel().as_dvec3() - linear_velocity.as_dvec3()) * f64::from(body.mass());
    let angular = inertia * (body.angvel().as_dvec3() - angular_velocity.as_dvec3());
    let locked = body.locked_axes();
    ledger.given = ledger.given + Momentum { linear, angular };
    ledger.held.add(Impulse {
        linear: impulse.linear * locked_axes(locked, LockedAxes::TRANSLATION_LOCKED_X, body.mass() == 0.0),
        angular: impulse.angular * locked_axes(locked, LockedAxes::ROTATION_LOCKED_X, inertia == glam::DMat3::ZERO),
    });
}

/// Inertia tensor in world axes, kg m2.
fn world_inertia(body: &RigidBody) -> glam::DMat3 {
    let axes = glam::Mat3::from_quat(*body.rotation()).as_dmat3();
    axes * body.mass_properties().local_mprops.reconstruct_inertia_matrix().as_dmat3() * axes.transpose()
}

/// One for each of three consecutive axes that is locked, from `first` on, or for all.
fn locked_axes(locked: LockedAxes, first: LockedAxes, all: bool) -> Vec3 {
    let is_locked = |axis: u8| all || locked.bits() & (first.bits() << axis) != 0;
    Vec3::from_array([0, 1, 2].map(|axis| if is_locked(axis) { 1.0 } else { 0.0 }))
}

/// Moves a body's centre of mass by `shift`, m, and turns it about there by the rotation vector `turn`, rad.
pub(crate) fn displace(body: &mut RigidBody, shift: Vec3, turn: Vec3) {
    if shift == Vec3::ZERO && turn == Vec3::ZERO {
        return;
    }
    let center = body.center_of_mass() + shift;
    let rotation = (Quat::from_scaled_axis(turn) * *body.rotation()).normalize();
    let translation = center - rotation * body.local_center_of_mass();
    body.set_position(Pose::from_parts(translation, rotation), false);
}
