//! Stage `body_sort`: samples to where the bodies are, sorted by cell.

use freshet_core::grid::Grid;
use freshet_core::plan::PlannedBody;
use glam::Vec3;

use super::body_motion::MovingBody;
use crate::lanes::PADDING;
use crate::neighbours::Rows;
use crate::particles::Particles;
use crate::samples::SortedSamples;

/// Samples of all bodies.
#[derive(Default)]
pub struct BodySamples {
    /// Sorted by cell; sources count through the bodies in the plan's order.
    pub sorted: SortedSamples,
    positions: Vec<Vec3>,
    volumes: Vec<f32>,
    /// What a body's own samples add to the density of each, over the density at rest; negative for those of a single layer.
    own_densities: Vec<f32>,
    /// Of each body the first sample.
    firsts: Vec<usize>,
    /// In the order of slots, padded: from the centre of mass along x, y and z, m, and the index of the body, likewise.
    arms: [Vec<f32>; 3],
    owners: Vec<f32>,
}

impl BodySamples {
    /// `x_body + R s` for every sample, as far as its body has [swollen](freshet_core::swelling), then a counting sort on the fluid's grid.
    pub fn update(&mut self, grid: &Grid, plan: &[PlannedBody], bodies: &[MovingBody]) {
        self.positions.clear();
        self.volumes.clear();
        self.own_densities.clear();
        self.firsts.clear();
        for (planned, body) in plan.iter().zip(bodies) {
            self.firsts.push(self.positions.len());
            let sample = |index| body.position + body.rotation * planned.sample(index, body.swollen);
            self.positions.extend((0..planned.samples.len()).map(sample));
            let weight = PlannedBody::weight(body.swollen);
            self.volumes.extend(planned.volumes.iter().map(|volume| weight * volume));
            self.own_densities.extend(planned.own_densities.iter().map(|own| weight * own));
            self.own_densities.resize(self.volumes.len(), -1.0);
        }
        self.sorted.sort(grid, &self.positions, &self.volumes);
    }

    /// Finds out whose each sorted sample is, and where about its centre of mass.
    pub fn find_arms(&mut self, bodies: &[MovingBody]) {
        let padded = self.sorted.len() + PADDING;
        for values in self.arms.iter_mut().chain([&mut self.owners]) {
            values.clear();
            values.resize(padded, 0.0);
        }
        for (slot, &source) in self.sorted.source.iter().enumerate() {
            let index = self.owner_of(source);
            let arm = self.positions[source as usize] - bodies[index].position;
            for (values, along) in self.arms.iter_mut().zip(arm.to_array()) {
                values[slot] = along;
            }
            self.owners[slot] = index as f32;
        }
    }

    /// Index of the body that a source belongs to.
    fn owner_of(&self, source: u32) -> usize {
        self.firsts.partition_point(|&first| first <= source as usize) - 1
    }

    /// Counts of each body the samples with a particle's centre within the support radius.
    pub fn count_wetted(&self, grid: &Grid, starts: &[u32], particles: &Particles, counts: &mut Vec<u32>) {
        counts.clear();
        counts.resize(self.firsts.len(), 0);
        let reach = grid.support_radius * grid.support_radius;
        let (mut rows, mut rows_of) = (Rows::default(), None);
        for (slot, &source) in self.sorted.source.iter().enumerate() {
            let at = self.sorted.position_of(slot);
            let cell = grid.index(grid.coordinates(at)) as usize;
            if rows_of != Some(cell) {
                (rows, rows_of) = (Rows::around(grid, starts, cell), Some(cell));
            }
            let is_near = |a: u32| {
                let way = grid.periodic.nearest(particles.position_of(a as usize) - at);
                way.length_squared() < reach
            };
            if rows.all().iter().any(|&(start, end)| (start..end).any(is_near)) {
                counts[self.owner_of(source)] += 1;
            }
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
        let unsorted = size_of::<Vec3>() * self.positions.capacity()
            + 4 * (self.volumes.capacity() + self.own_densities.capacity());
        let arms: usize = self.arms.iter().chain([&self.owners]).map(Vec::capacity).sum();
        let firsts = size_of::<usize>() * self.firsts.capacity();
        self.sorted.bytes() + (unsorted + firsts + 4 * arms) as u64
    }

    /// What a body's own samples add to the density of each, by source index; see the field.
    pub fn own_densities(&self) -> &[f32] {
        &self.own_densities
    }

    /// Position of a sample by its source index, m.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }
}
