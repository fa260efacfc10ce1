//! How much arithmetic a substep takes, counted from its formulas: what a measured time is to be compared with.
//!
//! Additions, subtractions, multiplications, comparisons, roundings, quotients and roots are one operation each, a multiply-add
//! is two, a general power [`POWER`]. Terms are counted as `freshet_cpu` writes them; the GPU solver's shaders differ by a few.
//! Pairs are the particles that a support ball holds at rest. Left out is whatever a solver does besides: candidates out of
//! reach, samples of walls and bodies, moving data.

use std::f64::consts::PI;

use crate::equation_of_state::EquationOfState;
use crate::kernel::KernelKind;
use crate::plan::{Parameters, StageKind};
use crate::pressure_force::PressureForce;
use crate::pressure_solver::PressureSolver;
use crate::variable_support;

/// Operations that a power with an exponent other than 7 counts as.
pub const POWER: u32 = 30;

/// Difference of two positions: three subtractions, three multiply-adds.
const DISTANCE: u32 = 9;
/// `min(r/H, 1)` from a squared distance: root, factor, comparison.
const RELATIVE: u32 = 3;
/// Three multiply-adds into a vector.
const ADD_VECTOR: u32 = 6;

/// Operations of a stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// For each particle.
    pub per_particle: u32,
    /// For each pair of a particle and a neighbour, itself included; each pair counts for both of its particles.
    pub per_pair: u32,
}

