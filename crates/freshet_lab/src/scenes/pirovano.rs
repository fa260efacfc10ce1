//! Pirovano's comparison of CPU and GPU (Pirovano 2011, section 5.2): a cube of fluid without gravity or walls.
//!
//! From the thesis: 16 or 32 particles along an edge, 27 within the support, Tait's equation with a speed of sound of 10 m/s,
//! 10 Pa s, double density relaxation, steps of 1 ms.
//!
//! Not in its text, so ours: an edge of 1 m. Different in ours: Morris' viscosity where he has Müller's, one kernel (Wendland C2)
//! for all, semi-implicit Euler where he has a velocity Verlet; and no surface tension, which his code computes at zero strength.

use freshet_core::equation_of_state::EquationOfState;
use freshet_core::scene::{FluidScene, Support, Volume};
use freshet_core::viscosity::ViscosityModel;
use glam::Vec3;

/// Edge of the cube, m.
const EDGE: f32 = 1.0;
/// Step, s: below the limits of all conditions at both resolutions, so that a tick of this length is one substep; of the first
/// few, in which the surface draws together, two.
pub const STEP: f64 = 0.001;

/// The cube with about `particles` particles, the nearest cube of a whole number.
pub fn scene(particles: u32) -> FluidScene {
    let along = f64::from(particles).cbrt().round().max(1.0) as f32;
    let mut scene = FluidScene {
        name: format!("Pirovano's cube with {particles} particles"),
        gravity: Vec3::ZERO,
        volumes: vec![Volume::block(Vec3::splat(EDGE / 2.0), Vec3::ZERO)],
        ..FluidScene::with_spacing(EDGE / along)
    };
    scene.material.dynamic_viscosity = 10.0;
    let settings = &mut scene.settings;
    settings.support = Support::Neighbours(27.0);
    settings.equation_of_state = Some(EquationOfState::Tait { sound_speed: 10.0, exponent: 7.0 });
    settings.expected_speed = Some(1.0);
    settings.clamp_negative_pressure = false;
    settings.near_pressure = 0.01;
    settings.artificial_viscosity = 0.0;
    settings.viscosity_model = Some(ViscosityModel::Morris1997);
    scene
}

#[cfg(test)]
mod tests {
    use freshet_core::plan::{Plan, SceneError};
    use freshet_core::work::neighbours;

    use super::*;

    #[test]
    fn the_cube_is_as_published() -> Result<(), SceneError> {
        for particles in [4_096, 32_768] {
            let plan = Plan::new(&scene(particles))?;
            assert_eq!(plan.positions.len(), particles as usize);
            assert!((neighbours(&plan.parameters) - 27.0).abs() < 1e-3);
            assert!(plan.boundary.positions.is_empty());
            let limit = f64::from(plan.parameters.substep_limit(0.5, 1.0));
            assert!(limit > STEP, "a step of {STEP} s is two of {limit}");
        }
        Ok(())
    }
}
