//! Freshet's laboratory on the command line.

use std::process::ExitCode;

use clap::Parser;
use freshet_lab::commands::Command;
use freshet_lab::error::LabError;
use freshet_lab::output::say;

/// Freshet's laboratory: simulations against measurements, charts of accuracy and speed.
///
/// Every command prints a table, writes CSV and SVG files after each finished case (so Ctrl-C leaves what was done), and
/// ends with 0 if every bound was kept, 1 if a case missed its bound, 2 for a bad argument, 3 if it could not run.
/// Build it with --release: otherwise times mean nothing.
#[derive(Parser)]
#[command(name = "freshet_lab", version, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

fn main() -> ExitCode {
    match Arguments::parse().command.run() {
        Ok(verdict) => {
            say(format_args!("\n{verdict}"));
            if verdict.passes() { ExitCode::SUCCESS } else { ExitCode::from(1) }
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(if matches!(error, LabError::Argument { .. }) { 2 } else { 3 })
        }
    }
}
