//! Rigid bodies in the fluid.

use bevy::prelude::*;
use bevy_rapier3d::prelude::{ReadMassProperties, Velocity};

/// Lets the fluid push this rapier body, and the body the fluid.
///
/// It stands beside a `RigidBody` and a `Collider`, whose surface is sampled. Mass and inertia are rapier's.
#[derive(Component, Clone, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[require(Transform, Velocity, ReadMassProperties)]
#[non_exhaustive]
pub struct FluidBody;
