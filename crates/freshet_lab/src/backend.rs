//! Opens a solver behind the one trait all commands are written against.

use freshet_core::plan::Plan;
use freshet_core::solver::FluidSolver;
use freshet_cpu::{CpuOptions, CpuSolver};
use freshet_gpu::{DeviceRequest, FluidDevice, GpuOptions, GpuSolver, open_device};

use crate::error::LabError;
use crate::measure::machine::processor_name;

/// Where a case runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Backend {
    /// `freshet_cpu`.
    Cpu,
    /// `freshet_gpu`, waiting for every tick.
    Gpu,
}

/// What a solver runs on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Hardware {
    /// As it calls itself.
    pub name: String,
    /// Whether it is the processor: the CPU solver's, or that of a GPU driver in software.
    pub is_processor: bool,
}

impl Backend {
    /// Name, as in files and tables.
    pub fn name(self) -> &'static str {
        match self {
            Backend::Cpu => "cpu",
            Backend::Gpu => "gpu",
        }
    }

    /// A solver for the plan; `threads` is for the CPU, none takes all cores.
    pub fn open(self, plan: Plan, threads: Option<usize>) -> Result<Box<dyn FluidSolver>, LabError> {
        self.open_with(plan, threads, false).map(|opened| opened.0)
    }

    /// A solver that also says what each pass costs, and what it runs on. On the GPU that makes the whole a little slower, and needs an adapter
    /// with time stamps; the CPU solver always does it.
    pub fn open_timed(self, plan: Plan, threads: Option<usize>) -> Result<(Box<dyn FluidSolver>, Hardware), LabError> {
        self.open_with(plan, threads, true)
    }

    /// Whether it runs on the processor: the CPU solver, or the GPU solver on a driver in software, which gets short forms only.
    pub fn is_processor(self) -> Result<bool, LabError> {
        Ok(match self {
            Backend::Cpu => true,
            Backend::Gpu => open_device(DeviceRequest::default())?.is_software(),
        })
    }

    fn open_with(
        self,
        plan: Plan,
        threads: Option<usize>,
        timed: bool,
    ) -> Result<(Box<dyn FluidSolver>, Hardware), LabError> {
        match self {
            Backend::Cpu => {
                let solver = CpuSolver::new(plan, CpuOptions { threads, ..CpuOptions::default() })?;
                Ok((Box::new(solver), Hardware { name: processor_name(), is_processor: true }))
            }
            Backend::Gpu => {
                let opened = open_device(DeviceRequest { time_stamps: timed, large_buffers: true })?;
                let is_processor = opened.is_software();
                let FluidDevice { device, queue, adapter } = opened;
                let options = GpuOptions { time_stamps: timed, ..GpuOptions::default() };
                let solver = GpuSolver::new(&device, &queue, plan, options)?;
                Ok((Box::new(solver), Hardware { name: adapter.name, is_processor }))
            }
        }
    }
}

impl std::fmt::Display for Backend {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}
