//! Layouts, and one pipeline for each kind of view.

use bevy::camera::CompositingSpace;
use bevy::core_pipeline::core_3d::CORE_3D_DEPTH_FORMAT;
use bevy::core_pipeline::tonemapping::{
    DebandDither, Tonemapping, TonemappingLuts, get_lut_bind_group_layout_entries, get_lut_bindings,
};
use bevy::ecs::query::QueryItem;
use bevy::prelude::*;
use bevy::render::camera::ExtractedCamera;
use bevy::render::render_asset::RenderAssets;
use bevy::render::render_resource::binding_types::{storage_buffer_read_only_sized, uniform_buffer};
use bevy::render::render_resource::{
    BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries, CachedRenderPipelineId,
    ColorTargetState, ColorWrites, CompareFunction, DepthStencilState, FragmentState, MultisampleState, PipelineCache,
    PrimitiveState, PrimitiveTopology, RenderPipelineDescriptor, ShaderStages, SpecializedRenderPipeline,
    SpecializedRenderPipelines, TextureFormat, VertexState,
};
use bevy::render::renderer::RenderDevice;
use bevy::render::texture::{FallbackImage, GpuImage};
use bevy::render::view::{ExtractedView, ViewUniform, ViewUniforms};
use bevy::shader::{Shader, ShaderDefVal};

use super::uniform::FluidUniform;

/// The shader, made in the main world.
#[derive(Resource)]
pub(crate) struct ImpostorShader(pub(crate) Handle<Shader>);

/// Layouts of the two bind groups; specialises pipelines.
#[derive(Resource, Clone)]
pub(crate) struct ImpostorLayouts {
    pub(crate) view: BindGroupLayoutDescriptor,
    pub(crate) fluid: BindGroupLayoutDescriptor,
    shader: Handle<Shader>,
}

/// What differs between views.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(crate) struct ImpostorKey {
    pub(crate) format: TextureFormat,
    pub(crate) samples: u32,
    /// Without HDR, shaders map to the display themselves.
    tonemapping: Option<Tonemapping>,
    dither: bool,
    space: Option<&'static str>,
}

/// On a view: its pipeline.
#[derive(Component)]
pub(crate) struct ImpostorPipeline(pub(crate) CachedRenderPipelineId);

/// On a view: its bind group.
#[derive(Component)]
pub(crate) struct ImpostorViewBindGroup(pub(crate) BindGroup);

pub(crate) fn make_layouts(mut commands: Commands, shader: Res<ImpostorShader>) {
    let [lut_texture, lut_sampler] = get_lut_bind_group_layout_entries();
    let view = BindGroupLayoutDescriptor::new(
        "freshet:layout:impostor_view",
        &BindGroupLayoutEntries::sequential(
            ShaderStages::VERTEX_FRAGMENT,
            (
                uniform_buffer::<ViewUniform>(true),
                lut_texture.visibility(ShaderStages::FRAGMENT),
                lut_sampler.visibility(ShaderStages::FRAGMENT),
            ),
        ),
    );
    let values = || storage_buffer_read_only_sized(false, None).visibility(ShaderStages::VERTEX);
    let fluid = BindGroupLayoutDescriptor::new(
        "freshet:layout:impostor_fluid",
        &BindGroupLayoutEntries::sequential(
            ShaderStages::VERTEX_FRAGMENT,
            (uniform_buffer::<FluidUniform>(true), values(), values(), values()),
        ),
    );
    commands.insert_resource(ImpostorLayouts { view, fluid, shader: shader.0.clone() });
    commands.insert_resource(SpecializedRenderPipelines::<ImpostorLayouts>::default());
}

impl SpecializedRenderPipeline for ImpostorLayouts {
    type Key = ImpostorKey;

    fn specialize(&self, key: Self::Key) -> RenderPipelineDescriptor {
        let shader_defs = key.shader_defs();
        RenderPipelineDescriptor {
            label: Some("freshet:pipeline:impostor".into()),
            layout: vec![self.view.clone(), self.fluid.clone()],
            vertex: VertexState {
                shader: self.shader.clone(),
                shader_defs: shader_defs.clone(),
                entry_point: Some("vertex".into()),
                ..default()
            },
            primitive: PrimitiveState { topology: PrimitiveTopology::TriangleStrip, ..default() },
            depth_stencil: Some(DepthStencilState {
                format: CORE_3D_DEPTH_FORMAT,
                depth_write_enabled: Some(true),
                // Bevy's depth is reversed: near is 1.
                depth_compare: Some(CompareFunction::GreaterEqual),
                stencil: default(),
                bias: default(),
            }),
            multisample: MultisampleState { count: key.samples, ..default() },
            fragment: Some(FragmentState {
                shader: self.shader.clone(),
                shader_defs,
                entry_point: Some("fragment".into()),
                targets: vec![Some(ColorTargetState { format: key.format, blend: None, write_mask: ColorWrites::ALL })],
            }),
            ..default()
        }
    }
}

