//! Percentile, median, mean, order of convergence.

/// The percentile `percent` (0 to 100) with linear interpolation between ranks, as numpy's default does it; none without
/// values. Reorders the values.
pub fn percentile(values: &mut [f32], percent: f64) -> Option<f64> {
    let last = values.len().checked_sub(1)?;
    let rank = percent.clamp(0.0, 100.0) / 100.0 * last as f64;
    let below = (rank.floor() as usize).min(last);
    let (_, &mut low, above) = values.select_nth_unstable_by(below, f32::total_cmp);
    let low = f64::from(low);
    let high = above.iter().copied().min_by(f32::total_cmp).map_or(low, f64::from);
    Some(low + (high - low) * (rank - below as f64))
}

/// The median; none without values.
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    Some((sorted[last / 2] + sorted[last.div_ceil(2)]) / 2.0)
}

/// The smallest and the largest value; none without values.
pub fn spread(values: &[f64]) -> Option<(f64, f64)> {
    let least = values.iter().copied().min_by(f64::total_cmp)?;
    let most = values.iter().copied().max_by(f64::total_cmp)?;
    Some((least, most))
}

/// The mean; none without values.
pub fn mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.into_iter().fold((0.0, 0_u64), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / count as f64)
}

/// The observed order of convergence: errors shrink as the resolution, of `(resolution, error)`, to minus this. None where an error
/// is zero or none.
pub fn order(coarse: (f64, f64), fine: (f64, f64)) -> Option<f64> {
    let order = (coarse.1 / fine.1).ln() / (fine.0 / coarse.0).ln();
    order.is_finite().then_some(order)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentile_interpolates_between_ranks() {
        let mut values: Vec<f32> = (0..=200).rev().map(|value| value as f32).collect();
        assert_eq!(percentile(&mut values, 99.5), Some(199.0));
        let mut values = vec![3.0, 1.0, 2.0, 10.0];
        // numpy.percentile([1, 2, 3, 10], 99.5) = 9.895
        let found = percentile(&mut values, 99.5);
        assert!(found.is_some_and(|value| (value - 9.895).abs() < 1e-9), "{found:?}");
        assert_eq!(percentile(&mut values, 0.0), Some(1.0));
        assert_eq!(percentile(&mut values, 100.0), Some(10.0));
        assert_eq!(percentile(&mut [], 50.0), None);
    }

    #[test]
    fn median_of_even_and_odd_counts() {
        assert_eq!(median(&[5.0, 1.0, 3.0]), Some(3.0));
        assert_eq!(median(&[5.0, 1.0, 3.0, 4.0]), Some(3.5));
        assert_eq!(median(&[]), None);
    }

    #[test]
    fn mean_and_spread() {
        assert_eq!(mean([1.0, 2.0, 6.0]), Some(3.0));
        assert_eq!(mean([]), None);
        assert_eq!(spread(&[2.0, -1.0, 7.0]), Some((-1.0, 7.0)));
    }

    #[test]
    fn errors_that_fall_with_the_square_are_of_second_order() {
        assert!(order((10.0, 0.04), (20.0, 0.01)).is_some_and(|order| (order - 2.0).abs() < 1e-12));
        assert_eq!(order((10.0, 0.04), (20.0, 0.0)), None);
        assert_eq!(order((10.0, f64::NAN), (20.0, 0.1)), None);
    }
}
