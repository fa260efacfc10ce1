//! Time stamps around passes.

use freshet_core::solver::SolverError;
use freshet_core::step::PassTime;

use crate::errors::guarded;
use crate::memory::{Held, Memory};

/// Substeps of a tick whose passes are measured; the times of the others are taken to be the same.
pub const MEASURED_SUBSTEPS: u32 = 16;

/// A query set for the passes of the first substeps of a tick.
#[derive(Debug)]
pub(crate) struct Timer {
    set: wgpu::QuerySet,
    resolved: Held<wgpu::Buffer>,
    passes: Vec<&'static str>,
    period: f32,
}

impl Timer {
    /// None if the device has no time stamps.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        passes: Vec<&'static str>,
        memory: &Memory,
    ) -> Result<Option<Self>, SolverError> {
        if !device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return Ok(None);
        }
        let count = 2 * MEASURED_SUBSTEPS * passes.len() as u32;
        let (set, resolved) = guarded(device, "allocating time stamps", || {
            let set = device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("freshet:query_set:time_stamps"),
                ty: wgpu::QueryType::Timestamp,
                count,
            });
            let about = wgpu::BufferDescriptor {
                label: Some("freshet:buffer:time_stamps"),
                size: 8 * u64::from(count),
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            };
            let resolved = memory.allocate(device, &about);
            (set, resolved)
        })?;
        Ok(Some(Self { set, resolved, passes, period: queue.get_timestamp_period() }))
    }

    /// Where the stamps end up.
    pub fn buffer(&self) -> &wgpu::Buffer {
        &self.resolved
    }

    /// The queries of a pass; none past the measured substeps.
    pub fn writes(&self, substep: u32, pass: usize) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        if substep >= MEASURED_SUBSTEPS {
            return None;
        }
        let first = 2 * (substep * self.passes.len() as u32 + pass as u32);
        Some(wgpu::ComputePassTimestampWrites {
            query_set: &self.set,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        })
    }

    /// Encodes the resolving of the stamps of `encoded` substeps; only those that were written may be resolved.
    pub fn resolve(&self, encoder: &mut wgpu::CommandEncoder, encoded: u32) {
        let count = 2 * encoded.min(MEASURED_SUBSTEPS) * self.passes.len() as u32;
        if count > 0 {
            encoder.resolve_query_set(&self.set, 0..count, &self.resolved, 0);
        }
    }

    /// The times of all `made` substeps, those made again among them, from the stamps of the first of them.
    pub fn times(&self, stamps: &[u8], encoded: u32, made: u32) -> Vec<PassTime> {
        let measured = encoded.min(made).min(MEASURED_SUBSTEPS);
        let stamps: Vec<u64> = stamps.chunks_exact(8).map(bytemuck::pod_read_unaligned).collect();
        let time = |(pass, name): (usize, &&'static str)| {
            let ticks: u64 = (0..measured as usize)
                .map(|substep| 2 * (substep * self.passes.len() + pass))
                .map(|first| stamps[first + 1].saturating_sub(stamps[first]))
                .sum();
            let share = made as f32 / measured.max(1) as f32;
            PassTime { pass: (*name).to_owned(), milliseconds: ticks as f32 * self.period * 1e-6 * share }
        };
        self.passes.iter().enumerate().map(time).collect()
    }
}
