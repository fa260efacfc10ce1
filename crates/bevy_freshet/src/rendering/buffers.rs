//! The buffers that are drawn from: the GPU solver's own, or copies of what the CPU solver has.

use std::collections::HashMap;

use bevy::prelude::*;
use bevy::render::render_resource::{
    BindGroup, BindGroupEntries, BufferUsages, DynamicUniformBuffer, PipelineCache, RawBufferVec,
};
use bevy::render::renderer::{RenderDevice, RenderQueue};
use bytemuck::{Pod, Zeroable};
use freshet_gpu::layout::ParticleRecord;

use super::extract::{ExtractedFluids, ExtractedSun, Particles};
use super::pipeline::ImpostorLayouts;
use super::uniform::FluidUniform;
use crate::engine::frame::ParticleFrame;
use crate::engine::gpu_engine::DrawBuffers;

/// Corners of the quad of one particle.
pub(crate) const CORNERS: u32 = 4;

/// Arguments of an indirect draw, in WebGPU's order.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct DrawArguments {
    vertex_count: u32,
    instance_count: u32,
    first_vertex: u32,
    first_instance: u32,
}

/// Copies of a CPU solver's particles.
struct Uploaded {
    version: u64,
    particles: RawBufferVec<ParticleRecord>,
    densities: RawBufferVec<[f32; 2]>,
    accelerations: RawBufferVec<[f32; 4]>,
    arguments: RawBufferVec<DrawArguments>,
}

impl Uploaded {
    fn new() -> Self {
        Self {
            version: 0,
            particles: labelled("particle"),
            densities: labelled("density"),
            accelerations: labelled("acceleration"),
            arguments: {
                let mut arguments = RawBufferVec::new(BufferUsages::INDIRECT);
                arguments.set_label(Some("freshet:buffer:draw_arguments"));
                arguments
            },
        }
    }

    fn upload(&mut self, frame: &ParticleFrame, device: &RenderDevice, queue: &RenderQueue) {
        if self.version == frame.version {
            return;
        }
        self.version = frame.version;
        fill(&mut self.particles, &frame.particles, device, queue);
        fill(&mut self.densities, &frame.densities, device, queue);
        fill(&mut self.accelerations, &frame.accelerations, device, queue);
        let instance_count = frame.particles.len() as u32;
        let arguments = DrawArguments { vertex_count: CORNERS, instance_count, first_vertex: 0, first_instance: 0 };
        fill(&mut self.arguments, &[arguments], device, queue);
    }

    fn draw_buffers(&self) -> Option<DrawBuffers> {
        Some(DrawBuffers {
            particles: self.particles.buffer()?.clone(),
            densities: self.densities.buffer()?.clone(),
            accelerations: self.accelerations.buffer()?.clone(),
            arguments: self.arguments.buffer()?.clone(),
            arguments_offset: 0,
        })
    }
}

fn labelled<T: bytemuck::NoUninit>(name: &str) -> RawBufferVec<T> {
    let mut buffer = RawBufferVec::new(BufferUsages::STORAGE);
    buffer.set_label(Some(&format!("freshet:buffer:drawn_{name}")));
    buffer
}

fn fill<T: bytemuck::NoUninit>(buffer: &mut RawBufferVec<T>, values: &[T], device: &RenderDevice, queue: &RenderQueue) {
    buffer.clear();
    buffer.extend(values.iter().copied());
    // A binding must not be empty.
    buffer.reserve(values.len().max(1), device);
    buffer.write_buffer(device, queue);
}

/// A domain ready to be drawn.
pub(crate) struct DrawnFluid {
    pub(crate) bind_group: Option<BindGroup>,
    pub(crate) uniform_offset: u32,
    pub(crate) buffers: DrawBuffers,
    pub(crate) is_surface: bool,
}

/// All domains ready to be drawn, and what is kept for them.
#[derive(Resource, Default)]
pub(crate) struct DrawnFluids {
    pub(crate) fluids: Vec<DrawnFluid>,
    uploaded: HashMap<Entity, Uploaded>,
    pub(crate) uniforms: DynamicUniformBuffer<FluidUniform>,
}

/// Buffers of a lost device are of no use.
pub(crate) fn forget_all(mut drawn: ResMut<DrawnFluids>) {
    *drawn = default();
}

pub(crate) fn prepare_buffers(
    extracted: Res<ExtractedFluids>,
    sun: Res<ExtractedSun>,
    mut drawn: ResMut<DrawnFluids>,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
) {
    let drawn = &mut *drawn;
    drawn.fluids.clear();
    drawn.uniforms.clear();
    drawn.uploaded.retain(|entity, _| extracted.0.iter().any(|fluid| fluid.entity == *entity));
    for fluid in &extracted.0 {
        let buffers = match &fluid.particles {
            Particles::Frame(frame) => {
                let uploaded = drawn.uploaded.entry(fluid.entity).or_insert_with(Uploaded::new);
                uploaded.upload(frame, &device, &queue);
                uploaded.draw_buffers()
            }
            Particles::Gpu(shared) => shared.draw_buffers(),
        };
        let Some(buffers) = buffers else { continue };
        let uniform = FluidUniform {
            towards_light: sun.towards.extend(0.0),
            light: sun.light.to_vec4(),
            ambient: sun.ambient.to_vec4(),
            ..fluid.uniform
        };
        let uniform_offset = drawn.uniforms.push(&uniform);
        let is_surface = fluid.is_surface;
        drawn.fluids.push(DrawnFluid { bind_group: None, uniform_offset, buffers, is_surface });
    }
    drawn.uniforms.write_buffer(&device, &queue);
}

pub(crate) fn prepare_fluid_bind_groups(
    mut drawn: ResMut<DrawnFluids>,
    layouts: Res<ImpostorLayouts>,
    pipelines: Res<PipelineCache>,
    device: Res<RenderDevice>,
) {
    let DrawnFluids { fluids, uniforms, .. } = &mut *drawn;
    let Some(uniform) = uniforms.binding() else { return };
    let layout = pipelines.get_bind_group_layout(&layouts.fluid);
    for fluid in fluids {
        let DrawBuffers { particles, densities, accelerations, .. } = &fluid.buffers;
        fluid.bind_group = Some(device.create_bind_group(
            "freshet:bind_group:impostor",
            &layout,
            &BindGroupEntries::sequential((
                uniform.clone(),
                particles.as_entire_buffer_binding(),
                densities.as_entire_buffer_binding(),
                accelerations.as_entire_buffer_binding(),
            )),
        ));
    }
}
