//! Whether contacts and joints hold a body in its motion.

use freshet_core::step::Impulse;
use glam::Vec3;
use rapier3d::dynamics::RigidBody;

/// Share of what pushes a body that may change its velocities while it counts as held.
const LEFT: f32 = 0.1;

/// A body at the end of a tick, and what has pushed it since.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Hold {
    linear_velocity: Vec3,
    angular_velocity: Vec3,
    /// By the fluid, N s and N m s.
    impulse: Impulse,
    /// By everything else but contacts and joints, m/s.
    external: Vec3,
}

impl Hold {
    /// Nothing has pushed it yet.
    pub(crate) fn since(body: &RigidBody) -> Self {
        Self { linear_velocity: body.linvel(), angular_velocity: body.angvel(), ..Self::default() }
    }

    /// Takes note of what the fluid gives.
    pub(crate) fn add(&mut self, impulse: Impulse) {
        self.impulse = self.impulse + impulse;
    }

    /// Takes note of what else changes its velocity, m/s.
    pub(crate) fn add_external(&mut self, change: Vec3) {
        self.external += change;
    }

    /// Whether it has kept its velocities to a tenth of what the push would change of that of some point of it. What nothing pushes is not
    /// held.
    pub(crate) fn holds(&self, body: &RigidBody) -> bool {
        let properties = body.mass_properties();
        let extent = properties.max_extent();
        let linear = self.external + self.impulse.linear * properties.effective_inv_mass;
        let angular = properties.effective_world_inv_inertia * self.impulse.angular;
        let push = linear.length() + angular.length() * extent;
        let (linear, angular) = (body.linvel() - self.linear_velocity, body.angvel() - self.angular_velocity);
        push > 0.0 && linear.length() + angular.length() * extent <= LEFT * push
    }
}
