//! Encoding ticks: beginning, commands, substeps, the report's way back.

use freshet_core::plan::StageKind;
use freshet_core::solver::SolverError;

use crate::buffers::INPUT_STRIDE;
use crate::commands::group_grid;
use crate::errors::guarded;
use crate::layout::Binding;
use crate::passes::{Dispatch, position_iterations};
use crate::pipelines::Pipeline;
use crate::pool::fitting_capacity;
use crate::solver::{GpuSolver, PreparedTick, Spawning, TickMemo};

impl GpuSolver {
    /// Encodes all prepared ticks. Submit the encoder's commands, then call [`collect`](Self::collect).
    ///
    /// # Errors
    /// If memory cannot be had or the ring of reports is full.
    pub fn encode(&mut self, encoder: &mut wgpu::CommandEncoder) -> Result<(), SolverError> {
        while let Some(tick) = self.prepared.pop_front() {
            self.encode_tick(encoder, &tick)?;
            self.encode_close(encoder);
            self.encode_report(encoder, tick.about)?;
        }
        Ok(())
    }

    /// Encodes a tick but for its report, and for the end of solves that it leaves open.
    pub(crate) fn encode_tick(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        tick: &PreparedTick,
    ) -> Result<(), SolverError> {
        let bound = self.most_particles();
        self.spawning.push_back(Spawning { count: tick.about.spawned, left_out: tick.edits.left_out.clone() });
        self.emitted = self.emitted.into_iter().chain(tick.edits.emitted).reduce(f64::max);
        self.fit(encoder, bound.saturating_add(tick.about.spawned))?;
        self.encode_beginning(encoder, tick, bound)?;
        self.encode_substeps(encoder, tick.about.encoded, self.iterations_to_encode());
        Ok(())
    }

