//! Pieces of a command line. What is wrong is said in one line.

use std::ffi::OsString;
use std::process::ExitCode;

use bevy_freshet::prelude::FluidBackend;
use clap::Parser;
use clap::error::ErrorKind;

/// Reads the command line. Otherwise the program is over: the help was asked for, or something is wrong with it, which has been said.
pub fn read<T: Parser>(given: impl IntoIterator<Item = OsString>) -> Result<T, ExitCode> {
    T::try_parse_from(given).map_err(|error| match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => {
            print!("{error}");
            ExitCode::SUCCESS
        }
        _ => {
            let text = error.to_string();
            refuse(text.lines().next().unwrap_or_default().trim_start_matches("error: "))
        }
    })
}

/// Says what is wrong with the input.
pub fn refuse(message: &str) -> ExitCode {
    eprintln!("error: {message}");
    ExitCode::from(2)
}

/// How a program ends: what went wrong is its last line.
pub fn end(result: Result<(), String>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

/// A whole number in a range.
pub fn count(text: &str, least: u32, most: u32) -> Result<u32, String> {
    text.parse()
        .ok()
        .filter(|count| (least..=most).contains(count))
        .ok_or_else(|| format!("allowed: {least} to {most}"))
}

/// Simulated seconds, 0.01 to 600.
pub fn seconds(text: &str) -> Result<f32, String> {
    text.parse()
        .ok()
        .filter(|seconds| (0.01..=600.0).contains(seconds))
        .ok_or_else(|| "allowed: 0.01 to 600".to_owned())
}

/// What simulates.
pub fn backend(text: &str) -> Result<FluidBackend, String> {
    match text {
        "auto" => Ok(FluidBackend::Auto),
        "gpu" => Ok(FluidBackend::Gpu),
        "cpu" => Ok(FluidBackend::Cpu),
        _ => Err("allowed: auto, gpu, cpu".to_owned()),
    }
}
