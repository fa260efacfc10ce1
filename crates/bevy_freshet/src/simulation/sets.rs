//! The order of a fixed tick.

use bevy::prelude::*;

/// What the plugin does in each fixed tick, in this order: all but the last between rapier's `SyncBackend` and
/// `StepSimulation`, `Complete` between its `StepSimulation` and `Writeback`.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FreshetSystems {
    /// Finds out what changed, and plans anew. Spawn and change fluid components before this to see them in this tick.
    Plan,
    /// Takes what the solver has finished. [`FluidStats`](crate::components::stats::FluidStats) is current after this.
    Collect,
    /// Corrects bodies for what has become known, and reads their state. Set velocities of bodies before this.
    Prepare,
    /// Sends the tick to the solver. In lockstep it is finished, and collected, after this.
    Step,
    /// Tells rapier what the fluid does to bodies. Read the fluid's pushes on bodies after this.
    Apply,
    /// After rapier's step: closes the books of the tick.
    Complete,
}
