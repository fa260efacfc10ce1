//! What can go wrong before there is a result. A case that misses its bound is not an error: see
//! [`Verdict`](crate::verdict::Verdict).

use std::path::{Path, PathBuf};

use freshet_core::error::InvalidInput;
use freshet_core::plan::SceneError;
use freshet_core::solver::SolverError;

/// Why a command has no result.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LabError {
    /// A scene of the laboratory cannot be planned.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A value is not allowed.
    #[error(transparent)]
    Invalid(#[from] InvalidInput),
    /// A solver refused or failed.
    #[error(transparent)]
    Solver(#[from] SolverError),
    /// A file cannot be written.
    #[error("{path}: {source}")]
    File {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A chart cannot be drawn.
    #[error("{path}: the chart cannot be drawn: {reason}")]
    Chart {
        /// The chart's file.
        path: PathBuf,
        /// What the drawing library says.
        reason: String,
    },
    /// An argument passed clap but makes no sense.
    #[error("{argument}: {reason}")]
    Argument {
        /// Its name on the command line.
        argument: &'static str,
        /// What is wrong and what is allowed.
        reason: String,
    },
    /// Another system failed.
    #[error("{peer} failed: {reason}")]
    Peer {
        /// Its name.
        peer: &'static str,
        /// What it says.
        reason: String,
    },
    /// A run gave too little to measure.
    #[error("{what} cannot be measured: {reason}")]
    Measure {
        /// What was to be measured.
        what: &'static str,
        /// Why it cannot.
        reason: String,
    },
}

impl LabError {
    /// For `map_err` on file operations.
    pub fn file(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self::File { path, source }
    }
}
