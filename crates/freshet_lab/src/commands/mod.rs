//! The commands, one file each.

use clap::Subcommand;

use crate::error::LabError;
use crate::options::CommonOptions;
use crate::output::say;
use crate::verdict::Verdict;

pub mod bench;
pub mod column;
pub mod convergence;
pub mod dam_break;
pub mod float;
pub mod integrators;
pub mod leaks;
pub mod pareto;
pub mod peers;
pub mod report;
pub mod stability;
pub mod validate;

/// What the laboratory can do.
#[derive(Subcommand, Debug)]
#[expect(missing_docs, reason = "a comment here would hide that of the arguments from --help")]
pub enum Command {
    DamBreak(dam_break::DamBreakArgs),
    Column(column::ColumnArgs),
    Convergence(convergence::ConvergenceArgs),
    Float(float::FloatArgs),
    Integrators(integrators::IntegratorsArgs),
    Leaks(leaks::LeaksArgs),
    Validate(validate::ValidateArgs),
    Stability(stability::StabilityArgs),
    Bench(bench::BenchArgs),
    Pareto(pareto::ParetoArgs),
    Peers(peers::PeersArgs),
    Report(report::ReportArgs),
}

impl Command {
    /// The options that it shares with others.
    fn common(&self) -> Option<&CommonOptions> {
        match self {
            Command::DamBreak(args) => Some(&args.common),
            Command::Column(args) => Some(&args.common),
            Command::Convergence(args) => Some(&args.common),
            Command::Float(args) => Some(&args.common),
            Command::Integrators(args) => Some(&args.common),
            Command::Leaks(args) => Some(&args.common),
            Command::Validate(args) => (!args.list).then_some(&args.common),
            Command::Stability(args) => Some(&args.common),
            Command::Bench(args) => Some(&args.common),
            Command::Pareto(args) => Some(&args.common),
            Command::Peers(args) => Some(&args.common),
            Command::Report(_) => None,
        }
    }

    /// Runs it.
    pub fn run(&self) -> Result<Verdict, LabError> {
        if self.common().is_some_and(|common| common.quick) {
            say(
                "quick form: coarser, shorter or fewer cases than the full one; its numbers are not those of the full form",
            );
        }
        match self {
            Command::DamBreak(args) => dam_break::run(args),
            Command::Column(args) => column::run(args),
            Command::Convergence(args) => convergence::run(args),
            Command::Float(args) => float::run(args),
            Command::Integrators(args) => integrators::run(args),
            Command::Leaks(args) => leaks::run(args),
            Command::Validate(args) => validate::run(args),
            Command::Stability(args) => stability::run(args),
            Command::Bench(args) => bench::run(args),
            Command::Pareto(args) => pareto::run(args),
            Command::Peers(args) => peers::run(args),
            Command::Report(args) => report::run(args),
        }
    }
}
