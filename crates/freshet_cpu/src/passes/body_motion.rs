//! Stage `body_motion`: bodies move by the fluid's force within the tick.

use freshet_core::plan::Parameters;
use freshet_core::snapshot::{BodyPose, Exchange};
use freshet_core::step::{BodyInput, Impulse};
use glam::{Mat3, Quat, Vec3};

/// How a body moves or is accelerated: its centre of mass, and about it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// m/s or m/s2.
    pub linear: Vec3,
    /// rad/s or rad/s2, world axes.
    pub angular: Vec3,
}

/// A body during a tick.
#[derive(Clone, Copy, Debug, Default)]
pub struct MovingBody {
    /// Centre of mass, m.
    pub position: Vec3,
    /// Orientation.
    pub rotation: Quat,
    /// m/s.
    pub linear_velocity: Vec3,
    /// rad/s, world axes.
    pub angular_velocity: Vec3,
    /// 1/kg.
    pub inverse_mass: f32,
    /// 1/(kg m2), world axes, kept from the tick's start.
    pub inverse_inertia: Mat3,
    /// The largest distance of a sample from the centre of mass, m.
    pub reach: f32,
    /// m/s2, from everything but the fluid.
    pub acceleration: Vec3,
    /// Velocity that takes the body in this tick from where the last one left it to where it should be, m/s.
    pub drift: Vec3,
    /// The same for its orientation, rad/s, world axes.
    pub turn: Vec3,
    /// How far it has [swollen](freshet_core::swelling), 0 to 1.
    pub swollen: f32,
    /// What the fluid gave in this tick so far.
    pub impulse: Impulse,
}

impl MovingBody {
    /// The body at the start of tick `tick`: as its engine knows it, plus what the engine has not heard of yet.
    pub fn begin(input: &BodyInput, reach: f32, exchanges: &[Exchange], tick: u64, duration: f32) -> Self {
        let mut body = Self {
            position: input.position,
            rotation: input.rotation,
            linear_velocity: input.linear_velocity,
            angular_velocity: input.angular_velocity,
            inverse_mass: input.inverse_mass,
            inverse_inertia: input.inverse_inertia,
            reach,
            acceleration: input.acceleration,
            drift: Vec3::ZERO,
            turn: Vec3::ZERO,
            swollen: 1.0,
            impulse: Impulse::default(),
        };
        for exchange in exchanges {
            let Some(past) = exchange.tick_plus_one.checked_sub(1) else { continue };
            if past < input.corrected_before || past >= tick {
                continue;
            }
            let velocity = exchange.error.linear * body.inverse_mass;
            let turn = body.inverse_inertia * exchange.error.angular;
            body.linear_velocity += velocity;
            body.angular_velocity += turn;
            if input.free {
                let late = ((tick - past) as f32 - 0.5) * duration;
                body.position += velocity * late;
                body.rotation = (Quat::from_scaled_axis(turn * late) * body.rotation).normalize();
            }
        }
        body
    }

    /// How far it has swollen where it begins, if the last tick left it at `left`: not at all where it is new, or elsewhere.
    pub fn swollen_since(&self, left: Option<&BodyPose>, given: &BodyInput, parameters: &Parameters) -> f32 {
        let Some(left) = left else { return 0.0 };
        let (way, angle) = (self.position.distance(left.position), self.turn_from(left).length());
        let jumps = given.placed || way > parameters.body_reach();
        if jumps && parameters.is_put_elsewhere(way, angle, self.reach) { 0.0 } else { left.swollen }
    }

    /// The turn that takes it from its orientation there to its own, the shorter way round: axis times angle, rad.
    fn turn_from(&self, left: &BodyPose) -> Vec3 {
        let turned = (self.rotation * left.rotation.conjugate()).normalize();
        if turned.w < 0.0 { -turned } else { turned }.to_scaled_axis()
    }

    /// Lets the body start from `left`, where the last tick left it, and drift to its place within `duration` seconds, no
    /// faster than the flow is expected to be. From beyond [`Parameters::body_reach`] it jumps.
    ///
    /// What contacts and joints do to a body the solver learns a tick later. A body that jumped there would find fluid where it
    /// had made room for itself a moment ago.
    pub fn continue_from(&mut self, left: &BodyPose, duration: f32, parameters: &Parameters) {
        let (limit, reach) = (parameters.expected_speed, parameters.body_reach());
        let away = self.position - left.position;
        if duration <= 0.0 || away.length() > reach {
            return;
        }
        self.drift = (away / duration).clamp_length_max(limit);
        self.turn = (self.turn_from(left) / duration).clamp_length_max(limit / reach);
        self.position = left.position;
        self.rotation = left.rotation;
    }

    /// Velocity of its surface at a place so far from its centre of mass, m/s.
    pub fn surface_velocity(&self, arm: Vec3) -> Vec3 {
        self.linear_velocity + self.drift + (self.angular_velocity + self.turn).cross(arm)
    }

    /// What no sample is faster than, m/s.
    pub fn speed(&self) -> f32 {
        (self.linear_velocity + self.drift).length() + (self.angular_velocity + self.turn).length() * self.reach
    }

    /// How it is accelerated by `force` (N) and `torque` (N m) alone.
    pub fn answer(&self, force: Vec3, torque: Vec3) -> Motion {
        Motion { linear: force * self.inverse_mass, angular: self.inverse_inertia * torque }
    }

    /// How it would move within `dt` seconds by `force` and `torque`, what takes it to its place included: see
    /// [`advance`](Self::advance).
    pub fn ahead(&self, force: Vec3, torque: Vec3, dt: f32) -> Motion {
        let answer = self.answer(force, torque);
        Motion {
            linear: self.linear_velocity + self.drift + dt * (answer.linear + self.acceleration),
            angular: self.angular_velocity + self.turn + dt * answer.angular,
        }
    }

    /// Where it is.
    pub fn pose(&self) -> BodyPose {
        BodyPose { position: self.position, rotation: self.rotation, swollen: self.swollen }
    }

    /// Moves by `force` (N) and `torque` (N m) over `dt` seconds, velocities first.
    pub fn advance(&mut self, force: Vec3, torque: Vec3, dt: f32) {
        self.impulse.linear += force * dt;
        self.impulse.angular += torque * dt;
        let answer = self.answer(force, torque);
        self.linear_velocity += dt * (answer.linear + self.acceleration);
        self.angular_velocity += dt * answer.angular;
        self.position += dt * (self.linear_velocity + self.drift);
        self.rotation = (Quat::from_scaled_axis((self.angular_velocity + self.turn) * dt) * self.rotation).normalize();
    }
}

/// Remembers a tick's exchange in place of the oldest.
pub fn remember(exchanges: &mut [Exchange; 4], tick: u64, given: Impulse, forecast: Impulse) {
    exchanges[(tick % 4) as usize] = Exchange { tick_plus_one: tick + 1, error: given - forecast };
}
