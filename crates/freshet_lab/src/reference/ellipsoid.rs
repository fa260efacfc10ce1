//! A ball of inviscid fluid that is drawn out, free of forces: Dirichlet's ellipsoid without its own gravity (Lamb, Hydrodynamics, 6th ed. 1932,
//! § 382), an exact solution with a free surface.
//!
//! Velocities `(x a'/a, y a'/a, z c'/c)` keep an ellipsoid of semi-axes `a, a, c` one, with `a^2 c = 1`. The pressure
//! `P (1 - (x^2 + y^2)/a^2 - z^2/c^2)` is zero on its surface, and Euler's equation is `a'' a = c'' c = 2 P/rho`. The energy, in proportion to
//! `2 a'^2 + c'^2 = a'^2 (2 + 4 a^-6)`, is constant, so that `P` is positive throughout: the fluid is nowhere under tension.

use crate::measure::curve::Curve;

/// Largest speed of the poles, over radius and rate at the start: `sqrt 6`, when all energy is theirs.
pub const MOST_SPEED: f64 = 2.449_489_742_783_178;

/// Step of the fourth-order integration, over the rate at the start.
const STEP: f64 = 1e-3;

/// The semi-axis `c` over time, both over those of the ball and the rate at which `a` shrinks at the start; up to `end`.
pub fn polar_axis(end: f64) -> Curve {
    // From the energy: a' = -sqrt(6 / (2 + 4 a^-6)).
    let rate = |a: f64| -(6.0 / (2.0 + 4.0 * a.powi(-6))).sqrt();
    let mut a = 1.0;
    let steps = (end / STEP).ceil() as u32 + 1;
    let mut curve: Curve = [(0.0, 1.0)].into_iter().collect();
    for step in 1..=steps {
        let k1 = rate(a);
        let k2 = rate(a + 0.5 * STEP * k1);
        let k3 = rate(a + 0.5 * STEP * k2);
        let k4 = rate(a + STEP * k3);
        a += STEP / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
        curve.push(f64::from(step) * STEP, a.powi(-2));
    }
    curve
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_start_as_given_and_obey_their_equation_of_motion() {
        let curve = polar_axis(1.0);
        let c = |time: f64| curve.at(time).unwrap_or(f64::NAN);
        assert!(((c(0.002) - c(0.0)) / 0.002 - 2.0).abs() < 0.01, "the poles start at twice the rate");
        // a'' a = c'' c, by central differences.
        let h = 0.02;
        for time in [0.1, 0.4, 0.8] {
            let second = |f: &dyn Fn(f64) -> f64| (f(time + h) - 2.0 * f(time) + f(time - h)) / (h * h);
            let a = |time: f64| c(time).powf(-0.5);
            let (of_a, of_c) = (second(&a) * a(time), second(&c) * c(time));
            assert!((of_a / of_c - 1.0).abs() < 0.01 && of_a > 0.0, "{of_a} and {of_c} at {time}");
        }
        let speed = (c(1.0) - c(0.99)) / 0.01;
        assert!(speed > 2.3 && speed < MOST_SPEED, "{speed}");
    }
}
