//! Stage `step_control`: the substep, from the fastest particle and the largest acceleration or pressure.

use freshet_core::plan::{Parameters, PlannedBody};
use freshet_core::pressure_solver::PressureSolver;
use glam::Vec3;

use super::acceleration::Maxima;
use super::body_motion::MovingBody;

/// The longest substep within the limits of `freshet_core`, s.
pub fn limit(
    parameters: &Parameters,
    maxima: &Maxima,
    (planned, bodies): (&[PlannedBody], &[MovingBody]),
    gravity: Vec3,
) -> f32 {
    let speed = bodies.iter().map(MovingBody::speed).fold(maxima.speed_squared.sqrt(), f32::max);
    let limit = match parameters.pressure_solver {
        PressureSolver::WeaklyCompressible => parameters.substep_limit(speed, maxima.acceleration_squared.sqrt()),
        PressureSolver::PositionBased(_)
        | PressureSolver::PressureCorrected(_)
        | PressureSolver::PressurePoisson(_) => parameters.position_based_limit(speed, gravity.length()),
        PressureSolver::DivergenceFree(_) => {
            let pressure = maxima.pressure_term * parameters.rest_density;
            parameters.incompressible_limit(speed, gravity.length(), pressure)
        }
    };
    let of_drag = |(planned, body): (&PlannedBody, &MovingBody)| {
        parameters.drag_limit(planned.samples.len(), body.reach, body.inverse_mass, body.inverse_inertia)
    };
    planned.iter().zip(bodies).map(of_drag).fold(limit, f32::min)
}
