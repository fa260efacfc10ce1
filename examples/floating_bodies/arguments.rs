//! The command line.

use std::path::PathBuf;

use bevy_freshet::prelude::FluidBackend;
use clap::Parser;
use freshet_examples::arguments::{backend, count, seconds};

/// Bodies of any shape and density in a pool: drop them with the mouse, drag them, see what the water does to them.
#[derive(Parser, Clone, Debug)]
#[command(name = "floating_bodies")]
pub struct Arguments {
    /// Particles of the pool, about: 1000 to 500000.
    #[arg(long, default_value = "12000", value_parser = |text: &str| count(text, 1000, 500_000))]
    pub particles: u32,
    /// What simulates: auto, gpu or cpu. auto is the GPU where there is a hardware adapter.
    #[arg(long, default_value = "auto", value_parser = backend)]
    pub backend: FluidBackend,
    /// Drops a body of each shape without a window, and prints how they float.
    #[arg(long)]
    pub headless: bool,
    /// Simulated seconds, 0.01 to 600; without a window.
    #[arg(long, default_value = "8", value_parser = seconds)]
    pub seconds: f32,
    /// A picture of the end; without a window.
    #[arg(long, value_name = "FILE.png")]
    pub picture: Option<PathBuf>,
}
