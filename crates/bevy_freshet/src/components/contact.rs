//! What the fluid does to a body, for the app.

use bevy::prelude::*;

/// What the fluid does to the [`FluidBody`](super::body::FluidBody) it stands beside; it comes with it. Only read it.
///
/// It is that of the last tick that is known: in lockstep the present one after
/// [`FreshetSystems::Apply`](crate::simulation::sets::FreshetSystems::Apply), pipelined one to three ticks before
/// ([`FluidStats::ticks_in_flight`](super::stats::FluidStats::ticks_in_flight)). All is zero while the body is in no fluid domain that
/// runs.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_freshet::prelude::*;
/// fn creak(hulls: Query<&FluidContact, Changed<FluidContact>>) {
///     for contact in &hulls {
///         if contact.force.length() > 500.0 && contact.submerged < 0.5 {
///             info!("a wave hits the hull");
///         }
///     }
/// }
/// ```
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
pub struct FluidContact {
    /// Mean force of the fluid in the tick, N, world axes: the impulse that it gives over the time simulated. Buoyancy is in it, the
    /// body's weight is not.
    pub force: Vec3,
    /// Mean torque likewise, N m, world axes, about the body's centre of mass.
    pub torque: Vec3,
    /// Share of the samples that are wetted, 0 to 1.
    ///
    /// Fluid reaches a sample from as far as about a spacing off the surface (a support radius, less the depth of the samples), so
    /// that of a body that floats up to a spacing more than its draft counts. Where parts of a compound or colliders only touch
    /// each other, samples between them stay dry.
    pub submerged: f32,
    /// Samples of its surface that the fluid reaches: those with the centre of a particle within the fluid's support radius, two
    /// spacings by default.
    pub wetted: u32,
    /// Samples of its surface.
    pub samples: u32,
    /// Whether it has entered the fluid, and not left it: see [`FluidEntered`].
    pub in_fluid: bool,
}

impl FluidContact {
    /// Share of the samples from which on a body enters the fluid, and below which it leaves it. Between them nothing changes: a
    /// surface that ripples, or a drop, makes no events.
    pub(crate) const ENTERS: f32 = 0.05;
    pub(crate) const LEAVES: f32 = 0.01;
}

/// A body enters the fluid: at least 5 % of its samples are wetted, for the first time since it left. Sent to the body.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_freshet::prelude::*;
/// fn spawn_splashing(mut commands: Commands) {
///     commands.spawn(FluidBody::default()).observe(|entered: On<FluidEntered>| info!("{} splashes", entered.entity));
/// }
/// ```
#[derive(EntityEvent, Clone, Copy, Debug, PartialEq, Eq)]
pub struct FluidEntered {
    /// The body.
    pub entity: Entity,
}

/// A body that had entered leaves the fluid: less than 1 % of its samples are wetted, or it is no longer in a fluid domain that runs.
/// Sent to the body; not to one that is despawned.
#[derive(EntityEvent, Clone, Copy, Debug, PartialEq, Eq)]
pub struct FluidLeft {
    /// The body.
    pub entity: Entity,
}
