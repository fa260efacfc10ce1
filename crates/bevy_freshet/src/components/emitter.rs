//! Fluid that flows in.

use bevy::prelude::*;

use super::material::Fluid;

/// A disc through which fluid flows in at a constant speed, along [`Transform::forward`].
///
/// It may move and turn. Particles it made stay when it is despawned.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component, Clone, Debug, PartialEq)]
#[require(Transform, Fluid)]
pub struct FluidEmitter {
    /// Radius of the disc, m, 1e-5 to 1e4.
    pub radius: f32,
    /// Speed of the flow, m/s, 1e-3 to 1e3. The flow is `pi radius^2 speed` of simulated time, whatever the spacing; a disc
    /// narrower than a particle drips.
    pub speed: f32,
    /// Time after which a particle is retired, s, more than 0; infinite for ever, which needs
    /// [`FluidDomain::max_particles`](super::domain::FluidDomain::max_particles).
    pub lifetime: f32,
    /// Whether it flows.
    pub enabled: bool,
}

impl FluidEmitter {
    /// A disc of `radius` metres through which fluid flows at `speed` m/s and lives for `lifetime` seconds.
    pub fn disc(radius: f32, speed: f32, lifetime: f32) -> Self {
        Self { radius, speed, lifetime, enabled: true }
    }
}
