//! What every solver can do, whatever it runs on.

use crate::error::InvalidInput;
use crate::field::{Field, FieldData};
use crate::plan::{Parameters, Plan, StageKind};
use crate::snapshot::{Snapshot, SnapshotError};
use crate::step::{StepInput, StepReport};
use crate::work::{Work, neighbours};

/// A solver that executes a [`Plan`] tick by tick and waits for each.
///
/// The GPU solver can also be driven without waiting; that is its own interface.
pub trait FluidSolver {
    /// The plan being executed.
    fn plan(&self) -> &Plan;

    /// What the plan was lowered to: passes, buffers, bytes.
    fn schedule(&self) -> &Schedule;

    /// Covers the input's duration and returns when it is done.
    ///
    /// Numbers of ticks are the caller's: see [`StepInput::tick`] for what gaps and repetitions do. An input that is refused
    /// changes nothing.
    fn step(&mut self, input: &StepInput) -> Result<StepReport, SolverError>;

    /// Values of a field for all live particles, in the solver's order.
    fn read(&mut self, field: Field) -> Result<FieldData, SolverError>;

    /// The whole state.
    fn snapshot(&mut self) -> Result<Snapshot, SolverError>;

    /// Returns to a state; one of more particles than the plan's `max_particles` is refused.
    fn restore(&mut self, snapshot: &Snapshot) -> Result<(), SolverError>;

    /// Continues with another plan; particles, time and gravity stay as they are. A plan for fewer particles than there are
    /// is refused.
    fn reconfigure(&mut self, plan: Plan) -> Result<(), SolverError>;
}

/// Why a solver could not do what it was asked.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SolverError {
    /// A number in the input is not allowed.
    #[error(transparent)]
    Invalid(#[from] InvalidInput),
    /// A snapshot cannot be used.
    #[error(transparent)]
    Snapshot(#[from] SnapshotError),
    /// The plan asks for something this backend does not have.
    #[error("the {backend} backend cannot do {what}: {reason}")]
    Unsupported {
        /// `cpu` or `gpu`.
        backend: &'static str,
        /// The method or setting.
        what: String,
        /// Why, and what to use instead.
        reason: String,
    },
    /// The plan does not write this field.
    #[error("the plan has no field {0}")]
    NoSuchField(&'static str),
    /// The device is too weak; names the limit.
    #[error("the adapter {adapter} offers {limit} = {offered}, Freshet needs {needed}")]
    WeakAdapter {
        /// Name of the adapter.
        adapter: String,
        /// Name of the limit or feature.
        limit: String,
        /// What it offers.
        offered: u64,
        /// What is needed.
        needed: u64,
    },
    /// The device ran out of memory, was lost, or refused a command.
    #[error("the device failed: {0}")]
    Device(String),
}

/// A plan lowered to what one backend executes.
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule {
    /// `cpu` or `gpu`.
    pub backend: &'static str,
    /// Passes of one substep, in order.
    pub passes: Vec<ScheduledPass>,
    /// The memory that the solver holds from one tick to the next, apart from the plan itself. Left out is what comes and goes
    /// within a tick: on a GPU the uploads of its commands and the staging of downloads.
    pub buffers: Vec<ScheduledBuffer>,
    /// Particles the buffers have room for.
    pub capacity: u32,
}

impl Schedule {
    /// Bytes of all buffers together.
    pub fn bytes(&self) -> u64 {
        self.buffers.iter().map(|buffer| buffer.bytes).sum()
    }

    /// Bytes of the buffers that grow with the number of particles (their grid included), per particle of capacity.
    pub fn bytes_per_particle(&self) -> f64 {
        let bytes: u64 = self.buffers.iter().filter(|buffer| buffer.per_particle).map(|buffer| buffer.bytes).sum();
        bytes as f64 / f64::from(self.capacity.max(1))
    }

    /// Bytes that a substep reads and writes per particle, each neighbour's once.
    pub fn moved_bytes_per_particle(&self) -> f64 {
        self.passes.iter().map(|pass| f64::from(pass.bytes_per_particle)).sum()
    }

    /// Floating-point operations of a substep per particle with the neighbours it has at rest, see [`work`](crate::work).
    pub fn operations_per_particle(&self, parameters: &Parameters) -> f64 {
        let neighbours = neighbours(parameters);
        let of = |stage| Work::of(stage, parameters).with(neighbours);
        self.passes.chunk_by(|a, b| a.stage == b.stage).map(|passes| of(passes[0].stage)).sum()
    }
}

/// One pass of a substep.
#[derive(Clone, Debug, PartialEq)]
pub struct ScheduledPass {
    /// The stage it belongs to.
    pub stage: StageKind,
    /// Name, unique in the schedule.
    pub name: &'static str,
    /// Bytes read and written per particle, neighbours counted once.
    pub bytes_per_particle: u32,
}

/// One piece of memory.
#[derive(Clone, Debug, PartialEq)]
pub struct ScheduledBuffer {
    /// Name, unique in the schedule.
    pub name: &'static str,
    /// Size.
    pub bytes: u64,
    /// Whether it grows with the number of particles (the particles' grid included).
    pub per_particle: bool,
}

impl std::fmt::Display for Schedule {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "schedule of the {} backend, room for {} particles", self.backend, self.capacity)?;
        for pass in &self.passes {
            writeln!(f, "  pass   {:<20} {:>6} B/particle", pass.name, pass.bytes_per_particle)?;
        }
        for buffer in &self.buffers {
            writeln!(f, "  buffer {:<20} {:>12} B", buffer.name, buffer.bytes)?;
        }
        write!(f, "  {:.0} B a particle with its grid, {} B in all", self.bytes_per_particle(), self.bytes())
    }
}