    /// Ends what solves are still open, so that the tick ends with a whole substep.
    pub(crate) fn encode_close(&self, encoder: &mut wgpu::CommandEncoder) {
        if self.compiled.close.is_empty() {
            return;
        }
        let groups = &self.groups[self.compiled.begin.len() + self.compiled.substep.len()..];
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("freshet:pass:close"),
            timestamp_writes: None,
        });
        for (pipeline, group) in self.compiled.close.iter().zip(groups) {
            self.dispatch_stage(&mut pass, pipeline, group);
        }
    }

    /// No fewer particles than there can be, from the last report and what was spawned since.
    fn most_particles(&self) -> u32 {
        let spawned = self.spawning.iter().fold(0u32, |sum, tick| sum.saturating_add(tick.count));
        self.known.particles.saturating_add(spawned).min(self.plan.max_particles)
    }

    /// Grows or shrinks the buffers for up to `bound` particles.
    fn fit(&mut self, encoder: &mut wgpu::CommandEncoder, bound: u32) -> Result<(), SolverError> {
        let capacity = fitting_capacity(self.buffers.capacity, bound, self.plan.max_particles);
        if capacity != self.buffers.capacity {
            self.buffers.resize(&self.device, encoder, &self.plan, capacity)?;
            self.rebind()?;
        }
        Ok(())
    }

    fn encode_beginning(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        tick: &PreparedTick,
        bound: u32,
    ) -> Result<(), SolverError> {
        let most = self.plan.max_particles;
        let edits = self.compiled.commands.dispatches(&self.device, &self.buffers, &tick.edits, most, bound)?;
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("freshet:pass:begin_tick"),
            timestamp_writes: None,
        });
        let input = [tick.slot * INPUT_STRIDE as u32];
        let body_groups = (self.plan.bodies.len() as u32).div_ceil(self.options.workgroup_size);
        for (pipeline, group) in self.compiled.begin.iter().zip(&self.groups) {
            let groups = if pipeline.pass.dispatch == Dispatch::Single { (1, 1) } else { group_grid(body_groups) };
            dispatch(&mut pass, pipeline, group, &input, Groups::Direct(groups.0, groups.1));
        }
        for edit in &edits {
            dispatch(&mut pass, edit.pipeline, &edit.group, &[], Groups::Direct(edit.groups.0, edit.groups.1));
        }
        Ok(())
    }

    /// Encodes `count` substeps, each with so many iterations of its two solves; those that the tick does not need dispatch nothing.
    pub(crate) fn encode_substeps(&self, encoder: &mut wgpu::CommandEncoder, count: u32, iterations: [u32; 2]) {
        let groups = &self.groups[self.compiled.begin.len()..];
        let pipelines: Vec<_> = self.compiled.substep.iter().zip(groups).collect();
        let entries = || pipelines.chunk_by(|(one, _), (next, _)| one.pass.iterates_with(&next.pass));
        let times = |entry: &[(&Pipeline, &wgpu::BindGroup)]| match entry {
            [(first, _), ..] if first.pass.iterates => match first.pass.stage {
                Some(StageKind::PositionSolve) => position_iterations(&self.plan),
                Some(StageKind::DensitySolve) => iterations[1],
                _ => iterations[0],
            },
            _ => 1,
        };
        let Some(timer) = &self.timer else {
            if count > 0 {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                    label: Some("freshet:pass:substeps"),
                    timestamp_writes: None,
                });
                for entry in (0..count).flat_map(|_| entries()) {
                    for (pipeline, group) in (0..times(entry)).flat_map(|_| entry) {
                        self.dispatch_stage(&mut pass, pipeline, group);
                    }
                }
            }
            return;
        };
        for substep in 0..count {
            for (index, entry) in entries().enumerate() {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                    label: entry.first().map(|(pipeline, _)| pipeline.label.as_str()),
                    timestamp_writes: timer.writes(substep, index),
                });
                for (pipeline, group) in (0..times(entry)).flat_map(|_| entry) {
                    self.dispatch_stage(&mut pass, pipeline, group);
                }
            }
        }
    }

    /// Dispatches a pass of a substep with as many groups as it has by now.
    fn dispatch_stage(&self, pass: &mut wgpu::ComputePass<'_>, pipeline: &Pipeline, group: &wgpu::BindGroup) {
        let Some(arguments) = self.buffers.get(Binding::Arguments) else { return };
        let groups = match pipeline.pass.dispatch {
            Dispatch::Indirect(which) => Groups::Indirect(arguments, which.offset()),
            Dispatch::Single | Dispatch::Direct => Groups::Direct(1, 1),
        };
        dispatch(pass, pipeline, group, &[], groups);
    }

    /// Encodes the way back of what the GPU has to say.
    pub(crate) fn encode_report(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        about: TickMemo,
    ) -> Result<(), SolverError> {
        let mut sources: Vec<&wgpu::Buffer> = Vec::new();
        sources.extend(self.buffers.get(Binding::Control));
        sources.extend(self.buffers.get(Binding::Bodies));
        if let Some(timer) = &self.timer {
            timer.resolve(encoder, about.encoded);
            sources.push(timer.buffer());
        }
        self.readback.copy(encoder, &sources, about)
    }

    /// Submits an encoder filled by `fill`, with errors caught.
    pub(crate) fn submit(
        &mut self,
        fill: impl FnOnce(&mut Self, &mut wgpu::CommandEncoder) -> Result<(), SolverError>,
    ) -> Result<(), SolverError> {
        let device = self.device.clone();
        guarded(&device, "executing a tick", || {
            let mut encoder = device
                .create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("freshet:encoder:lockstep") });
            fill(self, &mut encoder)?;
            self.queue.submit([encoder.finish()]);
            Ok(())
        })?
    }
}

/// How many groups a dispatch has.
enum Groups<'a> {
    Direct(u32, u32),
    Indirect(&'a wgpu::Buffer, u64),
}

fn dispatch(
    pass: &mut wgpu::ComputePass<'_>,
    pipeline: &Pipeline,
    group: &wgpu::BindGroup,
    offsets: &[u32],
    groups: Groups<'_>,
) {
    // Only what has a ring takes an offset.
    let ring = pipeline.pass.uses.iter().any(|&(binding, _)| binding == Binding::Input);
    pass.push_debug_group(&pipeline.label);
    pass.set_pipeline(&pipeline.pipeline);
    pass.set_bind_group(0, group, if ring { offsets } else { &[] });
    match groups {
        Groups::Direct(x, y) => pass.dispatch_workgroups(x, y, 1),
        Groups::Indirect(buffer, offset) => pass.dispatch_workgroups_indirect(buffer, offset),
    }
    pass.pop_debug_group();
}
