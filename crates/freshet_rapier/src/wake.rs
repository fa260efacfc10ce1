//! When the fluid wakes a sleeping body, or keeps one from falling asleep.

use freshet_core::step::Impulse;
use glam::Vec3;
use rapier3d::dynamics::RigidBody;

/// A body wakes when the fluid pushes it otherwise than it did when it fell asleep, and stays awake while the push varies.
///
/// The push is compared with its running mean, which stands still while the body sleeps. So a ball at rest in a pond
/// and a stone on its bed both sleep until the water rises, falls or moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WakeRule {
    /// Change of acceleration by the fluid, of any point of the body, that wakes it, m/s2; 0 never lets it sleep,
    /// infinite leaves sleep to rapier alone. Negative counts as 0. Default 0.5, a twentieth of gravity.
    pub acceleration: f32,
    /// Time over which the push is averaged, s; default 0.5, as long as rapier waits before sleep. Less than a tick
    /// takes the last tick alone.
    pub memory: f32,
}

impl Default for WakeRule {
    fn default() -> Self {
        Self { acceleration: 0.5, memory: 0.5 }
    }
}

/// The running mean of the push on one body.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Habit {
    /// Mean force, N, and torque, N m; none before the first impulse.
    mean: Option<(Vec3, Vec3)>,
}

impl Habit {
    /// Takes note of a tick's impulse; says whether it wakes the body.
    pub(crate) fn note(&mut self, rule: WakeRule, impulse: Impulse, duration: f32, body: &RigidBody) -> bool {
        let (force, torque) = (impulse.linear / duration, impulse.angular / duration);
        let (mean_force, mean_torque) = self.mean.unwrap_or((Vec3::ZERO, Vec3::ZERO));
        let properties = body.mass_properties();
        let linear = (force - mean_force) * properties.effective_inv_mass;
        let angular = properties.effective_world_inv_inertia * (torque - mean_torque);
        let change = linear.length() + angular.length() * properties.max_extent();
        if !body.is_sleeping() {
            let share = (duration / rule.memory.max(duration)).min(1.0);
            let (mean_force, mean_torque) = self.mean.unwrap_or((force, torque));
            self.mean = Some((mean_force.lerp(force, share), mean_torque.lerp(torque, share)));
        }
        change >= rule.acceleration
    }
}
