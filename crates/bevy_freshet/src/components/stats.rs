//! What the solver says of itself.

use bevy::prelude::*;

use super::domain::FluidBackend;

/// Statistics of a domain's latest known tick; written by the plugin.
#[derive(Component, Clone, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
pub struct FluidStats {
    /// What simulates; [`FluidBackend::Auto`] as long as nothing does.
    pub backend: FluidBackend,
    /// Why nothing is simulated any more, such as a lost device; none as long as it goes on. The particles are lost: it starts
    /// again from its volumes when a setting changes.
    pub stopped: Option<String>,
    /// Boundaries whose mesh or image has not come yet: until it has, no tick is simulated, and nothing is lost. A handle to which
    /// nothing ever comes makes the domain wait for ever.
    pub waiting_for: Vec<Entity>,
    /// Ticks known, or zero: the number of the next tick after the one described here.
    pub ticks: u64,
    /// Ticks asked for and not known yet, 0 to 3.
    pub ticks_in_flight: u64,
    /// Simulated time, s.
    pub time: f64,
    /// Live particles.
    pub particles: u32,
    /// Particles there is room for.
    pub capacity: u32,
    /// Substeps of the tick.
    pub substeps: u32,
    /// Time covered over time asked for; 1 when real time is kept.
    pub time_scale: f32,
    /// Mean over particles of `max(density / rest_density - 1, 0)`, the largest of the tick's substeps.
    pub mean_compression: f32,
    /// Largest `density / rest_density - 1` of any particle in the tick.
    pub max_compression: f32,
    /// Largest speed, m/s.
    pub max_speed: f32,
    /// Iterations of the tick's pressure solves, of velocities and of positions; zero for a weakly compressible fluid.
    pub iterations: [u32; 2],
    /// What the tick's Poisson solves left at most of what they began with; zero for other fluids.
    pub residual: f32,
    /// Pressure solves so far that ended at their most iterations.
    pub unsolved: u64,
    /// Substeps so far that turned out too long and were made again: see [`Settings::redo_substeps`](freshet_core::scene::Settings::redo_substeps).
    pub redone: u64,
    /// Particles removed so far because they left the bounds or were not finite.
    pub removed: u64,
    /// Those of the [`removed`](Self::removed) so far that were not finite: the simulation broke down around them. The others
    /// have left the bounds.
    pub not_finite: u64,
    /// Particles so far that went through a wall, each once; none unless [`FluidDomain::count_leaks`](super::domain::FluidDomain::count_leaks) is
    /// set. What counts stands at [`leaks`](freshet_core::leaks). Ticks that fall behind are left out where walls move.
    pub leaks: Option<u64>,
    /// Particles retired so far because their lifetime was over or they were told to.
    pub retired: u64,
    /// Particles not made so far because the capacity was reached.
    pub refused: u64,
    /// Particles left out so far because they would have started inside a body, or were spawned inside a wall or a body; of
    /// volumes that are partly in a wall, [`notes`](Self::notes) say how many were left out.
    pub inside_solids: u64,
    /// Particles left out likewise because a body was nearer than half a spacing, or a wall than a fifth.
    pub beside_solids: u64,
    /// Time the solver took for the tick, ms: wall time on the CPU, the sum of time stamps on the GPU (zero without them).
    pub milliseconds: f32,
    /// Cost of each pass in the tick, where it was measured.
    pub passes: Vec<FluidPassTime>,
    /// How often the domain has been planned so far: at the start, and whenever walls, bodies, volumes or settings change.
    pub plannings: u64,
    /// What the plan decided or warns of, such as a sound speed below ten times the expected speed, or a wall along which fluid slips because it has
    /// been moved ([`FluidWallMotion::Auto`](super::wall::FluidWallMotion::Auto)).
    pub notes: Vec<String>,
}

/// Cost of one pass in one tick.
#[derive(Clone, Debug, Default, PartialEq, Reflect)]
#[reflect(Default, Clone, Debug, PartialEq)]
pub struct FluidPassTime {
    /// Name of the pass.
    pub pass: String,
    /// Sum over the tick's substeps, ms.
    pub milliseconds: f32,
}
