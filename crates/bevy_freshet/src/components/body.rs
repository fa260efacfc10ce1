//! Rigid bodies in the fluid.

use bevy::prelude::*;
use bevy_rapier3d::prelude::{ReadMassProperties, Velocity};

use super::contact::FluidContact;

/// Lets the fluid push this rapier body, and the body the fluid.
///
/// It stands beside a `RigidBody` and a `Collider`, whose surface is sampled. Mass and inertia are rapier's. What the fluid does to it
/// is in [`FluidContact`]. Body type, mass, collider and scale may change at any time, and it may be despawned. Where it
/// comes into fluid from one tick to the next, new, put elsewhere or with a larger shape, it swells to its size and pushes the fluid out gently:
/// see [`freshet_core::swelling`].
///
/// All of rapier's shapes will do but half-spaces, segments, triangles, polylines and voxels: with one of these, and with one too
/// small for the spacing, a [`FluidProblem`](super::problem::FluidProblem) says so, and body and fluid pass through each other. Parts of
/// a compound may overlap; a cup made of cuboids is hollow. A triangle mesh without holes is solid, any other has fluid on both
/// sides. A height field is ground, with the fluid above it.
#[derive(Component, Clone, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[require(Transform, Velocity, ReadMassProperties, FluidContact)]
#[non_exhaustive]
pub struct FluidBody {
    /// What its surface is sampled by.
    pub sampling: FluidBodySampling,
}

impl FluidBody {
    /// A body of three layers of quasi-fluid.
    pub fn quasi_fluid() -> Self {
        Self { sampling: FluidBodySampling::QuasiFluid }
    }
}

/// What the surface of a [`FluidBody`] is sampled by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Default, Clone, Debug, PartialEq)]
pub enum FluidBodySampling {
    /// One layer of weighted samples: for every fluid.
    #[default]
    SingleLayer,
    /// Three layers with densities and pressures of their own ([`freshet_core::sampling::quasi_fluid`]): weakly compressible fluids only, of one width
    /// of support and without a viscosity model. With any other a [`FluidProblem`](super::problem::FluidProblem) says so.
    QuasiFluid,
}
