//! A quantity over time, between whose samples it is taken as straight.

/// Samples `(time, value)` in the order of time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    samples: Vec<(f64, f64)>,
}

impl Curve {
    /// Adds a sample later than all others; an earlier one is left out.
    pub fn push(&mut self, time: f64, value: f64) {
        if self.samples.last().is_none_or(|&(last, _)| time > last) {
            self.samples.push((time, value));
        }
    }

    /// All samples.
    pub fn samples(&self) -> &[(f64, f64)] {
        &self.samples
    }

    /// The value at a time; none before the first and after the last sample.
    pub fn at(&self, time: f64) -> Option<f64> {
        let next = self.samples.partition_point(|&(sample, _)| sample < time);
        let &(after, value_after) = self.samples.get(next)?;
        if after == time {
            return Some(value_after);
        }
        let &(before, value_before) = self.samples.get(next.checked_sub(1)?)?;
        Some(value_before + (value_after - value_before) * (time - before) / (after - before))
    }

    /// The values from a time on.
    pub fn values_from(&self, time: f64) -> impl Iterator<Item = f64> + Clone {
        self.samples.iter().filter(move |sample| sample.0 >= time).map(|sample| sample.1)
    }
}

impl FromIterator<(f64, f64)> for Curve {
    fn from_iter<T: IntoIterator<Item = (f64, f64)>>(samples: T) -> Self {
        let mut curve = Self::default();
        samples.into_iter().for_each(|(time, value)| curve.push(time, value));
        curve
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_samples_it_is_straight_and_outside_there_is_nothing() {
        let curve: Curve = [(1.0, 10.0), (2.0, 20.0), (4.0, 0.0)].into_iter().collect();
        assert_eq!(curve.at(1.0), Some(10.0));
        assert_eq!(curve.at(1.5), Some(15.0));
        assert_eq!(curve.at(3.0), Some(10.0));
        assert_eq!(curve.at(4.0), Some(0.0));
        assert_eq!(curve.at(0.999), None);
        assert_eq!(curve.at(4.001), None);
        assert_eq!(curve.values_from(2.0).collect::<Vec<_>>(), [20.0, 0.0]);
    }

    #[test]
    fn time_only_goes_forward() {
        let curve: Curve = [(1.0, 10.0), (1.0, 20.0), (0.5, 0.0)].into_iter().collect();
        assert_eq!(curve.samples(), [(1.0, 10.0)]);
    }
}
