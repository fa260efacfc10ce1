//! How many substeps to encode before the GPU has said how many it needs.

use freshet_core::plan::Parameters;
use freshet_core::pressure_solver::PressureSolver;

/// Substeps encoded beyond the predicted ones; those not needed dispatch nothing.
pub(crate) const SPARE_SUBSTEPS: u32 = 2;

/// Iterations encoded beyond those that the last ticks needed at most.
const SPARE_ITERATIONS: u32 = 1;

/// Iterations of each of the two solves encoded before any are known: as many as a fluid at rest takes to start.
const FIRST_ITERATIONS: [u32; 2] = [16, 4];

/// The number of iterations to encode, when the last known substeps needed at most `known` (zero for none).
pub(crate) fn iterations_to_encode(known: [u32; 2]) -> [u32; 2] {
    if known == [0; 2] { FIRST_ITERATIONS } else { known.map(|most| most + SPARE_ITERATIONS) }
}

/// The number of substeps to encode for `asked` seconds, when the last known substep was `last` seconds (zero for none).
/// A tick of no length takes one, which evaluates the stages and moves nothing.
pub(crate) fn substeps_to_encode(parameters: &Parameters, asked: f32, last: f32) -> u32 {
    if asked <= 0.0 {
        return 1;
    }
    let known = if last > 0.0 { last } else { first_limit(parameters) };
    let predicted = (asked / known - 1e-3).ceil().clamp(1.0, 1e6) as u32;
    // Where substeps are made again, those taken back have a place each, and the last one is judged in one more.
    let again = if parameters.redo_substeps { 1 + Parameters::MOST_REDOS } else { 0 };
    predicted.saturating_add(SPARE_SUBSTEPS).min(parameters.max_substeps).saturating_add(again)
}

/// The substep at the expected speed, before there was one.
fn first_limit(parameters: &Parameters) -> f32 {
    let (speed, gravity) = (parameters.expected_speed, parameters.gravity.length());
    match parameters.pressure_solver {
        PressureSolver::WeaklyCompressible => parameters.substep_limit(speed, gravity),
        PressureSolver::PositionBased(_)
        | PressureSolver::PressureCorrected(_)
        | PressureSolver::PressurePoisson(_) => parameters.position_based_limit(speed, gravity),
        // What is that fast has fallen from where the pressure was as much.
        PressureSolver::DivergenceFree(_) => parameters.incompressible_limit(speed, gravity, 0.5 * speed * speed),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use freshet_core::plan::Plan;
    use freshet_core::scene::{FluidScene, Volume};
    use glam::Vec3;

    #[test]
    fn follows_the_last_substep_and_starts_from_the_expected_speed() {
        let scene =
            FluidScene { volumes: vec![Volume::block(Vec3::splat(0.5), Vec3::ZERO)], ..FluidScene::with_spacing(0.1) };
        let parameters = Plan::new(&scene).unwrap().parameters;
        assert_eq!(substeps_to_encode(&parameters, 0.01, 0.001), 10 + SPARE_SUBSTEPS);
        assert_eq!(substeps_to_encode(&parameters, 0.0, 0.001), 1);
        let limit = parameters.substep_limit(parameters.expected_speed, 9.81);
        assert_eq!(substeps_to_encode(&parameters, 3.0 * limit, 0.0), 3 + SPARE_SUBSTEPS);
        assert_eq!(substeps_to_encode(&Parameters { max_substeps: 4, ..parameters }, 1.0, 1e-3), 4);
    }
}