/// Name of a tone mapping in Bevy's shaders.
fn tonemapping_def(tonemapping: Tonemapping) -> &'static str {
    match tonemapping {
        Tonemapping::None => "TONEMAP_METHOD_NONE",
        Tonemapping::Reinhard => "TONEMAP_METHOD_REINHARD",
        Tonemapping::ReinhardLuminance => "TONEMAP_METHOD_REINHARD_LUMINANCE",
        Tonemapping::AcesFitted => "TONEMAP_METHOD_ACES_FITTED",
        Tonemapping::AgX => "TONEMAP_METHOD_AGX",
        Tonemapping::SomewhatBoringDisplayTransform => "TONEMAP_METHOD_SOMEWHAT_BORING_DISPLAY_TRANSFORM",
        Tonemapping::TonyMcMapface => "TONEMAP_METHOD_TONY_MC_MAPFACE",
        Tonemapping::BlenderFilmic => "TONEMAP_METHOD_BLENDER_FILMIC",
        Tonemapping::KhronosPbrNeutral => "TONEMAP_METHOD_PBR_NEUTRAL",
    }
}

impl ImpostorKey {
    /// What differs in this view.
    pub(crate) fn of((view, camera, msaa, tonemapping, dither): QueryItem<ViewData>) -> Self {
        Self {
            format: view.target_format,
            samples: msaa.samples(),
            tonemapping: tonemapping.copied().filter(|_| !camera.hdr),
            dither: matches!(dither, Some(DebandDither::Enabled)),
            space: match camera.compositing_space {
                Some(CompositingSpace::Srgb) => Some("SRGB_OUTPUT"),
                Some(CompositingSpace::Oklab) => Some("OKLAB_OUTPUT"),
                _ => None,
            },
        }
    }

    /// The same for shaders that write colours.
    pub(crate) fn shader_defs(&self) -> Vec<ShaderDefVal> {
        let mut shader_defs = Vec::new();
        if let Some(tonemapping) = self.tonemapping {
            shader_defs.extend(["TONEMAP_IN_SHADER".into(), tonemapping_def(tonemapping).into()]);
            shader_defs.push(ShaderDefVal::UInt("TONEMAPPING_LUT_TEXTURE_BINDING_INDEX".into(), 1));
            shader_defs.push(ShaderDefVal::UInt("TONEMAPPING_LUT_SAMPLER_BINDING_INDEX".into(), 2));
            if self.dither {
                shader_defs.push("DEBAND_DITHER".into());
            }
        }
        shader_defs.extend(self.space.map(ShaderDefVal::from));
        shader_defs
    }
}

/// What of a view decides its pipelines.
pub(crate) type ViewData = (
    &'static ExtractedView,
    &'static ExtractedCamera,
    &'static Msaa,
    Option<&'static Tonemapping>,
    Option<&'static DebandDither>,
);

pub(crate) fn queue_pipelines(
    mut commands: Commands,
    views: Query<(Entity, ViewData)>,
    layouts: Res<ImpostorLayouts>,
    cache: Res<PipelineCache>,
    mut pipelines: ResMut<SpecializedRenderPipelines<ImpostorLayouts>>,
) {
    for (entity, data) in &views {
        let pipeline = pipelines.specialize(&cache, &layouts, ImpostorKey::of(data));
        commands.entity(entity).insert(ImpostorPipeline(pipeline));
    }
}

pub(crate) fn prepare_view_bind_groups(
    mut commands: Commands,
    views: Query<(Entity, Option<&Tonemapping>), With<ImpostorPipeline>>,
    layouts: Res<ImpostorLayouts>,
    cache: Res<PipelineCache>,
    device: Res<RenderDevice>,
    uniforms: Res<ViewUniforms>,
    luts: Res<TonemappingLuts>,
    images: Res<RenderAssets<GpuImage>>,
    fallback: Res<FallbackImage>,
) {
    let Some(view) = uniforms.uniforms.binding() else { return };
    let layout = cache.get_bind_group_layout(&layouts.view);
    for (entity, tonemapping) in &views {
        let (texture, sampler) = get_lut_bindings(&images, &luts, tonemapping.unwrap_or(&Tonemapping::None), &fallback);
        let entries = BindGroupEntries::sequential((view.clone(), texture, sampler));
        let bind_group = device.create_bind_group("freshet:bind_group:impostor_view", &layout, &entries);
        commands.entity(entity).insert(ImpostorViewBindGroup(bind_group));
    }
}
