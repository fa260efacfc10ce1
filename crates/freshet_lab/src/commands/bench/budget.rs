//! What fits into the time given: costs are forecast from what was measured, and what would not fit is left out by name.

use std::time::Duration;

use super::Configuration;
use crate::backend::Backend;

/// Time given and spent, and what was learned on the way.
#[derive(Clone, Debug)]
pub struct Budget {
    seconds: f64,
    spent: f64,
    known: Vec<Known>,
}

/// What a run took, everything included: planning, opening, reading.
#[derive(Clone, Copy, Debug)]
struct Known {
    configuration: Configuration,
    /// Mean substep, s.
    substep: f64,
    /// Nanoseconds per particle and substep.
    nanoseconds: f64,
}

/// A configuration that did not fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Skipped {
    /// Which.
    pub configuration: Configuration,
    /// What all its runs would take, s.
    pub estimate: f64,
    /// What was left of the budget, s.
    pub left: f64,
}

impl std::fmt::Display for Skipped {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { configuration, estimate, left } = self;
        write!(f, "{configuration}: about {estimate:.1} s, {left:.1} s left of --budget")
    }
}

/// Nanoseconds per particle and substep where nothing of a backend was measured yet: on the slow side, so that the first run
/// does not exceed the budget by much.
fn cautious(configuration: &Configuration) -> f64 {
    match configuration.backend {
        Backend::Cpu => 500.0 / configuration.threads.unwrap_or(1).min(4) as f64,
        Backend::Gpu => 3000.0,
    }
}

impl Budget {
    /// So many seconds.
    pub fn new(seconds: f64) -> Self {
        Self { seconds, spent: 0.0, known: Vec::new() }
    }

    /// Seconds left.
    pub fn left(&self) -> f64 {
        self.seconds - self.spent
    }

    /// Time that went into something else than a run.
    pub fn spend(&mut self, time: Duration) {
        self.spent += time.as_secs_f64();
    }

    /// A run of so many substeps of mean length `substep` took `time`.
    pub fn learn(&mut self, configuration: Configuration, particle_steps: f64, substep: f64, time: Duration) {
        self.spend(time);
        let nanoseconds = time.as_secs_f64() * 1e9 / particle_steps;
        if nanoseconds.is_finite() && substep > 0.0 {
            self.known.push(Known { configuration, substep, nanoseconds });
        }
    }

    /// What a run of a configuration over `simulated` seconds will take, s. Substeps shrink with the spacing; the time per
    /// particle and substep is that of the nearest size.
    pub fn estimate(&self, configuration: &Configuration, simulated: f64) -> f64 {
        let particles = f64::from(configuration.particles);
        let of_scene = self.nearest(configuration, |known| known.scene == configuration.scene);
        let substep = of_scene.map_or_else(
            || configuration.scene.expected_substep(configuration.particles),
            |known| known.substep * (f64::from(known.configuration.particles) / particles).cbrt(),
        );
        let same_solver =
            |known: &Configuration| known.backend == configuration.backend && known.threads == configuration.threads;
        let pace = self
            .nearest(configuration, |known| same_solver(known) && known.scene == configuration.scene)
            .or_else(|| self.nearest(configuration, same_solver));
        let nanoseconds = pace.map_or_else(|| cautious(configuration), |known| known.nanoseconds);
        particles * (simulated / substep).ceil() * nanoseconds / 1e9
    }

    /// The estimate of `repeats` runs if it fits into what is left, with `reserved` already promised to others.
    ///
    /// # Errors
    /// The configuration and its estimate if it does not fit.
    pub fn admit(
        &self,
        configuration: Configuration,
        simulated: f64,
        repeats: u16,
        reserved: f64,
    ) -> Result<f64, Skipped> {
        let estimate = self.estimate(&configuration, simulated) * f64::from(repeats);
        let left = (self.left() - reserved).max(0.0);
        if estimate <= left { Ok(estimate) } else { Err(Skipped { configuration, estimate, left }) }
    }

    fn nearest(&self, to: &Configuration, wanted: impl Fn(&Configuration) -> bool) -> Option<&Known> {
        let distance = |known: &Known| (f64::from(known.configuration.particles) / f64::from(to.particles)).ln().abs();
        let wanted = self.known.iter().filter(|known| wanted(&known.configuration));
        wanted.min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }
}

#[cfg(test)]
mod tests {
    use super::super::BenchScene;
    use super::*;

    fn on_cpu(particles: u32) -> Configuration {
        Configuration { scene: BenchScene::Tank, backend: Backend::Cpu, threads: Some(2), particles }
    }

    #[test]
    fn what_does_not_fit_is_named_with_its_cost() {
        let mut budget = Budget::new(30.0);
        // 8,000 particles, 1,000 substeps of 0.1 ms in 1.6 s: 200 ns.
        budget.learn(on_cpu(8_000), 8e6, 1e-4, Duration::from_millis(1600));
        // Twice as fine: half the substep.
        let estimate = budget.estimate(&on_cpu(64_000), 0.1);
        assert!((estimate - 64_000.0 * 2000.0 * 200e-9).abs() < 0.02, "{estimate}");
        assert!(budget.admit(on_cpu(64_000), 0.1, 1, 0.0).is_ok());
        assert!(budget.admit(on_cpu(64_000), 0.1, 1, 10.0).is_err(), "10 of 28.4 s are promised to others");
        let skipped = budget.admit(on_cpu(64_000), 0.1, 3, 0.0);
        let Err(skipped) = skipped else { panic!("77 s into 28 s: {skipped:?}") };
        let text = skipped.to_string();
        assert!(text.starts_with("tank, 64000 particles, cpu, 2 threads: about 76.8 s, 28.4 s left"), "{text}");
    }

    #[test]
    fn before_anything_is_known_costs_are_guessed_high() {
        let budget = Budget::new(1.0);
        let gpu = Configuration { backend: Backend::Gpu, threads: None, ..on_cpu(64_000) };
        assert!(budget.estimate(&gpu, 0.5) > 4.0 * budget.estimate(&on_cpu(64_000), 0.5));
        assert!(budget.admit(gpu, 0.5, 1, 0.0).is_err());
    }

    #[test]
    fn another_scene_lends_its_pace_not_its_step() {
        let mut budget = Budget::new(1e3);
        budget.learn(on_cpu(32_768), 1e9, 1e-4, Duration::from_secs(100));
        let krog = Configuration { scene: BenchScene::Krog, ..on_cpu(32_768) };
        let substeps = (0.25 / BenchScene::Krog.expected_substep(32_768)).ceil();
        assert!((budget.estimate(&krog, 0.25) - 32_768.0 * substeps * 100e-9).abs() < 1e-6);
    }
}
