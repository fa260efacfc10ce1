//! The command line.

use std::path::{Path, PathBuf};

use bevy_freshet::prelude::FluidBackend;
use clap::Parser;
use freshet_examples::arguments::{backend, count};

use crate::level::Level;

/// Guide water through a mill wheel into a basin before the time is over.
#[derive(Parser, Clone, Debug)]
#[command(name = "sluice")]
pub struct Arguments {
    /// The level to begin with; 1 is the first.
    #[arg(long, default_value = "1")]
    pub level: usize,
    /// Folder with levels (*.ron, in the order of their names) instead of assets/sluice.
    #[arg(long, value_name = "FOLDER")]
    pub levels: Option<PathBuf>,
    /// Particles of a level's water, about: 500 to 200000.
    #[arg(long, default_value = "10000", value_parser = |text: &str| count(text, 500, 200_000))]
    pub particles: u32,
    /// What simulates: auto, gpu or cpu. auto is the GPU where there is a hardware adapter.
    #[arg(long, default_value = "auto", value_parser = backend)]
    pub backend: FluidBackend,
    /// Makes the moves that the level's file says.
    #[arg(long)]
    pub autoplay: bool,
    /// Plays one level without a window, and prints how it ended.
    #[arg(long)]
    pub headless: bool,
    /// A picture of the end; without a window.
    #[arg(long, value_name = "FILE.png")]
    pub picture: Option<PathBuf>,
}

impl Arguments {
    /// All levels; the error is one line.
    pub fn levels(&self) -> Result<Vec<Level>, String> {
        let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/sluice");
        let folder = self.levels.as_deref().unwrap_or(&own);
        let levels = Level::read_all(folder)?;
        if (1..=levels.len()).contains(&self.level) {
            Ok(levels)
        } else {
            Err(format!("--level {}: allowed: 1 to {}", self.level, levels.len()))
        }
    }
}
