//! Points of cost and error, and which of them nothing beats.

use freshet_core::configuration::Configuration;

use super::scenes::Benchmark;
use super::trial::{Failure, Trial};
use crate::backend::Backend;

/// A configuration at a resolution on a backend.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// How.
    pub configuration: &'static Configuration,
    /// Where.
    pub backend: Backend,
    /// Particles across the fluid.
    pub across: u32,
    /// One of each scene it is judged by, in their order.
    pub trials: Vec<Trial>,
    /// Of the scene that takes no part; none where it was not run.
    pub held_out: Option<Trial>,
}

impl Point {
    /// Its error, a share: that of the scene it does worst on. None if any failed.
    pub fn error(&self) -> Option<f64> {
        let errors = self.trials.iter().map(Trial::error).collect::<Option<Vec<f64>>>()?;
        errors.into_iter().reduce(f64::max)
    }

    /// Its cost, wall seconds per simulated second: the geometric mean of the scenes that started. None if none did.
    pub fn cost(&self) -> Option<f64> {
        let costs: Vec<f64> = self.trials.iter().filter_map(|trial| trial.cost).collect();
        let logarithm = costs.iter().map(|cost| cost.ln()).sum::<f64>() / costs.len() as f64;
        (!costs.is_empty()).then(|| logarithm.exp())
    }

    /// Cost and error of one that did not fail.
    pub fn place(&self) -> Option<(f64, f64)> {
        Some((self.cost()?, self.error()?))
    }

    /// The first scene that failed, and how.
    pub fn failure(&self, scenes: &[&'static Benchmark]) -> Option<(&'static Benchmark, Failure)> {
        scenes.iter().zip(&self.trials).find_map(|(scene, trial)| Some((*scene, trial.failure()?)))
    }

    /// Name and resolution.
    pub fn name(&self) -> String {
        format!("{} at {}", self.configuration.name, self.across)
    }

    /// Whether it is as cheap and as good as another, and one of both better.
    pub fn dominates(&self, other: &Self) -> bool {
        match (self.place(), other.place()) {
            (Some((cost, error)), Some((other_cost, other_error))) => {
                self.backend == other.backend
                    && cost <= other_cost
                    && error <= other_error
                    && (cost, error) != (other_cost, other_error)
            }
            _ => false,
        }
    }
}

/// The points of a backend that no other dominates, the cheapest first.
pub fn front(points: &[Point], backend: Backend) -> Vec<&Point> {
    let of_backend = || points.iter().filter(|point| point.backend == backend && point.place().is_some());
    let mut front: Vec<&Point> =
        of_backend().filter(|point| of_backend().all(|other| !other.dominates(point))).collect();
    front.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
    // Of equals the first.
    front.dedup_by(|a, b| a.place() == b.place());
    front
}

/// What presets are chosen from: a point for each configuration that failed nowhere on the CPU, at no resolution that was run there. Settings go with
/// any resolution, so on each scene its error is that of the worse one; its cost is that of the finest.
pub fn choices(points: &[Point]) -> Vec<Point> {
    let on_cpu = || points.iter().filter(|point| point.backend == Backend::Cpu);
    let mut all: Vec<u32> = on_cpu().map(|point| point.across).collect();
    all.sort_unstable();
    all.dedup();
    let Some(&finest) = all.last() else { return Vec::new() };
    let choice = |fine: &Point| {
        let of_it: Vec<&Point> = on_cpu().filter(|point| point.configuration == fine.configuration).collect();
        let passes = of_it.len() == all.len() && of_it.iter().all(|point| point.place().is_some());
        let worse = |(index, trial): (usize, &Trial)| {
            let worst = of_it.iter().map(|point| &point.trials[index]).max_by(|a, b| error(a).total_cmp(&error(b)));
            Trial { parts: worst.unwrap_or(trial).parts.clone(), cost: trial.cost }
        };
        passes.then(|| Point { trials: fine.trials.iter().enumerate().map(worse).collect(), ..fine.clone() })
    };
    on_cpu().filter(|point| point.across == finest).filter_map(choice).collect()
}

fn error(trial: &Trial) -> f64 {
    trial.error().unwrap_or(f64::INFINITY)
}

/// Of what dominates a point, the one on the front with the smallest product of cost and error; none for those on the front.
pub fn dominator<'a>(points: &'a [Point], point: &Point) -> Option<&'a Point> {
    let all = front(points, point.backend).into_iter().filter(|other| other.dominates(point));
    all.min_by(|a, b| product(a).total_cmp(&product(b)))
}

/// What [`FluidFidelity`](freshet_core::fidelity::FluidFidelity) offers: `Fast`, `Balanced`, `Accurate`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Presets<'a>(pub [&'a Point; 3]);

/// Largest error of `Fast`, a share.
const FAST: f64 = 0.1;

