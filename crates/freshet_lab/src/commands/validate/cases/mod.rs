//! The cases, one file each; those that are commands of their own are in [`commands`].

pub mod added_mass;
pub mod calm;
mod channel;
pub mod commands;
pub mod couette;
pub mod crates;
pub mod deep_column;
pub mod density_drift;
pub mod draft;
pub mod free_flight;
pub mod gate;
pub mod heave;
pub mod hydrostatic;
pub mod light_and_heavy;
pub mod pinned;
pub mod poiseuille;
pub mod pool_drop;
pub mod position_based;
pub mod pressure_corrected;
pub mod relaxing_cube;
pub mod righting;
pub mod spin;
pub mod splash;
pub mod stacked;
pub mod taylor_green;
pub mod walls;
pub mod wet;
