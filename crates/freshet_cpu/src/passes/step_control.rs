//! Stage `step_control`: the substep, from the fastest particle and the largest acceleration or pressure.

use freshet_core::plan::Parameters;
use freshet_core::pressure_solver::PressureSolver;
use glam::Vec3;

use super::acceleration::Maxima;
use super::body_motion::MovingBody;

/// The longest substep within the limits of `freshet_core`, s.
pub fn limit(parameters: &Parameters, maxima: &Maxima, bodies: &[MovingBody], gravity: Vec3) -> f32 {
    let speed = bodies.iter().map(MovingBody::speed).fold(maxima.speed_squared.sqrt(), f32::max);
    match parameters.pressure_solver {
        PressureSolver::WeaklyCompressible => parameters.substep_limit(speed, maxima.acceleration_squared.sqrt()),
        PressureSolver::DivergenceFree(_) => {
            let pressure = maxima.pressure_term * parameters.rest_density;
            parameters.incompressible_limit(speed, gravity.length(), pressure)
        }
    }
}

/// The substep that covers `remaining` seconds in equal parts within the limits of `freshet_core`.
pub fn substep(parameters: &Parameters, maxima: &Maxima, bodies: &[MovingBody], gravity: Vec3, remaining: f32) -> f32 {
    Parameters::equal_substep(remaining, limit(parameters, maxima, bodies, gravity))
}
