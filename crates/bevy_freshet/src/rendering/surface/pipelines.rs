//! Pipelines of a view's surfaces, and their bindings.

use bevy::core_pipeline::core_3d::CORE_3D_DEPTH_FORMAT;
use bevy::prelude::*;
use bevy::render::render_resource::binding_types::{sampler, texture_2d, uniform_buffer};
use bevy::render::render_resource::{
    BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries, BlendComponent, BlendFactor,
    BlendOperation, BlendState, CachedRenderPipelineId, ColorTargetState, ColorWrites, CompareFunction,
    DepthStencilState, FilterMode, FragmentState, MultisampleState, PipelineCache, PrimitiveState, PrimitiveTopology,
    RenderPipelineDescriptor, Sampler, SamplerBindingType, SamplerDescriptor, ShaderStages, SpecializedRenderPipeline,
    SpecializedRenderPipelines, TextureFormat, TextureSampleType, VertexState,
};
use bevy::render::renderer::RenderDevice;
use bevy::shader::{Shader, ShaderDefVal};

use super::SurfaceShader;
use super::textures::{DEPTH_FORMAT, SurfaceTextures, THICKNESS_FORMAT};
use crate::rendering::buffers::DrawnFluids;
use crate::rendering::extract::ExtractedFluids;
use crate::rendering::pipeline::{ImpostorKey, ImpostorLayouts, ImpostorShader, ViewData};
use crate::rendering::uniform::FluidUniform;

/// Layouts and shaders; specialises pipelines.
#[derive(Resource, Clone)]
pub(crate) struct SurfaceLayouts {
    view: BindGroupLayoutDescriptor,
    fluid: BindGroupLayoutDescriptor,
    screen: BindGroupLayoutDescriptor,
    spheres: Handle<Shader>,
    screens: Handle<Shader>,
    sampler: Sampler,
}

/// One pipeline of those that make a surface.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(crate) enum SurfaceKey {
    /// Depth of the nearest spheres.
    Nearest,
    /// How much fluid there is, in a view of so many samples.
    Thickness(u32),
    /// The filter along rows, or columns.
    Smooth(Direction),
    /// Light, in a view.
    Light(ImpostorKey),
}

/// Of a filter.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Direction {
    Row,
    Column,
}

/// On a view: its pipelines.
#[derive(Component)]
pub(crate) struct SurfacePipelines {
    pub(crate) nearest: CachedRenderPipelineId,
    pub(crate) thickness: CachedRenderPipelineId,
    pub(crate) smooth: [CachedRenderPipelineId; 2],
    pub(crate) light: CachedRenderPipelineId,
}

/// On a view: bindings that read each of its depths.
#[derive(Component)]
pub(crate) struct SurfaceBindGroups(pub(crate) [BindGroup; 2]);

pub(crate) fn make_layouts(
    mut commands: Commands,
    impostors: Res<ImpostorLayouts>,
    spheres: Res<ImpostorShader>,
    screens: Res<SurfaceShader>,
    device: Res<RenderDevice>,
) {
    let values = || texture_2d(TextureSampleType::Float { filterable: false });
    let screen = BindGroupLayoutDescriptor::new(
        "freshet:layout:surface",
        &BindGroupLayoutEntries::sequential(
            ShaderStages::FRAGMENT,
            (
                uniform_buffer::<FluidUniform>(true),
                values(),
                values(),
                texture_2d(TextureSampleType::Float { filterable: true }),
                sampler(SamplerBindingType::Filtering),
            ),
        ),
    );
    let sampler = device.create_sampler(&SamplerDescriptor {
        label: Some("freshet:sampler:surface_scene"),
        mag_filter: FilterMode::Linear,
        min_filter: FilterMode::Linear,
        ..default()
    });
    commands.insert_resource(SurfaceLayouts {
        view: impostors.view.clone(),
        fluid: impostors.fluid.clone(),
        screen,
        spheres: spheres.0.clone(),
        screens: screens.0.clone(),
        sampler,
    });
    commands.insert_resource(SpecializedRenderPipelines::<SurfaceLayouts>::default());
}

impl SurfaceLayouts {
    /// Draws spheres.
    fn of_spheres(
        &self,
        label: &'static str,
        entry_point: &'static str,
        format: TextureFormat,
    ) -> RenderPipelineDescriptor {
        RenderPipelineDescriptor {
            label: Some(label.into()),
            layout: vec![self.view.clone(), self.fluid.clone()],
            vertex: VertexState { shader: self.spheres.clone(), entry_point: Some("vertex".into()), ..default() },
            primitive: PrimitiveState { topology: PrimitiveTopology::TriangleStrip, ..default() },
            fragment: Some(fragment(&self.spheres, Vec::new(), entry_point, format, None)),
            ..default()
        }
    }

