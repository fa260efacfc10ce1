//! Between rapier's world and a domain's frame.

use bevy::math::{Isometry3d, Mat3};
use freshet_core::step::{BodyInput, Impulse};

/// A body as seen from a domain's frame.
pub(crate) fn to_domain(body: BodyInput, frame: Isometry3d) -> BodyInput {
    if frame == Isometry3d::IDENTITY {
        return body; // Exactly.
    }
    let inverse = frame.inverse();
    let axes = Mat3::from_quat(inverse.rotation);
    BodyInput {
        position: inverse * body.position,
        rotation: (inverse.rotation * body.rotation).normalize(),
        linear_velocity: axes * body.linear_velocity,
        angular_velocity: axes * body.angular_velocity,
        inverse_inertia: axes * body.inverse_inertia * axes.transpose(),
        acceleration: axes * body.acceleration,
        forecast: rotated(body.forecast, inverse),
        ..body
    }
}

/// An impulse in world axes.
pub(crate) fn to_world(impulse: Impulse, frame: Isometry3d) -> Impulse {
    rotated(impulse, frame)
}

fn rotated(impulse: Impulse, frame: Isometry3d) -> Impulse {
    Impulse { linear: frame.rotation * impulse.linear, angular: frame.rotation * impulse.angular }
}

#[cfg(test)]
mod tests {
    use bevy::math::{Quat, Vec3};

    use super::*;

    #[test]
    fn a_body_seen_from_a_turned_frame_has_the_same_motion_and_inertia() {
        let frame = Isometry3d::new(Vec3::new(1.0, 2.0, 3.0), Quat::from_rotation_y(0.7) * Quat::from_rotation_x(0.3));
        let body = BodyInput {
            position: Vec3::new(-1.0, 0.5, 2.0),
            linear_velocity: Vec3::X,
            angular_velocity: Vec3::new(0.1, 0.2, 0.3),
            inverse_inertia: Mat3::from_diagonal(Vec3::new(1.0, 2.0, 3.0)),
            ..BodyInput::default()
        };
        let seen = to_domain(body, frame);
        assert!((frame * seen.position).abs_diff_eq(body.position, 1e-5));
        let torque = Vec3::new(0.3, -0.2, 0.5);
        let turned = frame.rotation * (seen.inverse_inertia * (frame.rotation.inverse() * torque));
        assert!(turned.abs_diff_eq(body.inverse_inertia * torque, 1e-5));
        let impulse = Impulse { linear: seen.linear_velocity, angular: seen.angular_velocity };
        assert!(to_world(impulse, frame).linear.abs_diff_eq(body.linear_velocity, 1e-5));
    }
}
