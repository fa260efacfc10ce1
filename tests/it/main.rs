//! What crosses crates: headless apps on both backends and in both modes, pictures, the example's command line.

mod bodies;
mod components;
mod emitters;
mod example;
mod games;
mod golden;
mod harness;
mod lost_device;
mod meshes;
mod moving_walls;
mod order;
mod problems;
