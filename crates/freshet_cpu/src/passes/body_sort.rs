//! Stage `body_sort`: samples to where the bodies are, sorted by cell.

use freshet_core::grid::Grid;
use freshet_core::plan::PlannedBody;
use glam::Vec3;

use super::body_motion::MovingBody;
use crate::samples::SortedSamples;

/// Samples of all bodies.
#[derive(Default)]
pub struct BodySamples {
    /// Sorted by cell; sources count through the bodies in the plan's order.
    pub sorted: SortedSamples,
    positions: Vec<Vec3>,
    volumes: Vec<f32>,
}

impl BodySamples {
    /// `x_body + R s` for every sample, then a counting sort on the fluid's grid.
    pub fn update(&mut self, grid: &Grid, plan: &[PlannedBody], bodies: &[MovingBody]) {
        self.positions.clear();
        self.volumes.clear();
        for (planned, body) in plan.iter().zip(bodies) {
            self.positions.extend(planned.samples.iter().map(|&sample| body.position + body.rotation * sample));
            self.volumes.extend(&planned.volumes);
        }
        self.sorted.sort(grid, &self.positions, &self.volumes);
    }

    /// Bytes allocated.
    pub fn bytes(&self) -> u64 {
        let unsorted = size_of::<Vec3>() * self.positions.capacity() + 4 * self.volumes.capacity();
        self.sorted.bytes() + unsorted as u64
    }

    /// Position of a sample by its source index, m.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }
}
