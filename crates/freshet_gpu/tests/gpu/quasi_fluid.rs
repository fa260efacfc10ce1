//! Bodies of three layers of quasi-fluid, against sums over all pairs in double precision, and what must come of them.

use freshet_core::prelude::*;
use freshet_gpu::{GpuOptions, NeighbourMemory};

use crate::common::{solver, solver_with};

#[path = "../../../freshet_cpu/tests/common/quasi_fluid.rs"]
mod shared;
use shared::{assert_a_quasi_fluid_ball_gets_what_the_fluid_loses, quasi_fluid_errors, quasi_fluid_scene};

/// And a wrong constant would be noticed.
#[test]
fn samples_have_pressures_of_their_own_and_exchange_them() {
    for (kernel, neighbours) in
        [(KernelKind::WendlandC2, NeighbourMemory::Textures), (KernelKind::CubicSpline, NeighbourMemory::Buffers)]
    {
        let options = GpuOptions { neighbours, ..GpuOptions::default() };
        let found = quasi_fluid_errors(&mut solver_with(&quasi_fluid_scene(kernel), options));
        assert!(found.iter().all(|&error| error < 1.0), "{kernel:?}, {neighbours:?}: {found:?}");
    }
    for (from, to) in [
        ("swollen * swollen * own * rest_density", "1.01 * own * rest_density"),
        ("fields::sample(k), fields::sample_pressure(k)", "fields::sample(k), 0.99 * fields::sample_pressure(k)"),
        ("if (own < 0.0)", "if (own < -2.0)"),
        ("slopes += slope * x;", "slopes += 1.01 * slope * x;"),
    ] {
        let options = GpuOptions { patch: Some((from, to)), ..GpuOptions::default() };
        let found = quasi_fluid_errors(&mut solver_with(&quasi_fluid_scene(KernelKind::WendlandC2), options));
        assert!(found.iter().any(|&error| error > 1.0), "{from} -> {to} went unnoticed: {found:?}");
    }
}

#[test]
fn a_ball_gets_what_the_fluid_loses() {
    assert_a_quasi_fluid_ball_gets_what_the_fluid_loses(&mut |scene| Box::new(solver(scene)));
}
