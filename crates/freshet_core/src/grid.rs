//! The wrapped uniform grid both solvers search neighbours in.
//!
//! Cells have the edge length of the widest support, that is of the support radius where all are the same; the number of cells along each axis is a power of two and at least
//! four, so that the 27 cells around a particle are 27 different ones. Cell indices wrap around: the domain is
//! infinite, and particles far apart that share a cell are told apart by their distance.
//!
//! Along an axis that repeats itself the cells divide the period evenly, so that the wrapping is the domain's own. They are
//! then up to twice as long, which costs candidates and no neighbours.

use glam::{IVec3, UVec3, Vec3};
use serde::{Deserialize, Serialize};

use crate::periodic::Periodic;

/// Shape of a wrapped grid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Grid {
    /// Edge length of a cell, m: the [widest support](crate::variable_support), mostly the support radius. Cells are longer along axes
    /// that repeat, see [`Grid::cell_edges`].
    pub cell_size: f32,
    /// Support radius H, m: no more than the edge.
    pub support_radius: f32,
    /// Binary logarithm of the number of cells along x, y and z, each at least 2.
    pub log_cells: UVec3,
    /// Where the domain repeats itself.
    pub periodic: Periodic,
}

/// Share of a cell by which the cells of a period may be shorter than the support: what rounding takes.
const ROUNDING: f32 = 1e-5;

impl Grid {
    /// A grid for points within `extent` (m) with at most `max_cells` cells (but never fewer than 64).
    ///
    /// Axes are halved, longest first, until the cells fit: fewer cells cost time, not correctness.
    pub fn fitting(cell_size: f32, extent: Vec3, max_cells: u32) -> Self {
        Self::repeating(cell_size, extent, Periodic::default(), max_cells)
    }

    /// The same for a domain that repeats itself, each period at least four cells long.
    pub fn repeating(cell_size: f32, extent: Vec3, periodic: Periodic, max_cells: u32) -> Self {
        let (wanted, lengths) = ((extent / cell_size).max(Vec3::ZERO) + Vec3::splat(3.0), periodic.lengths());
        let mut log_cells = [0, 1, 2].map(|axis| match periodic.along(axis) {
            Some(_) => ((1.0 + ROUNDING) * lengths[axis] / cell_size).clamp(4.0, 1024.0).log2().floor() as u32,
            None => wanted[axis].clamp(4.0, 1024.0).log2().ceil() as u32,
        });
        while log_cells.iter().sum::<u32>() > 6 && (1u64 << log_cells.iter().sum::<u32>()) > u64::from(max_cells) {
            let longest = (0..3).max_by_key(|&axis| log_cells[axis]).unwrap_or(0);
            log_cells[longest] -= 1;
        }
        Self {
            cell_size,
            support_radius: cell_size,
            log_cells: UVec3::from_array(log_cells.map(|log| log.max(2))),
            periodic,
        }
    }

    /// The shortest period the cells can divide, m.
    pub fn shortest_period(cell_size: f32) -> f32 {
        4.0 * (1.0 - ROUNDING) * cell_size
    }

    /// Edge lengths of a cell, m.
    pub fn cell_edges(&self) -> Vec3 {
        let periods = self.periodic.lengths() / self.dimensions().as_vec3();
        Vec3::from([0, 1, 2].map(|axis| if periods[axis] > 0.0 { periods[axis] } else { self.cell_size }))
    }

    /// Lower end of the cells with coordinate 0, m.
    pub fn origin(&self) -> Vec3 {
        Vec3::from([0, 1, 2].map(|axis| self.periodic.along(axis).map_or(0.0, |(low, _)| low)))
    }

    /// Number of cells.
    pub fn cells(&self) -> u32 {
        1 << (self.log_cells.x + self.log_cells.y + self.log_cells.z)
    }

    /// Number of cells along each axis.
    pub fn dimensions(&self) -> UVec3 {
        UVec3::new(1 << self.log_cells.x, 1 << self.log_cells.y, 1 << self.log_cells.z)
    }

    /// Unwrapped cell coordinates of a point: `floor((position - origin) / edge)`. Along an axis that repeats the point lies
    /// within the period, and what rounding puts beyond the last cell is in it.
    pub fn coordinates(&self, position: Vec3) -> IVec3 {
        if !self.periodic.any() {
            return (position * (1.0 / self.cell_size)).floor().as_ivec3();
        }
        let mut cell = ((position - self.origin()) * (1.0 / self.cell_edges())).floor().as_ivec3();
        let last = self.dimensions().as_ivec3() - 1;
        for axis in (0..3).filter(|&axis| self.periodic.along(axis).is_some()) {
            cell[axis] = cell[axis].clamp(0, last[axis]);
        }
        cell
    }

    /// Wrapped index of a cell; x runs fastest.
    pub fn index(&self, coordinates: IVec3) -> u32 {
        let wrapped = coordinates.as_uvec3() & (self.dimensions() - UVec3::ONE);
        wrapped.x | (wrapped.y << self.log_cells.x) | (wrapped.z << (self.log_cells.x + self.log_cells.y))
    }
}
