//! What can go wrong in the exchange.

use rapier3d::dynamics::RigidBodyHandle;

/// Why a call of the coupling was refused. Nothing has been changed then.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CouplingError {
    /// The rigid body has been removed from its set.
    #[error("rigid body {0:?} does not exist")]
    NoSuchBody(RigidBodyHandle),
    /// A tick was begun that is not the next one.
    #[error("tick {given} is not allowed; allowed: {expected}, the one after the last completed")]
    UnexpectedTick {
        /// The tick given.
        given: u64,
        /// The tick that is next.
        expected: u64,
    },
    /// An impulse arrived out of order, twice, or before its tick was begun.
    #[error("the impulse of tick {given} is not allowed; allowed: {expected}, ticks arrive in order and once")]
    UnexpectedImpulse {
        /// Its tick.
        given: u64,
        /// The tick whose impulse is next.
        expected: u64,
    },
    /// Too many impulses are under way; wait for the oldest.
    #[error("tick {tick} is {} ticks ahead of the last known impulse; allowed: {most}, wait for a report", tick - corrected_before)]
    TooFarAhead {
        /// The tick that was to begin.
        tick: u64,
        /// The first tick whose impulse is not known.
        corrected_before: u64,
        /// Most ticks whose impulse may be unknown.
        most: u64,
    },
    /// A call came in the wrong order.
    #[error("{call} is not allowed here; allowed: {allowed}")]
    OutOfOrder {
        /// The call.
        call: &'static str,
        /// The call that is due.
        allowed: &'static str,
    },
    /// A report is about another number of bodies.
    #[error("the report has {given} bodies; allowed: {expected}, those of the plan")]
    WrongCount {
        /// Bodies in the report.
        given: usize,
        /// Bodies coupled.
        expected: usize,
    },
    /// An impulse is infinite or not a number.
    #[error("the impulse of tick {tick} is not finite")]
    NotFinite {
        /// Its tick.
        tick: u64,
    },
    /// Rapier's time step is out of range.
    #[error("IntegrationParameters::dt: {0} is not allowed; allowed: more than 0 s, up to 1 s")]
    Duration(f32),
}