impl<'a> Presets<'a> {
    /// Chosen from a [`front`]: none from an empty one.
    ///
    /// `Accurate` has the smallest error. `Fast` is the cheapest with an error of at most a tenth, `Accurate` if none has. `Balanced` has the smallest product
    /// of both among what is between them; if there is nothing, of them.
    pub fn of(front: &[&'a Point]) -> Option<Self> {
        let accurate = front.len().checked_sub(1)?;
        let fast = front.iter().position(|point| point.error().is_some_and(|error| error <= FAST)).unwrap_or(accurate);
        let between = front.get(fast + 1..accurate).filter(|between| !between.is_empty()).unwrap_or(&front[fast..]);
        let balanced = between.iter().min_by(|a, b| product(a).total_cmp(&product(b)))?;
        Some(Self([front[fast], *balanced, front[accurate]]))
    }
}

fn cost(point: &Point) -> f64 {
    point.cost().unwrap_or(f64::INFINITY)
}

fn product(point: &Point) -> f64 {
    point.place().map_or(f64::INFINITY, |(cost, error)| cost * error)
}

#[cfg(test)]
pub mod tests {
    use freshet_core::configuration::CONFIGURATIONS;

    use super::*;
    use crate::commands::pareto::scenes::{CHOSEN_BY, HELD_OUT};

    /// A point of so many wall seconds and an error on every scene, a share; of a failure where it is not finite.
    pub fn point(configuration: usize, across: u32, cost: f64, error: f64) -> Point {
        // All in the first part, so that rounding the parts does not change their sum.
        let parts = |scene: &Benchmark| {
            let mut parts = vec![0.0; scene.parts.len().max(1)];
            parts[0] = error;
            parts
        };
        let trial = |scene: &&Benchmark| Trial {
            parts: if error.is_finite() { Ok(parts(scene)) } else { Err(Failure::Energy) },
            cost: Some(cost),
        };
        Point {
            configuration: &CONFIGURATIONS[configuration],
            backend: Backend::Cpu,
            across,
            trials: CHOSEN_BY.iter().map(trial).collect(),
            held_out: Some(Trial {
                parts: Ok(parts(HELD_OUT).into_iter().map(|part| 0.5 * part).collect()),
                cost: Some(cost),
            }),
        }
    }

    #[test]
    fn the_front_is_what_nothing_beats_and_others_know_what_beats_them() {
        let points = [
            point(0, 12, 1.0, 0.2),
            point(1, 12, 2.0, 0.05),
            point(2, 12, 3.0, 0.06),
            point(3, 12, 9.0, 0.01),
            point(4, 12, 0.1, f64::NAN),
            point(5, 12, 2.5, 0.3),
        ];
        let front = front(&points, Backend::Cpu);
        assert_eq!(front, [&points[0], &points[1], &points[3]]);
        assert_eq!(dominator(&points, &points[2]), Some(&points[1]));
        assert_eq!(dominator(&points, &points[5]), Some(&points[1]), "both do; this one has the smaller product");
        assert_eq!(dominator(&points, &points[0]), None);
        assert_eq!(dominator(&points, &points[4]), None, "a failure is beaten by nothing, it is a failure");
        assert_eq!(Presets::of(&front), Some(Presets([&points[1], &points[3], &points[3]])));
        assert_eq!(Presets::of(&front[..1]), Some(Presets([&points[0]; 3])), "nothing is within a tenth");
        assert_eq!(Presets::of(&[]), None);
    }

    #[test]
    fn presets_are_chosen_from_what_fails_at_no_resolution_by_the_worse_error() {
        let points = [
            point(0, 12, 1.0, 0.2),
            point(0, 24, 9.0, 0.1),
            point(1, 12, 1.0, 0.02),
            point(1, 24, 8.0, 0.05),
            point(2, 12, 1.0, f64::NAN),
            point(2, 24, 2.0, 0.01),
            point(3, 24, 2.0, 0.01),
        ];
        let choices = choices(&points);
        let places: Vec<(&str, u32, f64)> = choices
            .iter()
            .map(|point| (point.configuration.name, point.across, (1e3 * point.error().unwrap_or(f64::NAN)).round()))
            .collect();
        assert_eq!(places, [("tait", 24, 200.0), ("linear", 24, 50.0)]);
        assert!(choices[1].cost().is_some_and(|cost| (cost - 8.0).abs() < 1e-9));
        assert!(super::choices(&[]).is_empty());
    }

    #[test]
    fn the_error_is_that_of_the_worst_scene_and_the_cost_a_geometric_mean() {
        let mut point = point(0, 12, 2.0, 0.02);
        point.trials[1] = Trial { parts: Ok(vec![0.03, 0.04]), cost: Some(32.0) };
        assert!(point.error().is_some_and(|error| (error - 0.05).abs() < 1e-12));
        let cost = 512.0_f64.powf(0.2);
        assert!(point.cost().is_some_and(|found| (found - cost).abs() < 1e-12), "fifth root of 2 * 32 * 2 * 2 * 2");
        point.trials[2].parts = Err(Failure::Lost);
        assert_eq!(point.place(), None);
        let failure = point.failure(&CHOSEN_BY);
        assert!(failure.is_some_and(|(scene, failure)| scene == CHOSEN_BY[2] && failure == Failure::Lost));
    }
}
