//! Fluid that sticks to bodies, against sums over all pairs in double precision, and what must come of it.

use freshet_core::prelude::*;
use freshet_gpu::{GpuOptions, NeighbourMemory};

use crate::common::{solver, solver_with};

#[path = "../../../freshet_cpu/tests/common/sticking.rs"]
mod shared;
use shared::{assert_a_ball_is_braked, sticking_errors, sticking_scene};

/// And a wrong constant would be noticed.
#[test]
fn a_viscous_fluid_drags_bodies_and_they_drag_it() {
    for (kernel, neighbours) in
        [(KernelKind::WendlandC2, NeighbourMemory::Textures), (KernelKind::CubicSpline, NeighbourMemory::Buffers)]
    {
        let options = GpuOptions { neighbours, ..GpuOptions::default() };
        let found = sticking_errors(&mut solver_with(&sticking_scene(kernel), options));
        assert!(found.iter().all(|&error| error < 1.0), "{kernel:?}, {neighbours:?}: {found:?}");
    }
    for (from, to) in [
        ("strength * distance / y", "1.02 * strength * distance / y"),
        ("fields::body_turn(body), arm)", "fields::body_turn(body), 0.9 * arm)"),
        ("size_of(found) < size_of(best)", "size_of(found) > size_of(best)"),
        ("drag += share;", "drag += 1.001 * share;"),
        ("cross(arm + x, share)", "cross(arm, share)"),
    ] {
        let options = GpuOptions { patch: Some((from, to)), ..GpuOptions::default() };
        let found = sticking_errors(&mut solver_with(&sticking_scene(KernelKind::WendlandC2), options));
        assert!(found.iter().any(|&error| error > 1.0), "{from} -> {to} went unnoticed: {found:?}");
    }
}

#[test]
fn a_ball_is_braked_by_what_the_fluid_gets() {
    assert_a_ball_is_braked(&mut |scene| Box::new(solver(scene)));
}
