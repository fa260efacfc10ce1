//! Plane Couette flow from rest, the plate at `y = L` moving from the start: series solution, Morris, Fox & Zhu 1997,
//! J. Comput. Phys. 136, 214, eq. 18.

use std::f64::consts::PI;

/// Terms of the series: it is not asked for a time before 0.01, where the last is 1e-40.
const TERMS: u32 = 40;

/// Velocity over the plate's at `y / L` and at `nu t / L^2`, which is 0.01 or more.
pub fn velocity(y: f64, time: f64) -> f64 {
    let decaying: f64 = (1..=TERMS)
        .map(f64::from)
        .map(|n| 2.0 / (n * PI) * (n * PI * (1.0 - y)).sin() * (-n * n * PI * PI * time).exp())
        .sum();
    y - decaying
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn at_rest_at_first_and_a_line_in_the_end() {
        assert!(velocity(0.3, 0.01) < 1e-3);
        assert!((velocity(0.3, 9.0) - 0.3).abs() < 1e-12);
        // Integrated independently.
        assert!((velocity(0.5, 0.0225) - 0.018_422_1).abs() < 1e-6);
        assert!((velocity(0.25, 0.1125) - 0.105_438).abs() < 1e-6);
    }
}
