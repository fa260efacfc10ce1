//! Integrators: how accelerations become velocities and positions.
//!
//! All ten that Pirovano 2011 compares (section 2.3.1), each with one evaluation of the acceleration `f(x, v)` a step. [`oscillator`] has
//! each as an exact step of a linear oscillator: that is their definition, and what their limits are found from.
//!
//! Solvers evaluate accelerations where particles are and move them then: [`Integrator::velocity`], [`Integrator::motion`] and
//! [`Integrator::keep`] are the same steps in that order, from one evaluation to the next, with steps of any length. What a particle
//! keeps is its [`Past`].

pub mod oscillator;
pub mod past;

pub use self::past::Past;

use serde::{Deserialize, Serialize};

/// How accelerations become velocities and positions. `h` is the step, `f(x, v)` the acceleration.
///
/// Equations are those of Pirovano 2011 (P), put right. "Order" is that of positions over a fixed time, first for accelerations that depend on
/// positions alone, then for those that depend on velocities too. "Limit" is the largest stable `omega h` of an oscillator, without damping and
/// with critical damping.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Integrator {
    /// P 2.29: `x' = x + v h`, `v' = v + f(x, v) h`. Order 1, 1; limit 0, 2. Every oscillation grows.
    ForwardEuler,
    /// P 2.30 (Cromer 1981): `v' = v + f(x, v) h`, `x' = x + v' h`. Order 1, 1; limit 2, 0.828. Keeps nothing.
    #[default]
    SemiImplicitEuler,
    /// P 2.31 (Verlet 1967): `x' = 2 x - x_before + f h^2`, with the velocity one step late, `(x' - x_before) / 2 h`, which `f` sees.
    /// Order 2, 1; limit 2, 0.732. Keeps the last position. Moves as [velocity Verlet](Self::VelocityVerlet) does.
    Verlet,
    /// P 2.32 (Swope et al. 1982): `x' = x + v h + a h^2/2`, `a' = f(x', v)`, `v' = v + (a + a') h/2`. Order 2, 1; limit 2, 0.732. Keeps the
    /// last acceleration.
    VelocityVerlet,
    /// P 2.33, there "corrected" or "modified" velocity Verlet: `u = v + a h/2`, `x' = x + u h`, `a' = f(x', u)`, `v' = u + a' h/2`. Order 2, 1;
    /// limit 2, 0.828. Moves as [leapfrog](Self::Leapfrog) does, and has the velocity of its position besides.
    ModifiedVelocityVerlet,
    /// P 2.34: `x' = x + u h`, `u' = u + f(x', u) h`, with `u` the velocity half a step later than `x`. Order 2, 1; limit 2, 0.828.
    Leapfrog,
    /// P 2.35, prediction and relaxation (Clavet, Beaudoin & Poulin 2005) with all forces at once: `y = x + v h`, `x' = y + f(y, v) h^2`,
    /// `v' = (x' - x)/h`. Order 1, 1; limit 1.155, 0.667. It takes much energy. Keeps nothing.
    Clavet,
    /// P 2.36 (Beeman 1976): `x' = x + v h + (4 a - a_before) h^2/6`, `a' = f(x', v)`, `v' = v + (2 a' + 5 a - a_before) h/6`. Order 2, 1; limit 2,
    /// 0.534. Keeps two accelerations.
    Beeman,
    /// P 2.37: Beeman's, with `a' = f(x', u)`, `u = v + (3 a - a_before) h/2`. Order 2, 2; limit 2, 0.294. Keeps two accelerations.
    VelocityCorrectedBeeman,
    /// P 2.38: the same, then `x' = x + v h + (a' + 2 a) h^2/6`, `v' = v + (5 a' + 8 a - a_before) h/12`. Order 3, 2; limit 0, 0.260: every
    /// oscillation grows, slowly. Keeps two accelerations.
    PositionCorrectedBeeman,
}

impl Integrator {
    /// All, in the order of the source.
    pub const ALL: [Self; 10] = [
        Self::ForwardEuler,
        Self::SemiImplicitEuler,
        Self::Verlet,
        Self::VelocityVerlet,
        Self::ModifiedVelocityVerlet,
        Self::Leapfrog,
        Self::Clavet,
        Self::Beeman,
        Self::VelocityCorrectedBeeman,
        Self::PositionCorrectedBeeman,
    ];

    /// Name, as in tables and panels.
    pub fn name(self) -> &'static str {
        match self {
            Self::ForwardEuler => "forward Euler",
            Self::SemiImplicitEuler => "semi-implicit Euler",
            Self::Verlet => "Verlet",
            Self::VelocityVerlet => "velocity Verlet",
            Self::ModifiedVelocityVerlet => "modified velocity Verlet",
            Self::Leapfrog => "leapfrog",
            Self::Clavet => "Clavet",
            Self::Beeman => "Beeman",
            Self::VelocityCorrectedBeeman => "velocity-corrected Beeman",
            Self::PositionCorrectedBeeman => "position-corrected Beeman",
        }
    }

    /// What it is in a solver, for plans; none for those that solvers do not have, under which every oscillation grows.
    pub fn in_solvers(self) -> Option<&'static str> {
        Some(match self {
            Self::ForwardEuler | Self::PositionCorrectedBeeman => return None,
            Self::SemiImplicitEuler => "one force evaluation a substep, energy error bounded",
            Self::Verlet | Self::VelocityVerlet => {
                "of second order; particles keep a vector; velocities are a substep late"
            }
            Self::ModifiedVelocityVerlet | Self::Leapfrog => "of second order; velocities are half a substep late",
            Self::Clavet => "prediction and relaxation, which takes energy",
            Self::Beeman => "of second order; particles keep two accelerations; velocities are a substep late",
            Self::VelocityCorrectedBeeman => {
                "of second order; particles keep two accelerations; short substeps where viscous"
            }
        })
    }
}