impl Work {
    /// Of a stage. Stages of bodies and of the step count nothing: they have no share for every particle.
    pub fn of(stage: StageKind, parameters: &Parameters) -> Self {
        let (shape, slope) = (of_kernel(parameters.kernel).0, of_kernel(parameters.pressure_kernel).1);
        // Sum of two widths, quotient, factor of the distance; and what a power of it takes.
        let width = |power: u32| if parameters.widest_support > 1.0 { 3 + power } else { 0 };
        match stage {
            // Cell of a position.
            StageKind::Sort => Self { per_particle: 3 * 2, per_pair: 0 },
            StageKind::Density => {
                if parameters.density.is_carried() {
                    // Difference of velocities, way back, v.x; what is carried and the density of it, pressure and compression.
                    let per_pair = DISTANCE + 3 + ADD_VECTOR + RELATIVE + slope + 5 + 2;
                    return Self { per_particle: 3 + 2 + of_pressure(parameters) + 2 + 7, per_pair };
                }
                let of_density = DISTANCE + RELATIVE + shape + 2 + width(3);
                match parameters.pressure_solver {
                    // p / rho^2 and the compression.
                    PressureSolver::WeaklyCompressible
                    | PressureSolver::PositionBased(_)
                    | PressureSolver::PressureCorrected(_)
                    | PressureSolver::PressurePoisson(_) => {
                        Self { per_particle: of_pressure(parameters) + 2 + 7, per_pair: of_density }
                    }
                    // The system's diagonal and the compression.
                    PressureSolver::DivergenceFree(_) => {
                        Self { per_particle: 9 + 7, per_pair: of_density + slope + ADD_VECTOR + 4 }
                    }
                }
            }
            // The sum of each evaluation; its cube, quotient, root and limits.
            StageKind::Support => {
                let evaluations = variable_support::EVALUATIONS;
                let per_pair = evaluations * (DISTANCE + RELATIVE + 1 + shape + 1);
                Self { per_particle: evaluations * (2 + 4 + POWER + 3), per_pair }
            }
            StageKind::Acceleration => {
                let mueller = parameters.pressure_force == PressureForce::Mueller;
                // Mueller's form takes the way of the artificial viscosity, whether there is any or not.
                let (artificial, physical) =
                    (mueller || parameters.artificial_viscosity > 0.0, parameters.dynamic_viscosity > 0.0);
                let mut per_pair = DISTANCE + RELATIVE + slope + 2 + ADD_VECTOR + width(4);
                if artificial || physical {
                    // Difference of velocities.
                    per_pair += 3;
                }
                if artificial {
                    // v.x, its factor, divisor, quotient, subtraction.
                    per_pair += 5 + 1 + 3 + 2;
                }
                if physical {
                    // Divisor, dividend, quotient, slope, vector.
                    per_pair += 3 + 1 + 1 + 1 + ADD_VECTOR;
                }
                if parameters.has_own_viscosity_kernel() {
                    // A loop of its own.
                    per_pair += DISTANCE + RELATIVE + 3 + of_kernel(parameters.viscosity_kernel).1;
                }
                if mueller {
                    // A loop of its own: differences of densities and pressures, divisor, dividend, quotient, product.
                    per_pair += DISTANCE + RELATIVE + slope + 6 + ADD_VECTOR;
                }
                if parameters.tensile_correction > 0.0 {
                    // A loop of its own: kernel and its fourth power, tensions, choice, product.
                    let shape = of_kernel(parameters.pressure_kernel).0;
                    per_pair += DISTANCE + RELATIVE + shape + slope + 3 + 7 + 2 + ADD_VECTOR;
                }
                if parameters.near_pressure > 0.0 {
                    // A loop of its own.
                    per_pair += DISTANCE + RELATIVE + 1 + 3 + 2 + ADD_VECTOR;
                }
                // Gravity and factor, squared speed and acceleration with their maxima.
                Self { per_particle: ADD_VECTOR + 2 * 6, per_pair }
            }
            StageKind::Integrate => Self { per_particle: 2 * ADD_VECTOR, per_pair: 0 },
            // Of one iteration of a Poisson equation: a sum of pressures, and the next.
            StageKind::PositionSolve if matches!(parameters.pressure_solver, PressureSolver::PressurePoisson(_)) => {
                Self { per_particle: 14, per_pair: DISTANCE + RELATIVE + slope + 2 }
            }
            // Of one iteration: sums as those of an incompressible fluid's densities, and as that of pressures; the move.
            StageKind::PositionSolve => {
                let sums = DISTANCE + RELATIVE + shape + 2 + slope + ADD_VECTOR + 4;
                Self {
                    per_particle: 9 + 6 + 2 * ADD_VECTOR,
                    per_pair: sums + DISTANCE + RELATIVE + slope + 2 + ADD_VECTOR,
                }
            }
            // Of one iteration: a sum as that of pressures, one of rates, and the next pressure.
            StageKind::DivergenceSolve | StageKind::DensitySolve => {
                let per_pair = 2 * (DISTANCE + RELATIVE + slope + 2 + ADD_VECTOR) + 2;
                Self { per_particle: ADD_VECTOR + 14, per_pair }
            }
            // Difference of velocities, sum of densities, quotient; acceleration before, factor after.
            StageKind::Xsph => {
                let per_pair = DISTANCE + RELATIVE + shape + 3 + 1 + 1 + ADD_VECTOR;
                Self { per_particle: ADD_VECTOR + 3, per_pair }
            }
            // Of particles beside such walls only.
            StageKind::Friction
            | StageKind::BodyFriction
            | StageKind::WallForce
            | StageKind::WallCollision
            | StageKind::BodySort
            | StageKind::BodyDensity
            | StageKind::WallDensity
            | StageKind::BodyDrag
            | StageKind::BodyLoad
            | StageKind::StepControl
            | StageKind::BodyMotion => Self::default(),
        }
    }

    /// For each particle with the pairs of `neighbours` others, itself among them.
    pub fn with(self, neighbours: f64) -> f64 {
        f64::from(self.per_particle) + neighbours * f64::from(self.per_pair)
    }
}

/// Particles within the support at rest, on average, the one in its middle included: `4 pi/3 (H/d)^3`.
pub fn neighbours(parameters: &Parameters) -> f64 {
    4.0 / 3.0 * PI * f64::from(parameters.support_radius / parameters.spacing).powi(3)
}

/// Operations of `f(q)` and of `f'(q)/q`.
fn of_kernel(kernel: KernelKind) -> (u32, u32) {
    match kernel {
        KernelKind::Gaussian => (25, 25),
        KernelKind::CubicSpline => (10, 8),
        KernelKind::QuinticSpline => (22, 24),
        KernelKind::Quadratic => (2, 4),
        KernelKind::Quartic => (8, 4),
        KernelKind::WendlandC2 => (6, 4),
        KernelKind::WendlandNotch => (18, 16),
        KernelKind::Poly6 => (6, 6),
        KernelKind::Spiky => (3, 5),
        // In viscous forces only.
        KernelKind::Viscosity => (0, 2),
    }
}

