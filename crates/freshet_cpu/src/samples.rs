//! Samples of walls and bodies, sorted by cell.

use freshet_core::grid::Grid;
use glam::Vec3;

use crate::lanes::PADDING;

/// Samples in the order of their cells, in the order given within a cell.
#[derive(Clone, Debug, Default)]
pub struct SortedSamples {
    /// First sample of each cell, and the number of samples.
    pub starts: Vec<u32>,
    /// Positions, m, padded.
    pub position: [Vec<f32>; 3],
    /// Volume weights, m3, padded with zero.
    pub volume: Vec<f32>,
    /// Volume weights of those that drag the fluid along, zero for the others; empty if there is none, padded otherwise.
    pub viscous_volume: Vec<f32>,
    /// Volume weights times the coefficients of friction of what sticks and of what slides, m3, padded; empty if there is none.
    pub friction: [Vec<f32>; 2],
    /// `p / rho^2`, m5/(kg s2), padded: of quasi-fluid samples, zero for the others; empty if there are none.
    pub pressure_term: Vec<f32>,
    /// Velocities, m/s, padded; one array of zeros for all axes if none moves.
    velocity: Vec<Vec<f32>>,
    /// Index of each sample in the order given.
    pub source: Vec<u32>,
}

impl SortedSamples {
    /// Sorts samples, each as its image within the periods; reuses memory.
    pub fn sort(&mut self, grid: &Grid, positions: &[Vec3], volumes: &[f32]) {
        if grid.periodic.any() {
            let images = positions.iter().map(|&position| grid.periodic.wrap(position));
            self.sort_within(grid, images, volumes);
        } else {
            self.sort_within(grid, positions.iter().copied(), volumes);
        }
    }

    fn sort_within(&mut self, grid: &Grid, positions: impl ExactSizeIterator<Item = Vec3> + Clone, volumes: &[f32]) {
        let count = positions.len();
        let cells = grid.cells() as usize;
        self.starts.clear();
        self.starts.resize(cells + 1, 0);
        let cell_of = |position: Vec3| grid.index(grid.coordinates(position)) as usize;
        for position in positions.clone() {
            self.starts[cell_of(position)] += 1;
        }
        let mut total = 0;
        for start in &mut self.starts {
            total += std::mem::replace(start, total);
        }
        for values in self.position.iter_mut().chain(std::iter::once(&mut self.volume)) {
            values.clear();
            values.resize(count + PADDING, 0.0);
        }
        self.source.resize(count, 0);
        for (index, (position, &volume)) in positions.zip(volumes).enumerate() {
            // Starts serve as cursors and end up one cell ahead; they are moved back below.
            let cursor = &mut self.starts[cell_of(position)];
            let slot = *cursor as usize;
            *cursor += 1;
            self.source[slot] = index as u32;
            self.volume[slot] = volume;
            for axis in 0..3 {
                self.position[axis][slot] = position[axis];
            }
        }
        self.starts.copy_within(0..cells, 1);
        self.starts[0] = 0;
    }

    /// Marks the samples that drag the fluid along, in the order given to [`SortedSamples::sort`].
    pub fn set_viscous(&mut self, viscous: &[bool]) {
        self.viscous_volume.clear();
        if viscous.contains(&true) {
            let drag = |(&source, &volume): (&u32, &f32)| if viscous[source as usize] { volume } else { 0.0 };
            self.viscous_volume.extend(self.source.iter().zip(&self.volume).map(drag));
            self.viscous_volume.resize(self.len() + PADDING, 0.0);
        }
    }

    /// Gives the samples coefficients of friction, in the order given to [`SortedSamples::sort`]; none if there are none.
    pub fn set_frictions(&mut self, frictions: &[[f32; 2]]) {
        for (kind, weights) in self.friction.iter_mut().enumerate() {
            weights.clear();
            if !frictions.is_empty() {
                let weight = |(&source, &volume): (&u32, &f32)| frictions[source as usize][kind] * volume;
                weights.extend(self.source.iter().zip(&self.volume).map(weight));
                weights.resize(self.source.len() + PADDING, 0.0);
            }
        }
    }

    /// Says how the samples' surfaces move, in the order given to [`SortedSamples::sort`]; not at all if there is no velocity.
    pub fn set_velocities(&mut self, velocities: &[Vec3]) {
        let along = |axis: usize| {
            let mut values: Vec<f32> =
                self.source.iter().map(|&source| velocities.get(source as usize).map_or(0.0, |v| v[axis])).collect();
            values.resize(self.len() + PADDING, 0.0);
            values
        };
        let axes = if velocities.is_empty() { 0..1 } else { 0..3 };
        self.velocity = axes.map(along).collect();
    }

    /// Velocities of the surfaces along x, y and z, m/s, padded.
    pub fn velocity(&self) -> [&[f32]; 3] {
        [0, 1, 2].map(|axis| self.velocity.get(axis).or(self.velocity.first()).map_or(&[][..], Vec::as_slice))
    }

    /// Whether any moves.
    pub fn moves(&self) -> bool {
        self.velocity.len() > 1
    }

    /// Whether any drags the fluid along.
    pub fn drags(&self) -> bool {
        !self.viscous_volume.is_empty()
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.source.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.source.is_empty()
    }

    /// Position of the sample in a slot, m.
    pub fn position_of(&self, slot: usize) -> Vec3 {
        Vec3::new(self.position[0][slot], self.position[1][slot], self.position[2][slot])
    }

    /// Bytes allocated.
    pub fn bytes(&self) -> u64 {
        let weights = [&self.volume, &self.viscous_volume, &self.pressure_term];
        let reals: usize =
            self.position.iter().chain(weights).chain(&self.friction).chain(&self.velocity).map(Vec::capacity).sum();
        4 * (reals + self.source.capacity() + self.starts.capacity()) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_grouped_by_cell_and_stable() {
        let grid = Grid::fitting(1.0, Vec3::splat(6.0), 1 << 20);
        let positions: Vec<Vec3> =
            (0..100).map(|i| Vec3::new((i * 7 % 13) as f32, (i * 5 % 11) as f32, (i % 3) as f32) * 0.7).collect();
        let volumes: Vec<f32> = (0..100).map(|i| i as f32).collect();
        let mut sorted = SortedSamples::default();
        for _ in 0..2 {
            sorted.sort(&grid, &positions, &volumes);
        }
        assert_eq!(sorted.starts[grid.cells() as usize], 100);
        for cell in 0..grid.cells() as usize {
            let range = sorted.starts[cell] as usize..sorted.starts[cell + 1] as usize;
            assert!(sorted.source[range.clone()].is_sorted());
            for slot in range {
                let source = sorted.source[slot] as usize;
                assert_eq!(grid.index(grid.coordinates(positions[source])) as usize, cell);
                assert_eq!(sorted.position_of(slot), positions[source]);
                assert_eq!(sorted.volume[slot], volumes[source]);
            }
        }
    }
}
