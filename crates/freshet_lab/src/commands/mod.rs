//! The commands, one file each.

use clap::Subcommand;

use crate::error::LabError;
use crate::verdict::Verdict;

pub mod bench;
pub mod column;
pub mod dam_break;
pub mod float;
pub mod leaks;
pub mod peers;
pub mod report;
pub mod stability;
pub mod validate;

/// What the laboratory can do.
#[derive(Subcommand, Debug)]
pub enum Command {
    /// Dam breaks against Martin & Moyce 1952 and Lobovsky 2014: front and column height over time at several resolutions.
    DamBreak(dam_break::DamBreakArgs),
    /// A column of water at rest: floor pressure, weight on the container, surface level, compression, speed.
    Column(column::ColumnArgs),
    /// A rapier ball of half the density of water: draft, heave, momentum ledger, at several latencies.
    Float(float::FloatArgs),
    /// Thin walls, moving walls and every shape under fire: nothing may get through.
    Leaks(leaks::LeaksArgs),
    /// Every case of the registry against exact solutions and measurements, at three resolutions.
    Validate(validate::ValidateArgs),
    /// The largest stable step for every kernel, number of neighbours, speed of sound and equation of state.
    Stability(stability::StabilityArgs),
    /// Speed: nanoseconds per particle and step by scene, size, pass and number of threads, within a time.
    Bench(bench::BenchArgs),
    /// Freshet, salva3d and SPlisHSPlasH in the benchmark tank, in turn in one run.
    Peers(peers::PeersArgs),
    /// All charts, tables and pictures of the last runs on one HTML page.
    Report(report::ReportArgs),
}

impl Command {
    /// Runs it.
    pub fn run(&self) -> Result<Verdict, LabError> {
        match self {
            Command::DamBreak(args) => dam_break::run(args),
            Command::Column(args) => column::run(args),
            Command::Float(args) => float::run(args),
            Command::Leaks(args) => leaks::run(args),
            Command::Validate(args) => validate::run(args),
            Command::Stability(args) => stability::run(args),
            Command::Bench(args) => bench::run(args),
            Command::Peers(args) => peers::run(args),
            Command::Report(args) => report::run(args),
        }
    }
}
