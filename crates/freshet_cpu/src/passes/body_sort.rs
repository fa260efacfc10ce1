//! Stage `body_sort`: samples to where the bodies are, sorted by cell.

use freshet_core::grid::Grid;
use freshet_core::plan::PlannedBody;
use glam::Vec3;

use super::body_motion::MovingBody;
use crate::lanes::PADDING;
use crate::samples::SortedSamples;

/// Samples of all bodies.
#[derive(Default)]
pub struct BodySamples {
    /// Sorted by cell; sources count through the bodies in the plan's order.
    pub sorted: SortedSamples,
    positions: Vec<Vec3>,
    volumes: Vec<f32>,
    /// Of each body the first sample, of plans that ask for it.
    firsts: Vec<usize>,
    /// In the order of slots, padded: from the centre of mass along x, y and z, m, and the index of the body, likewise.
    arms: [Vec<f32>; 3],
    owners: Vec<f32>,
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

    /// Finds out whose each sorted sample is, and where about its centre of mass.
    pub fn find_arms(&mut self, plan: &[PlannedBody], bodies: &[MovingBody]) {
        let padded = self.sorted.len() + PADDING;
        for values in self.arms.iter_mut().chain([&mut self.owners]) {
            values.clear();
            values.resize(padded, 0.0);
        }
        self.firsts.clear();
        self.firsts.extend(plan.iter().scan(0, |next, body| {
            let first = *next;
            *next += body.samples.len();
            Some(first)
        }));
        for (slot, &source) in self.sorted.source.iter().enumerate() {
            let source = source as usize;
            let index = self.firsts.partition_point(|&first| first <= source) - 1;
            let arm = self.positions[source] - bodies[index].position;
            for (values, along) in self.arms.iter_mut().zip(arm.to_array()) {
                values[slot] = along;
            }
            self.owners[slot] = index as f32;
        }
    }

    /// Where the samples in the slots are about their bodies' centres of mass, along x, y and z, m, padded.
    pub fn arms(&self) -> [&[f32]; 3] {
        self.arms.each_ref().map(Vec::as_slice)
    }

    /// The bodies that the samples in the slots belong to, padded.
    pub fn owners(&self) -> &[f32] {
        &self.owners
    }

    /// Bytes allocated.
    pub fn bytes(&self) -> u64 {
        let unsorted = size_of::<Vec3>() * self.positions.capacity() + 4 * self.volumes.capacity();
        let arms: usize = self.arms.iter().chain([&self.owners]).map(Vec::capacity).sum();
        let firsts = size_of::<usize>() * self.firsts.capacity();
        self.sorted.bytes() + (unsorted + firsts + 4 * arms) as u64
    }

    /// Position of a sample by its source index, m.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }
}
