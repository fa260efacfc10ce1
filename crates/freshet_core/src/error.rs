//! Errors of the model: one enum a stage, each naming the thing, the value and what is allowed.

use std::fmt::Display;

/// One input outside its allowed range.
///
/// `field` is a path such as `volumes[1].shape.radius`, so that the user finds the place without guessing.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{field}: {value} is not allowed; allowed: {allowed}")]
pub struct InvalidInput {
    /// Path of the field in the scene, argument list or component.
    pub field: String,
    /// The value as given.
    pub value: String,
    /// The allowed range, in words or as an interval with its unit.
    pub allowed: String,
}

impl InvalidInput {
    /// Builds the error from anything printable.
    pub fn new(field: impl Display, value: impl Display, allowed: impl Display) -> Self {
        Self { field: field.to_string(), value: value.to_string(), allowed: allowed.to_string() }
    }

    /// The same error, seen from one level further out: `inside("volumes[1]")` turns `radius` into `volumes[1].radius`.
    #[must_use]
    pub fn inside(mut self, parent: impl Display) -> Self {
        self.field = format!("{parent}.{}", self.field);
        self
    }
}

/// Checks that `value` is finite and within `min..=max`; `unit` is printed with the range.
pub fn check_range(field: &str, value: f32, min: f32, max: f32, unit: &str) -> Result<(), InvalidInput> {
    if value.is_finite() && (min..=max).contains(&value) {
        Ok(())
    } else {
        Err(InvalidInput::new(field, value, format_args!("{min} to {max} {unit}")))
    }
}

/// Checks that all three components are finite.
pub fn check_finite(field: &str, value: glam::Vec3) -> Result<(), InvalidInput> {
    if value.is_finite() { Ok(()) } else { Err(InvalidInput::new(field, value, "finite numbers")) }
}
