//! Draws the surfaces, one fluid after the other.

use bevy::camera::{MainPassResolutionOverride, Viewport};
use bevy::color::LinearRgba;
use bevy::image::ToExtents;
use bevy::prelude::*;
use bevy::render::camera::ExtractedCamera;
use bevy::render::diagnostic::RecordDiagnostics;
use bevy::render::render_resource::{
    LoadOp, Operations, PipelineCache, RenderPassColorAttachment, RenderPassDepthStencilAttachment,
    RenderPassDescriptor, RenderPipeline, StoreOp, TextureView,
};
use bevy::render::renderer::{RenderContext, ViewQuery};
use bevy::render::view::{ViewDepthTexture, ViewTarget, ViewUniformOffset};

use super::pipelines::{SurfaceBindGroups, SurfacePipelines};
use super::textures::SurfaceTextures;
use crate::rendering::buffers::{DrawnFluid, DrawnFluids};
use crate::rendering::pipeline::ImpostorViewBindGroup;

/// How often the depth is smoothed along rows and columns.
const ROUNDS: usize = 2;

type View = (
    &'static ExtractedCamera,
    &'static ViewTarget,
    &'static ViewDepthTexture,
    &'static ViewUniformOffset,
    &'static ImpostorViewBindGroup,
    &'static SurfacePipelines,
    &'static SurfaceTextures,
    &'static SurfaceBindGroups,
    Option<&'static MainPassResolutionOverride>,
);

/// The pipelines, compiled.
struct Ready<'a> {
    nearest: &'a RenderPipeline,
    thickness: &'a RenderPipeline,
    smooth: [&'a RenderPipeline; 2],
    light: &'a RenderPipeline,
}

impl<'a> Ready<'a> {
    fn new(cache: &'a PipelineCache, pipelines: &SurfacePipelines) -> Option<Self> {
        let [row, column] = pipelines.smooth;
        Some(Self {
            nearest: cache.get_render_pipeline(pipelines.nearest)?,
            thickness: cache.get_render_pipeline(pipelines.thickness)?,
            smooth: [cache.get_render_pipeline(row)?, cache.get_render_pipeline(column)?],
            light: cache.get_render_pipeline(pipelines.light)?,
        })
    }
}

pub(crate) fn draw_surfaces(
    view: ViewQuery<View>,
    drawn: Res<DrawnFluids>,
    cache: Res<PipelineCache>,
    mut ctx: RenderContext,
) {
    let (camera, target, depth, view_offset, view_group, pipelines, textures, groups, resolution) = view.into_inner();
    let (Some(ready), Some(size)) = (Ready::new(&cache, pipelines), camera.physical_target_size) else { return };
    let viewport = Viewport::from_viewport_and_override(camera.viewport.as_ref(), resolution);
    let diagnostics = ctx.diagnostic_recorder();
    let diagnostics = diagnostics.as_deref();
    for fluid in drawn.fluids.iter().filter(|fluid| fluid.is_surface) {
        let Some(fluid_group) = &fluid.bind_group else { continue };
        // What is seen through it: all that has been drawn, the surfaces before it as well.
        ctx.command_encoder().copy_texture_to_texture(
            target.main_texture().as_image_copy(),
            textures.scene.texture.as_image_copy(),
            size.to_extents(),
        );
        let mut draw = |label: &'static str, stage: Stage, pipeline: &RenderPipeline, what: Drawn| {
            let color = [Some(stage.color)];
            let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
                label: Some(label),
                color_attachments: &color,
                depth_stencil_attachment: stage.depth,
                timestamp_writes: None,
                occlusion_query_set: None,
                multiview_mask: None,
            });
            let span = diagnostics.pass_span(&mut pass, stage.path);
            if let Some(viewport) = &viewport {
                pass.set_camera_viewport(viewport);
            }
            pass.set_render_pipeline(pipeline);
            pass.set_bind_group(0, &view_group.0, &[view_offset.offset]);
            match what {
                Drawn::Spheres(DrawnFluid { buffers, uniform_offset, .. }) => {
                    pass.set_bind_group(1, fluid_group, &[*uniform_offset]);
                    pass.draw_indirect(&buffers.arguments, buffers.arguments_offset);
                }
                Drawn::Screen(depth) => {
                    pass.set_bind_group(1, &groups.0[depth], &[fluid.uniform_offset]);
                    pass.draw(0..3, 0..1);
                }
            }
            span.end(&mut pass);
        };

        let occlusion = RenderPassDepthStencilAttachment {
            view: &textures.occlusion.default_view,
            depth_ops: Some(Operations { load: LoadOp::Clear(0.0), store: StoreOp::Discard }),
            stencil_ops: None,
        };
        let nearest = Stage {
            path: "freshet/surface_nearest",
            color: cleared(&textures.depths[0].default_view, None),
            depth: Some(occlusion),
        };
        draw("freshet:pass:surface_nearest", nearest, ready.nearest, Drawn::Spheres(fluid));

        let resolved = &textures.thickness.default_view;
        let color = match &textures.sampled_thickness {
            Some(sampled) => cleared(&sampled.default_view, Some(resolved)),
            None => cleared(resolved, None),
        };
        let thickness =
            Stage { path: "freshet/surface_thickness", color, depth: Some(depth.get_attachment(StoreOp::Store)) };
        draw("freshet:pass:surface_thickness", thickness, ready.thickness, Drawn::Spheres(fluid));

        for _ in 0..ROUNDS {
            for (from, pipeline) in ready.smooth.into_iter().enumerate() {
                let color = cleared(&textures.depths[1 - from].default_view, None);
                let smooth = Stage { path: "freshet/surface_smooth", color, depth: None };
                draw("freshet:pass:surface_smooth", smooth, pipeline, Drawn::Screen(from));
            }
        }

        let light = Stage {
            path: "freshet/surface_light",
            color: target.get_color_attachment(),
            depth: Some(depth.get_attachment(StoreOp::Store)),
        };
        draw("freshet:pass:surface_light", light, ready.light, Drawn::Screen(0));
    }
}

/// What a pass draws to.
struct Stage<'a> {
    path: &'static str,
    color: RenderPassColorAttachment<'a>,
    depth: Option<RenderPassDepthStencilAttachment<'a>>,
}

/// What a pass draws.
enum Drawn<'a> {
    Spheres(&'a DrawnFluid),
    /// The whole screen, from the depth of this number.
    Screen(usize),
}

fn cleared<'a>(view: &'a TextureView, resolve_target: Option<&'a TextureView>) -> RenderPassColorAttachment<'a> {
    RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: resolve_target.map(|view| &**view),
        ops: Operations { load: LoadOp::Clear(LinearRgba::NONE.into()), store: StoreOp::Store },
    }
}
