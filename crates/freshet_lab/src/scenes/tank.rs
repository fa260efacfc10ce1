//! The benchmark tank: 2.0 x 1.5 x 1.0 m with all six walls, a cubic metre of water in a corner.

use freshet_core::scene::{Boundary, FluidScene, Volume};
use glam::Vec3;

/// The tank with about `particles` particles, the nearest cube of a whole number.
pub fn scene(particles: u32) -> FluidScene {
    let spacing = 1.0 / edge(particles) as f32;
    let tank = Vec3::new(2.0, 1.5, 1.0);
    FluidScene {
        name: format!("tank with {} particles", count(particles)),
        volumes: vec![Volume::block(Vec3::splat(0.5), Vec3::splat(0.5))],
        boundaries: vec![Boundary::closed_box(tank, tank / 2.0)],
        ..FluidScene::with_spacing(spacing)
    }
}

/// Particles the tank really gets.
pub fn count(particles: u32) -> u32 {
    edge(particles).pow(3)
}

fn edge(particles: u32) -> u32 {
    f64::from(particles).cbrt().round().max(1.0) as u32
}

#[cfg(test)]
mod tests {
    use freshet_core::plan::{Plan, SceneError};

    use super::*;

    #[test]
    fn the_block_has_the_particles_asked_for() -> Result<(), SceneError> {
        for particles in [8_000, 27_000, 64_000, 125_000] {
            assert_eq!(Plan::new(&scene(particles))?.positions.len(), particles as usize);
        }
        assert_eq!(count(10_000), 10_648);
        Ok(())
    }

    #[test]
    fn all_six_walls_are_there() -> Result<(), SceneError> {
        let plan = Plan::new(&scene(8_000))?;
        let (depth, size) = (plan.parameters.boundary_depth, Vec3::new(2.0, 1.5, 1.0));
        for axis in 0..3 {
            for face in [-depth, size[axis] + depth] {
                let near = plan.boundary.positions.iter().filter(|sample| (sample[axis] - face).abs() < 0.1 * depth);
                assert!(near.count() > 100, "axis {axis} at {face} m");
            }
        }
        Ok(())
    }
}
