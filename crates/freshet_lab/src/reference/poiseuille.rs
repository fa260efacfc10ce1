//! Plane Poiseuille flow from rest between plates at rest: series solution, Morris, Fox & Zhu 1997, J. Comput. Phys. 136, 214,
//! eq. 21.

use std::f64::consts::PI;

/// Terms of the series: the last are 1e-7 of the first.
const TERMS: u32 = 100;

/// Velocity over the steady one in the middle, `F L^2 / (8 nu)`, at `y / L` and at `nu t / L^2`.
pub fn velocity(y: f64, time: f64) -> f64 {
    let decaying: f64 = (0..TERMS)
        .map(|n| f64::from(2 * n + 1))
        .map(|k| 32.0 / (PI * k).powi(3) * (k * PI * y).sin() * (-k * k * PI * PI * time).exp())
        .sum();
    4.0 * y * (1.0 - y) - decaying
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn at_rest_at_first_and_a_parabola_in_the_end() {
        for y in [0.1, 0.3, 0.5] {
            assert!(velocity(y, 0.0).abs() < 1e-4);
            assert!((velocity(y, 9.0) - 4.0 * y * (1.0 - y)).abs() < 1e-12);
        }
        // Integrated independently.
        assert!((velocity(0.25, 0.0225) - 0.161_915).abs() < 1e-6);
        assert!((velocity(0.5, 0.1125) - 0.659_993).abs() < 1e-6);
    }
}
