//! Reading a rapier body for the solver.

use freshet_core::step::{BodyInput, Impulse};
use glam::{Mat3, Quat, Vec3};
use rapier3d::dynamics::{RigidBody, RigidBodyType};
use rapier3d::math::AngularInertia;

use crate::world::RapierView;

/// Pose, velocities and inertia as they are now. A body that is asleep, fixed or kinematic cannot be moved by the fluid.
pub(crate) fn body_input(body: &RigidBody, duration: f32) -> BodyInput {
    let moved_by_fluid = body.is_dynamic() && !body.is_sleeping();
    let properties = body.mass_properties();
    let (linear_velocity, angular_velocity) = velocities(body, duration);
    BodyInput {
        position: body.center_of_mass(),
        rotation: body.rotation().normalize(),
        linear_velocity,
        angular_velocity,
        inverse_mass: if moved_by_fluid { properties.effective_inv_mass.max_element() } else { 0.0 },
        inverse_inertia: if moved_by_fluid { matrix(properties.effective_world_inv_inertia) } else { Mat3::ZERO },
        ..BodyInput::default()
    }
}

/// Acceleration from everything but the fluid, m/s2: gravity and the user's forces, as rapier applies them. A locked
/// axis holds against the forecast too.
pub(crate) fn acceleration(body: &RigidBody, gravity: Vec3, forecast: Impulse, duration: f32) -> Vec3 {
    if !body.is_dynamic() || body.is_sleeping() {
        return Vec3::ZERO;
    }
    let inverse = body.mass_properties().effective_inv_mass;
    let holding = (inverse - Vec3::splat(inverse.max_element())) * forecast.linear / duration;
    let unlocked = Vec3::select(inverse.cmpgt(Vec3::ZERO), Vec3::ONE, Vec3::ZERO);
    (gravity * body.gravity_scale()) * unlocked + body.user_force() * inverse + holding
}

/// Impulse by which rapier's step, `k` semi-implicit Euler substeps, runs ahead of a steady acceleration: it covers
/// `v t + a t^2 (k + 1)/(2 k)` instead of `v t + a t^2/2`, as if it were faster by `a t/(2 k)`.
pub(crate) fn overshoot(body: &RigidBody, world: &RapierView<'_>) -> Impulse {
    let substeps = (world.parameters.num_solver_iterations + body.additional_solver_iterations()).max(1) as f32;
    let share = world.parameters.dt / (2.0 * substeps);
    let weight = world.gravity * body.gravity_scale() * body.mass();
    Impulse { linear: (weight + body.user_force()) * share, angular: body.user_torque() * share }
}

/// A kinematic body that is told where to go moves there in the coming step; rapier finds its velocity only then.
fn velocities(body: &RigidBody, duration: f32) -> (Vec3, Vec3) {
    if body.is_sleeping() {
        return (Vec3::ZERO, Vec3::ZERO);
    }
    if body.body_type() != RigidBodyType::KinematicPositionBased {
        return (body.linvel(), body.angvel());
    }
    let next = body.next_position();
    let center = *next * body.local_center_of_mass();
    let turn: Quat = (next.rotation * body.rotation().inverse()).normalize();
    let turn = if turn.w < 0.0 { -turn } else { turn };
    ((center - body.center_of_mass()) / duration, turn.to_scaled_axis() / duration)
}

fn matrix(inertia: AngularInertia) -> Mat3 {
    let (m11, m12, m13) = (inertia.m11, inertia.m12, inertia.m13);
    let (m22, m23, m33) = (inertia.m22, inertia.m23, inertia.m33);
    Mat3::from_cols(Vec3::new(m11, m12, m13), Vec3::new(m12, m22, m23), Vec3::new(m13, m23, m33))
}
