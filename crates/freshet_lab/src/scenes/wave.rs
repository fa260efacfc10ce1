//! A standing wave on water of one depth: a wavelength of it that repeats itself.

use std::f64::consts::TAU;

use freshet_core::periodic::Periodic;
use freshet_core::scene::{Boundary, BoundaryShape, FluidScene, Volume};
use glam::{DVec3, Vec3};

use super::GRAVITY;
use crate::reference::standing_wave;

/// Depth, m.
pub const DEPTH: f64 = 0.5;
/// Length of the wave, m: twice the depth, so that next to nothing moves at the bottom.
pub const LENGTH: f64 = 1.0;
/// Amplitude times wavenumber. The period grows by an eighth of its square, 0.1 %.
pub const STEEPNESS: f64 = 0.1;
/// Width in spacings: four support radii of up to three spacings, the shortest there is.
const WIDTH: f32 = 12.0;

/// Wavenumber, 1/m.
pub fn wavenumber() -> f64 {
    TAU / LENGTH
}

/// The water at rest, flat, `across` particles deep, its crests to be along z.
pub fn scene(across: u32) -> FluidScene {
    let spacing = (DEPTH / f64::from(across)) as f32;
    let half = Vec3::new(LENGTH as f32, DEPTH as f32, WIDTH * spacing) / 2.0;
    FluidScene {
        name: format!("standing wave, {across} spacings of depth"),
        volumes: vec![Volume { hydrostatic: true, ..Volume::block(half, Vec3::Y * half.y) }],
        boundaries: vec![Boundary::new(BoundaryShape::Plane { half_extents: [half.x, half.z] }, Vec3::ZERO)],
        periodic: Periodic { x: Some((-half.x, half.x)), y: None, z: Some((-half.z, half.z)) },
        ..FluidScene::with_spacing(spacing)
    }
}

/// The velocity of the flat water from which the wave rises, m/s: potential flow with the amplitude of [`STEEPNESS`].
pub fn velocity(position: Vec3) -> Vec3 {
    let (x, k) = (position.as_dvec3(), wavenumber());
    let surface = STEEPNESS / k * standing_wave::frequency(GRAVITY, k, DEPTH);
    let (along, up) = ((k * x.y).cosh(), (k * x.y).sinh());
    let flow = DVec3::new(-(k * x.x).sin() * along, (k * x.x).cos() * up, 0.0);
    (surface / (k * DEPTH).sinh() * flow).as_vec3()
}

/// How high the wave is of what it is at most, from where the particles are: 1 at `cos(k x)` times the amplitude.
///
/// The mean of `cos(k x)` over all of an incompressible fluid: its integral over the depth is `integral of eta cos(k x) dx`.
pub fn height(positions: &[Vec3]) -> f64 {
    let k = wavenumber();
    let sum: f64 = positions.iter().map(|x| (k * f64::from(x.x)).cos()).sum();
    sum / positions.len() as f64 * 2.0 * DEPTH * k / STEEPNESS
}

#[cfg(test)]
mod tests {
    use freshet_core::plan::Plan;

    use super::*;

    #[test]
    fn the_flow_compresses_nothing_and_stays_on_the_floor() {
        let h = 1e-2;
        let v = |x: f32, y: f32| velocity(Vec3::new(x, y, 0.0));
        for (x, y) in [(0.1, 0.1), (0.3, 0.4), (-0.2, 0.25)] {
            let divergence = (v(x + h, y).x - v(x - h, y).x + v(x, y + h).y - v(x, y - h).y) / (2.0 * h);
            let rate = (v(x + h, y).x - v(x - h, y).x).abs() / (2.0 * h);
            assert!(divergence.abs() < 1e-2 * rate, "{divergence} of {rate} at {x}, {y}");
        }
        assert!(v(0.1, 0.0).y.abs() < 1e-6);
        let (crest, k) = (v(0.0, DEPTH as f32).y, wavenumber());
        let wanted = STEEPNESS / k * standing_wave::frequency(GRAVITY, k, DEPTH);
        assert!((f64::from(crest) / wanted - 1.0).abs() < 1e-5, "{crest} of {wanted}");
    }

    #[test]
    fn heights_are_those_of_a_surface_that_is_a_cosine() -> Result<(), freshet_core::plan::SceneError> {
        let plan = Plan::new(&scene(24))?;
        assert!(height(&plan.positions).abs() < 1e-4, "{}", height(&plan.positions));
        // Moved as the flow moves it, to first order.
        let k = wavenumber();
        let time = 1.0 / standing_wave::frequency(GRAVITY, k, DEPTH);
        let moved: Vec<Vec3> = plan.positions.iter().map(|&x| x + time as f32 * velocity(x)).collect();
        assert!((height(&moved) - 1.0).abs() < 0.02, "{}", height(&moved));
        Ok(())
    }
}
