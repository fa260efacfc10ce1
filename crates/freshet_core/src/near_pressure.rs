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

/// `f'(q)/q` of `f(q) = (1 - q)^4`, for `0 < q`; zero at and beyond the support.
///
/// At most `4e6`: where two particles meet the direction is lost anyway.
pub fn slope_over_q(q: f64) -> f64 {
    -4.0 * (1.0 - q).max(0.0).powi(3) / q.max(1e-6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kernel_integrates_to_one_and_its_slope_is_its_derivative() {
        let value = |q: f64| (1.0 - q).powi(4);
        let steps = 10_000;
        let shells = (0..steps).map(|i| (f64::from(i) + 0.5) / f64::from(steps));
        let integral: f64 = shells.map(|q| 4.0 * PI * q * q * value(q) / f64::from(steps)).sum();
        assert!((NORMALISATION * integral - 1.0).abs() < 1e-6, "{integral}");
        for q in [0.05, 0.4, 0.9, 0.999] {
            let derivative = (value(q + 1e-6) - value(q - 1e-6)) / 2e-6;
            assert!((slope_over_q(q) * q - derivative).abs() < 1e-8);
        }
        assert_eq!((slope_over_q(1.0), slope_over_q(1.5)), (0.0, 0.0));
    }
}
