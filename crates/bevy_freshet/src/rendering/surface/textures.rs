//! What a view's surfaces are made in.

use bevy::camera::Camera3d;
use bevy::core_pipeline::core_3d::CORE_3D_DEPTH_FORMAT;
use bevy::image::ToExtents;
use bevy::prelude::*;
use bevy::render::camera::ExtractedCamera;
use bevy::render::render_resource::{TextureDescriptor, TextureDimension, TextureFormat, TextureUsages};
use bevy::render::renderer::RenderDevice;
use bevy::render::texture::{CachedTexture, TextureCache};
use bevy::render::view::ExtractedView;

use super::pipelines::SurfaceBindGroups;
use crate::rendering::buffers::DrawnFluids;

/// Depth of a point of the surface below the eye's plane, m; zero where there is none.
pub(crate) const DEPTH_FORMAT: TextureFormat = TextureFormat::R32Float;
/// Colour times thickness, and thickness, m.
pub(crate) const THICKNESS_FORMAT: TextureFormat = TextureFormat::Rgba16Float;

/// On a view, while a fluid is drawn as a surface.
#[derive(Component)]
pub(crate) struct SurfaceTextures {
    /// Filters read one and write the other.
    pub(crate) depths: [CachedTexture; 2],
    /// Which sphere is nearest.
    pub(crate) occlusion: CachedTexture,
    pub(crate) thickness: CachedTexture,
    /// The same, as many samples as the view has; none if that is one.
    pub(crate) sampled_thickness: Option<CachedTexture>,
    /// What is seen through the fluid.
    pub(crate) scene: CachedTexture,
}

pub(crate) fn prepare_textures(
    mut commands: Commands,
    drawn: Res<DrawnFluids>,
    mut cache: ResMut<TextureCache>,
    device: Res<RenderDevice>,
    views: Query<(Entity, &ExtractedCamera, &ExtractedView, &Msaa), With<Camera3d>>,
) {
    let is_needed = drawn.fluids.iter().any(|fluid| fluid.is_surface);
    for (entity, camera, view, msaa) in &views {
        let Some(size) = camera.physical_target_size.filter(|_| is_needed) else {
            commands.entity(entity).remove::<(SurfaceTextures, SurfaceBindGroups)>();
            continue;
        };
        let mut texture = |label, format, sample_count, usage| {
            let descriptor = TextureDescriptor {
                label: Some(label),
                size: size.to_extents(),
                mip_level_count: 1,
                sample_count,
                dimension: TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            };
            cache.get(&device, descriptor)
        };
        let drawn_to = TextureUsages::RENDER_ATTACHMENT;
        let both = drawn_to | TextureUsages::TEXTURE_BINDING;
        let copied_to = TextureUsages::COPY_DST | TextureUsages::TEXTURE_BINDING;
        let textures = SurfaceTextures {
            depths: ["freshet:texture:surface_depth_0", "freshet:texture:surface_depth_1"]
                .map(|label| texture(label, DEPTH_FORMAT, 1, both)),
            occlusion: texture("freshet:texture:surface_occlusion", CORE_3D_DEPTH_FORMAT, 1, drawn_to),
            thickness: texture("freshet:texture:surface_thickness", THICKNESS_FORMAT, 1, both),
            sampled_thickness: (msaa.samples() > 1).then(|| {
                texture("freshet:texture:surface_sampled_thickness", THICKNESS_FORMAT, msaa.samples(), drawn_to)
            }),
            scene: texture("freshet:texture:surface_scene", view.target_format, 1, copied_to),
        };
        commands.entity(entity).insert(textures);
    }
}
