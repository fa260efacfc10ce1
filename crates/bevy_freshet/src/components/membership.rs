//! Which domain something belongs to.

use bevy::prelude::*;

/// The domain this volume, emitter, boundary, container or body belongs to.
///
/// Without it, it belongs to the only domain there is; with several domains that is an error
/// ([`FluidProblem`](super::problem::FluidProblem)).
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Component, Clone, Debug, PartialEq)]
#[relationship(relationship_target = FluidDomainMembers)]
pub struct FluidInDomain(pub Entity);

/// What says by [`FluidInDomain`] that it belongs to this domain; kept by Bevy.
#[derive(Component, Clone, Debug, Default, Reflect)]
#[reflect(Component, Default, Clone, Debug)]
#[relationship_target(relationship = FluidInDomain)]
pub struct FluidDomainMembers(Vec<Entity>);
