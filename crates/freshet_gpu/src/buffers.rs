//! The solver's memory: what is needed for a plan and a capacity, and its allocation.

use freshet_core::plan::Plan;
use freshet_core::solver::{ScheduledBuffer, SolverError};
use wgpu::BufferUsages as Usage;

use crate::cells::{CellTables, sort_walls};
use crate::device::check_device;
use crate::errors::guarded;
use crate::layout::{
    Binding, BodyInputRecord, BodyRecord, BodySampleRecord, Parameters, SampleLoadRecord, StepControl,
};
use crate::memory::{Held, Memory};
use crate::parameters::parameters;
use crate::passes::{Arguments, moving_walls};

/// Ticks that can be prepared without their report being collected.
pub(crate) const TICK_SLOTS: usize = 8;

/// Distance of the ring's ticks in the buffer of inputs: WebGPU's alignment of dynamic offsets.
pub(crate) const INPUT_STRIDE: u64 = 256;

/// One buffer of the solver.
struct Need {
    binding: Binding,
    bytes: u64,
    per_particle: bool,
    usage: Usage,
}

fn needs(plan: &Plan, capacity: u32) -> Vec<Need> {
    let tables = CellTables::of(plan);
    let mut needs = Vec::new();
    let mut need = |binding: Binding, bytes: u64, usage: Usage| {
        let per_particle =
            binding.particle_bytes().is_some() || matches!(binding, Binding::CellCounts | Binding::CellStarts);
        needs.push(Need { binding, bytes, per_particle, usage });
    };
    let bytes = |size: usize, count: usize| (size * count) as u64;
    let state = Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST;
    need(Binding::Parameters, size_of::<Parameters>() as u64, Usage::UNIFORM | Usage::COPY_DST);
    need(Binding::Input, INPUT_STRIDE * TICK_SLOTS as u64, Usage::UNIFORM | Usage::COPY_DST);
    need(Binding::Control, size_of::<StepControl>() as u64, state);
    let arguments = 4 * (3 * Arguments::COUNT as u64 + 4);
    need(Binding::Arguments, arguments, Usage::STORAGE | Usage::INDIRECT | Usage::COPY_DST | Usage::COPY_SRC);
    for binding in Binding::ALL.into_iter().filter(|binding| binding.memory() == *binding) {
        if let Some(each) = binding.particle_bytes() {
            need(binding, each * u64::from(capacity), state);
        }
    }
    need(Binding::CellCounts, 4 * u64::from(tables.counts), state);
    need(Binding::CellStarts, 4 * u64::from(tables.starts), state);
    let (walls, moving) = (plan.boundary.positions.len(), plan.body_samples());
    if walls + moving > 0 {
        need(Binding::Samples, bytes(16, walls + moving), state);
    }
    if moving_walls(plan) {
        need(Binding::WallVelocities, bytes(16, walls), state);
    }
    if !plan.bodies.is_empty() {
        let bodies = plan.bodies.len();
        need(Binding::Bodies, bytes(size_of::<BodyRecord>(), bodies), state);
        need(Binding::BodyInputs, bytes(size_of::<BodyInputRecord>(), bodies * TICK_SLOTS), state);
        need(Binding::BodySamples, bytes(size_of::<BodySampleRecord>(), moving), state);
        need(Binding::BodySlots, bytes(4, moving), Usage::STORAGE);
        need(Binding::SampleLoads, bytes(size_of::<SampleLoadRecord>(), moving), Usage::STORAGE);
    }
    needs
}

/// The buffers that shaders see.
#[derive(Debug)]
pub(crate) struct Buffers {
    buffers: Vec<(Binding, bool, Held)>,
    memory: Memory,
    /// Particles there is room for.
    pub capacity: u32,
}

