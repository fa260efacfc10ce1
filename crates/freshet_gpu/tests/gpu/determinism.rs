//! The same bits whatever the workgroup size, and from run to run.

use freshet_core::prelude::*;
use freshet_gpu::{GpuOptions, NeighbourMemory};

use crate::common::{dam_break, solver_with, tick};

fn state_after(workgroup_size: u32, substeps: u32) -> Snapshot {
    state_with(GpuOptions { workgroup_size, ..Default::default() }, substeps)
}

fn state_with(options: GpuOptions, substeps: u32) -> Snapshot {
    let mut solver = solver_with(&dam_break(0.05), options);
    let (mut made, mut number) = (0, 0);
    while made < substeps {
        let report = solver.step(&tick(number, 1.0 / 60.0)).unwrap();
        assert_eq!((report.particles, report.removed), (1000, 0));
        assert_eq!(report.time_scale, 1.0);
        assert!(report.max_compression < 0.05, "{report:?}");
        made += report.substeps;
        number += 1;
    }
    solver.snapshot().unwrap()
}

#[test]
fn bits_do_not_depend_on_the_workgroup_size() {
    let reference = state_after(64, 50);
    assert!(reference.velocities.iter().any(|velocity| velocity.x > 0.1), "the dam does not break");
    for size in [32, 256] {
        assert!(state_after(size, 50) == reference, "workgroup size {size} gives other bits than 64");
    }
}

#[test]
fn bits_do_not_depend_on_what_holds_the_neighbours() {
    let state = |neighbours| state_with(GpuOptions { neighbours, ..Default::default() }, 50);
    let buffers = state(NeighbourMemory::Buffers);
    assert!(buffers.velocities.iter().any(|velocity| velocity.x > 0.1), "the dam does not break");
    assert!(state(NeighbourMemory::Textures) == buffers, "textures give other bits than buffers");
}

#[test]
fn a_second_run_gives_the_same_bits() {
    assert!(state_after(64, 50) == state_after(64, 50));
}

#[test]
fn dispatches_of_several_rows_give_the_same_bits() {
    // As with more than four million particles: rows of 65535 workgroups, here of three.
    let options = GpuOptions { patch: Some(("#{MAX_WORKGROUPS}u", "3u")), ..Default::default() };
    assert!(state_with(options, 10) == state_after(64, 10));
}
