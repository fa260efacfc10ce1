//! The decaying vortices of Taylor & Green 1937 (Proc. R. Soc. A 158, 499) in two dimensions, a square of edge L with periodic
//! ends: an exact solution of the Navier-Stokes equations.

use std::f64::consts::PI;

/// Velocity over U, at `x / L` and `y / L`, at the start.
pub fn velocity(x: f64, y: f64) -> [f64; 2] {
    let (a, b) = (2.0 * PI * x, 2.0 * PI * y);
    [-a.cos() * b.sin(), a.sin() * b.cos()]
}

/// Pressure over `rho U^2`, at the start.
pub fn pressure(x: f64, y: f64) -> f64 {
    -0.25 * ((4.0 * PI * x).cos() + (4.0 * PI * y).cos())
}

/// The rate at which velocities decay, over `U / L`: `u ~ exp(-rate t)`.
pub fn decay_rate(reynolds: f64) -> f64 {
    8.0 * PI * PI / reynolds
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_free_of_divergence_and_balanced_by_its_pressure() {
        let e = 1e-5;
        for (x, y) in [(0.1, 0.2), (0.4, 0.35), (0.77, 0.9)] {
            let slope = |f: &dyn Fn(f64, f64) -> f64| {
                [(f(x + e, y) - f(x - e, y)) / (2.0 * e), (f(x, y + e) - f(x, y - e)) / (2.0 * e)]
            };
            let (du, dv) = (slope(&|x, y| velocity(x, y)[0]), slope(&|x, y| velocity(x, y)[1]));
            assert!((du[0] + dv[1]).abs() < 1e-8);
            let ([u, v], dp) = (velocity(x, y), slope(&pressure));
            assert!((u * du[0] + v * du[1] + dp[0]).abs() < 1e-7);
            assert!((u * dv[0] + v * dv[1] + dp[1]).abs() < 1e-7);
        }
        assert!((decay_rate(100.0) - 0.789_568).abs() < 1e-6);
    }
}
