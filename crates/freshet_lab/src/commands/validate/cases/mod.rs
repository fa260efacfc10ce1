//! The cases, one file each; those that are commands of their own are in [`commands`].

pub mod added_mass;
pub mod calm;
mod channel;
pub mod commands;
pub mod couette;
pub mod deep_column;
pub mod draft;
pub mod free_flight;
pub mod gate;
pub mod heave;
pub mod hydrostatic;
pub mod light_and_heavy;
pub mod poiseuille;
pub mod pool_drop;
pub mod relaxing_cube;
pub mod spin;
pub mod taylor_green;
