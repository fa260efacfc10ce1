//! The compiled passes of a plan, which outlive it where another plan needs the same.

use freshet_core::plan::Plan;
use freshet_core::solver::SolverError;

use crate::commands::CommandPipelines;
use crate::options::GpuOptions;
use crate::passes::{Pass, begin_bodies, begin_tick, substep_passes};
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
        let substep = substep.into_iter().map(compile).collect::<Result<Vec<_>, _>>()?;
        let begin = begin.into_iter().map(compile).collect::<Result<Vec<_>, _>>()?;
        let commands = CommandPipelines::new(options.workgroup_size, compile)?;
        Ok(Self { definitions, options, begin, substep, commands })
    }

    /// What was selected in the shaders.
    pub fn definitions(&self) -> &Definitions {
        &self.definitions
    }
}

fn is_made_from(pipelines: &[Pipeline], passes: &[Pass]) -> bool {
    pipelines.iter().map(|pipeline| &pipeline.pass).eq(passes)
}
