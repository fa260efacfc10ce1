//! Freshet's solver on CPU cores: every core, explicit SIMD chosen at run time, the same bits whatever the number of
//! threads.
//!
//! [`CpuSolver`] executes a [`Plan`](freshet_core::plan::Plan); each stage is a file in `passes`, with the formulas of
//! `docs/substep.md`.

mod candidates;
mod lanes;
mod near_walls;
mod neighbours;
mod packed;
mod particles;
mod passes;
mod samples;
mod schedule;
mod simd_kernel;
mod solver;
mod tasks;
mod workers;
mod workspace;

pub use solver::{CpuOptions, CpuSolver, InstructionSet, Iteration};
