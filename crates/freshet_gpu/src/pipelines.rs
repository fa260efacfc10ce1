//! Pipelines of the passes and the bind groups that go with them.

use freshet_core::solver::SolverError;

use crate::buffers::Buffers;
use crate::errors::guarded;
use crate::layout::{Access, Binding};
use crate::memory::TEXEL_FORMAT;
use crate::options::GpuOptions;
use crate::passes::Pass;

/// A compiled pass; clones share what was compiled.
#[derive(Clone, Debug)]
pub(crate) struct Pipeline {
    /// What it was compiled from.
    pub pass: Pass,
    /// The pipeline.
    pub pipeline: wgpu::ComputePipeline,
    /// Label, `freshet:pass:name`.
    pub label: String,
    layout: wgpu::BindGroupLayout,
}

impl Pipeline {
    /// Compiles a pass. Bounds are checked by the driver or by naga, as the device is set up.
    pub fn new(
        device: &wgpu::Device,
        module: wgpu::naga::Module,
        pass: Pass,
        options: &GpuOptions,
    ) -> Result<Self, SolverError> {
        let label = format!("freshet:pass:{}", pass.name);
        guarded(device, &label.clone(), || {
            let shader = device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(&format!("freshet:shader:{}", pass.name)),
                source: wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(module)),
            });
            let mut entries: Vec<_> =
                pass.uses.iter().map(|&(binding, access)| layout_entry(binding, access, options.textures())).collect();
            entries.sort_by_key(|entry| entry.binding);
            let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(&format!("freshet:bind_group_layout:{}", pass.name)),
                entries: &entries,
            });
            let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(&format!("freshet:pipeline_layout:{}", pass.name)),
                bind_group_layouts: &[Some(&layout)],
                immediate_size: 0,
            });
            let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(&label),
                layout: Some(&pipeline_layout),
                module: &shader,
                entry_point: Some(pass.name),
                compilation_options: Default::default(),
                cache: None,
            });
            Self { pass, pipeline, label, layout }
        })
    }

    /// The same for a pass that differs only in where it is in a substep.
    pub fn with_pass(self, pass: Pass) -> Self {
        Self { pass, ..self }
    }

    /// Binds the solver's buffers and, for passes of commands, a tick's own.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        buffers: &Buffers,
        own: &[(Binding, wgpu::BindingResource)],
    ) -> wgpu::BindGroup {
        let resource = |binding: Binding| {
            if let Some((_, resource)) = own.iter().find(|entry| entry.0 == binding) {
                return Some(resource.clone());
            }
            buffers.resource(binding)
        };
        let mut entries: Vec<_> = self
            .pass
            .uses
            .iter()
            .filter_map(|&(binding, _)| {
                Some(wgpu::BindGroupEntry { binding: binding.number(), resource: resource(binding)? })
            })
            .collect();
        entries.sort_by_key(|entry| entry.binding);
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(&format!("freshet:bind_group:{}", self.pass.name)),
            layout: &self.layout,
            entries: &entries,
        })
    }
}

fn layout_entry(binding: Binding, access: Access, textures: bool) -> wgpu::BindGroupLayoutEntry {
    let buffer =
        |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: binding == Binding::Input, min_binding_size: None };
    let ty = if binding.is_uniform() {
        buffer(wgpu::BufferBindingType::Uniform)
    } else if textures && binding.is_of_neighbours() {
        wgpu::BindingType::StorageTexture {
            access: match access {
                Access::Read => wgpu::StorageTextureAccess::ReadOnly,
                Access::Write => wgpu::StorageTextureAccess::WriteOnly,
            },
            format: TEXEL_FORMAT,
            view_dimension: wgpu::TextureViewDimension::D2,
        }
    } else {
        buffer(wgpu::BufferBindingType::Storage { read_only: access == Access::Read && !binding.is_atomic() })
    };
    wgpu::BindGroupLayoutEntry { binding: binding.number(), visibility: wgpu::ShaderStages::COMPUTE, ty, count: None }
}
