//! Double density relaxation: a second, short-ranged pressure against clumping (Pirovano 2011, section 3.1, after Clavet,
//! Beaudoin & Poulin 2005).
//!
//! Where pressure is negative the pressure force pulls, most at middle distances, and particles meet in clumps: the tensile
//! instability (Monaghan 2000). Against it every pair repels with a near pressure `p_near = k rho`, always positive, and a
//! steeper kernel `W_near = 105/(4 pi H^7) (H - r)^4`. As `p_near / rho^2 = k / rho` hardly changes in a fluid that is hardly
//! compressed, it is taken at rest density:
//!
//! `a_a = -(1/G) m sum_b (2 k / rho0) F_near x_ab`, `F_near = (dW_near/dr)/r`, `k = near_pressure * c^2`.
//!
//! Pirovano's `k_P`, that of his equation of state, leaves nothing that holds a block together. With `k = 0.01 c^2` a cube under
//! tension alone rounds itself off with no two particles nearer than 0.7 d; without, most of its particles clump
//! (`freshet_lab validate --case relaxing-cube`). Walls and bodies exert none.

use std::f64::consts::PI;

/// `A` of `W_near = A/H^3 (1 - q)^4`: its integral is one.
pub const NORMALISATION: f64 = 105.0 / (4.0 * PI);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kernel_integrates_to_one() {
        let steps = 10_000;
        let shells = (0..steps).map(|i| (f64::from(i) + 0.5) / f64::from(steps));
        let integral: f64 = shells.map(|q| 4.0 * PI * q * q * (1.0 - q).powi(4) / f64::from(steps)).sum();
        assert!((NORMALISATION * integral - 1.0).abs() < 1e-6, "{integral}");
    }
}
