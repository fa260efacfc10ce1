//! Fluid at the start.

use bevy::prelude::*;

use super::material::Fluid;

/// Fills a shape with fluid, once, at the first fixed tick after it was spawned.
///
/// [`Transform`] is the shape's centre and orientation; its scale must be 1. Later changes do nothing; despawning the
/// entity (or removing this component) removes the particles. Volumes that overlap each other are refused. Of one spawned
/// later, particles less than half a spacing from fluid that is there are left out, and a
/// [`FluidProblem`](super::problem::FluidProblem) says how many; to see what is there, that tick waits for the fluid.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component, Clone, Debug, PartialEq)]
#[require(Transform, Fluid)]
pub struct FluidVolume {
    /// What is filled.
    pub shape: FluidShape,
    /// Velocity at the start, m/s, world axes; each component within 10,000.
    pub velocity: Vec3,
    /// Whether it starts as dense as fluid standing there would be: closer together with depth, by 0.1 % and less. Without,
    /// a column starts with a bounce that rings for seconds.
    pub hydrostatic: bool,
}

impl FluidVolume {
    fn new(shape: FluidShape) -> Self {
        Self { shape, velocity: Vec3::ZERO, hydrostatic: true }
    }

    /// The same volume, moving.
    #[must_use]
    pub fn with_velocity(mut self, velocity: Vec3) -> Self {
        self.velocity = velocity;
        self
    }
}

/// A solid shape about its own centre.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Clone, Debug, PartialEq)]
pub enum FluidShape {
    /// A box.
    Cuboid {
        /// Half its edge lengths, m, 1e-5 to 1e6 and at least half a spacing.
        half_size: Vec3,
    },
    /// A ball.
    Sphere {
        /// Radius, m, 1e-5 to 1e6 and large enough for a particle.
        radius: f32,
    },
}

impl From<Cuboid> for FluidVolume {
    fn from(cuboid: Cuboid) -> Self {
        Self::new(FluidShape::Cuboid { half_size: cuboid.half_size })
    }
}

impl From<Sphere> for FluidVolume {
    fn from(sphere: Sphere) -> Self {
        Self::new(FluidShape::Sphere { radius: sphere.radius })
    }
}
