//! How deep bodies float, after Archimedes.

/// Draft over diameter of a ball of this density over the fluid's: `3 t^2 - 2 t^3`, the volume of a cap over that of the ball.
pub fn draft_of_ball(ratio: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let draft: f64 = (low + high) / 2.0;
        if draft * draft * (3.0 - 2.0 * draft) < ratio { low = draft } else { high = draft }
    }
    (low + high) / 2.0
}

/// The same of a cube that floats upright, over its edge.
pub fn draft_of_cube(ratio: f64) -> f64 {
    ratio.clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_floats_half_under_and_light_ones_on_top() {
        assert!((draft_of_ball(0.5) - 0.5).abs() < 1e-12);
        // A spherical cap of a quarter of the diameter has 5/32 of the volume.
        assert!((draft_of_ball(5.0 / 32.0) - 0.25).abs() < 1e-9);
        assert!((draft_of_ball(0.2) + draft_of_ball(0.8) - 1.0).abs() < 1e-9);
        assert_eq!(draft_of_cube(0.3), 0.3);
    }
}
