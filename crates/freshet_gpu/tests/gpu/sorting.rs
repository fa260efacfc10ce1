//! The counting sort against sorting on the CPU.

use freshet_core::grid::Grid;
use freshet_core::prelude::*;
use freshet_gpu::GpuOptions;
use glam::{IVec3, UVec3};

use crate::common::{INSTANT, dam_break, device, place, random_vector, solver, solver_with, tick, tick_with};

/// Wrapped index of a point in a grid whose cells are cut in two along x, as the shaders'.
fn half_cell(grid: &Grid, x: Vec3) -> u32 {
    let half = (x.x * (2.0 / grid.cell_size)).floor() as i32;
    let whole = grid.coordinates(x);
    let dimensions = grid.dimensions() * UVec3::new(2, 1, 1);
    let cell = IVec3::new(half, whole.y, whole.z).as_uvec3() & (dimensions - UVec3::ONE);
    cell.x + dimensions.x * (cell.y + dimensions.y * cell.z)
}

#[test]
fn particles_are_sorted_by_cell_and_by_id_within_a_cell() {
    for workgroup_size in [32, 64, 256] {
        let mut solver = solver_with(&dam_break(0.05), GpuOptions { workgroup_size, ..Default::default() });
        // Scattered over more than the grid, so that it wraps, on both sides of zero.
        let count = 1000;
        let positions: Vec<Vec3> = (0..count).map(|i| 4.0 * random_vector(i, 1)).collect();
        let ids: Vec<u32> = (0..count as u32).map(|i| 3 * i).collect();
        place(&mut solver, &ids, &positions, &vec![Vec3::ZERO; count]);
        let report = solver.step(&tick(0, INSTANT)).unwrap();
        assert_eq!((report.particles, report.substeps), (count as u32, 1));

        let grid = solver.plan().grid;
        let mut wanted: Vec<(u32, u32)> =
            positions.iter().zip(&ids).map(|(&x, &id)| (half_cell(&grid, x), id)).collect();
        wanted.sort_unstable();
        let found = solver.read(Field::Id).unwrap().integers().unwrap();
        assert!(found.iter().eq(wanted.iter().map(|(_, id)| id)), "workgroup size {workgroup_size}");
    }
}

#[test]
fn all_particles_in_one_cell_are_in_order_too() {
    let mut solver = solver(&dam_break(0.05));
    let count = 300;
    let ids: Vec<u32> = (0..count as u32).collect();
    let positions: Vec<Vec3> = (0..count).map(|i| Vec3::new(0.575, 0.55, 0.55) + 0.02 * random_vector(i, 2)).collect();
    place(&mut solver, &ids, &positions, &vec![Vec3::ZERO; count]);
    // At such a density forces are huge: what counts is the order in which the sort left them.
    let report = solver.step(&tick(0, 1e-12)).unwrap();
    assert_eq!(report.particles, count as u32);
    let found = solver.read(Field::Id).unwrap().integers().unwrap();
    assert!(found.iter().copied().eq(0..count as u32));
}

#[test]
fn what_is_not_finite_or_out_of_bounds_is_removed_and_counted() {
    let mut solver = solver(&dam_break(0.05));
    let plan = Plan { max_particles: 2000, ..solver.plan().clone() };
    let outside = plan.parameters.bounds_max + 1.0;
    solver.reconfigure(plan).unwrap();
    // Inputs with such numbers are refused, so they come about as in a running solver: a speed that overflows makes
    // infinite positions in the first substep and differences that are not numbers in the next.
    let flung = Command::Spawn(NewParticles {
        positions: vec![outside, Vec3::new(0.7, 0.5, 0.25), Vec3::new(0.72, 0.5, 0.25)],
        velocities: vec![Vec3::ZERO, Vec3::splat(3e38), Vec3::splat(-3e38)],
        lifetime: f32::INFINITY,
        at: None,
    });
    let report = solver.step(&tick_with(0, 1.0 / 60.0, vec![flung])).unwrap();
    assert_eq!((report.removed, report.not_finite, report.particles), (3, 2, 1000), "{report:?}");
    let after = solver.snapshot().unwrap();
    assert!(after.positions.iter().chain(&after.velocities).all(|vector| vector.is_finite()));
    assert!(after.ids.iter().copied().eq(0..1000));

    // Not-a-number itself, as a fault in memory would leave it.
    let buffers = solver.buffers().unwrap();
    device().queue.write_buffer(buffers.particles, 32 * 500, bytemuck::bytes_of(&[f32::NAN; 3]));
    let report = solver.step(&tick(1, 1.0 / 60.0)).unwrap();
    assert_eq!((report.removed, report.not_finite, report.particles), (1, 1, 999), "{report:?}");
}
