//! Position-based fluids (Macklin & Mueller 2013): particles go where they would without pressure, are moved apart there a fixed number of times, and have the velocity of the way that
//! they made.
//!
//! Constraints are `C_a = rho_a/rho0 - 1 <= 0`, walls included, with the density sum of every plan. With `c = m/(S rho0)`, an iteration moves all particles at once:
//!
//! - `lambda_a = omega max(C_a, 0) / (c^2 (|g_a|^2 + sum_b |grad W_ab|^2) + epsilon)`, `g_a = sum_b grad W_ab + rho0/m sum_k V_k grad W_ak` (eqs. 8 to 11; there with `rho0`
//!   alone, without walls, and with the sign in `lambda`),
//! - `x_a -= c [sum_b (lambda_a + lambda_b) grad W_ab + rho0/m sum_k V_k lambda_a grad W_ak]` (eq. 12): equal and opposite within the fluid.
//!
//! In the terms of [`DivergenceFree`](crate::pressure_solver::DivergenceFree), whose diagonal is `K_a`, this is `x_a += dt^2 a_a(P)` with `dt^2 P_a = omega max(C_a, 0) / (max(K_a, least) + softness K)`:
//! solvers have it so, `p_a = rho_a^2 sum P_a` over the iterations is the pressure of a substep, and `K` that of the lattice. All particles at once is a Jacobi step, which diverges above twice one over
//! the [largest eigenvalue](crate::pressure_solver::largest_eigenvalue) of `C` over its diagonal; `omega` is [`RELAXATION`](PositionBased::RELAXATION) over that, 0.5 at H = 2d. The source has one, and sums over
//! more neighbours. Its artificial pressure against clumping (eq. 13) is left out, as densities too small are left alone.
//!
//! A substep, as solvers have it: particles are sorted where they would be without pressure (`x*`); their neighbours are those of there for all iterations, densities and gradients of these are those of where they have
//! been moved to; then `v += (x - x*)/dt` with the `dt` that led to `x*`, then gravity and viscosity by the neighbours at `x*`, the next `dt` and `x* = x + v dt`. Between
//! substeps particles are at `x*`, and positions, velocities and speeds that are read, and those of snapshots, are those of the way to there, which pressure is still
//! to change: a fluid at rest has a velocity of `g dt` down, 82 mm/s at 1/120 s, though it stays where it is. What particles move by is the difference of their places.
//!
//! What the fixed number of iterations does not undo stays: the fluid gives in like a spring. An iteration pushes with `C/K`, so that `n` of them hold the pressure `p` at a compression of
//! about `p dt^2 / (rho0 n omega d^2)` times a number of the kernel: stiffness is that of iterations and step, not of the material, and a deeper column sinks in further (`freshet_lab validate --case
//! position-based`). By default half a metre of
//! water, 8 particles deep, loses 2.3 % of its depth in substeps of 8 ms, 0.7 % with 32 iterations and 0.4 % in substeps of 2 ms, 20 particles deep 9.7, 1.6 and 0.8 %; its pressure is that of the weight above within 2 % in all of these. Nor is the
//! energy conserved: a density too large by `e` is undone at a speed of `e d/dt`, from nothing, the faster the shorter the substep. By the measures of
//! `freshet_lab stability` (energy within 5 %, mean compression within 5 %) it fails at both ends. Fronts of breaking dams are as near to experiments as with the other solvers.

use serde::{Deserialize, Serialize};

use crate::error::{InvalidInput, check_range};

/// How often and how far particles are moved apart. See the [module](self).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PositionBased {
    /// Iterations of a substep, 1 to 1000.
    pub iterations: u32,
    /// `epsilon` over the sum of squares of the rest lattice, 0 to 10: softens what has few neighbours.
    pub softness: f32,
}

impl Default for PositionBased {
    fn default() -> Self {
        Self { iterations: 4, softness: 0.02 }
    }
}

impl PositionBased {
    /// Share of a Jacobi step times the largest eigenvalue of the lattice, no unit: from 2 on it diverges.
    pub const RELAXATION: f32 = 1.3;

    pub(crate) fn validate(&self) -> Result<(), InvalidInput> {
        if !(1..=1000).contains(&self.iterations) {
            return Err(InvalidInput::new("iterations", self.iterations, "1 to 1000"));
        }
        check_range("softness", self.softness, 0.0, 10.0, "times the lattice's sum of squares")
    }
}
