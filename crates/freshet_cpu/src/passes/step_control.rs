//! Stage `step_control`: the substep, from the fastest particle and the largest acceleration.

use freshet_core::plan::Parameters;

use super::acceleration::Maxima;
use super::body_motion::MovingBody;

/// The substep that covers `remaining` seconds in equal parts within the limits of `freshet_core`.
pub fn substep(parameters: &Parameters, maxima: &Maxima, bodies: &[MovingBody], remaining: f32) -> f32 {
    let speed = bodies.iter().map(MovingBody::speed).fold(maxima.speed_squared.sqrt(), f32::max);
    let limit = parameters.substep_limit(speed, maxima.acceleration_squared.sqrt());
    Parameters::equal_substep(remaining, limit)
}
