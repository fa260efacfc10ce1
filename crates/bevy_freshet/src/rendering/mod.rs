//! Draws particles as shaded spheres, or as a surface, straight from the solver's buffers.
//!
//! [`appearance`] and [`gradient`] are for users. In the render world, each frame: `extract` notes what is to be drawn,
//! `buffers` finds or uploads the particles, `pipeline` makes the pipeline of each kind of view, `pass` draws after
//! Bevy's opaque meshes. `surface` makes one surface of the spheres instead, where that is asked for.

pub mod appearance;
mod buffers;
mod extract;
pub mod gradient;
mod pass;
mod pipeline;
mod ranges;
mod surface;
mod uniform;

use bevy::core_pipeline::core_3d::{main_opaque_pass_3d, main_transparent_pass_3d};
use bevy::core_pipeline::{Core3d, Core3dSystems};
use bevy::prelude::*;
use bevy::render::{ExtractSchedule, Render, RenderApp, RenderStartup, RenderSystems};
use bevy::shader::Shader;

use crate::components::domain::FluidDomain;
use appearance::FluidAppearance;

/// Draws the fluids of all 3D cameras.
pub struct FluidRenderPlugin;

/// There is a renderer: backends whose particles are not on the GPU keep copies to upload.
#[derive(Resource)]
pub(crate) struct FluidsAreDrawn;

impl Plugin for FluidRenderPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<FluidAppearance>().register_required_components::<FluidDomain, FluidAppearance>();
        if app.get_sub_app(RenderApp).is_none() {
            return; // A server, or no adapter: nothing to draw on.
        }
        app.insert_resource(FluidsAreDrawn);
        let mut shaders = app.world_mut().resource_mut::<Assets<Shader>>();
        let (shader, surface_shader) =
            (shaders.add(uniform::impostor_shader()), shaders.add(uniform::surface_shader()));
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else { return };
        render_app
            .insert_resource(pipeline::ImpostorShader(shader))
            .init_resource::<extract::ExtractedFluids>()
            .init_resource::<extract::ExtractedSun>()
            .init_resource::<buffers::DrawnFluids>()
            // Again after a lost device.
            .add_systems(RenderStartup, (pipeline::make_layouts, buffers::forget_all))
            .add_systems(ExtractSchedule, (extract::extract_fluids, extract::extract_sun))
            .add_systems(
                Render,
                (
                    pipeline::queue_pipelines.in_set(RenderSystems::Queue),
                    buffers::prepare_buffers.in_set(RenderSystems::PrepareResources),
                    (buffers::prepare_fluid_bind_groups, pipeline::prepare_view_bind_groups)
                        .in_set(RenderSystems::PrepareBindGroups),
                ),
            )
            .add_systems(
                Core3d,
                pass::draw_fluids
                    .in_set(Core3dSystems::MainPass)
                    // Spheres hide what is behind them and are hidden by what is before them: depth must be there.
                    .after(main_opaque_pass_3d)
                    // Glass is blended over the fluid.
                    .before(main_transparent_pass_3d),
            );
        surface::add_to(render_app, surface_shader);
    }
}
