//! Written by `freshet_lab pareto --sources` from `docs/charts/pareto.csv`; not to be edited.

use super::Measured;

/// The front, the cheapest first.
pub const MEASURED: [Measured; 4] = [
    Measured { configuration: "dfsph-fast", across: 12, error: 0.03896, cost: 0.04111, held_out: 0.008102 },
    Measured { configuration: "sound-5-courant-0.8", across: 12, error: 0.02338, cost: 0.0556, held_out: 0.003195 },
    Measured { configuration: "sound-5-linear", across: 12, error: 0.01948, cost: 0.09586, held_out: 0.003417 },
    Measured { configuration: "dfsph-fast", across: 24, error: 0.0189, cost: 0.4052, held_out: 0.002712 },
];
/// [`FluidFidelity::Fast`](super::FluidFidelity::Fast).
pub const FAST: Measured = MEASURED[0];
/// [`FluidFidelity::Balanced`](super::FluidFidelity::Balanced).
pub const BALANCED: Measured = MEASURED[1];
/// [`FluidFidelity::Accurate`](super::FluidFidelity::Accurate).
pub const ACCURATE: Measured = MEASURED[3];
