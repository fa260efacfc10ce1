//! What a boundary sample weighs in a density sum (Akinci et al. 2012, eq. 4; E 13-16).
//!
//! A sample counts as the volume `V_b = gamma / sum_k W_bk`, over all samples `k` of the same boundary, itself included: the
//! closer they lie, the less each is worth, so that an uneven sampling still makes an even wall.
//!
//! `gamma` makes up for there being one layer only, where the fluid would have had as many as the support reaches. With
//! `m = rho0 d^3` and the density sum `rho_a = (1/S) (sum_b m W_ab + rho0 sum_b V_b W_ab)`, which is calibrated with
//! `S = d^3 sum W` over the whole lattice ([`Kernel::lattice_sum`]), the first layer of a fluid at rest has `rho_a = rho0` when
//! the samples stand in exactly for the missing half of the lattice.

use glam::Vec3;

use crate::kernel::Kernel;

/// The `gamma` that gives the first layer of fluid on a plane its rest density; no unit.
///
/// An infinite plane is sampled by a square lattice of spacing `d` (metres), the fluid is the cubic lattice that goes on from
/// it: its first layer is `d` above the samples, particles straight above samples. With `P(z)` the sum of W over one layer at
/// height z, a sample's volume is `gamma / P(0)`; the layers that are missing at heights `d`, `2 d`... give
/// `gamma = d^3 P(0) (P(d) + P(2 d) + ...) / P(d)`.
///
/// S drops out, being on both sides; for `H <= 2 d` so do all layers but one, and `gamma = d^3 P(0)`. Cubic spline 0.70 and
/// Wendland C2 0.78 at `H = 2 d`, 0.57 and 0.61 at `2.5 d`; 1/2 in the limit of many neighbours.
///
/// Where the fluid does not reach the samples (`H <= d`) it is `d^3 W(0)`. Not a number unless `spacing` is positive; infinite or
/// not a number for [`KernelKind::Viscosity`](crate::kernel::KernelKind::Viscosity). A spacing below `H/64` is taken as `H/64`.
pub fn plane_gamma(kernel: &Kernel, spacing: f32) -> f64 {
    let Some((d, reach)) = kernel.lattice_reach(spacing) else { return f64::NAN };
    let layer = |height: i32| {
        let mut sum = 0.0;
        for j in -reach..=reach {
            for i in -reach..=reach {
                sum += kernel.value(d * f64::from(i * i + j * j + height * height).sqrt());
            }
        }
        sum
    };
    let (own, nearest) = (layer(0), layer(1));
    let missing: f64 = nearest + (2..=reach).map(layer).sum::<f64>();
    let layers = if nearest == 0.0 { 1.0 } else { missing / nearest };
    d.powi(3) * own * layers
}

/// The volumes `V_b = gamma / sum_k W_bk` in m3 of the samples of one boundary, b among the k; in the order of `positions`.
///
/// `positions` are in metres and finite; those of different boundaries do not belong in one call, since a body must not grow
/// lighter where it touches a wall. `gamma` is positive, normally [`plane_gamma`]. A sample alone gets `gamma / W(0)`.
///
/// Sorts the samples into cells of the support radius: `n log n`, with 36 bytes of memory a sample.
pub fn volume_weights(positions: &[Vec3], kernel: &Kernel, gamma: f64) -> Vec<f32> {
    let mut cells: Vec<(Cell, usize)> =
        positions.iter().enumerate().map(|(index, &x)| (cell_of(x, kernel), index)).collect();
    // By z, y, then x: three neighbouring cells in a row of x lie next to each other.
    cells.sort_unstable();

    let mut volumes = vec![0.0; positions.len()];
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
            let sum: f64 = rows
                .iter()
                .flat_map(|row| *row)
                .map(|&(_, k)| kernel.value(x_b.distance(positions[k].as_dvec3())))
                .sum();
            volumes[b] = (gamma / sum) as f32;
        }
    }
    volumes
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
