//! A Poisson equation for the pressure, as in the moving-particle semi-implicit method (MPS, Koshizuka & Oka 1996; Pirovano 2011, section 3.2.1; Krog 2010, section 4.2.2).
//!
//! A substep, as that of [position-based fluids](crate::position_based), whose frame this is, goes first to where particles would be without pressure. There `e_a = rho_a/rho0 - 1`, walls included, is what is
//! too dense (`(n* - n0)/n0` of number densities, with particles of one mass), and the pressure that undoes it solves
//!
//! `lap p = -(rho0/dt^2) e` (Pirovano's eq. 3.2 prints `dt` for `dt^2`; `rho0/dt div v*`, Krog's form, is the same but for the drift that it keeps).
//!
//! With `Q = dt^2 p/rho0^2` and the Laplacian of SPH (Brookshaw 1985; Cummins & Rudman 1999) this is `sum_b w_ab (Q_a - Q_b) + k_a Q_a = e_a`, `w_ab = -(2m/S) F_ab >= 0`, `F = W'(r)/r`:
//!
//! - The weights are those of `D_a(a(P))` of [`DivergenceFree`](crate::pressure_solver::DivergenceFree) for waves that are long beside the spacing: `sum_b 2 (m/rho0) F (p_a - p_b) / G` is exact for a
//!   parabola on the lattice, and `D` has `G/S` of a divergence. Short waves, of which the force does nothing, are filled in by the Laplacian: it is a projection by approximation, and what it leaves is next time's `e`.
//! - Samples of walls add nothing: `dp/dn = 0`. What goes into them is in `e`.
//! - `k_a = m^2/(S G rho0) |sum_b grad W_ab + (rho0/m) sum_k V_k grad W_ak|^2` is how much a particle undoes by its own way, zero among neighbours on all sides. Without it a drop against a wall, all
//!   Neumann, had no solution.
//! - A free surface is where `rho_a < 0.97 rho0` ([`SURFACE`](PressurePoisson::SURFACE)): there `Q = 0`. Elsewhere `Q >= 0`: fluid is pushed, never pulled. What has next to no neighbours has the least `k_a` of any plan.
//!
//! The system is symmetric, has no positive number off its diagonal and none below zero in a row's sum: Jacobi's matrix has eigenvalues up to two at most (Gershgorin), whatever the disorder, and half a step
//! with Nesterov's momentum, as that of `DivergenceFree`, converges. From zero pressure in every substep, until the mean of `|e - A Q|` where it counts (not at surfaces, nor where `Q = 0` and less is wanted) is
//! the [tolerance](PressurePoisson::tolerance) of what it was, or the iterations are over. Then `v += dt a(P)` and `x += dt^2 a(P)`, by the force of every plan, walls included.
//!
//! As each substep begins from zero, what bears a weight is what is too dense after a substep's fall: a spring, as position-based fluids are, whatever the tolerance. Half a metre of water, 8 particles deep,
//! loses 1.8 % of its depth in substeps of 8 ms and 0.37 % in 2 ms, with a tolerance of 0.02 as of 0.002; its pressure is 1.9 % of `rho g D` off (root mean square; 3.2 % on the GPU). All of an error `e` of
//! a density is undone at once, at a speed of `e d/dt`: the shorter the substep, the more energy comes of it. In `freshet_lab stability --quick` no step holds, from a Courant number of 0.1 on: dam breaks
//! gain more than 5 % of energy, and a column at rest loses a particle. Fronts of breaking dams are within 3.2 and 3.9 % of Martin & Moyce's at 20 particles of width (`dam-break --quick`), in the
//! substeps of the plan.

use serde::{Deserialize, Serialize};

use crate::error::{InvalidInput, check_range};

/// How exactly the equation is solved. See the [module](self).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PressurePoisson {
    /// What iterations leave of the mean that they begin with, 1e-4 to 0.5.
    pub tolerance: f32,
    /// Most iterations of a substep, 2 to 1000: the first only finds out what is left to do.
    pub max_iterations: u32,
}

impl Default for PressurePoisson {
    fn default() -> Self {
        Self { tolerance: 0.02, max_iterations: 60 }
    }
}

impl PressurePoisson {
    /// Density over that at rest below which a particle is at a free surface, no unit (Koshizuka & Oka 1996).
    pub const SURFACE: f32 = 0.97;
    /// Share of a Jacobi step: one over the largest eigenvalue there can be.
    pub const RELAXATION: f32 = 0.5;

    pub(crate) fn validate(&self) -> Result<(), InvalidInput> {
        check_range("tolerance", self.tolerance, 1e-4, 0.5, "of what iterations begin with")?;
        match (2..=1000).contains(&self.max_iterations) {
            true => Ok(()),
            false => Err(InvalidInput::new("max_iterations", self.max_iterations, "2 to 1000")),
        }
    }
}
