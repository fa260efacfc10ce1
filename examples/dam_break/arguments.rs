//! The command line.

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

use bevy_freshet::prelude::FluidBackend;
use clap::Parser;
use clap::error::ErrorKind;

/// Fewest particles of the tank, about.
pub const MIN_PARTICLES: u32 = 100;
/// Most particles of the tank, about.
pub const MAX_PARTICLES: u32 = 2_000_000;
/// Fixed ticks in a second without a window.
pub const TICKS_PER_SECOND: u32 = 60;

/// A column of water collapses in a tank, and two balls float away on it.
#[derive(Parser, Clone, Debug)]
#[command(name = "dam_break")]
pub struct Arguments {
    /// Particles, about: 100 to 2000000.
    #[arg(long, default_value = "12000", value_parser = particles)]
    pub particles: u32,
    /// Simulated seconds, 0.01 to 600, rounded to ticks of 1/60 s; without a window.
    #[arg(long, default_value = "2", value_parser = seconds)]
    pub seconds: f32,
    /// What simulates: auto, gpu or cpu. auto is the GPU where there is a hardware adapter.
    #[arg(long, default_value = "auto", value_parser = backend)]
    pub backend: FluidBackend,
    /// Writes pictures instead of opening a window. So it does without a display, too.
    #[arg(long)]
    pub headless: bool,
    /// Pictures for each simulated second, 1 to 60, and one at the end; without a window.
    #[arg(long, default_value = "15", value_parser = pictures)]
    pub pictures: u32,
    /// Folder for pictures, summary and plot.
    #[arg(long, default_value = "target/dam_break")]
    pub out: PathBuf,
    /// Another scene, in RON, instead of the tank (then --particles does not count).
    #[arg(long, value_name = "FILE.ron")]
    pub scene: Option<PathBuf>,
}

impl Arguments {
    /// Reads the command line. What is wrong is said in one line.
    pub fn read(given: impl IntoIterator<Item = OsString>) -> Result<Self, ExitCode> {
        Self::try_parse_from(given).map_err(|error| match error.kind() {
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

    /// Makes the folder for what is written; the error is one line.
    pub fn make_folder(&self) -> Result<(), String> {
        std::fs::create_dir_all(&self.out).map_err(|error| format!("--out {}: {error}", self.out.display()))
    }

    /// Ticks to be simulated without a window, at least one.
    pub fn ticks(&self) -> u32 {
        (f64::from(self.seconds) * f64::from(TICKS_PER_SECOND)).round().max(1.0) as u32
    }
}

/// Says what is wrong with the input.
pub fn refuse(message: &str) -> ExitCode {
    eprintln!("error: {message}");
    ExitCode::from(2)
}

fn particles(text: &str) -> Result<u32, String> {
    text.parse()
        .ok()
        .filter(|count| (MIN_PARTICLES..=MAX_PARTICLES).contains(count))
        .ok_or_else(|| format!("allowed: {MIN_PARTICLES} to {MAX_PARTICLES}"))
}

fn pictures(text: &str) -> Result<u32, String> {
    text.parse().ok().filter(|count| (1..=60).contains(count)).ok_or_else(|| "allowed: 1 to 60".to_owned())
}

fn seconds(text: &str) -> Result<f32, String> {
    text.parse()
        .ok()
        .filter(|seconds| (0.01..=600.0).contains(seconds))
        .ok_or_else(|| "allowed: 0.01 to 600".to_owned())
}

fn backend(text: &str) -> Result<FluidBackend, String> {
    match text {
        "auto" => Ok(FluidBackend::Auto),
        "gpu" => Ok(FluidBackend::Gpu),
        "cpu" => Ok(FluidBackend::Cpu),
        _ => Err("allowed: auto, gpu, cpu".to_owned()),
    }
}
