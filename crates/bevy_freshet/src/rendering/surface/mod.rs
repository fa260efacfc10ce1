//! Draws a fluid as one surface, in screen space: the nearest spheres' depth, smoothed; how much fluid lies behind it; then light.
//!
//! After van der Laan, Green & Sainz 2009, "Screen space fluid rendering with curvature flow": depth and thickness of spheres, a
//! smoothed depth, normals from it. Smoothing is a narrow-range filter along rows and columns (Truong & Yuksel 2018): what is far in
//! front of a point or behind it does not count. `textures` holds what a view needs, `pipelines` makes its pipelines and bindings,
//! `pass` draws. The shaders are `impostor.wgsl` (spheres) and `surface.wgsl` (whole screens).

mod pass;
mod pipelines;
mod textures;

use bevy::core_pipeline::core_3d::main_transparent_pass_3d;
use bevy::core_pipeline::{Core3d, Core3dSystems};
use bevy::prelude::*;
use bevy::render::{Render, RenderStartup, RenderSystems};
use bevy::shader::Shader;

use super::{pass as impostors, pipeline};

/// The shader of whole screens, made in the main world.
#[derive(Resource)]
pub(crate) struct SurfaceShader(pub(crate) Handle<Shader>);

/// Adds what draws surfaces to the render world.
pub(crate) fn add_to(render_app: &mut SubApp, shader: Handle<Shader>) {
    render_app
        .insert_resource(SurfaceShader(shader))
        .add_systems(RenderStartup, pipelines::make_layouts.after(pipeline::make_layouts))
        .add_systems(
            Render,
            (
                pipelines::queue_pipelines.in_set(RenderSystems::Queue),
                // After it is known which fluids are drawn how.
                textures::prepare_textures
                    .in_set(RenderSystems::PrepareResources)
                    .after(super::buffers::prepare_buffers),
                pipelines::prepare_bind_groups
                    .in_set(RenderSystems::PrepareBindGroups)
                    .after(super::buffers::prepare_fluid_bind_groups),
            ),
        )
        .add_systems(
            Core3d,
            pass::draw_surfaces
                .in_set(Core3dSystems::MainPass)
                // Spheres of other fluids are seen through a surface, as meshes are.
                .after(impostors::draw_fluids)
                // Glass is blended over the fluid.
                .before(main_transparent_pass_3d),
        );
}
