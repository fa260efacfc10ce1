//! The grid of the shaders: the plan's, with its cells cut along x, so that a row of them fits the support more closely.

use freshet_core::grid::Grid;
use glam::{IVec3, UVec3, Vec3};

/// Binary logarithm of the number of cells along x in a support radius.
const LOG_CUTS: u32 = 1;

/// Cells along x in a support radius.
pub(crate) const CELLS_PER_RADIUS: u32 = 1 << LOG_CUTS;

/// Shape of the shaders' grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FineGrid {
    /// One over the edge lengths of a cell, 1/m.
    pub inverse_cell_size: Vec3,
    /// Lower corner of cell zero, m.
    pub origin: Vec3,
    /// Binary logarithm of the number of cells along x, y and z.
    pub log_cells: UVec3,
}

impl FineGrid {
    /// Cuts the cells of a plan's grid.
    pub fn of(grid: &Grid) -> Self {
        Self {
            inverse_cell_size: Vec3::new(CELLS_PER_RADIUS as f32, 1.0, 1.0) / grid.cell_edges(),
            origin: grid.origin(),
            log_cells: grid.log_cells + UVec3::new(LOG_CUTS, 0, 0),
        }
    }

    /// Number of cells.
    pub fn cells(&self) -> u32 {
        1 << self.log_cells.element_sum()
    }

    /// Number of cells along each axis.
    pub fn dimensions(&self) -> UVec3 {
        UVec3::from_array(self.log_cells.to_array().map(|log| 1 << log))
    }

    /// Wrapped index of the cell that holds a point, as `freshet::grid` forms it.
    pub fn index(&self, position: Vec3) -> u32 {
        self.wrapped(((position - self.origin) * self.inverse_cell_size).floor().as_ivec3())
    }

    /// The cells of the nine rows around a cell, itself among them.
    pub fn around(&self, cell: u32) -> impl Iterator<Item = u32> {
        let last = self.dimensions() - UVec3::ONE;
        let yz = cell >> self.log_cells.x;
        let center = UVec3::new(cell & last.x, yz & last.y, yz >> self.log_cells.y).as_ivec3();
        let reach = CELLS_PER_RADIUS as i32;
        let rows = (-1..=1).flat_map(|z| (-1..=1).map(move |y| (y, z)));
        rows.flat_map(move |(y, z)| (-reach..=reach).map(move |x| IVec3::new(x, y, z)))
            .map(move |step| self.wrapped(center + step))
    }

    fn wrapped(&self, cell: IVec3) -> u32 {
        let cell = cell.as_uvec3() & (self.dimensions() - UVec3::ONE);
        cell.x | (cell.y << self.log_cells.x) | (cell.z << (self.log_cells.x + self.log_cells.y))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cells_around_one_are_different_and_near_it_across_the_wrap_too() {
        let grid = FineGrid::of(&Grid::fitting(0.5, Vec3::new(1.0, 2.0, 6.0), 1 << 20));
        let period = grid.dimensions().as_vec3() / grid.inverse_cell_size;
        for position in [Vec3::splat(0.1), Vec3::new(-0.1, 0.7, 3.2), period - 0.1] {
            let mut found: Vec<u32> = grid.around(grid.index(position)).collect();
            let offsets = (-2..=2).flat_map(|x| (-1..=1).flat_map(move |y| (-1..=1).map(move |z| IVec3::new(x, y, z))));
            let mut wanted: Vec<u32> =
                offsets.map(|offset| grid.index(position + offset.as_vec3() / grid.inverse_cell_size)).collect();
            found.sort_unstable();
            wanted.sort_unstable();
            assert_eq!(found, wanted);
            found.dedup();
            assert_eq!(found.len(), 45);
        }
    }
}
