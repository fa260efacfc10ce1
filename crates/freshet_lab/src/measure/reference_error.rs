//! How far a simulated curve is from measured points, with and without a shift of the clock.

use super::curve::Curve;

/// Largest shift of the clock that is tried, in units of `T`.
///
/// When the fluid of an experiment began to move is known to about this: a gate takes time to open, and the papers' authors
/// set the origin by eye.
pub const LARGEST_SHIFT: f64 = 0.2;

/// Steps of the search for the best shift, in units of `T`.
const SHIFT_STEP: f64 = 0.001;

/// What a difference between simulated and measured is divided by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// The measured value: for what grows.
    Relative,
    /// One, the unit in which the curve is given: for what falls from one towards zero. Divided by themselves the last few
    /// values, which are known to a rounding only, would be all that counts.
    InUnits,
}

/// Root mean square of the error, and what the best shift of the clock makes of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferenceError {
    /// Without shift.
    pub rms: f64,
    /// With the best shift.
    pub rms_shifted: f64,
    /// The best shift: the simulation's value at `T - shift` is compared with the point at `T`. Positive: the experiment
    /// is late, as behind a gate that opens slowly.
    pub shift: f64,
    /// Mean error without shift; positive: the simulation's values are too large.
    pub bias: f64,
    /// Points compared.
    pub points: usize,
}

impl ReferenceError {
    /// The root mean square with a given shift of the clock, over the same points as [`Self::between`] does.
    ///
    /// None if there is no such point, or the shifted curve does not cover them all.
    pub fn with_shift(
        simulated: &Curve,
        measured: &[(f64, f64)],
        window: (f64, f64),
        measure: Measure,
        shift: f64,
    ) -> Option<f64> {
        Some(error(simulated, &inside(measured, window), measure, shift)?.0)
    }

    /// Compares over the points with `window.0 < T < window.1`.
    ///
    /// None if there is no such point, or the curve does not cover them all.
    pub fn between(simulated: &Curve, measured: &[(f64, f64)], window: (f64, f64), measure: Measure) -> Option<Self> {
        let points = inside(measured, window);
        let (rms, bias) = error(simulated, &points, measure, 0.0)?;
        let steps = (LARGEST_SHIFT / SHIFT_STEP).round() as i32;
        let (rms_shifted, shift) = (-steps..=steps)
            .map(|step| f64::from(step) * SHIFT_STEP)
            .filter_map(|shift| Some((error(simulated, &points, measure, shift)?.0, shift)))
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.abs().total_cmp(&b.1.abs())))?;
        Some(Self { rms, rms_shifted, shift, bias, points: points.len() })
    }
}

/// The points that count.
fn inside(measured: &[(f64, f64)], window: (f64, f64)) -> Vec<(f64, f64)> {
    measured.iter().copied().filter(|&(time, _)| time > window.0 && time < window.1).collect()
}

/// Root mean square and mean of `Z_simulated(T - shift) - Z`, over `Z` if it is to be relative.
fn error(simulated: &Curve, points: &[(f64, f64)], measure: Measure, shift: f64) -> Option<(f64, f64)> {
    if points.is_empty() {
        return None;
    }
    let (mut squares, mut sum) = (0.0, 0.0);
    for &(time, value) in points {
        let unit = match measure {
            Measure::Relative => value,
            Measure::InUnits => 1.0,
        };
        let error = (simulated.at(time - shift)? - value) / unit;
        squares += error * error;
        sum += error;
    }
    let count = points.len() as f64;
    Some(((squares / count).sqrt(), sum / count))
}

#[cfg(test)]
mod tests {
    use super::Measure::{InUnits, Relative};
    use super::*;

    fn line(slope: f64, origin: f64) -> Curve {
        (0..=400).map(|i| f64::from(i) * 0.01).map(|time| (time, 1.0 + slope * (time - origin))).collect()
    }

    const POINTS: [(f64, f64); 5] = [(0.5, 99.0), (1.5, 2.5), (2.0, 3.0), (3.0, 4.0), (3.3, 99.0)];
    const WINDOW: (f64, f64) = (1.0, 3.3);

    #[test]
    fn a_perfect_curve_has_no_error_and_points_outside_do_not_count() {
        let error = ReferenceError::between(&line(1.0, 0.0), &POINTS, WINDOW, Relative);
        assert!(error.is_some_and(|e| e.rms < 1e-12 && e.shift == 0.0 && e.points == 3), "{error:?}");
    }

    #[test]
    fn a_curve_that_is_early_is_shifted_by_a_positive_time() {
        // The simulation is where the experiment will be 0.1 later.
        let error = ReferenceError::between(&line(1.0, -0.1), &POINTS, WINDOW, Relative);
        assert!(error.is_some_and(|e| e.rms > 0.03 && e.bias > 0.03 && e.rms_shifted < 1e-9), "{error:?}");
        let given = |shift| ReferenceError::with_shift(&line(1.0, -0.1), &POINTS, WINDOW, Relative, shift);
        assert!(given(0.1).is_some_and(|rms| rms < 1e-9), "{:?}", given(0.1));
        assert_eq!(given(0.0), error.map(|e| e.rms));
        assert!(error.is_some_and(|e| (e.shift - 0.1).abs() < 1e-9), "{error:?}");
    }

    #[test]
    fn the_shift_is_limited() {
        let error = ReferenceError::between(&line(1.0, -0.5), &POINTS, WINDOW, Relative);
        assert!(error.is_some_and(|e| (e.shift - LARGEST_SHIFT).abs() < 1e-9 && e.rms_shifted > 0.08), "{error:?}");
    }

    #[test]
    fn the_error_is_relative_or_in_units() {
        let simulated: Curve = [(0.0, 0.6), (4.0, 0.6)].into_iter().collect();
        for (measure, expected) in [(Relative, 0.2), (InUnits, 0.1)] {
            let error = ReferenceError::between(&simulated, &[(2.0, 0.5)], WINDOW, measure);
            assert!(error.is_some_and(|e| (e.rms - expected).abs() < 1e-12), "{measure:?}: {error:?}");
        }
    }

    #[test]
    fn a_curve_that_ends_early_is_no_result() {
        let simulated: Curve = [(0.0, 1.0), (2.5, 3.5)].into_iter().collect();
        assert_eq!(ReferenceError::between(&simulated, &POINTS, WINDOW, Relative), None);
        assert_eq!(ReferenceError::between(&line(1.0, 0.0), &[], WINDOW, Relative), None);
    }
}
