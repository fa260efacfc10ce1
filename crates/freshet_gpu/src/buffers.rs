//! The solver's memory: what is needed for a plan and a capacity, and its allocation.

use freshet_core::plan::{Plan, StageKind};
use freshet_core::solver::{ScheduledBuffer, SolverError};
use wgpu::BufferUsages as Usage;

use crate::cells::{CellTables, first_body_sample, sort_walls};
use crate::device::{check_device, check_textures};
use crate::errors::guarded;
use crate::layout::{
    Binding, BodyAnswerRecord, BodyInputRecord, BodyRecord, BodySampleRecord, Parameters, SampleLoadRecord, StepControl,
};
use crate::memory::{Held, Memory, TEXEL_BYTES, write_texels};
use crate::options::GpuOptions;
use crate::parameters::parameters;
use crate::passes::{
    Arguments, answering_bodies, before_words, history_words, incompressible, sample_arms, solve_words,
};

/// Ticks that can be prepared without their report being collected.
pub(crate) const TICK_SLOTS: usize = 8;

/// Distance of the ring's ticks in the buffer of inputs: WebGPU's alignment of dynamic offsets.
pub(crate) const INPUT_STRIDE: u64 = 256;

/// One buffer of the solver; a texture in its stead has a texel for every particle.
struct Need {
    binding: Binding,
    bytes: u64,
    per_particle: bool,
    usage: Usage,
}

/// One of the solver's bindings and what holds it.
#[derive(Debug)]
struct Allocated {
    binding: Binding,
    per_particle: bool,
    store: Store,
}

#[derive(Debug)]
enum Store {
    Buffer(Held<wgpu::Buffer>),
    Texels(Held<wgpu::Texture>, wgpu::TextureView),
}

impl Store {
    fn buffer(&self) -> Option<&wgpu::Buffer> {
        match self {
            Store::Buffer(buffer) => Some(buffer),
            Store::Texels(..) => None,
        }
    }
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
    let needed = |binding: &Binding| {
        let asked_for = match binding {
            Binding::Motions => incompressible(plan) || plan.has(StageKind::PositionSolve),
            Binding::Solves => incompressible(plan),
            Binding::Places => plan.has(StageKind::PositionSolve),
            Binding::Drifts => plan.has(StageKind::Xsph),
            Binding::Widths => plan.has(StageKind::Support),
            Binding::Contacts => plan.has(StageKind::BodyDrag) || plan.has(StageKind::BodyFriction),
            Binding::Histories => history_words(plan) > 0,
            Binding::Befores => plan.parameters.redo_substeps,
            _ => true,
        };
        asked_for && binding.memory() == *binding
    };
    for binding in Binding::ALL.into_iter().filter(needed) {
        if let Some(each) = binding.particle_bytes() {
            let each = match binding {
                Binding::Solves => 4 * u64::from(solve_words(plan)),
                Binding::Histories => 2 * 4 * history_words(plan),
                Binding::Befores => 4 * before_words(plan),
                _ => each,
            };
            need(binding, each * u64::from(capacity), state);
        }
    }
    need(Binding::CellCounts, 4 * u64::from(tables.counts), state);
    need(Binding::CellStarts, 4 * u64::from(tables.starts), state);
    let moving = plan.body_samples();
    // Plans have the one or the other.
    let beside = if sample_arms(plan) || plan.has(StageKind::BodyDensity) { moving } else { 0 };
    let samples = first_body_sample(plan) + moving + beside;
    if samples > 0 {
        need(Binding::Samples, bytes(16, samples), state);
    }
    if plan.has(StageKind::Friction) {
        need(Binding::WallFrictions, bytes(8, plan.boundary.positions.len()), state);
    }
    if !plan.boundary.faces.is_empty() {
        need(Binding::WallFaces, bytes(16, plan.boundary.faces.len()), state);
    }
    if !plan.boundary.own_densities.is_empty() {
        need(Binding::WallDensities, bytes(8, plan.boundary.own_densities.len()), state);
    }
    if !plan.bodies.is_empty() {
        let bodies = plan.bodies.len();
        need(Binding::Bodies, bytes(size_of::<BodyRecord>(), bodies), state);
        if plan.parameters.redo_substeps {
            need(Binding::BodiesBefore, bytes(size_of::<BodyRecord>(), bodies), Usage::STORAGE);
        }
        need(Binding::BodyInputs, bytes(size_of::<BodyInputRecord>(), bodies * TICK_SLOTS), state);
        need(Binding::BodySamples, bytes(size_of::<BodySampleRecord>(), moving), state);
        need(Binding::BodySlots, bytes(4, moving), Usage::STORAGE);
        need(Binding::SampleLoads, bytes(size_of::<SampleLoadRecord>(), moving), Usage::STORAGE);
        if answering_bodies(plan) {
            need(Binding::Answers, bytes(size_of::<BodyAnswerRecord>(), bodies), Usage::STORAGE);
        }
    }
    needs
}

