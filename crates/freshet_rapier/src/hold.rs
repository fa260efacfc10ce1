//! Whether contacts and joints hold a body in its motion.

use freshet_core::step::Impulse;
use glam::Vec3;
use rapier3d::dynamics::RigidBody;

/// Share of a push's energy that a body may get while it counts as held.
const LEFT: f32 = 0.03;

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

    /// Whether it has taken next to nothing of what pushed it: contacts and joints leave of a push its projection on what they allow, orthogonal by
    /// the body's masses, so that the product of push and change of velocities over the push's with itself is the share that is left. A change across
    /// the push, as contacts make when they settle, is none of it. What nothing pushes is not held.
    ///
    /// Some of what is free to move takes less than that in a tick: a gate on a hinge at its foot in low water, where the hinge carries nearly all. It goes on
    /// moving, and what is held does not. So the velocity that it has by now may be no more of a push than the change.
    pub(crate) fn holds(&self, body: &RigidBody) -> bool {
        let properties = body.mass_properties();
        let linear = self.external * body.mass() + self.impulse.linear;
        let angular = self.impulse.angular;
        let share = |changes: [Vec3; 2]| changes[0].dot(linear) + changes[1].dot(angular);
        let free = share([
            self.external + self.impulse.linear * properties.effective_inv_mass,
            properties.effective_world_inv_inertia * angular,
        ]);
        let changed = share([body.linvel() - self.linear_velocity, body.angvel() - self.angular_velocity]);
        let moves = share([body.linvel(), body.angvel()]);
        free > 0.0 && changed.abs().max(moves.abs()) <= LEFT * free
    }
}
