//! Two-way coupling of Freshet's fluids with rapier bodies: shape sampling, impulses and their ledger on rapier's own
//! types. Bevy is not needed.
//!
//! Each tick, in this order (`COUPLING.md` beside the sources derives it):
//!
//! | | pipelined | lockstep |
//! |---|---|---|
//! | 1 | [`Coupling::receive`] the reports that have arrived | |
//! | 2 | [`Coupling::begin_tick`], its inputs go to the solver | the same; the solver waits for its report |
//! | 3 | | [`Coupling::receive`] this tick's report |
//! | 4 | [`Coupling::apply_forecast`] | the same: now the forecast is the true impulse |
//! | 5 | rapier steps | the same |
//! | 6 | [`Coupling::complete`] | the same |

mod body_coupling;
mod coupling;
mod error;
mod hold;
mod input;
mod kick;
mod ledger;
mod record;
mod sampling;
mod wake;
mod world;

pub use body_coupling::BodyCoupling;
pub use coupling::Coupling;
pub use error::CouplingError;
pub use ledger::{Ledger, Momentum};
pub use sampling::{SamplingError, body_from_rigid_body, quasi_fluid_from_rigid_body, sample_shape};
pub use wake::WakeRule;
pub use world::{RapierView, is_free};