/// The buffers that shaders see, and the textures that hold what they read of every neighbour.
#[derive(Debug)]
pub(crate) struct Buffers {
    allocated: Vec<Allocated>,
    textures: bool,
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
        options: &GpuOptions,
        memory: &Memory,
    ) -> Result<Self, SolverError> {
        let mut buffers =
            Self { allocated: Vec::new(), textures: options.textures(), memory: memory.clone(), capacity };
        buffers.allocated = buffers.allocate(device, needs(plan, capacity))?;
        buffers.write(queue, Binding::Parameters, &[parameters(plan)]);
        let tables = CellTables::of(plan);
        if !plan.boundary.positions.is_empty() {
            let walls = sort_walls(plan);
            buffers.write_samples(queue, &[walls.samples, walls.velocities].concat());
            buffers.write(queue, Binding::WallFrictions, &walls.frictions);
            buffers.write(queue, Binding::WallFaces, &walls.faces);
            buffers.write(queue, Binding::WallDensities, &walls.densities);
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
        needs.retain(|need| need.binding.particle_bytes().is_some());
        for fresh in self.allocate(device, needs)? {
            let Some(old) = self.allocated.iter_mut().find(|old| old.binding == fresh.binding) else { continue };
            // Of the solves the first section is state, of the histories the first half.
            if matches!(
                fresh.binding,
                Binding::Particles | Binding::Densities | Binding::Accelerations | Binding::Solves | Binding::Histories
            ) && let (Some(from), Some(to)) = (old.store.buffer(), fresh.store.buffer())
            {
                encoder.copy_buffer_to_buffer(from, 0, to, 0, from.size().min(to.size()));
            }
            *old = fresh;
        }
        self.capacity = capacity;
        Ok(())
    }

    fn allocate(&self, device: &wgpu::Device, needs: Vec<Need>) -> Result<Vec<Allocated>, SolverError> {
        let largest = |texels: bool| {
            let of_kind = needs.iter().filter(|need| (self.textures && need.binding.is_of_neighbours()) == texels);
            of_kind.map(|need| need.bytes).max().unwrap_or(0)
        };
        check_device(device, largest(false))?;
        if self.textures {
            check_textures(device, largest(true) / TEXEL_BYTES)?;
        }
        let allocate = |need: Need| {
            let label = format!("freshet:buffer:{}", need.binding.name());
            let store = if self.textures && need.binding.is_of_neighbours() {
                let texture = self.memory.allocate_texels(device, &label, need.bytes / TEXEL_BYTES);
                let view = texture.create_view(&Default::default());
                Store::Texels(texture, view)
            } else {
                Store::Buffer(self.memory.allocate(
                    device,
                    &wgpu::BufferDescriptor {
                        label: Some(&label),
                        // wgpu refuses to bind a buffer of no bytes.
                        size: need.bytes.max(16),
                        usage: need.usage,
                        mapped_at_creation: false,
                    },
                ))
            };
            Allocated { binding: need.binding, per_particle: need.per_particle, store }
        };
        guarded(device, "allocating buffers", || needs.into_iter().map(allocate).collect())
    }

    /// The buffer of a binding; none if the plan does not need it, or if it is a texture.
    pub fn get(&self, binding: Binding) -> Option<&wgpu::Buffer> {
        self.store(binding)?.buffer()
    }

    /// What a binding is bound to; none if the plan does not need it.
    pub fn resource(&self, binding: Binding) -> Option<wgpu::BindingResource<'_>> {
        Some(match self.store(binding)? {
            Store::Buffer(buffer) => {
                let size = (binding == Binding::Input).then(|| wgpu::BufferSize::new(INPUT_STRIDE)).flatten();
                wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: 0, size })
            }
            Store::Texels(_, view) => wgpu::BindingResource::TextureView(view),
        })
    }

    fn store(&self, binding: Binding) -> Option<&Store> {
        self.allocated.iter().find(|allocated| allocated.binding == binding.memory()).map(|found| &found.store)
    }

    /// As they stand in the schedule: their true sizes.
    pub fn scheduled(&self) -> Vec<ScheduledBuffer> {
        let buffer = |allocated: &Allocated| ScheduledBuffer {
            name: allocated.binding.name(),
            bytes: match &allocated.store {
                Store::Buffer(buffer) => buffer.bytes(),
                Store::Texels(texture, _) => texture.bytes(),
            },
            per_particle: allocated.per_particle,
        };
        self.allocated.iter().map(buffer).collect()
    }

    /// Writes the start of a buffer before the next submit; nothing if the plan does not need it.
    pub fn write<T: bytemuck::NoUninit>(&self, queue: &wgpu::Queue, binding: Binding, values: &[T]) {
        self.write_at(queue, binding, 0, values);
    }

    /// Writes the first samples before the next submit.
    fn write_samples(&self, queue: &wgpu::Queue, samples: &[[f32; 4]]) {
        match self.store(Binding::Samples) {
            Some(Store::Texels(texture, _)) => write_texels(queue, texture, samples),
            _ => self.write(queue, Binding::Samples, samples),
        }
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

fn body_records(plan: &Plan) -> (Vec<BodySampleRecord>, Vec<BodyRecord>) {
    let (mut samples, mut bodies) = (Vec::new(), Vec::new());
    for (index, body) in plan.bodies.iter().enumerate() {
        bodies.push(BodyRecord {
            rotation: [0.0, 0.0, 0.0, 1.0],
            first_sample: samples.len() as u32,
            sample_count: body.samples.len() as u32,
            reach: body.reach,
            swelling_reach: body.swelling_reach,
            friction_at_rest: body.friction.at_rest,
            friction_sliding: body.friction.sliding,
            ..Default::default()
        });
        let weighted = body.samples.iter().zip(&body.volumes).zip(&body.roots).enumerate();
        samples.extend(weighted.map(|(k, ((&offset, &volume), &root))| BodySampleRecord {
            offset,
            volume,
            root,
            body: index as u32,
            own_density: body.own_densities.get(k).copied().unwrap_or(-1.0),
            ..Default::default()
        }));
    }
    (samples, bodies)
}
