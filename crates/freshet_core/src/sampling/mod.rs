//! Points in volumes and on walls: the start positions of fluids, and the samples that boundaries are made of.
//!
//! Everything is deterministic, centred on the origin and in the axes of the shape; placing it in the world is up to the
//! caller. Coordinates are worked out in `f64` and rounded once.

pub mod boundary;
pub mod lattice;
mod level_set;
mod poisson;
pub mod quasi_fluid;
pub mod shapes;
mod surface;
mod thin_parts;
pub mod volume_weights;
pub mod wall_layer;

use glam::Vec3;

use crate::error::{InvalidInput, check_range};

/// Most samples that one call makes, 64 Mi; it is checked before any memory is taken.
pub const MAX_SAMPLES: usize = 64 << 20;

/// Most samples of a layer behind a curved surface or a mesh, 2 Mi; it is estimated by the area, before any memory is taken.
pub const MAX_CURVED_SAMPLES: usize = 2 << 20;

/// Smallest spacing of samples, in metres.
pub const MIN_SPACING: f32 = 1.0e-6;
/// Largest spacing of samples, in metres.
pub const MAX_SPACING: f32 = 1.0e4;
/// Smallest half extent or radius of a sampled shape, in metres.
pub const MIN_EXTENT: f32 = 1.0e-6;
/// Largest half extent or radius of a sampled shape, in metres.
pub const MAX_EXTENT: f32 = 1.0e6;

/// Lengths that were meant to be equal differ by rounding in `f32`; in comparisons this share is let pass.
const ROUNDING: f64 = 1.0e-6;

fn check_spacing(spacing: f32) -> Result<f64, InvalidInput> {
    check_range("spacing", spacing, MIN_SPACING, MAX_SPACING, "m")?;
    Ok(f64::from(spacing))
}

fn check_extent(field: &str, extent: f32) -> Result<f64, InvalidInput> {
    check_range(field, extent, MIN_EXTENT, MAX_EXTENT, "m")?;
    Ok(f64::from(extent))
}

fn check_half_extents(half_extents: Vec3) -> Result<[f64; 3], InvalidInput> {
    Ok([
        check_extent("half_extents.x", half_extents.x)?,
        check_extent("half_extents.y", half_extents.y)?,
        check_extent("half_extents.z", half_extents.z)?,
    ])
}

/// `count`, which may be far beyond any integer, as a size to allocate.
fn check_count(spacing: f64, count: f64) -> Result<usize, InvalidInput> {
    if count <= MAX_SAMPLES as f64 {
        Ok(count as usize)
    } else {
        let allowed =
            format_args!("a spacing for at most {MAX_SAMPLES} samples; this one makes {count:.3e}").to_string();
        Err(InvalidInput::new("spacing", spacing as f32, allowed))
    }
}

/// Refuses a curved layer of more than [`MAX_CURVED_SAMPLES`] by an estimate, which may be far beyond any integer.
fn check_estimate(count: f64, spacing: f64) -> Result<(), InvalidInput> {
    if count <= MAX_CURVED_SAMPLES as f64 { Ok(()) } else { Err(too_many(spacing, count)) }
}

fn too_many(spacing: f64, count: f64) -> InvalidInput {
    let allowed = format!("a spacing for at most {MAX_CURVED_SAMPLES} samples; this one makes {count:.3e}");
    InvalidInput::new("spacing", spacing as f32, allowed)
}

/// The error of a shape thinner than `least` metres, which is what the spacing allows.
fn too_thin(field: &str, value: f64, least: f64) -> InvalidInput {
    InvalidInput::new(field, value as f32, format_args!("at least {} m at this spacing", least as f32))
}
