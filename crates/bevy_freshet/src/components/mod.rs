//! What a user spawns and reads. SI units throughout; lengths are metres of the world.

pub mod body;
pub mod boundary;
pub mod boundary_mesh;
pub mod contact;
pub mod container;
pub mod domain;
pub mod emitter;
pub mod layers;
pub mod material;
pub mod membership;
pub mod problem;
pub mod readback;
pub mod scene;
pub mod settings;
pub mod stats;
pub mod volume;
pub mod wall;
pub mod wall_method;
