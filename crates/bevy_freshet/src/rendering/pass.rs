//! Draws the spheres.

use bevy::camera::{MainPassResolutionOverride, Viewport};
use bevy::prelude::*;
use bevy::render::camera::ExtractedCamera;
use bevy::render::diagnostic::RecordDiagnostics;
use bevy::render::render_resource::{PipelineCache, RenderPassDescriptor, StoreOp};
use bevy::render::renderer::{RenderContext, ViewQuery};
use bevy::render::view::{ViewDepthTexture, ViewTarget, ViewUniformOffset};

use super::buffers::DrawnFluids;
use super::pipeline::{ImpostorPipeline, ImpostorViewBindGroup};

type View = (
    &'static ExtractedCamera,
    &'static ViewTarget,
    &'static ViewDepthTexture,
    &'static ViewUniformOffset,
    &'static ImpostorPipeline,
    &'static ImpostorViewBindGroup,
    Option<&'static MainPassResolutionOverride>,
);

pub(crate) fn draw_fluids(
    view: ViewQuery<View>,
    drawn: Res<DrawnFluids>,
    pipelines: Res<PipelineCache>,
    mut ctx: RenderContext,
) {
    let (camera, target, depth, view_offset, pipeline, view_bind_group, resolution) = view.into_inner();
    let Some(pipeline) = pipelines.get_render_pipeline(pipeline.0) else { return };
    if drawn.fluids.iter().all(|fluid| fluid.is_surface) {
        return;
    }
    let diagnostics = ctx.diagnostic_recorder();
    let diagnostics = diagnostics.as_deref();
    let color_attachments = [Some(target.get_color_attachment())];
    let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
        label: Some("freshet:pass:impostor"),
        color_attachments: &color_attachments,
        depth_stencil_attachment: Some(depth.get_attachment(StoreOp::Store)),
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    });
    let span = diagnostics.pass_span(&mut pass, "freshet/impostor");
    if let Some(viewport) = Viewport::from_viewport_and_override(camera.viewport.as_ref(), resolution) {
        pass.set_camera_viewport(&viewport);
    }
    pass.set_render_pipeline(pipeline);
    pass.set_bind_group(0, &view_bind_group.0, &[view_offset.offset]);
    for fluid in drawn.fluids.iter().filter(|fluid| !fluid.is_surface) {
        if let Some(bind_group) = &fluid.bind_group {
            pass.set_bind_group(1, bind_group, &[fluid.uniform_offset]);
            pass.draw_indirect(&fluid.buffers.arguments, fluid.buffers.arguments_offset);
        }
    }
    span.end(&mut pass);
}
