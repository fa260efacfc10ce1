//! The wrapped uniform grid both solvers search neighbours in.
//!
//! Cells have the edge length of the support radius; the number of cells along each axis is a power of two and at least
//! four, so that the 27 cells around a particle are 27 different ones. Cell indices wrap around: the domain is
//! infinite, and particles far apart that share a cell are told apart by their distance.

use glam::{IVec3, UVec3, Vec3};
use serde::{Deserialize, Serialize};

/// Shape of a wrapped grid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Grid {
    /// Edge length of a cell, m: the support radius.
    pub cell_size: f32,
    /// Binary logarithm of the number of cells along x, y and z, each at least 2.
    pub log_cells: UVec3,
}

impl Grid {
    /// A grid for points within `extent` (m) with at most `max_cells` cells (but never fewer than 64).
    ///
    /// Axes are halved, longest first, until the cells fit: fewer cells cost time, not correctness.
    pub fn fitting(cell_size: f32, extent: Vec3, max_cells: u32) -> Self {
        let wanted = (extent / cell_size).max(Vec3::ZERO) + Vec3::splat(3.0);
        let mut log_cells = wanted.to_array().map(|cells| cells.clamp(4.0, 1024.0).log2().ceil() as u32);
        while log_cells.iter().sum::<u32>() > 6 && (1u64 << log_cells.iter().sum::<u32>()) > u64::from(max_cells) {
            let longest = (0..3).max_by_key(|&axis| log_cells[axis]).unwrap_or(0);
            log_cells[longest] -= 1;
        }
        Self { cell_size, log_cells: UVec3::from_array(log_cells.map(|log| log.max(2))) }
    }

    /// Number of cells.
    pub fn cells(&self) -> u32 {
        1 << (self.log_cells.x + self.log_cells.y + self.log_cells.z)
    }

    /// Number of cells along each axis.
    pub fn dimensions(&self) -> UVec3 {
        UVec3::new(1 << self.log_cells.x, 1 << self.log_cells.y, 1 << self.log_cells.z)
    }

    /// Unwrapped cell coordinates of a point: `floor(position / cell_size)`.
    pub fn coordinates(&self, position: Vec3) -> IVec3 {
        (position * (1.0 / self.cell_size)).floor().as_ivec3()
    }

    /// Wrapped index of a cell; x runs fastest.
    pub fn index(&self, coordinates: IVec3) -> u32 {
        let wrapped = coordinates.as_uvec3() & (self.dimensions() - UVec3::ONE);
        wrapped.x | (wrapped.y << self.log_cells.x) | (wrapped.z << (self.log_cells.x + self.log_cells.y))
    }
}
