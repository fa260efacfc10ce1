//! The space a scene takes.

use glam::Vec3;

use crate::scene::FluidScene;

/// The box around a scene.
pub(super) struct Extent {
    pub min: Vec3,
    pub max: Vec3,
}

impl Extent {
    pub fn of<'a>(points: impl Iterator<Item = &'a Vec3>, scene: &FluidScene, margin: f32) -> Self {
        let mut extent = Self { min: Vec3::splat(f32::INFINITY), max: Vec3::splat(f32::NEG_INFINITY) };
        for &point in points {
            extent.min = extent.min.min(point);
            extent.max = extent.max.max(point);
        }
        for emitter in &scene.emitters {
            extent.min = extent.min.min(emitter.center - emitter.radius);
            extent.max = extent.max.max(emitter.center + emitter.radius);
        }
        if extent.min.x > extent.max.x {
            extent = Self { min: Vec3::splat(-1.0), max: Vec3::splat(1.0) };
        }
        Self { min: extent.min - margin, max: extent.max + margin }
    }

    pub fn grown(&self, factor: f32) -> (Vec3, Vec3) {
        let reach = (self.max - self.min).length() * factor;
        (self.min - reach, self.max + reach)
    }
}
