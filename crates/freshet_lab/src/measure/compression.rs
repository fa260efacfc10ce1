//! How much denser than at rest a fluid is.

/// Mean over particles of `max(density / rest_density - 1, 0)`; zero without particles.
pub fn mean_compression(densities: &[f32], rest_density: f32) -> f64 {
    let rest = f64::from(rest_density);
    let sum: f64 = densities.iter().map(|&density| (f64::from(density) / rest - 1.0).max(0.0)).sum();
    sum / densities.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn particles_below_rest_density_count_as_zero() {
        assert!((mean_compression(&[1020.0, 500.0, 1000.0, 1000.0], 1000.0) - 0.005).abs() < 1e-9);
        assert_eq!(mean_compression(&[], 1000.0), 0.0);
    }
}
