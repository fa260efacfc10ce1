//! What a dam-break experiment is: a column of water whose gate is removed, and where its front was when.

use super::{lobovsky_2014, martin_moyce_1952};

/// A column of width `a` and height `n^2 a` that collapses along +x from the wall at x = 0.
///
/// Time is `T = n t sqrt(g/a)`, the front is `Z = x/a`.
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
}

impl DamBreakExperiment {
    /// All experiments.
    pub const ALL: [&'static Self; 3] = [&martin_moyce_1952::SQUARE, &martin_moyce_1952::TALL, &lobovsky_2014::SQUARE];

    /// Height of the column, m.
    pub fn height(&self) -> f64 {
        self.aspect * self.width
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
        }
    }

    #[test]
    fn time_is_scaled_as_the_papers_do() {
        let square = &martin_moyce_1952::SQUARE;
        assert!((1.0 / square.time_unit(9.81) - (9.81_f64 / 0.05715).sqrt()).abs() < 1e-9);
        let tall = &martin_moyce_1952::TALL;
        assert!((1.0 / tall.time_unit(9.81) - (2.0 * 9.81_f64 / 0.05715).sqrt()).abs() < 1e-9);
        assert!((tall.height() - 0.1143).abs() < 1e-12);
    }
}
