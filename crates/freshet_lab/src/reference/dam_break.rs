//! What a dam-break experiment is: a column of water whose gate is removed, where its front was when, and how high it still was.

use super::{lobovsky_2014, martin_moyce_1952};

/// A column of width `a` and height `n^2 a` that collapses along +x from the wall at x = 0.
///
/// Time is `T = n t sqrt(g/a)`, the front is `Z = x/a`. Where the height of the column at the back wall was measured too, it
/// is `H = y/(n^2 a)`, one at the start, over a time of its own, `tau = t sqrt(g/a) = T/n`.
#[derive(Debug, PartialEq)]
pub struct DamBreakExperiment {
    /// Name in files and on the command line.
    pub name: &'static str,
    /// Name in tables and charts.
    pub title: &'static str,
    /// The paper, and how the numbers came here.
    pub source: &'static str,
    /// `a`, m.
    pub width: f64,
    /// `n^2`, height over width.
    pub aspect: f64,
    /// Distance of the far wall from the back wall, in units of `a`.
    pub tank_length: f64,
    /// Points with `T` between these count.
    pub window: (f64, f64),
    /// `(T, Z)`.
    pub points: &'static [(f64, f64)],
    /// `(tau, H)`; empty where it was not measured. All points count.
    pub heights: &'static [(f64, f64)],
}

impl DamBreakExperiment {
    /// All experiments.
    pub const ALL: [&'static Self; 3] = [&martin_moyce_1952::SQUARE, &martin_moyce_1952::TALL, &lobovsky_2014::SQUARE];

    /// Height of the column, m.
    pub fn height(&self) -> f64 {
        self.aspect * self.width
    }

    /// The heights over the clock of the front: `(T, H)` with `T = n tau`.
    pub fn heights_over_time(&self) -> Vec<(f64, f64)> {
        let n = self.aspect.sqrt();
        self.heights.iter().map(|&(tau, height)| (n * tau, height)).collect()
    }

    /// The last `T` of a point that counts.
    pub fn end(&self) -> f64 {
        self.heights_over_time().last().map_or(self.window.1, |point| point.0.max(self.window.1))
    }

    /// Seconds in one unit of `T`.
    pub fn time_unit(&self, gravity: f64) -> f64 {
        (self.width / gravity / self.aspect).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_in_order_and_reach_their_window() {
        for experiment in DamBreakExperiment::ALL {
            let name = experiment.name;
            assert!(experiment.points.is_sorted_by(|a, b| a.0 < b.0 && a.1 < b.1), "{name}");
            let counted = experiment.points.iter().filter(|p| p.0 > experiment.window.0 && p.0 < experiment.window.1);
            assert!(counted.count() >= 10, "{name}");
            let furthest = experiment.points.last().map_or(0.0, |point| point.1);
            assert!(furthest < experiment.tank_length, "{name}");
            assert!(experiment.heights.is_sorted_by(|a, b| a.0 < b.0 && a.1 > b.1), "{name}");
            assert!(experiment.heights.iter().all(|point| point.1 > 0.0 && point.1 < 1.0), "{name}");
            assert!(experiment.end() >= experiment.window.1, "{name}");
        }
    }

    #[test]
    fn time_is_scaled_as_the_papers_do() {
        let square = &martin_moyce_1952::SQUARE;
        assert!((1.0 / square.time_unit(9.81) - (9.81_f64 / 0.05715).sqrt()).abs() < 1e-9);
        let tall = &martin_moyce_1952::TALL;
        assert!((1.0 / tall.time_unit(9.81) - (2.0 * 9.81_f64 / 0.05715).sqrt()).abs() < 1e-9);
        assert!((tall.height() - 0.1143).abs() < 1e-12);
        // tau = 7.4 is the last height of the tall column: t = 7.4 sqrt(a/g) by either clock.
        assert!((tall.end() * tall.time_unit(9.81) - 7.4 * (0.05715_f64 / 9.81).sqrt()).abs() < 1e-9);
        assert!((square.end() - 6.29).abs() < 1e-9);
    }
}
