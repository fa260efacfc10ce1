//! Why a scene cannot be planned or read.

use crate::error::InvalidInput;

/// Why a scene cannot be planned or read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A value is not allowed.
    #[error(transparent)]
    Invalid(#[from] InvalidInput),
    /// Two volumes share space.
    #[error("volumes[{first}] and volumes[{second}] overlap near {place}; allowed: shapes that share no space")]
    Overlap {
        /// Index of one volume.
        first: usize,
        /// Index of the other.
        second: usize,
        /// Where, m.
        place: String,
    },
    /// The flow would be faster than a tenth of the speed of sound.
    #[error(
        "{field}: a speed of sound of {sound_speed} m/s is not allowed; allowed: at least {least} m/s, ten times the \
         expected speed, or set settings.allow_compressible"
    )]
    Compressible {
        /// The setting it comes from.
        field: &'static str,
        /// The given speed of sound.
        sound_speed: String,
        /// The least that is allowed.
        least: String,
    },
    /// A scene file does not parse.
    #[error("line {line}, column {column}: {message}")]
    Parse {
        /// Line, from one.
        line: usize,
        /// Column, from one.
        column: usize,
        /// What is wrong there.
        message: String,
    },
    /// A value in a scene file is not allowed.
    #[error("line {line}: {error}")]
    InFile {
        /// Line, from one.
        line: usize,
        /// What is wrong there.
        error: Box<SceneError>,
    },
    /// A scene file is too large to be one.
    #[error("the file has {bytes} bytes; allowed: up to {allowed}")]
    TooLarge {
        /// Its size.
        bytes: u64,
        /// The largest accepted.
        allowed: u64,
    },
}
