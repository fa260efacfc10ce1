//! Values of the first and the last colour where the user gives none: what the scene is expected to show.

use freshet_core::field::Field;
use freshet_core::plan::Plan;

/// The range of a field in a scene.
pub(crate) fn expected_range(field: Field, plan: &Plan) -> (f32, f32) {
    let p = &plan.parameters;
    let gravity = p.gravity.length().max(1e-3);
    match field {
        Field::Id => (0.0, 1.0),
        Field::Position => {
            let heights = plan.boundary.positions.iter().map(|position| position.y);
            let (low, high) =
                heights.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), y| (low.min(y), high.max(y)));
            if low < high { (low, high) } else { (0.0, 1.0) }
        }
        // Few particles are as fast as the fastest.
        Field::Velocity | Field::Speed => (0.0, 0.6 * p.expected_speed),
        Field::Density => (0.97 * p.rest_density, 1.03 * p.rest_density),
        // Twice sqrt(g D) is the expected speed of a column D deep, and rho g D its pressure.
        Field::Pressure => (0.0, p.rest_density * p.expected_speed * p.expected_speed / 4.0),
        Field::Acceleration => (0.0, 4.0 * gravity),
        Field::RemainingLife => {
            let lives = plan.emitters.iter().map(|emitter| emitter.lifetime).filter(|life| life.is_finite());
            (0.0, lives.fold(1e-3, f32::max))
        }
    }
}
