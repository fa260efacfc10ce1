//! Options every command has.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::backend::Backend;

/// What every command understands.
#[derive(Args, Clone, Debug)]
pub struct CommonOptions {
    /// Short form for tests: under a minute on the CPU, two with a software GPU driver. Coarser or shorter: the command says so first.
    #[arg(long)]
    pub quick: bool,
    /// Which solver runs. Each command says what it takes when this is not given.
    #[arg(long, value_enum)]
    pub backend: Option<BackendChoice>,
    /// Folder for the CSV and SVG files; made if it is not there.
    #[arg(long, value_name = "DIR", default_value = "out/lab")]
    pub out: PathBuf,
}

impl CommonOptions {
    /// The backends to run, the command's own choice unless one was given.
    pub fn backends(&self, unless_given: BackendChoice) -> &'static [Backend] {
        match self.backend.unwrap_or(unless_given) {
            BackendChoice::Cpu => &[Backend::Cpu],
            BackendChoice::Gpu => &[Backend::Gpu],
            BackendChoice::Both => &[Backend::Cpu, Backend::Gpu],
        }
    }
}

/// `--threads`, for the commands that run with one number of them.
#[derive(Args, Clone, Copy, Debug, Default)]
pub struct ThreadOption {
    /// Threads of the CPU solver [default: all cores].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

impl ThreadOption {
    /// Number of threads, none for all cores.
    pub fn count(self) -> Option<usize> {
        self.threads.map(usize::from)
    }
}

/// Value of `--backend`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BackendChoice {
    /// The CPU solver.
    Cpu,
    /// The GPU solver, on the first adapter found; a software driver counts.
    Gpu,
    /// One after the other.
    Both,
}
