//! The command line.

use std::path::PathBuf;

use bevy_freshet::prelude::{FluidBackend, FluidStyle};
use clap::Parser;
use freshet_examples::arguments::{backend, count, seconds};

use crate::stage::SURFACE;

/// Fewest particles of the tank, about.
pub const MIN_PARTICLES: u32 = 100;
/// Most particles of the tank, about.
pub const MAX_PARTICLES: u32 = 2_000_000;

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
    /// How the water is drawn: as one surface that refracts and tints what is behind it, or as spheres coloured by a field, for a look at
    /// particles; surface or spheres. In the window the key V switches.
    #[arg(long, default_value = "surface", value_parser = style)]
    pub style: FluidStyle,
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
    /// Makes the folder for what is written; the error is one line.
    pub fn make_folder(&self) -> Result<(), String> {
        std::fs::create_dir_all(&self.out).map_err(|error| format!("--out {}: {error}", self.out.display()))
    }
}

fn particles(text: &str) -> Result<u32, String> {
    count(text, MIN_PARTICLES, MAX_PARTICLES)
}

fn style(text: &str) -> Result<FluidStyle, String> {
    match text {
        "surface" => Ok(SURFACE),
        "spheres" => Ok(FluidStyle::Spheres),
        _ => Err("allowed: surface, spheres".to_owned()),
    }
}

fn pictures(text: &str) -> Result<u32, String> {
    count(text, 1, 60)
}
