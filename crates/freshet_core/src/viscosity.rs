//! Viscosity models: how a material's dynamic viscosity acts.

use serde::{Deserialize, Serialize};

/// How the [`dynamic_viscosity`](crate::material::Material::dynamic_viscosity) of a fluid acts.
///
/// Fluid sticks to bodies and to the viscous faces of walls: at their surface it has their velocity. Along other faces it slips
/// freely.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ViscosityModel {
    /// Morris, Fox & Zhu 1997 (J. Comput. Phys. 136, 214, eq. 22): `sum_b m_b (mu_a + mu_b)/(rho_a rho_b) F r^2/(r^2 + 0.01 h^2) v_ab`.
    ///
    /// Explicit, so substeps are at most `0.125 rho h^2 / mu`. Momentum is kept exactly, angular momentum is not.
    Morris1997,
}

impl ViscosityModel {
    /// Name, as in plans and panels.
    pub fn name(self) -> &'static str {
        match self {
            ViscosityModel::Morris1997 => "Morris 1997",
        }
    }
}