/// Operations of a pressure.
fn of_pressure(parameters: &Parameters) -> u32 {
    let law = parameters.pressure_law;
    let equation = match law.equation {
        EquationOfState::IdealGas { .. } => 1,
        EquationOfState::Desbrun { .. } | EquationOfState::Linear { .. } => 2,
        EquationOfState::Harada { .. } => 3,
        // Ratio, power, one less, factor; the seventh power is four multiplications.
        EquationOfState::Tait { exponent, .. } => 3 + if exponent == 7.0 { 4 } else { POWER },
    };
    equation + u32::from(law.clamp_negative)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::plan::{Plan, SceneError};
    use crate::scene::{FluidScene, Volume};

    fn parameters(change: impl Fn(&mut FluidScene)) -> Result<Parameters, SceneError> {
        let mut scene =
            FluidScene { volumes: vec![Volume::block(Vec3::splat(0.5), Vec3::ZERO)], ..FluidScene::with_spacing(0.1) };
        change(&mut scene);
        Ok(Plan::new(&scene)?.parameters)
    }

    /// By hand, from `passes/density.rs` and `passes/acceleration.rs` with `simd_kernel.rs`' Wendland C2.
    #[test]
    fn the_default_scene_is_as_counted_by_hand() -> Result<(), SceneError> {
        let parameters = parameters(|_| ())?;
        // dx dy dz 3, r^2 6, root and factor 2, min 1; 1-q, two squares, line, product 6; multiply-add 2.
        let density = Work { per_particle: 17, per_pair: 20 };
        assert_eq!(Work::of(StageKind::Density, &parameters), density);
        // dx and r^2 9, dv 3, P+P 1, v.x 5, factor 1, divisor 3, quotient and difference 2, slope 3 + 4, product 1, sum 6.
        let acceleration = Work { per_particle: 18, per_pair: 38 };
        assert_eq!(Work::of(StageKind::Acceleration, &parameters), acceleration);
        assert!((neighbours(&parameters) - 33.510_32).abs() < 1e-3);
        assert!((density.with(10.0) - 217.0).abs() < 1e-12);
        Ok(())
    }

    #[test]
    fn what_a_plan_leaves_out_is_not_counted() -> Result<(), SceneError> {
        let calm = parameters(|scene| scene.settings.artificial_viscosity = 0.0)?;
        assert_eq!(Work::of(StageKind::Acceleration, &calm).per_pair, 24);
        let near = parameters(|scene| {
            scene.settings.artificial_viscosity = 0.0;
            scene.settings.near_pressure = 0.01;
        })?;
        assert_eq!(Work::of(StageKind::Acceleration, &near).per_pair, 24 + 24);
        let mueller = parameters(|scene| {
            scene.settings.artificial_viscosity = 0.0;
            scene.settings.pressure_force = PressureForce::Mueller;
        })?;
        // What there is with viscosity, and a loop as that without any, whose strength takes 6.
        assert_eq!(Work::of(StageKind::Acceleration, &mueller).per_pair, 38 + 24 - 2 + 6);
        // As density without its factor, and: dv 3, rho + rho 1, quotient 1, sum 6.
        assert_eq!(Work::of(StageKind::Xsph, &calm).per_pair, 18 + 11);
        // As density, a factor more, without its multiply-add: each of the evaluations. Then widths, and powers of them.
        let wide = parameters(|scene| {
            scene.settings.artificial_viscosity = 0.0;
            scene.settings.widest_support = 1.5;
        })?;
        assert_eq!(Work::of(StageKind::Support, &wide).per_pair, 4 * (18 + 2));
        assert_eq!(Work::of(StageKind::Density, &wide).per_pair, 20 + 3 + 3);
        assert_eq!(Work::of(StageKind::Acceleration, &wide).per_pair, 24 + 3 + 4);
        assert_eq!(Work::of(StageKind::BodyLoad, &calm), Work::default());
        Ok(())
    }
}
