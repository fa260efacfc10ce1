//! Pressure-corrected SPH (Bao, Zhang, Zheng & Wu 2009; Pirovano 2011, section 3.2.2): pressures change by what velocities compress, velocities by the gradient of that change, so many times a substep.
//!
//! From the equation of continuity and `p = c^2 (rho - rho0)`: `dp/dt = -c^2 rho div v`. An iteration changes pressures by what the substep's velocities, with all changes so far, compress in it, and
//! velocities by `dv = -dt/rho grad dp`. Pirovano's printed `k_P = c^2` in front of that, too, is one too many. What the velocities compress alone lets a density drift that was there before stay
//! for ever. So here a substep, as that of [position-based fluids](crate::position_based), whose frame this is, goes first to where particles would be without pressure, and the density sum
//! there is both: `rho_a(x + dt v) - rho0` is what was there, and the integral of `-rho div v` over the way. An iteration is
//!
//! - `dp_a = c^2 (rho_a - rho0)`, but no more is taken away than there is: pressures stay at or above zero (without that a free surface would be pulled in),
//! - `x_a += dt^2 a_a(dp)`, `v_a += dt a_a(dp)`, by one of two [gradients](PressureGradient).
//!
//! With `P = p/rho0^2`, the density of a fluid that is not compressed (a sum below that lacks neighbours, not mass), the gradients are
//!
//! - *sum* (P 2.7): `a_a = -(1/G) [ m sum_b (P_a + P_b) grad W_ab + rho0 sum_k V_k P_a grad W_ak ]`, equal and opposite in the fluid, with walls as in every plan;
//! - *difference* (P 2.6): `a_a = -(1/G) [ m sum_b (P_b - P_a) grad W_ab + rho0 sum_k V_k (P_k - P_a) grad W_ak ]`, exact for an even pressure whatever the disorder, but two particles with the same
//!   pressure do not push each other and nothing keeps momentum. A wall with the pressure of the particle would not push at all, and a drop would run
//!   through it. `P_k = max(2 P_a - Q_a, P_a)`, with `Q_a` the mean of `P_b` weighted by the kernel (with less than a [quarter](PressureGradient::FEWEST) of a lattice's neighbours the rest counts as without
//!   pressure), is the fluid's pressure continued into the wall, where that does not pull: a single drop is pushed as by the sum, water at an even pressure not at all. Walls that may pull, or push with
//!   `2 P_a`, blow a column at rest up within two seconds. As it is, one of 0.6 m of twelve particles stands 3 to 8 % too high, with 1.3 and 1.2 times its pressure at the floor (4 iterations in 8 and 2 ms).
//!
//! On the lattice both are the same, and an iteration with `c dt` is a Richardson step of the system of [`DivergenceFree`](crate::pressure_solver::DivergenceFree): waves from one particle to the next grow
//! from `c dt = 0.64 H` on (Wendland C2 at H = 2d; 0.62 H where it was tried). Sound is as fast as [`Settings::sound_speed`](crate::scene::Settings::sound_speed) says, ten times the expected speed by default, but goes no farther in a
//! substep than [`longest_sound`](PressureCorrected::longest_sound), 0.50 H there: water's own 1,500 m/s are out of reach at any step worth it, and stiffness is that of iterations and step, as it is with
//! position-based fluids. By sums half a metre of water, 8 particles deep, loses 1.9 % of its depth with 4 iterations in substeps of 8 ms, 0.6 % with 32, and 0.4 % in 2 ms; its pressure is 1.8 % off. In `freshet_lab stability
//! --quick` dam breaks hold up to a Courant number of 0.20, and a column at rest is compressed by more than 5 % in all steps. By differences a dam break gains more than 5 % of energy (`pareto --quick`).

use serde::{Deserialize, Serialize};

use crate::error::InvalidInput;
use crate::kernel::Kernel;
use crate::plan::Parameters;
use crate::pressure_solver::{largest_eigenvalue, lattice_diagonal};

/// How a pressure's gradient is found. See the [module](self).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum PressureGradient {
    /// From the sums of pairs' pressures: equal and opposite forces.
    #[default]
    Sum,
    /// From their differences: none in an even pressure, however uneven the particles.
    Difference,
}

impl PressureGradient {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Sum, Self::Difference];

    /// Name, as in plans and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sum => "sum",
            Self::Difference => "difference",
        }
    }

    /// Share of the neighbours in the lattice without which what is missing counts as without pressure; no unit.
    pub const FEWEST: f32 = 0.25;

    /// `P_k` in walls of the difference, from the particle's own `P_a`, `sum_b P_b W_ab` and `sum_b W_ab` of its neighbours in units of the relative density, and its own part in that.
    pub fn in_walls(own: f32, pressures: f32, around: f32, own_density: f32) -> f32 {
        (2.0 * own - pressures / around.max(Self::FEWEST * (1.0 - own_density))).max(own)
    }
}

/// How often pressures are corrected and by which gradient. See the [module](self).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PressureCorrected {
    /// Iterations of a substep, 1 to 1000.
    pub iterations: u32,
    /// By which particles are moved.
    pub gradient: PressureGradient,
}

impl Default for PressureCorrected {
    fn default() -> Self {
        Self { iterations: 4, gradient: PressureGradient::default() }
    }
}

/// By how much a wave of the lattice changes in an iteration over `(c dt)^2`, at most, 1/m2.
fn strongest(kernel: &Kernel, spacing: f32) -> f64 {
    let calibrations = kernel.lattice_sum(spacing) * kernel.lattice_gradient_sum(spacing);
    largest_eigenvalue(kernel, spacing) * lattice_diagonal(kernel, spacing) / calibrations
}

impl PressureCorrected {
    /// Share of what would make the strongest wave of the lattice grow that sound takes at most, no unit, of two: particles in disorder bear less.
    pub const RELAXATION: f64 = 1.2;

    /// How far sound goes in a substep at most, m, with particles `spacing` metres apart.
    pub fn longest_sound(kernel: &Kernel, spacing: f32) -> f32 {
        (Self::RELAXATION / strongest(kernel, spacing)).sqrt() as f32
    }

    /// `dt^2 dP` of a relative density of one too much, m5/kg: `(c dt)^2 / rho0`.
    pub fn stiffness(parameters: &Parameters, dt: f32) -> f32 {
        let way = (parameters.sound_speed * dt).min(parameters.longest_sound);
        way * way / parameters.rest_density
    }

    pub(crate) fn validate(&self) -> Result<(), InvalidInput> {
        match (1..=1000).contains(&self.iterations) {
            true => Ok(()),
            false => Err(InvalidInput::new("iterations", self.iterations, "1 to 1000")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::KernelKind;

    #[test]
    fn waves_grow_from_the_known_limit_on() {
        let kernel = Kernel::new(KernelKind::WendlandC2, 0.2).unwrap();
        let limit = (2.0 / strongest(&kernel, 0.1)).sqrt() / 0.2;
        assert!((limit - 0.64).abs() < 0.005, "{limit} H");
        let longest = PressureCorrected::longest_sound(&kernel, 0.1) / 0.2;
        assert!((longest - 0.5).abs() < 0.005, "{longest} H");
    }
}
