//! How a ball's heave grows or decays.

use crate::measure::curve::Curve;
use crate::measure::statistics::mean;

/// The envelope of an oscillation from a time on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sway {
    /// Largest distance from the mean, in the curve's unit.
    pub largest: f64,
    /// Envelope at the end over that at the beginning, by a straight line through its logarithm.
    pub growth: f64,
}

/// Length of the windows whose largest deviation is the envelope, s; a ball of 0.3 m heaves with a period of 0.9 s, one of
/// 0.6 m with 1.3 s.
const WINDOW: f64 = 0.7;

impl Sway {
    /// Measures a curve from `start` on. Deviations below `floor` count as `floor`: they are noise. Not a number if fewer than
    /// two windows fit.
    pub fn of(curve: &Curve, start: f64, floor: f64) -> Self {
        let late: Vec<(f64, f64)> = curve.samples().iter().copied().filter(|sample| sample.0 >= start).collect();
        let middle = mean(late.iter().map(|sample| sample.1)).unwrap_or(f64::NAN);
        let end = late.last().map_or(start, |sample| sample.0);
        let count = ((end - start) / WINDOW).floor().max(0.0) as usize;
        let envelope: Vec<(f64, f64)> = (0..count)
            .map(|window| {
                let span = (end - start) / count as f64;
                let from = start + window as f64 * span;
                let inside = late.iter().filter(|sample| (from..from + span).contains(&sample.0));
                let largest = inside.map(|sample| (sample.1 - middle).abs()).fold(floor, f64::max);
                (from + span / 2.0, largest.ln())
            })
            .collect();
        let largest = late.iter().map(|sample| (sample.1 - middle).abs()).fold(0.0, f64::max);
        Self { largest, growth: (slope(&envelope) * (end - start)).exp() }
    }
}

/// Slope of the straight line through points by least squares; not a number with fewer than two.
fn slope(points: &[(f64, f64)]) -> f64 {
    let (x, y) = (mean(points.iter().map(|point| point.0)), mean(points.iter().map(|point| point.1)));
    let (Some(x), Some(y), 2..) = (x, y, points.len()) else { return f64::NAN };
    let over: f64 = points.iter().map(|point| (point.0 - x) * (point.1 - y)).sum();
    over / points.iter().map(|point| (point.0 - x).powi(2)).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heave(rate: f64) -> Curve {
        (0..1200)
            .map(|tick| f64::from(tick) / 60.0)
            .map(|t| (t, 3.0 + 0.01 * (rate * t).exp() * (7.0 * t).cos()))
            .collect()
    }

    #[test]
    fn growth_and_decay_are_told_apart() {
        for rate in [-0.1, 0.0, 0.05, 0.2] {
            let growth = Sway::of(&heave(rate), 10.0, 1e-4).growth;
            let expected = (rate * 10.0).exp();
            assert!((growth / expected - 1.0).abs() < 0.1, "{rate}: {growth} {expected}");
        }
    }

    #[test]
    fn noise_below_the_floor_does_not_grow() {
        assert_eq!(Sway::of(&heave(0.1), 10.0, 1.0).growth, 1.0);
        assert!(Sway::of(&heave(0.0), 19.9, 1e-4).growth.is_nan());
    }
}
