//! Torque of a viscous fluid on a ball that turns in it.
//!
//! Kirchhoff, G., 1876: Vorlesungen ueber mathematische Physik: Mechanik. Leipzig. 26th lecture. Also Lamb, Hydrodynamics, art. 334: between
//! two concentric spheres creeping flow turns with `omega r^-3 - b` about the axis, and `b` is such that it stands still at the outer one.

use std::f64::consts::PI;

/// Torque on a ball in an endless fluid, N m, from Pa s, m and rad/s: `8 pi mu R^3 omega`.
pub fn torque(viscosity: f64, radius: f64, speed: f64) -> f64 {
    8.0 * PI * viscosity * radius.powi(3) * speed
}

/// How much larger it is in a vessel, a sphere about the ball of a radius `1 / ratio` times the ball's: `1 / (1 - ratio^3)`.
pub fn confined(ratio: f64) -> f64 {
    1.0 / (1.0 - ratio.powi(3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vessel_near_the_ball_holds_it() {
        assert!((confined(0.25) - 64.0 / 63.0).abs() < 1e-12);
        // A thin gap is a plane one: mu omega R/gap over the surface, with arms R sin: 8/3 pi mu omega R^4/gap.
        let gap = 1e-4;
        let plane = 8.0 / 3.0 * PI / gap;
        assert!((torque(1.0, 1.0, 1.0) * confined(1.0 - gap) / plane - 1.0).abs() < 2.0 * gap);
    }
}
