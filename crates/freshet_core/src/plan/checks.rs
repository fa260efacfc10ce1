//! What a scene as a whole may not be.

use glam::Vec3;

use super::SceneError;
use crate::error::InvalidInput;
use crate::scene::{FluidScene, MAX_PARTICLES};

/// Refuses particles so far from the origin that `f32` cannot tell a sixty-fourth of their spacing.
pub(super) fn check_precision(corner: Vec3, spacing: f32) -> Result<(), InvalidInput> {
    let reach = corner.max_element();
    let least = reach / (1 << 17) as f32;
    if spacing < least {
        let allowed =
            format!("at least {least} m where positions are up to {reach} m from the origin, as f32 rounds them");
        return Err(InvalidInput::new("resolution", format_args!("spacing {spacing} m"), allowed));
    }
    Ok(())
}

/// Refuses bounds that leave out particles of the start: they would be gone after the first substep.
pub(super) fn check_bounds((min, max): (Vec3, Vec3), positions: &[Vec3]) -> Result<(Vec3, Vec3), InvalidInput> {
    let low = positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    if !(min.cmple(low).all() && max.cmpge(high).all()) {
        let allowed = format!("corners up to {low} and from {high} on, around all particles of the start");
        return Err(InvalidInput::new("settings.bounds", format_args!("{min} {max}"), allowed));
    }
    Ok((min, max))
}

/// Most samples of a body in a cube of the support radius: a layer a spacing apart has about ten there. All that share a place
/// are each other's neighbours, so the work grows with the square of this.
const MAX_CROWD: usize = 1000;

/// Refuses bodies with a crowd of samples.
pub(super) fn check_crowding(samples: &[Vec3], support_radius: f32) -> Result<(), InvalidInput> {
    let cell = |sample: &Vec3| (*sample / support_radius).floor().as_i64vec3().to_array();
    let mut cells: Vec<[i64; 3]> = samples.iter().map(cell).collect();
    cells.sort_unstable();
    let Some(crowd) = cells.chunk_by(|a, b| a == b).find(|crowd| crowd.len() > MAX_CROWD) else { return Ok(()) };
    let near = Vec3::from(crowd[0].map(|index| index as f32)) * support_radius;
    let value = format!("{} in a cube of {support_radius} m near {near}", crowd.len());
    Err(InvalidInput::new("samples", value, format_args!("up to {MAX_CROWD} there; they should lie a spacing apart")))
}

/// The most particles a scene allows, or its emitters can have alive.
pub(super) fn max_particles(scene: &FluidScene, start: usize, spacing: f32) -> Result<u32, SceneError> {
    if let Some(most) = scene.settings.max_particles {
        if (most as usize) < start {
            let allowed = format!("at least {start}, the particles of the start");
            return Err(InvalidInput::new("settings.max_particles", most, allowed).into());
        }
        return Ok(most);
    }
    let mut most = start as u64;
    for (index, emitter) in scene.emitters.iter().enumerate() {
        let Some(count) = emitter.steady_count(spacing) else {
            return Err(InvalidInput::new(
                "settings.max_particles",
                "none",
                format_args!("a number, as emitters[{index}] flows for ever"),
            )
            .into());
        };
        most = most.saturating_add(count);
    }
    if most > u64::from(MAX_PARTICLES) {
        return Err(InvalidInput::new("settings.max_particles", most, format_args!("1 to {MAX_PARTICLES}")).into());
    }
    Ok((most as u32).max(1))
}
