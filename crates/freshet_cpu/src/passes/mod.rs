//! The stages of a substep, and the commands before a tick's first, one file each, named as in the plan and as their WGSL
//! twins.

pub mod acceleration;
pub mod body_contact;
pub mod body_density;
pub mod body_drag;
pub mod body_friction;
pub mod body_load;
pub mod body_motion;
pub mod body_sort;
pub mod body_touch;
pub mod commands;
pub mod continuity;
pub mod density;
pub mod friction;
pub mod integrate;
pub mod morris1997;
pub mod position_solve;
pub mod projection;
pub mod sort;
pub mod step_control;
pub mod support;
pub mod viscosity;
pub mod wall_collision;
pub mod wall_density;
pub mod wall_force;
pub mod xsph;
