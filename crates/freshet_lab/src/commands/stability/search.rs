//! Finds the largest stable step of a configuration.

use freshet_core::scene::Settings;

use super::trial::{Configuration, Failure};
use crate::error::LabError;

/// The smallest CFL number that is tried.
pub const LEAST: f64 = 0.1;
/// The largest.
pub const MOST: f64 = 4.0;
/// What it takes for a stride before it bisects.
const STRIDE: f64 = 1.6;

/// What was found of a configuration.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Of which.
    pub configuration: Configuration,
    /// The largest CFL number that was stable; zero if not even the smallest tried was.
    pub stable: f64,
    /// How the smallest failed that was not; none if the largest tried was stable.
    pub failure: Option<Failure>,
    /// Runs made.
    pub runs: u32,
}

/// Bisects until the smallest failed over the largest stable number is at most `precision`; `survives` says of a number how a
/// run with it failed, if it did.
pub fn search(
    configuration: &Configuration,
    precision: f64,
    mut survives: impl FnMut(f64) -> Result<Option<Failure>, LabError>,
) -> Result<Found, LabError> {
    let mut found = Found { configuration: *configuration, stable: 0.0, failure: None, runs: 0 };
    // The search begins at the plan's own.
    let begin = f64::from(Settings::default().courant_factor);
    let (mut stable, mut failed): (Option<f64>, Option<f64>) = (None, None);
    loop {
        let number = match (stable, failed) {
            (None, None) => begin,
            (Some(stable), None) if stable >= MOST => break,
            (Some(stable), None) => (stable * STRIDE).min(MOST),
            (None, Some(failed)) if failed <= LEAST => break,
            (None, Some(failed)) => (failed / STRIDE).max(LEAST),
            (Some(stable), Some(failed)) if failed / stable <= precision => break,
            (Some(stable), Some(failed)) => (stable * failed).sqrt(),
        };
        found.runs += 1;
        match survives(number)? {
            None => stable = Some(number),
            Some(failure) => {
                failed = Some(number);
                found.failure = Some(failure);
            }
        }
    }
    found.stable = stable.unwrap_or(0.0);
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::Backend;
    use crate::commands::stability::Situation;

    fn found(limit: f64) -> Found {
        let configuration = Configuration::of_defaults(Backend::Cpu, Situation::Calm);
        let survives = |number| Ok((number > limit).then_some(Failure::Energy));
        search(&configuration, 1.05, survives).unwrap_or_else(|error| panic!("{error}"))
    }

    #[test]
    fn the_limit_is_bracketed_to_a_twentieth() {
        for limit in [0.11, 0.39, 0.41, 0.73, 1.9, 3.7] {
            let found = found(limit);
            assert!((limit / 1.05..=limit).contains(&found.stable), "{} of {limit}", found.stable);
            assert_eq!(found.failure, Some(Failure::Energy));
            assert!(found.runs < 14, "{} runs", found.runs);
        }
    }

    #[test]
    fn beyond_both_ends_it_stops() {
        assert_eq!((found(9.0).stable, found(9.0).failure), (MOST, None));
        assert_eq!((found(0.01).stable, found(0.01).failure), (0.0, Some(Failure::Energy)));
    }
}
