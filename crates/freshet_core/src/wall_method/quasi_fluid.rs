//! Walls of quasi-fluid samples (Pirovano 2011, section 3.5.3, after Crespo et al. 2007).

use serde::{Deserialize, Serialize};

use crate::error::{InvalidInput, check_range};

/// How the samples of a wall count beside particles. They lie 0.5, 1.5 and 2.5 spacings behind the face, each of the volume of a particle, see
/// [`quasi_fluid`](crate::sampling::quasi_fluid), and have the density that all around them makes, and a pressure by the fluid's equation of state:
///
/// `rho_k = (1/S) (m sum_a W_ak + s rho0 sum_j V_j W_jk)`, `a_a = -(1/G) s rho0 sum_k V_k (p_a/rho_a^2 + p_k/rho_k^2) F x_ak`,
///
/// with `s rho0` the density of the wall. Its pressure is that of `rho_k/s`, as its density at rest is that of its own. A wall that does not move answers to
/// nothing, so that this is the force of an energy: that of all samples is among it, and what a particle loses by it the wall has.
///
/// The source leaves the density open and draws a gap between plain walls and the fluid, gone in the adapted form of Solenthaler & Pajarola 2008, which
/// counts neighbours by their number: `rho_k = m/S sum W`, whatever they weigh. That is the plain form at `s = 1`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum QuasiFluid {
    /// Each sample counts with its mass.
    Plain {
        /// `s`, density of the wall over that of the fluid at rest, 0.1 to 10.
        relative_density: f32,
    },
    /// Each sample counts as a particle of the fluid.
    Adapted,
}

impl QuasiFluid {
    /// A wall twice as dense as the fluid, about that of stone in water.
    pub const PLAIN: Self = Self::Plain { relative_density: 2.0 };

    /// `s`.
    pub fn relative_density(self) -> f32 {
        match self {
            Self::Plain { relative_density } => relative_density,
            Self::Adapted => 1.0,
        }
    }

    pub(super) fn validate(self) -> Result<(), InvalidInput> {
        check_range("relative_density", self.relative_density(), 0.1, 10.0, "times that of the fluid")
    }
}
