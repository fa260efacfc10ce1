//! Period and damping of what swings.

use super::curve::Curve;
use super::statistics::mean;

/// How something swings about a mean that may be off zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillation {
    /// Time of a whole swing.
    pub period: f64,
    /// Share of the amplitude that is left after a period.
    pub kept: f64,
}

impl Oscillation {
    /// From a curve that begins at zero and crosses it four times at least, the start apart; none if it does not.
    ///
    /// The period is the mean time from a crossing to the next but one, so that a shifted mean does not count; what is kept is that of the way from one
    /// extreme to the next, over the next but one, to the power that makes it a period's.
    pub fn of(curve: &Curve) -> Option<Self> {
        let mut crossings = Vec::new();
        let mut extremes: Vec<f64> = Vec::new();
        let mut extreme = 0.0_f64;
        for pair in curve.samples().windows(2) {
            let [(before, from), (after, to)] = [pair[0], pair[1]];
            if from * to < 0.0 {
                crossings.push(before + (after - before) * from / (from - to));
                extremes.push(std::mem::take(&mut extreme));
            }
            if to.abs() > extreme.abs() {
                extreme = to;
            }
        }
        let period = mean(crossings.windows(3).map(|three| three[2] - three[0]))?;
        let ways: Vec<f64> = extremes.windows(2).map(|two| (two[1] - two[0]).abs()).collect();
        let (&first, &last) = (ways.first()?, ways.last()?);
        let kept = (ways.len() > 1).then(|| (last / first).powf(2.0 / (ways.len() - 1) as f64))?;
        Some(Self { period, kept })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_damped_sine_off_its_mean_is_known() {
        let rate = 0.2;
        let swing = |time: f64| (-rate * time).exp() * (std::f64::consts::TAU * time / 3.0).sin();
        let curve = |shift: f64, end: f64| -> Curve {
            let time = |index: u32| f64::from(index) * 0.02;
            (0..)
                .map(time)
                .take_while(|&time| time < end)
                .map(|time| (time, swing(time) + shift * time.min(0.1)))
                .collect()
        };
        for shift in [0.0, 0.2] {
            let found = Oscillation::of(&curve(shift, 7.5)).unwrap_or(Oscillation { period: f64::NAN, kept: f64::NAN });
            assert!((found.period / 3.0 - 1.0).abs() < 2e-3, "{found:?}");
            assert!((found.kept / (-3.0 * rate).exp() - 1.0).abs() < 0.02, "{found:?}");
        }
        assert_eq!(Oscillation::of(&curve(0.0, 4.0)), None, "two crossings");
        assert_eq!(Oscillation::of(&Curve::default()), None);
    }
}
