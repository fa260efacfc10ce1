//! The compiled passes of a plan, which outlive it where another plan needs the same.

use freshet_core::plan::Plan;
use freshet_core::solver::{ScheduledPass, SolverError};

use crate::commands::CommandPipelines;
use crate::options::GpuOptions;
use crate::passes::{Pass, begin_bodies, begin_tick, closing_passes, scheduled, substep_passes};
use crate::pipelines::Pipeline;
use crate::shader::{Definitions, compose, definitions, sources};

/// All pipelines of a solver; clones share them.
#[derive(Clone, Debug)]
pub(crate) struct Compiled {
    definitions: Definitions,
    options: GpuOptions,
    /// Run at the start of a tick.
    pub begin: Vec<Pipeline>,
    /// Run in a substep, in order.
    pub substep: Vec<Pipeline>,
    /// Run at the end of a tick that nobody waits for: they end the solves that are still open. None where nothing is solved for.
    pub close: Vec<Pipeline>,
    /// Carry out a tick's commands.
    pub commands: CommandPipelines,
}

impl Compiled {
    /// Compiles what a plan needs, or takes it from `earlier` if that was made from the same passes, definitions and options:
    /// a plan's numbers, walls and bodies are in buffers, and pipelines know nothing of them.
    pub fn new(
        device: &wgpu::Device,
        plan: &Plan,
        options: GpuOptions,
        earlier: Option<&Self>,
    ) -> Result<Self, SolverError> {
        let definitions = definitions(plan, &options)?;
        let substep = substep_passes(plan);
        let mut begin = vec![begin_tick()];
        if !plan.bodies.is_empty() {
            begin.push(begin_bodies());
        }
        if let Some(earlier) = earlier
            && earlier.options == options
            && earlier.definitions == definitions
            && is_made_from(&earlier.begin, &begin)
            && is_made_from(&earlier.substep, &substep)
        {
            return Ok(earlier.clone());
        }
        let passes = substep.iter().chain(&begin);
        if let Some((from, _)) = options.patch
            && !passes.flat_map(|pass| sources(pass, &options)).any(|(_, source)| source.contains(from))
        {
            return Err(SolverError::Device(format!("the patched WGSL is in no pass: {from}")));
        }
        let compile = |pass| Pipeline::new(device, compose(&pass, &definitions, &options)?, pass, &options);
        let mut compiled: Vec<Pipeline> = Vec::new();
        for pass in substep {
            // Both solves have the same iterations.
            let pipeline = match compiled.iter().find(|earlier| earlier.pass.name == pass.name) {
                Some(earlier) => earlier.clone().with_pass(pass),
                None => compile(pass)?,
            };
            compiled.push(pipeline);
        }
        let begin = begin.into_iter().map(compile).collect::<Result<Vec<_>, _>>()?;
        let close = |pass: Pass| match compiled.iter().find(|earlier| earlier.pass.name == pass.name) {
            Some(earlier) => Ok(earlier.clone()),
            None => compile(pass),
        };
        let close = closing_passes(plan).into_iter().map(close).collect::<Result<Vec<_>, _>>()?;
        let commands = CommandPipelines::new(plan, options.workgroup_size, compile)?;
        Ok(Self { definitions, options, begin, substep: compiled, close, commands })
    }

    /// All that have bind groups of their own: of the beginning, of a substep, of the end.
    pub fn in_order(&self) -> impl Iterator<Item = &Pipeline> {
        self.begin.iter().chain(&self.substep).chain(&self.close)
    }

    /// The entries of the schedule, in order: passes of a substep, those of an iteration as one.
    pub fn entries(&self) -> impl Iterator<Item = ScheduledPass> {
        let chunks = self.substep.chunk_by(|one, next| one.pass.iterates_with(&next.pass));
        chunks.filter_map(|entry| scheduled(&entry.iter().map(|pipeline| &pipeline.pass).collect::<Vec<_>>()))
    }

    /// What was selected in the shaders.
    pub fn definitions(&self) -> &Definitions {
        &self.definitions
    }
}

fn is_made_from(pipelines: &[Pipeline], passes: &[Pass]) -> bool {
    pipelines.iter().map(|pipeline| &pipeline.pass).eq(passes)
}
