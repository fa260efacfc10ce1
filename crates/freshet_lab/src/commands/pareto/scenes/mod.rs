//! What every configuration is tried on: scenes whose references are exact or measured, small enough for hundreds of runs.

mod ball;
mod channel;
mod column;
mod dam_break;
mod wave;

use std::time::Duration;

use freshet_core::configuration::Configuration;

use super::trial::{Outcome, Stopped};
use crate::backend::Backend;

/// A scene, and how far a run of it is from its reference.
#[derive(Debug)]
pub struct Benchmark {
    /// Name, as in files.
    pub name: &'static str,
    /// Name in sentences and charts.
    pub title: &'static str,
    /// What it is, what it is compared with and what its error is.
    pub about: &'static str,
    /// What its error is made of, as in files.
    pub parts: &'static [&'static str],
    /// Simulates it.
    pub simulate: fn(&Job) -> Outcome,
}

/// By name.
impl PartialEq for Benchmark {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

/// The scenes that a configuration is judged by.
pub const CHOSEN_BY: [&Benchmark; 5] =
    [&dam_break::SQUARE, &column::AT_REST, &ball::DRAWN_OUT, &channel::DRIVEN, &wave::STANDING];
/// The one that takes no part in any choice.
pub const HELD_OUT: &Benchmark = &dam_break::LARGE;

/// A run to make.
#[derive(Clone, Copy, Debug)]
pub struct Job {
    /// How.
    pub configuration: &'static Configuration,
    /// Particles across the fluid.
    pub across: u32,
    /// Where; on the CPU with one thread.
    pub backend: Backend,
    /// Most wall time.
    pub cap: Duration,
}

/// What a run gives: the parts of its error, shares.
type Measured = Result<Vec<f64>, Stopped>;
