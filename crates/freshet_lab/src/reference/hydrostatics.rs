//! A fluid at rest: exact.

/// Pressure at `depth` below the surface, Pa: `rho g D`.
pub fn pressure(density: f64, gravity: f64, depth: f64) -> f64 {
    density * gravity * depth
}

/// Mean compression of a weakly compressible column at rest, no unit: `g D / (2 c^2)`, the mean of `p / (rho c^2)`.
pub fn mean_compression(gravity: f64, depth: f64, sound_speed: f64) -> f64 {
    gravity * depth / (2.0 * sound_speed * sound_speed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_a_metre_of_water() {
        assert!((pressure(1000.0, 9.81, 0.5) - 4905.0).abs() < 1e-9);
        // c = 10 v_max = 20 sqrt(g D): c^2 = 400 g D whatever the depth.
        assert!((mean_compression(9.81, 0.5, 20.0 * (9.81_f64 * 0.5).sqrt()) - 1.0 / 800.0).abs() < 1e-12);
    }
}
