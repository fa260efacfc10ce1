//! How fast the flow and its sound are.

use glam::Vec3;

use super::resolution::spacing_of;
use crate::equation_of_state::EquationOfState;
use crate::sampling::wall_layer::WallLayer;
use crate::scene::{FluidScene, Settings};

/// The speed the flow is expected to reach, and why (METHODS, Pressure: twice `sqrt(g D)` for a dam break).
pub(super) fn expected_speed(
    scene: &FluidScene,
    positions: &[Vec3],
    walls: &[Vec3],
    layer: &WallLayer,
) -> (f32, String) {
    if let Some(speed) = scene.settings.expected_speed {
        return (speed, "given by settings.expected_speed".to_owned());
    }
    // Along an axis that repeats nothing is high or low.
    let down = scene.periodic.across(scene.gravity);
    let gravity = down.length();
    let up = if gravity > 0.0 { -down / gravity } else { Vec3::Y };
    let heights = |points: &[Vec3]| {
        points
            .iter()
            .map(|point| point.dot(up))
            .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), height| (low.min(height), high.max(height)))
    };
    let mut best = (1e-2, "nothing moves it; 0.01 m/s".to_owned());
    let mut consider = |speed: f32, reason: String| {
        if speed > best.0 {
            best = (speed, reason);
        }
    };
    let (fluid_low, fluid_high) = heights(positions);
    // Faces lie in front of their samples.
    let wall_low = heights(walls).0 + layer.depth;
    if !positions.is_empty() {
        let depth = fluid_high - fluid_low + spacing_of(scene);
        consider(2.0 * (gravity * depth).sqrt(), format!("2 sqrt(g D) of a column D = {depth:.4} m deep"));
    }
    for (index, volume) in scene.volumes.iter().enumerate() {
        let initial = volume.velocity.length();
        let fall = if wall_low.is_finite() { (fluid_high - wall_low).max(0.0) } else { 0.0 };
        let speed = (initial * initial + 2.0 * gravity * fall).sqrt();
        consider(speed, format!("volumes[{index}] at {initial} m/s falling {fall:.4} m"));
    }
    for (index, boundary) in scene.boundaries.iter().enumerate() {
        let speed = boundary.velocity.length();
        consider(speed, format!("boundaries[{index}] drags the fluid along at {speed} m/s"));
    }
    for (index, emitter) in scene.emitters.iter().enumerate() {
        let low = wall_low.min(fluid_low);
        let fall = if low.is_finite() { (emitter.center.dot(up) - low).max(0.0) } else { 0.0 };
        let speed = (emitter.speed * emitter.speed + 2.0 * gravity * fall).sqrt();
        consider(speed, format!("emitters[{index}] at {} m/s falling {fall:.4} m", emitter.speed));
    }
    best
}

/// The equation of state, and its speed of sound at rest density, m/s.
pub(super) fn equation_and_sound_speed(
    settings: &Settings,
    rest_density: f32,
    expected: f32,
) -> (EquationOfState, f32) {
    let sound_speed = settings.sound_speed.unwrap_or(10.0 * expected);
    let equation = settings.equation_of_state.unwrap_or(EquationOfState::Tait { sound_speed, exponent: 7.0 });
    (equation, equation.sound_speed(f64::from(rest_density)) as f32)
}
