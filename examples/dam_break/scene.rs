//! What is simulated: the tank, or a scene from a file.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use bevy::math::{Vec2, Vec3};
use freshet_core::plan::Plan;
use freshet_core::scene::{Boundary, BoundaryShape, FluidScene, Resolution, Volume};
use freshet_core::scene_file::MAX_SCENE_BYTES;

use crate::arguments::{Arguments, MAX_PARTICLES, MIN_PARTICLES};

/// Inner size of the tank, m.
const TANK: Vec3 = Vec3::new(5.0, 2.4, 2.0);
/// Size of the column, m.
const COLUMN: Vec3 = Vec3::new(2.1, 1.4, 2.0);

/// A ball beside the fluid.
#[derive(Clone, Copy, Debug)]
pub struct Ball {
    /// Where it is dropped, m.
    pub position: Vec3,
    /// m.
    pub radius: f32,
    /// kg/m3.
    pub density: f32,
}

/// A scene with what stands around it.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The fluid and its walls.
    pub scene: FluidScene,
    /// Rigid bodies.
    pub balls: Vec<Ball>,
    /// Corners of what is to be seen, m.
    pub bounds: (Vec3, Vec3),
    /// Distance of particles, m.
    pub spacing: f32,
    /// Particles at the start.
    pub particles: u32,
    is_tank: bool,
}

impl Setup {
    /// The scene of the command line; the error is one line.
    pub fn new(arguments: &Arguments) -> Result<Self, String> {
        let Some(path) = &arguments.scene else { return Self::tank(arguments.particles) };
        let name = path.display();
        let text = read_start(path).map_err(|error| format!("{name}: {error}"))?;
        let scene = FluidScene::from_ron_bytes(&text).map_err(|error| format!("{name}: {error}"))?;
        if !scene.bodies.is_empty() {
            return Err(format!(
                "{name}: bodies: {} is not allowed; allowed: none in this example",
                scene.bodies.len()
            ));
        }
        Self::of(scene, Vec::new(), false).map_err(|error| format!("{name}: {error}"))
    }

    /// The tank with about so many particles.
    pub fn tank(particles: u32) -> Result<Self, String> {
        let scene = FluidScene {
            name: "dam break".to_owned(),
            resolution: Resolution::Particles(particles),
            volumes: vec![Volume::block(COLUMN / 2.0, COLUMN / 2.0)],
            boundaries: vec![Boundary::open_box(TANK, TANK / 2.0)],
            ..FluidScene::with_spacing(1.0)
        };
        // Large enough to be sampled at the coarsest.
        let balls = vec![
            Ball { position: Vec3::new(3.2, 0.31, 0.6), radius: 0.3, density: 300.0 },
            Ball { position: Vec3::new(3.9, 0.26, 1.4), radius: 0.25, density: 600.0 },
        ];
        Self::of(scene, balls, true)
    }

    fn of(mut scene: FluidScene, balls: Vec<Ball>, is_tank: bool) -> Result<Self, String> {
        let plan = Plan::new(&scene).map_err(|error| error.to_string())?;
        let spacing = plan.parameters.spacing;
        scene.resolution = Resolution::Spacing(spacing);
        if let (Some(column), true) = (scene.volumes.first_mut(), is_tank) {
            // Whole layers, so that the water stands against the walls.
            let layers = (COLUMN / spacing).round().max(Vec3::ONE);
            *column = Volume::block(layers * spacing / 2.0, layers * spacing / 2.0);
            let depth = layers.z * spacing;
            let size = Vec3::new(TANK.x, TANK.y, depth);
            scene.boundaries = vec![Boundary::open_box(size, size / 2.0)];
        }
        let plan = Plan::new(&scene).map_err(|error| error.to_string())?;
        let particles = plan.positions.len() as u32;
        let mut bounds = (Vec3::splat(f32::INFINITY), Vec3::splat(f32::NEG_INFINITY));
        for point in plan.positions.iter().chain(&plan.boundary.positions) {
            bounds = (bounds.0.min(*point), bounds.1.max(*point));
        }
        if bounds.0.x > bounds.1.x {
            bounds = (Vec3::splat(-1.0), Vec3::splat(1.0));
        }
        Ok(Self { scene, balls, bounds, spacing, particles, is_tank })
    }

    /// The same with more particles (`factor` above 1) or fewer; the error is why there is none.
    pub fn scaled(&self, factor: f32) -> Result<Self, String> {
        if !self.is_tank {
            return Err("the scene comes from a file, which says how many particles there are".to_owned());
        }
        let wanted = (self.particles as f32 * factor).clamp(MIN_PARTICLES as f32, MAX_PARTICLES as f32);
        let scaled = Self::tank(wanted as u32)?;
        // Whole layers: at either end it may come out the other way.
        match factor > 1.0 {
            true if scaled.particles <= self.particles => Err(format!("{} particles are the most", self.particles)),
            false if scaled.particles >= self.particles => Err(format!("{} particles are the fewest", self.particles)),
            _ => Ok(scaled),
        }
    }

    /// Inner boxes to be drawn as glass: centre and size, m.
    pub fn tanks(&self) -> Vec<(Vec3, Vec3)> {
        let containers = self.scene.boundaries.iter().filter_map(|boundary| match boundary.shape {
            BoundaryShape::Container { half_extents, .. } => Some((boundary.center, 2.0 * half_extents)),
            _ => None,
        });
        containers.collect()
    }

    /// Height of the ground under the scene, m, and its extent.
    pub fn ground(&self) -> (f32, Vec2) {
        let size = self.bounds.1 - self.bounds.0;
        (self.bounds.0.y, Vec2::new(size.x, size.z))
    }
}

/// A file as far as it can be a scene: one that is larger, or has no end, is not read whole to be refused.
fn read_start(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(MAX_SCENE_BYTES as u64 + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}
