//! Chooses and starts what executes the ticks.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy::render::renderer::{RenderAdapterInfo, RenderDevice, RenderQueue};
use freshet_core::plan::Plan;
use freshet_core::snapshot::Snapshot;
use freshet_core::solver::SolverError;

use crate::components::domain::FluidBackend;
use crate::engine::Engine;
use crate::engine::cpu_worker::CpuWorker;
use crate::engine::gpu_engine::GpuEngine;
use crate::rendering::FluidsAreDrawn;

/// What the machine offers.
#[derive(SystemParam)]
pub(crate) struct Hardware<'w> {
    device: Option<Res<'w, RenderDevice>>,
    queue: Option<Res<'w, RenderQueue>>,
    adapter: Option<Res<'w, RenderAdapterInfo>>,
    drawn: Option<Res<'w, FluidsAreDrawn>>,
}

impl Hardware<'_> {
    /// Whether the machine offers something else than before.
    pub(crate) fn is_changed(&self) -> bool {
        self.device.as_ref().is_some_and(|device| device.is_changed())
            || self.adapter.as_ref().is_some_and(|adapter| adapter.is_changed())
    }

    /// What a wish comes to here: never [`FluidBackend::Auto`].
    pub(crate) fn choose(&self, wish: FluidBackend) -> FluidBackend {
        // A GPU imitated by the CPU is slower than the CPU solver.
        let is_hardware = self.adapter.as_ref().is_some_and(|info| info.device_type != wgpu::DeviceType::Cpu);
        match wish {
            FluidBackend::Auto if is_hardware && self.device.is_some() => FluidBackend::Gpu,
            FluidBackend::Auto => FluidBackend::Cpu,
            chosen => chosen,
        }
    }

    /// Starts an engine, from a snapshot if there is one.
    pub(crate) fn start(
        &self,
        backend: FluidBackend,
        plan: Plan,
        snapshot: Option<&Snapshot>,
    ) -> Result<Engine, SolverError> {
        if backend != FluidBackend::Gpu {
            return CpuWorker::start(plan, snapshot, self.drawn.is_some()).map(Engine::Cpu);
        }
        let (Some(device), Some(queue)) = (&self.device, &self.queue) else {
            return Err(SolverError::Unsupported {
                backend: "gpu",
                what: "an app without a render device".to_owned(),
                reason: "Bevy's RenderPlugin makes one, if it finds an adapter; otherwise use FluidBackend::Cpu"
                    .to_owned(),
            });
        };
        GpuEngine::start(device, queue, plan, snapshot).map(Engine::Gpu)
    }
}
