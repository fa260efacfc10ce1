//! Drives GPU solvers inside Bevy's render graph: ticks are encoded before the cameras draw, in the same submit, and
//! reports are taken after it. Nothing waits; what arrives late is corrected by the coupling.

use bevy::core_pipeline::schedule::camera_driver;
use bevy::prelude::*;
use bevy::render::renderer::{RenderContext, RenderDevice, RenderGraph, RenderGraphSystems, RenderQueue};
use bevy::render::{Extract, ExtractSchedule, RenderApp};

use crate::engine::Engine;
use crate::engine::gpu_engine::SharedGpu;
use crate::simulation::state::DomainState;

/// Part of [`FluidSimulationPlugin`](crate::simulation::FluidSimulationPlugin); does nothing without a renderer.
pub(crate) struct GpuDriverPlugin;

/// Solvers of all domains.
#[derive(Resource, Default)]
struct DrivenSolvers(Vec<SharedGpu>);

impl Plugin for GpuDriverPlugin {
    fn build(&self, app: &mut App) {
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else { return };
        render_app.init_resource::<DrivenSolvers>().add_systems(ExtractSchedule, extract_solvers).add_systems(
            RenderGraph,
            (
                // The cameras of this frame draw the particles of these ticks; within the set, so that Bevy's submit takes
                // the commands along.
                encode_ticks.in_set(RenderGraphSystems::Render).before(camera_driver),
                // Finish comes after the submit, so results can arrive.
                collect_reports.in_set(RenderGraphSystems::Finish),
            ),
        );
    }
}

fn extract_solvers(mut driven: ResMut<DrivenSolvers>, domains: Extract<Query<(Entity, &DomainState)>>) {
    let mut solvers: Vec<_> = domains
        .iter()
        .filter_map(|(entity, state)| match &state.engine {
            Some(Engine::Gpu(engine)) => Some((entity, engine.shared())),
            _ => None,
        })
        .collect();
    // The same order of work in every frame.
    solvers.sort_by_key(|(entity, _)| entity.index_u32());
    driven.0.clear();
    driven.0.extend(solvers.into_iter().map(|(_, solver)| solver));
}

fn encode_ticks(driven: Res<DrivenSolvers>, queue: Res<RenderQueue>, mut ctx: RenderContext) {
    let device = ctx.render_device().clone();
    for solver in &driven.0 {
        solver.encode(ctx.command_encoder(), &device, &queue);
    }
}

fn collect_reports(driven: Res<DrivenSolvers>, device: Res<RenderDevice>) {
    for solver in &driven.0 {
        solver.collect(&device);
    }
}