    /// Draws a triangle that covers the screen.
    fn of_screens(
        &self,
        label: &'static str,
        entry_point: &'static str,
        format: TextureFormat,
        shader_defs: Vec<ShaderDefVal>,
    ) -> RenderPipelineDescriptor {
        RenderPipelineDescriptor {
            label: Some(label.into()),
            layout: vec![self.view.clone(), self.screen.clone()],
            vertex: VertexState {
                shader: self.screens.clone(),
                shader_defs: shader_defs.clone(),
                entry_point: Some("vertex".into()),
                ..default()
            },
            fragment: Some(fragment(&self.screens, shader_defs, entry_point, format, None)),
            ..default()
        }
    }
}

fn fragment(
    shader: &Handle<Shader>,
    shader_defs: Vec<ShaderDefVal>,
    entry_point: &'static str,
    format: TextureFormat,
    blend: Option<BlendState>,
) -> FragmentState {
    FragmentState {
        shader: shader.clone(),
        shader_defs,
        entry_point: Some(entry_point.into()),
        targets: vec![Some(ColorTargetState { format, blend, write_mask: ColorWrites::ALL })],
    }
}

/// Bevy's depth is reversed: near is 1.
fn depth_test(writes: bool) -> Option<DepthStencilState> {
    Some(DepthStencilState {
        format: CORE_3D_DEPTH_FORMAT,
        depth_write_enabled: Some(writes),
        depth_compare: Some(CompareFunction::GreaterEqual),
        stencil: default(),
        bias: default(),
    })
}

impl SpecializedRenderPipeline for SurfaceLayouts {
    type Key = SurfaceKey;

    fn specialize(&self, key: Self::Key) -> RenderPipelineDescriptor {
        match key {
            SurfaceKey::Nearest => RenderPipelineDescriptor {
                depth_stencil: depth_test(true),
                ..self.of_spheres("freshet:pipeline:surface_nearest", "nearest", DEPTH_FORMAT)
            },
            SurfaceKey::Thickness(samples) => {
                let add = BlendComponent {
                    src_factor: BlendFactor::One,
                    dst_factor: BlendFactor::One,
                    operation: BlendOperation::Add,
                };
                let sum = BlendState { color: add, alpha: add };
                let entry = "thickness";
                RenderPipelineDescriptor {
                    depth_stencil: depth_test(false),
                    multisample: MultisampleState { count: samples, ..default() },
                    fragment: Some(fragment(&self.spheres, Vec::new(), entry, THICKNESS_FORMAT, Some(sum))),
                    ..self.of_spheres("freshet:pipeline:surface_thickness", entry, THICKNESS_FORMAT)
                }
            }
            SurfaceKey::Smooth(direction) => {
                let defs = match direction {
                    Direction::Row => vec!["ALONG_ROWS".into()],
                    Direction::Column => Vec::new(),
                };
                self.of_screens("freshet:pipeline:surface_smooth", "smooth_depth", DEPTH_FORMAT, defs)
            }
            SurfaceKey::Light(key) => RenderPipelineDescriptor {
                depth_stencil: depth_test(true),
                multisample: MultisampleState { count: key.samples, ..default() },
                ..self.of_screens("freshet:pipeline:surface_light", "light_surface", key.format, key.shader_defs())
            },
        }
    }
}

pub(crate) fn queue_pipelines(
    mut commands: Commands,
    extracted: Res<ExtractedFluids>,
    views: Query<(Entity, ViewData), With<Camera3d>>,
    layouts: Res<SurfaceLayouts>,
    cache: Res<PipelineCache>,
    mut pipelines: ResMut<SpecializedRenderPipelines<SurfaceLayouts>>,
) {
    if extracted.0.iter().all(|fluid| !fluid.is_surface) {
        return;
    }
    for (entity, data) in &views {
        let key = ImpostorKey::of(data);
        let mut pipeline = |key| pipelines.specialize(&cache, &layouts, key);
        let pipelines = SurfacePipelines {
            nearest: pipeline(SurfaceKey::Nearest),
            thickness: pipeline(SurfaceKey::Thickness(key.samples)),
            smooth: [Direction::Row, Direction::Column].map(|direction| pipeline(SurfaceKey::Smooth(direction))),
            light: pipeline(SurfaceKey::Light(key)),
        };
        commands.entity(entity).insert(pipelines);
    }
}

pub(crate) fn prepare_bind_groups(
    mut commands: Commands,
    views: Query<(Entity, &SurfaceTextures)>,
    drawn: Res<DrawnFluids>,
    layouts: Res<SurfaceLayouts>,
    cache: Res<PipelineCache>,
    device: Res<RenderDevice>,
) {
    let Some(uniform) = drawn.uniforms.binding() else { return };
    let layout = cache.get_bind_group_layout(&layouts.screen);
    for (entity, textures) in &views {
        let groups = [0, 1].map(|depth: usize| {
            device.create_bind_group(
                "freshet:bind_group:surface",
                &layout,
                &BindGroupEntries::sequential((
                    uniform.clone(),
                    &textures.depths[depth].default_view,
                    &textures.thickness.default_view,
                    &textures.scene.default_view,
                    &layouts.sampler,
                )),
            )
        });
        commands.entity(entity).insert(SurfaceBindGroups(groups));
    }
}
