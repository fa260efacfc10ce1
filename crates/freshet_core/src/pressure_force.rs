//! Forms of the pressure force between particles of a weakly compressible fluid.
//!
//! Both push a pair apart by equal and opposite forces, and give a linear pressure on the rest lattice its exact gradient. Where densities are the same so are the
//! forces; they differ by `m (rho_a - rho_b) (P_a rho_a - P_b rho_b) / (rho_a rho_b) grad W`, with `P = p/rho^2`.
//!
//! The number-density adapted forms of Solenthaler & Pajarola 2008, as forces `-sum (p_a/delta_a^2 + p_b/delta_b^2) grad W` and
//! `-(1/delta_a) sum (p_a + p_b)/delta_b grad W` with `delta_a = sum W_ab`, are these same two: all particles of a scene have one mass `m`, so that
//! `rho = m delta`. They would differ between fluids of different density, of which a scene has one.
//!
//! Walls and bodies push with `P_a` whatever the form: their force is the gradient of the energy that they add.

use serde::{Deserialize, Serialize};

/// How the pressures of two particles become a force.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum PressureForce {
    /// Monaghan 1992 (Annu. Rev. Astron. Astrophys. 30, 543, eq. 3.3): `a_a = -sum_b m (p_a/rho_a^2 + p_b/rho_b^2) grad W_ab`. It keeps the energy of the
    /// densities as they are summed.
    #[default]
    Monaghan,
    /// Mueller, Charypar & Gross 2003 (eq. 10) with the factor that makes it the gradient: `a_a = -(1/rho_a) sum_b m (p_a + p_b)/rho_b grad W_ab`; as printed, with
    /// `2 rho_b`, it is half of that, and a column at rest has twice its pressure. Not with supports of different width.
    Mueller,
}

impl PressureForce {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Monaghan, Self::Mueller];

    /// Name, as in plans and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Monaghan => "Monaghan",
            Self::Mueller => "Mueller",
        }
    }
}
