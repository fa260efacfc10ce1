//! Opens a solver behind the one trait all commands are written against.

use freshet_core::plan::Plan;
use freshet_core::solver::FluidSolver;
use freshet_cpu::{CpuOptions, CpuSolver};
use freshet_gpu::{DeviceRequest, FluidDevice, GpuOptions, GpuSolver, open_device};

use crate::error::LabError;

/// Where a case runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Backend {
    /// `freshet_cpu`.
    Cpu,
    /// `freshet_gpu`, waiting for every tick.
    Gpu,
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
        self.open_with(plan, threads, false)
    }

    /// A solver that also says what each pass costs. On the GPU that makes the whole a little slower, and needs an adapter
    /// with time stamps; the CPU solver always does it.
    pub fn open_timed(self, plan: Plan, threads: Option<usize>) -> Result<Box<dyn FluidSolver>, LabError> {
        self.open_with(plan, threads, true)
    }

    fn open_with(self, plan: Plan, threads: Option<usize>, timed: bool) -> Result<Box<dyn FluidSolver>, LabError> {
        match self {
            Backend::Cpu => Ok(Box::new(CpuSolver::new(plan, CpuOptions { threads, ..CpuOptions::default() })?)),
            Backend::Gpu => {
                let FluidDevice { device, queue, .. } =
                    open_device(DeviceRequest { time_stamps: timed, large_buffers: true })?;
                let options = GpuOptions { time_stamps: timed, ..GpuOptions::default() };
                Ok(Box::new(GpuSolver::new(&device, &queue, plan, options)?))
            }
        }
    }
}

impl std::fmt::Display for Backend {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}
