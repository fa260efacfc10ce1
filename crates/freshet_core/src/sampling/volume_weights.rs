//! What a boundary sample weighs in a density sum (Akinci et al. 2012, eq. 4; E 13-16).
//!
//! A sample counts as the volume `V_b = gamma / sum_k W_bk`, over all samples `k` of the same boundary, itself included: the
//! closer they lie, the less each is worth, so that an uneven sampling still makes an even wall.
//!
//! `gamma` makes up for there being one layer only, where the fluid would have had as many as the support reaches:
//! [`WallLayer`](super::wall_layer::WallLayer) derives it.

use glam::Vec3;

use crate::kernel::Kernel;

/// The volumes `V_b = gamma / sum_k W_bk` in m3 of the samples of one boundary, b among the k; in the order of `positions`.
///
/// `positions` are in metres and finite; those of different boundaries do not belong in one call, since a body must not grow
/// lighter where it touches a wall. `gamma` is positive, normally [`WallLayer::gamma`](super::wall_layer::WallLayer::gamma). A sample alone gets `gamma / W(0)`.
///
/// Sorts the samples into cells of the support radius: `n log n`, with 36 bytes of memory a sample.
pub fn volume_weights(positions: &[Vec3], kernel: &Kernel, gamma: f64) -> Vec<f32> {
    sums_around(positions, kernel, |_| 1.0).into_iter().map(|sum| (gamma / sum) as f32).collect()
}

/// `sum_k w_k W_bk`, b among the k, in the order of `positions`, with the weights of these.
pub(super) fn sums_around(positions: &[Vec3], kernel: &Kernel, weight: impl Fn(usize) -> f64) -> Vec<f64> {
    let mut cells: Vec<(Cell, usize)> =
        positions.iter().enumerate().map(|(index, &x)| (cell_of(x, kernel), index)).collect();
    // By z, y, then x: three neighbouring cells in a row of x lie next to each other.
    cells.sort_unstable();

    let mut sums = vec![0.0; positions.len()];
    for group in cells.chunk_by(|a, b| a.0 == b.0) {
        let [z, y, x] = group[0].0;
        let rows: Vec<&[(Cell, usize)]> = (z - 1..=z + 1)
            .flat_map(|z| (y - 1..=y + 1).map(move |y| (z, y)))
            .map(|(z, y)| {
                let start = cells.partition_point(|(cell, _)| *cell < [z, y, x - 1]);
                let end = start + cells[start..].partition_point(|(cell, _)| *cell <= [z, y, x + 1]);
                &cells[start..end]
            })
            .collect();
        for &(_, b) in group {
            let x_b = positions[b].as_dvec3();
            sums[b] = rows
                .iter()
                .flat_map(|row| *row)
                .map(|&(_, k)| weight(k) * kernel.value(x_b.distance(positions[k].as_dvec3())))
                .sum();
        }
    }
    sums
}

/// z, y, x of a cell.
type Cell = [i64; 3];

fn cell_of(x: Vec3, kernel: &Kernel) -> Cell {
    // Clamped so that the neighbour of a cell always exists.
    let cell = (x.as_dvec3() / f64::from(kernel.support_radius()))
        .floor()
        .clamp(-1e15 * glam::DVec3::ONE, 1e15 * glam::DVec3::ONE);
    [cell.z as i64, cell.y as i64, cell.x as i64]
}
