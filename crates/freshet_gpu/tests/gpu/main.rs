//! The shipped shaders on a real device, without features, with exactly WebGPU's default limits and bounds checks on.
//!
//! Without an adapter these tests fail and say what to install.

mod bodies;
mod commands;
mod common;
mod continuity;
mod determinism;
mod drawing;
mod forces;
mod incompressible;
mod incompressible_bodies;
mod integrators;
mod lowering;
#[path = "../../../freshet_cpu/tests/common/position_based.rs"]
mod moved;
mod pipelined;
#[path = "../../../freshet_cpu/tests/common/poisson.rs"]
mod poisson;
mod position_based;
mod quasi_fluid;
mod reconfigure;
mod redo;
mod reference;
mod rest;
mod rough;
mod sorting;
mod sticking;
mod swelling;
