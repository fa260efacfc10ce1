//! Equations of state: pressure from density.
//!
//! Densities are in kg/m3, pressures in Pa, speeds in m/s. All are stated so that their slope `dp/drho` is the square of a
//! speed of sound, which is what the time step and the compressibility depend on.

use serde::{Deserialize, Serialize};

use crate::error::{InvalidInput, check_range};

/// How pressure follows from density.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum EquationOfState {
    /// Ideal gas, `p = k rho` (K §4.2): never zero at rest, so it fills its container.
    IdealGas {
        /// `k` in m2/s2 (J/kg), 1e-6 to 1e8.
        stiffness: f32,
    },
    /// Desbrun & Gascuel 1996, `p = k (rho - rho0)` (P, K): zero at rest density.
    Desbrun {
        /// `k` in m2/s2 (J/kg), 1e-6 to 1e8.
        stiffness: f32,
    },
    /// Harada et al. 2007, `p = P0 + k (rho - rho0)` (K 4.17, which misprints it).
    Harada {
        /// `P0`, the pressure at rest density, in Pa, 0 to 1e9.
        reference_pressure: f32,
        /// `k` in m2/s2 (J/kg), 1e-6 to 1e8.
        stiffness: f32,
    },
    /// Tait in Monaghan's 1994 form, `p = rho0 c^2 / n ((rho/rho0)^n - 1)` (P, K, E): stiffer the more it is compressed.
    Tait {
        /// `c`, the speed of sound at rest density, in m/s, 1e-3 to 1e4. Ten times the fastest flow keeps compression
        /// near 1 %.
        sound_speed: f32,
        /// `n`, no unit, 1 to 20; 7 for water.
        exponent: f32,
    },
    /// Linear, `p = c^2 (rho - rho0)`: Desbrun's, given by the speed of sound.
    Linear {
        /// `c` in m/s, 1e-3 to 1e4.
        sound_speed: f32,
    },
}

impl EquationOfState {
    /// Pressure in Pa at `density`, for a fluid of `rest_density`, both in kg/m3 and positive.
    ///
    /// Below rest density all but the ideal gas and Harada's go negative: see [`PressureLaw::clamp_negative`].
    #[inline]
    pub fn pressure(&self, rest_density: f64, density: f64) -> f64 {
        match *self {
            EquationOfState::IdealGas { stiffness } => f64::from(stiffness) * density,
            EquationOfState::Desbrun { stiffness } => f64::from(stiffness) * (density - rest_density),
            EquationOfState::Harada { reference_pressure, stiffness } => {
                f64::from(reference_pressure) + f64::from(stiffness) * (density - rest_density)
            }
            EquationOfState::Tait { sound_speed, exponent } => {
                let (c, n) = (f64::from(sound_speed), f64::from(exponent));
                let ratio = density / rest_density;
                // Water's exponent; the general power takes thirty times as long.
                let power = if exponent == 7.0 { ratio.powi(7) } else { ratio.powf(n) };
                rest_density * c * c / n * (power - 1.0)
            }
            EquationOfState::Linear { sound_speed } => f64::from(sound_speed).powi(2) * (density - rest_density),
        }
    }

    /// The speed of sound `sqrt(dp/drho)` at rest density, in m/s.
    ///
    /// Of none of these does it depend on the rest density; a future equation may.
    pub fn sound_speed(&self, _rest_density: f64) -> f64 {
        match *self {
            EquationOfState::IdealGas { stiffness }
            | EquationOfState::Desbrun { stiffness }
            | EquationOfState::Harada { stiffness, .. } => f64::from(stiffness).sqrt(),
            EquationOfState::Tait { sound_speed, .. } | EquationOfState::Linear { sound_speed } => {
                f64::from(sound_speed)
            }
        }
    }

    /// Checks every parameter against the range in its documentation.
    ///
    /// # Errors
    /// Names the first parameter out of range.
    pub fn validate(&self) -> Result<(), InvalidInput> {
        match *self {
            EquationOfState::IdealGas { stiffness } | EquationOfState::Desbrun { stiffness } => {
                check_stiffness(stiffness)
            }
            EquationOfState::Harada { reference_pressure, stiffness } => {
                check_range("reference_pressure", reference_pressure, 0.0, 1.0e9, "Pa")?;
                check_stiffness(stiffness)
            }
            EquationOfState::Tait { sound_speed, exponent } => {
                check_sound_speed(sound_speed)?;
                check_range("exponent", exponent, 1.0, 20.0, "(no unit)")
            }
            EquationOfState::Linear { sound_speed } => check_sound_speed(sound_speed),
        }
    }

    /// The name in `snake_case`, as charts and file names use it.
    pub fn name(&self) -> &'static str {
        match self {
            EquationOfState::IdealGas { .. } => "ideal_gas",
            EquationOfState::Desbrun { .. } => "desbrun",
            EquationOfState::Harada { .. } => "harada",
            EquationOfState::Tait { .. } => "tait",
            EquationOfState::Linear { .. } => "linear",
        }
    }
}

/// An equation of state and what becomes of negative pressure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PressureLaw {
    /// Pressure from density.
    pub equation: EquationOfState,
    /// Takes negative pressure as zero (E eq. 9): at a free surface, where the density sum lacks neighbours, particles would
    /// otherwise be pulled into clumps.
    pub clamp_negative: bool,
}

impl PressureLaw {
    /// Pressure in Pa at `density`, for a fluid of `rest_density`, both in kg/m3 and positive.
    #[inline]
    pub fn pressure(&self, rest_density: f64, density: f64) -> f64 {
        let pressure = self.equation.pressure(rest_density, density);
        // Not f64::max, which would turn not-a-number into a harmless zero.
        if self.clamp_negative && pressure < 0.0 { 0.0 } else { pressure }
    }

    /// Checks the equation of state, see [`EquationOfState::validate`].
    ///
    /// # Errors
    /// Names the first parameter out of range.
    pub fn validate(&self) -> Result<(), InvalidInput> {
        self.equation.validate().map_err(|error| error.inside("equation"))
    }
}

fn check_stiffness(stiffness: f32) -> Result<(), InvalidInput> {
    check_range("stiffness", stiffness, 1.0e-6, 1.0e8, "m2/s2")
}

fn check_sound_speed(sound_speed: f32) -> Result<(), InvalidInput> {
    check_range("sound_speed", sound_speed, 1.0e-3, 1.0e4, "m/s")
}
