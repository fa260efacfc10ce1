//! Measures of what solvers produce: plain functions of plain numbers, the same for every run and every peer.

pub mod column;
pub mod compression;
pub mod containment;
pub mod crowding;
pub mod curve;
pub mod density_rates;
pub mod front;
pub mod machine;
pub mod oscillation;
pub mod reference_error;
pub mod spacing;
pub mod spectral_radius;
pub mod statistics;
pub mod wall_height;
