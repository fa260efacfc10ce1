//! A column of water at rest in a container that fits it. The container is a body, so that what it carries is reported.

use freshet_core::plan::SceneError;
use freshet_core::scene::{Body, FluidScene, Volume};
use freshet_core::step::BodyInput;
use glam::Vec3;

/// Edge of the column's square base, m.
pub const BASE: f64 = 0.25;
/// Depth of the water, m.
pub const DEPTH: f64 = 0.5;
/// Distance of particles, m.
pub const SPACING: f64 = 0.025;
/// Height of the container's walls, m.
const WALLS: f64 = 0.65;
/// Particles of a layer.
pub const PER_LAYER: usize = 100;

/// 2,000 particles in an open container whose floor is at y = 0.
pub fn scene() -> Result<FluidScene, SceneError> {
    let column = Vec3::new(BASE as f32, DEPTH as f32, BASE as f32);
    let size = Vec3::new(BASE as f32, WALLS as f32, BASE as f32);
    let mut scene = FluidScene {
        name: "column".to_owned(),
        volumes: vec![Volume::block(column / 2.0, Vec3::new(0.0, column.y / 2.0, 0.0))],
        ..FluidScene::with_spacing(SPACING as f32)
    };
    let open = [false, false, false, true, false, false];
    let samples = scene.wall_layer()?.container(size / 2.0, open)?;
    scene.bodies.push(Body { name: "container".to_owned(), samples });
    Ok(scene)
}

/// The container where it stands; the fluid cannot move it.
pub fn container() -> BodyInput {
    BodyInput { position: Vec3::new(0.0, WALLS as f32 / 2.0, 0.0), ..BodyInput::default() }
}

#[cfg(test)]
mod tests {
    use freshet_core::plan::Plan;

    use super::*;

    #[test]
    fn column_and_container_fit() -> Result<(), SceneError> {
        let plan = Plan::new(&scene()?)?;
        assert_eq!(plan.positions.len(), 2_000);
        let heights = plan.bodies[0].samples.iter().map(|sample| sample.y + container().position.y);
        let lowest = heights.fold(f32::INFINITY, f32::min);
        let depth = plan.parameters.boundary_depth;
        assert!((lowest + depth).abs() < 1e-5, "samples {depth} below the floor, not {lowest}");
        assert!((BASE / SPACING).powi(2) as usize == PER_LAYER);
        Ok(())
    }
}
