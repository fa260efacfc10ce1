//! Written by `freshet_lab pareto --sources` from `docs/charts/pareto.csv`; not to be edited.

use super::Measured;

/// The front of what fails at no resolution, the cheapest first.
#[rustfmt::skip]
pub const MEASURED: [Measured; 3] = [
    Measured { configuration: "dfsph-fast", coarsest: 12, finest: 24, error: 0.04021, cost: 0.4052, held_out: 0.01901 },
    Measured { configuration: "sound-5-courant-0.8", coarsest: 12, finest: 24, error: 0.03305, cost: 0.5607, held_out: 0.006354 },
    Measured { configuration: "sound-5-linear", coarsest: 12, finest: 24, error: 0.03295, cost: 0.8496, held_out: 0.006335 },
];
/// [`FluidFidelity::Fast`](super::FluidFidelity::Fast).
pub const FAST: Measured = MEASURED[0];
/// [`FluidFidelity::Balanced`](super::FluidFidelity::Balanced).
pub const BALANCED: Measured = MEASURED[1];
/// [`FluidFidelity::Accurate`](super::FluidFidelity::Accurate).
pub const ACCURATE: Measured = MEASURED[2];
