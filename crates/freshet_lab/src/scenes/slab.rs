//! A dam break as a slab: as wide as the experiment, ten spacings deep.

use freshet_core::scene::{Boundary, FluidScene, Volume};
use glam::Vec3;

use crate::reference::dam_break::DamBreakExperiment;

/// Depth of the slab in spacings: the front is a matter of the plane, and the side walls let the fluid slip freely.
pub const DEPTH_IN_SPACINGS: usize = 10;

/// Height of the walls over the column's. Nothing rises above the column before the front meets the far wall.
const WALL_HEIGHT: f64 = 1.25;

/// The sides stand for water that goes on: fluid slips along them freely.
const ALL_BUT_THE_SIDES: [bool; 6] = [true, true, true, true, false, false];

/// The experiment with `resolution` particles along its width `a`. The back wall's face is at x = 0, the floor at y = 0.
pub fn scene(experiment: &DamBreakExperiment, resolution: u32) -> FluidScene {
    let spacing = experiment.width / f64::from(resolution);
    let depth = DEPTH_IN_SPACINGS as f64 * spacing;
    let column = vector(experiment.width, experiment.height(), depth);
    let tank = tank(experiment, resolution);
    FluidScene {
        name: format!("{} a/d = {resolution}", experiment.name),
        volumes: vec![Volume::block(column / 2.0, column / 2.0)],
        boundaries: vec![Boundary::open_box(tank, tank / 2.0).with_viscous_faces(ALL_BUT_THE_SIDES)],
        ..FluidScene::with_spacing(spacing as f32)
    }
}

/// Inner size of the tank, m; its lower corner is the origin.
pub fn tank(experiment: &DamBreakExperiment, resolution: u32) -> Vec3 {
    let depth = DEPTH_IN_SPACINGS as f64 * experiment.width / f64::from(resolution);
    vector(experiment.tank_length * experiment.width, WALL_HEIGHT * experiment.height(), depth)
}

/// Particles of the scene.
pub fn particles(experiment: &DamBreakExperiment, resolution: u32) -> usize {
    let across = resolution as usize;
    across * (experiment.aspect * f64::from(resolution)).round() as usize * DEPTH_IN_SPACINGS
}

fn vector(x: f64, y: f64, z: f64) -> Vec3 {
    Vec3::new(x as f32, y as f32, z as f32)
}

#[cfg(test)]
mod tests {
    use freshet_core::plan::{Plan, SceneError};

    use super::*;
    use crate::measure::front::front;

    #[test]
    fn the_slab_is_the_column_of_the_experiment() -> Result<(), SceneError> {
        for experiment in DamBreakExperiment::ALL {
            let plan = Plan::new(&scene(experiment, 12))?;
            assert_eq!(plan.positions.len(), particles(experiment, 12), "{}", experiment.name);
            let start = front(&plan.positions, plan.parameters.spacing);
            assert!(start.is_some_and(|x| (x / experiment.width - 1.0).abs() < 1e-4), "{}: {start:?}", experiment.name);
            let mass = plan.positions.len() as f64 * f64::from(plan.parameters.particle_mass);
            let depth = 10.0 * experiment.width / 12.0;
            let expected = 1000.0 * experiment.width * experiment.height() * depth;
            assert!((mass / expected - 1.0).abs() < 1e-4, "{}: {mass} kg, not {expected}", experiment.name);
        }
        Ok(())
    }
}
