//! Written by `freshet_lab pareto --sources` from `docs/charts/pareto.csv`; not to be edited.

use super::Measured;

/// The front of what fails at no resolution, the cheapest first.
#[rustfmt::skip]
pub const MEASURED: [Measured; 3] = [
    Measured { configuration: "dfsph-fast", coarsest: 12, finest: 24, error: 0.0961, cost: 0.4885, held_out: 0.01901 },
    Measured { configuration: "dfsph-2.15", coarsest: 12, finest: 24, error: 0.07223, cost: 0.6438, held_out: 0.003636 },
    Measured { configuration: "spiky", coarsest: 12, finest: 24, error: 0.06975, cost: 2.215, held_out: 0.002662 },
];
/// [`FluidFidelity::Fast`](super::FluidFidelity::Fast).
pub const FAST: Measured = MEASURED[0];
/// [`FluidFidelity::Balanced`](super::FluidFidelity::Balanced).
pub const BALANCED: Measured = MEASURED[1];
/// [`FluidFidelity::Accurate`](super::FluidFidelity::Accurate).
pub const ACCURATE: Measured = MEASURED[2];
