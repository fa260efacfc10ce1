//! Where ticks are executed. The rest of the plugin sees orders going in and outcomes coming out, in order.

pub(crate) mod cpu_worker;
pub mod frame;
pub(crate) mod gpu_engine;

use freshet_core::field::{Field, FieldData};
use freshet_core::plan::Plan;
use freshet_core::snapshot::Snapshot;
use freshet_core::solver::SolverError;
use freshet_core::step::{StepInput, StepReport};

use cpu_worker::CpuWorker;
use gpu_engine::GpuEngine;

/// Most ticks asked for and not known yet; with more the app waits. Solvers remember four ticks of a body's impulses.
pub(crate) const MOST_IN_FLIGHT: u64 = 3;

/// What an engine is told.
pub(crate) enum Order {
    /// Simulate a tick.
    Tick(StepInput),
    /// Continue with another plan.
    Reconfigure(Box<Plan>),
}

/// What an engine says: one for each tick, and one for each reconfiguration that failed.
#[derive(Debug)]
pub(crate) enum Outcome {
    /// A tick is done; the time it took, ms.
    Report(StepReport, f32),
    /// It cannot go on.
    Failed(SolverError),
}

/// Executes the ticks of one domain.
pub(crate) enum Engine {
    /// On a thread of its own, which uses all cores.
    Cpu(CpuWorker),
    /// On the GPU.
    Gpu(GpuEngine),
}

impl Engine {
    /// Adds an order behind those already given.
    pub(crate) fn send(&mut self, order: Order) {
        match self {
            Self::Cpu(worker) => worker.send(order),
            Self::Gpu(engine) => engine.send(order),
        }
    }

    /// What has become known; never waits.
    pub(crate) fn outcomes(&mut self) -> Vec<Outcome> {
        match self {
            Self::Cpu(worker) => worker.outcomes(),
            Self::Gpu(engine) => engine.outcomes(),
        }
    }

    /// Waits until at least one more tick is known, and returns what is known. Only with a tick in flight.
    pub(crate) fn wait(&mut self) -> Vec<Outcome> {
        match self {
            Self::Cpu(worker) => worker.wait(),
            Self::Gpu(engine) => engine.wait(),
        }
    }

    /// The state after all orders given so far; waits for it.
    pub(crate) fn snapshot(&mut self) -> Result<Snapshot, SolverError> {
        match self {
            Self::Cpu(worker) => worker.snapshot(),
            Self::Gpu(engine) => engine.snapshot(),
        }
    }

    /// Values of a field after all orders given so far, in the solver's order; waits for it.
    pub(crate) fn read(&mut self, field: Field) -> Result<FieldData, SolverError> {
        match self {
            Self::Cpu(worker) => worker.read(field),
            Self::Gpu(engine) => engine.read(field),
        }
    }
}
