//! Neighbours as rows of x-adjacent cells: contiguous ranges of sorted particles.

use freshet_core::grid::Grid;

/// The ranges around one cell that hold particles: nine rows, each in two parts where the grid wraps.
#[derive(Clone, Debug, Default)]
pub struct Rows {
    rows: [(u32, u32); 18],
    /// How often each row is wrapped along x, y and z: -1, 0 or 1.
    wraps: [[i8; 3]; 18],
    len: usize,
}

impl Rows {
    /// The ranges around the cell of wrapped index `cell`.
    #[inline(always)]
    pub fn around(grid: &Grid, starts: &[u32], cell: usize) -> Self {
        let (log, size) = (grid.log_cells, grid.dimensions());
        let x = cell as u32 & (size.x - 1);
        let y = (cell as u32 >> log.x) & (size.y - 1);
        let z = cell as u32 >> (log.x + log.y);
        let mut rows = Self::default();
        for dz in -1..=1i32 {
            for dy in -1..=1i32 {
                let (row_y, wrap_y) = moved(y, dy, size.y);
                let (row_z, wrap_z) = moved(z, dz, size.z);
                let base = (row_y << log.x) | (row_z << (log.x + log.y));
                let mut add =
                    |first: u32, last: u32, wrap| rows.add(starts, base + first, base + last, [wrap, wrap_y, wrap_z]);
                if x == 0 {
                    add(0, 1, 0);
                    add(size.x - 1, size.x - 1, -1);
                } else if x == size.x - 1 {
                    add(0, 0, 1);
                    add(x - 1, x, 0);
                } else {
                    add(x - 1, x + 1, 0);
                }
            }
        }
        rows
    }

    #[inline(always)]
    fn add(&mut self, starts: &[u32], first_cell: u32, last_cell: u32, wraps: [i8; 3]) {
        let (start, end) = (starts[first_cell as usize], starts[last_cell as usize + 1]);
        if start < end {
            self.rows[self.len] = (start, end);
            self.wraps[self.len] = wraps;
            self.len += 1;
        }
    }

    /// All ranges: first particle, and one past the last.
    #[inline(always)]
    pub fn all(&self) -> &[(u32, u32)] {
        &self.rows[..self.len]
    }

    /// How often each range is wrapped along x, y and z.
    #[inline(always)]
    pub fn wraps(&self) -> &[[i8; 3]] {
        &self.wraps[..self.len]
    }
}

/// A cell's wrapped coordinate after a step of -1, 0 or 1, and how often that wrapped.
#[inline(always)]
fn moved(at: u32, step: i32, size: u32) -> (u32, i8) {
    let to = at.wrapping_add_signed(step);
    let wrapped = to & (size - 1);
    (wrapped, if to == wrapped { 0 } else { step as i8 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{IVec3, Vec3};

    #[test]
    fn rows_are_the_27_cells_also_where_the_grid_wraps() {
        let grid = Grid::fitting(1.0, Vec3::new(4.0, 1.0, 6.0), 1 << 20);
        // One particle a cell: the ranges then name the cells.
        let starts: Vec<u32> = (0..=grid.cells()).collect();
        let size = grid.dimensions().as_ivec3();
        for at in [IVec3::ZERO, size - 1, IVec3::new(1, 2, 3), IVec3::new(size.x - 1, 0, 1), IVec3::new(-1, -1, -1)] {
            let mut expected: Vec<u32> =
                (0..27).map(|n| grid.index(at + IVec3::new(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1))).collect();
            let mut found: Vec<u32> = Rows::around(&grid, &starts, grid.index(at) as usize)
                .all()
                .iter()
                .flat_map(|&(start, end)| start..end)
                .collect();
            expected.sort_unstable();
            found.sort_unstable();
            assert_eq!(found, expected, "around {at}");
        }
    }
}
