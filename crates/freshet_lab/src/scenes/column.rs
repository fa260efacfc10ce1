//! A column of water at rest in a container that fits it.

use freshet_core::plan::SceneError;
use freshet_core::scene::{Body, Boundary, FluidScene, Volume};
use freshet_core::step::BodyInput;
use glam::Vec3;

/// Edge of the column's square base, m.
pub const BASE: f64 = 0.25;
/// Depth of the water, m.
pub const DEPTH: f64 = 0.5;
/// Distance of particles, m.
pub const SPACING: f64 = 0.025;
/// Height of the container's walls over the depth of the water.
const FREEBOARD: f64 = 1.3;
/// Particles of a layer.
pub const PER_LAYER: usize = 100;

/// What the container is to the solver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Container {
    /// A body that the fluid cannot move, so that what it carries is reported. Fluid slips along it freely.
    Body,
    /// Walls, viscous as they are by default.
    Walls,
}

impl Container {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Body, Self::Walls];

    /// Name, as in files and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Body => "body",
            Self::Walls => "walls",
        }
    }

    /// The bodies of the scene where they stand.
    pub fn bodies(self) -> Vec<BodyInput> {
        match self {
            Self::Body => vec![BodyInput { position: center(), ..BodyInput::default() }],
            Self::Walls => Vec::new(),
        }
    }
}

fn walls(depth: f64) -> f32 {
    (depth * FREEBOARD) as f32
}

fn center() -> Vec3 {
    Vec3::new(0.0, walls(DEPTH) / 2.0, 0.0)
}

/// 2,000 particles in an open container whose floor is at y = 0.
pub fn scene(container: Container) -> Result<FluidScene, SceneError> {
    scene_of(container, BASE as f32, SPACING as f32)
}

/// The same depth of water on a square base of another edge and of another spacing, m.
pub fn scene_of(container: Container, base: f32, spacing: f32) -> Result<FluidScene, SceneError> {
    let mut scene = walled(base, DEPTH, spacing);
    if container == Container::Body {
        scene.boundaries.clear();
        let open = [false, false, false, true, false, false];
        let size = Vec3::new(base, walls(DEPTH), base);
        let samples = scene.wall_layer()?.container(size / 2.0, open)?;
        scene.bodies.push(Body { name: "container".to_owned(), samples, ..Body::default() });
    }
    Ok(scene)
}

/// Water of any depth between walls; base, depth and spacing in m, the floor at y = 0.
pub fn walled(base: f32, depth: f64, spacing: f32) -> FluidScene {
    let column = Vec3::new(base, depth as f32, base);
    let size = Vec3::new(base, walls(depth), base);
    FluidScene {
        name: "column".to_owned(),
        volumes: vec![Volume::block(column / 2.0, Vec3::new(0.0, column.y / 2.0, 0.0))],
        boundaries: vec![Boundary::open_box(size, Vec3::new(0.0, size.y / 2.0, 0.0))],
        ..FluidScene::with_spacing(spacing)
    }
}

#[cfg(test)]
mod tests {
    use freshet_core::plan::Plan;

    use super::*;

    #[test]
    fn column_and_container_fit() -> Result<(), SceneError> {
        for container in Container::ALL {
            let plan = Plan::new(&scene(container)?)?;
            assert_eq!(plan.positions.len(), 2_000);
            let of_body = plan.bodies.iter().flat_map(|body| &body.samples).map(|sample| sample.y + center().y);
            let lowest = of_body.chain(plan.boundary.positions.iter().map(|wall| wall.y)).fold(f32::INFINITY, f32::min);
            let depth = plan.parameters.boundary_depth;
            assert!((lowest + depth).abs() < 1e-5, "samples {depth} below the floor, not {lowest}");
        }
        assert!((BASE / SPACING).powi(2) as usize == PER_LAYER);
        let finer = Plan::new(&scene_of(Container::Walls, DEPTH as f32, DEPTH as f32 / 12.0)?)?;
        assert_eq!(finer.positions.len(), 12 * 12 * 12);
        Ok(())
    }
}
