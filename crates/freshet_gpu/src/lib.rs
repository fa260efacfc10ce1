//! Freshet's solver on a GPU, for any wgpu device.
//!
//! [`GpuSolver`] executes a [`Plan`](freshet_core::plan::Plan). It is driven in one of two ways:
//! - pipelined: [`prepare`](GpuSolver::prepare), [`encode`](GpuSolver::encode) into any command encoder, submit,
//!   [`collect`](GpuSolver::collect); the CPU never waits while at most [`TICKS_IN_FLIGHT`] ticks are under way, and
//!   reports come late;
//! - in lockstep: [`FluidSolver::step`](freshet_core::solver::FluidSolver::step) encodes, submits and waits.
//!
//! Particles never leave the GPU to be drawn: [`GpuSolver::buffers`] gives the buffers and their layout.
//! [`open_device`] opens a device for programs that have none.

mod buffers;
mod cells;
mod commands;
mod compiled;
mod device;
mod encode;
mod errors;
mod fine_grid;
pub mod layout;
mod lockstep;
mod memory;
mod options;
mod parameters;
mod passes;
mod pipelines;
mod pool;
mod prediction;
mod readback;
mod report;
mod shader;
mod sharing;
mod solver;
mod state;
mod timing;

pub use device::{DeviceRequest, FluidDevice, open_device};
pub use options::{GpuOptions, NeighbourMemory};
pub use readback::TICKS_IN_FLIGHT;
pub use shader::check;
pub use sharing::FluidBuffers;
pub use solver::GpuSolver;
pub use timing::MEASURED_SUBSTEPS;