impl Buffers {
    /// Allocates and fills what does not change: parameters, walls, samples of bodies.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        plan: &Plan,
        capacity: u32,
        memory: &Memory,
    ) -> Result<Self, SolverError> {
        let needs = needs(plan, capacity);
        check_device(device, needs.iter().map(|need| need.bytes).max().unwrap_or(0))?;
        let buffers = guarded(device, "allocating buffers", || {
            needs.into_iter().map(|need| (need.binding, need.per_particle, allocate(device, &need, memory))).collect()
        })?;
        let buffers = Self { buffers, memory: memory.clone(), capacity };
        buffers.write(queue, Binding::Parameters, &[parameters(plan)]);
        let tables = CellTables::of(plan);
        if !plan.boundary.positions.is_empty() {
            let walls = sort_walls(plan);
            buffers.write(queue, Binding::Samples, &walls.samples);
            buffers.write(queue, Binding::WallVelocities, &walls.velocities);
            buffers.write_at(queue, Binding::CellStarts, 4 * u64::from(tables.wall_starts), &walls.starts);
        }
        if !plan.bodies.is_empty() {
            let (samples, bodies) = body_records(plan);
            buffers.write(queue, Binding::BodySamples, &samples);
            buffers.write(queue, Binding::Bodies, &bodies);
        }
        Ok(buffers)
    }

    /// Replaces the buffers of particles by ones of another capacity; the state is copied on the GPU.
    pub fn resize(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        plan: &Plan,
        capacity: u32,
    ) -> Result<(), SolverError> {
        let mut needs = needs(plan, capacity);
        check_device(device, needs.iter().map(|need| need.bytes).max().unwrap_or(0))?;
        needs.retain(|need| need.binding.particle_bytes().is_some());
        let fresh: Vec<_> = guarded(device, "resizing buffers", || {
            needs.iter().map(|need| (need.binding, allocate(device, need, &self.memory))).collect()
        })?;
        for (binding, buffer) in fresh {
            let Some((_, _, old)) = self.buffers.iter_mut().find(|entry| entry.0 == binding) else { continue };
            if matches!(binding, Binding::Particles | Binding::Densities | Binding::Accelerations) {
                encoder.copy_buffer_to_buffer(old, 0, &buffer, 0, old.size().min(buffer.size()));
            }
            *old = buffer;
        }
        self.capacity = capacity;
        Ok(())
    }

    /// The buffer of a binding; none if the plan does not need it.
    pub fn get(&self, binding: Binding) -> Option<&wgpu::Buffer> {
        self.buffers.iter().find(|entry| entry.0 == binding.memory()).map(|entry| &*entry.2)
    }

    /// As they stand in the schedule: their true sizes.
    pub fn scheduled(&self) -> Vec<ScheduledBuffer> {
        let buffer = |(binding, per_particle, buffer): &(Binding, bool, Held)| ScheduledBuffer {
            name: binding.name(),
            bytes: buffer.size(),
            per_particle: *per_particle,
        };
        self.buffers.iter().map(buffer).collect()
    }

    /// Writes the start of a buffer before the next submit; nothing if the plan does not need it.
    pub fn write<T: bytemuck::NoUninit>(&self, queue: &wgpu::Queue, binding: Binding, values: &[T]) {
        self.write_at(queue, binding, 0, values);
    }

    /// Writes a part of a buffer before the next submit; nothing if the plan does not need it.
    pub fn write_at<T: bytemuck::NoUninit>(&self, queue: &wgpu::Queue, binding: Binding, offset: u64, values: &[T]) {
        if let Some(buffer) = self.get(binding)
            && !values.is_empty()
        {
            queue.write_buffer(buffer, offset, bytemuck::cast_slice(values));
        }
    }
}

fn allocate(device: &wgpu::Device, need: &Need, memory: &Memory) -> Held {
    let about = wgpu::BufferDescriptor {
        label: Some(&format!("freshet:buffer:{}", need.binding.name())),
        // wgpu refuses to bind a buffer of no bytes.
        size: need.bytes.max(16),
        usage: need.usage,
        mapped_at_creation: false,
    };
    memory.allocate(device, &about)
}

fn body_records(plan: &Plan) -> (Vec<BodySampleRecord>, Vec<BodyRecord>) {
    let (mut samples, mut bodies) = (Vec::new(), Vec::new());
    for (index, body) in plan.bodies.iter().enumerate() {
        bodies.push(BodyRecord {
            rotation: [0.0, 0.0, 0.0, 1.0],
            first_sample: samples.len() as u32,
            sample_count: body.samples.len() as u32,
            ..Default::default()
        });
        samples.extend(body.samples.iter().zip(&body.volumes).map(|(&offset, &volume)| BodySampleRecord {
            offset,
            volume,
            body: index as u32,
            ..Default::default()
        }));
    }
    (samples, bodies)
}
