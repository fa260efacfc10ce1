//! One body's side of forecast-and-correct (ARCHITECTURE, decision 4; derived in the crate's `COUPLING.md`).

use freshet_core::step::{BodyInput, Impulse};
use glam::{Mat3, Vec3};
use rapier3d::dynamics::{RigidBodyHandle, RigidBodySet};

use crate::error::CouplingError;
use crate::hold::Hold;
use crate::input::{acceleration, body_input, overshoot};
use crate::kick::{displace, kick};
use crate::ledger::Ledger;
use crate::record::{InFlight, Record};
use crate::wake::{Habit, WakeRule};
use crate::world::{RapierView, is_anchored, is_free};

/// The call that is due.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    /// `begin_tick`.
    Begin,
    /// `apply_forecast`, of this impulse.
    Apply(Impulse),
    /// `complete`, by this impulse.
    Complete(Impulse),
}

/// The exchange of momentum between a fluid and one rapier body.
///
/// [`Coupling`](crate::Coupling) drives several; the calls are the same.
#[derive(Clone, Debug)]
pub struct BodyCoupling {
    handle: RigidBodyHandle,
    /// When the fluid wakes the body.
    pub wake: WakeRule,
    phase: Phase,
    /// The tick that is under way, or else the next.
    tick: u64,
    in_flight: InFlight,
    /// The latest known impulse and the duration of its tick.
    latest: Option<(Impulse, f32)>,
    /// Whether the tick under way, or else the last, began without contact or joint.
    free: bool,
    /// Whether it began in contact or joined with what no impulse moves.
    is_anchored: bool,
    /// Impulse taken from the body before rapier's step and given back after it, so that the step covers the distance
    /// of a steady acceleration.
    overshoot: Impulse,
    /// The body at the end of the last tick, and what has pushed it since.
    hold: Hold,
    /// Whether contacts and joints held it in its motion in the last step.
    is_held: bool,
    habit: Habit,
    ledger: Ledger,
}

impl BodyCoupling {
    /// Most ticks whose impulse may be unknown when another begins.
    pub const MOST_IN_FLIGHT: u64 = 3;

    /// Begins the exchange at `first_tick`, with nothing in flight.
    pub fn new(handle: RigidBodyHandle, first_tick: u64) -> Self {
        Self {
            handle,
            wake: WakeRule::default(),
            phase: Phase::Begin,
            tick: first_tick,
            in_flight: InFlight::default(),
            latest: None,
            free: false,
            is_anchored: false,
            overshoot: Impulse::default(),
            hold: Hold::default(),
            is_held: false,
            habit: Habit::default(),
            ledger: Ledger::default(),
        }
    }

    /// The rapier body.
    pub fn handle(&self) -> RigidBodyHandle {
        self.handle
    }

    /// What has been exchanged; its sums agree between [`complete`](Self::complete) and the next
    /// [`begin_tick`](Self::begin_tick).
    pub fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    /// The first tick whose true impulse is not known.
    pub fn corrected_before(&self) -> u64 {
        self.in_flight.oldest().map_or(self.tick, |record| record.tick)
    }

    /// Begins a tick as long as rapier's step: how the body is now, and what rapier will be told of the fluid.
    ///
    /// # Errors
    /// A tick that is not the next; the last one not completed; more than [`MOST_IN_FLIGHT`](Self::MOST_IN_FLIGHT)
    /// ticks without their impulse; a time step out of range; a body that is gone.
    pub fn begin_tick(&mut self, tick: u64, world: &RapierView<'_>) -> Result<BodyInput, CouplingError> {
        let body = world.bodies.get(self.handle).ok_or(CouplingError::NoSuchBody(self.handle))?;
        self.check_due("begin_tick", |phase| phase == Phase::Begin)?;
        if tick != self.tick {
            return Err(CouplingError::UnexpectedTick { given: tick, expected: self.tick });
        }
        let corrected_before = self.corrected_before();
        if tick - corrected_before > Self::MOST_IN_FLIGHT {
            return Err(CouplingError::TooFarAhead { tick, corrected_before, most: Self::MOST_IN_FLIGHT });
        }
        let duration = world.parameters.dt;
        if !(duration > 0.0 && duration <= 1.0) {
            return Err(CouplingError::Duration(duration));
        }
        let forecast = self.forecast(duration);
        self.free = is_free(self.handle, world);
        self.is_anchored = !self.free && is_anchored(self.handle, world);
        self.is_held &= !self.free;
        self.overshoot = if self.free { overshoot(body, world) } else { Impulse::default() };
        let lacks_since = self.in_flight.oldest_lacking().map_or(tick, |record| record.tick);
        self.in_flight.push(Record { tick, duration, forecast, is_held: false });
        self.phase = Phase::Apply(forecast);
        let acceleration = acceleration(body, world.gravity, forecast, duration);
        self.hold.add_external(acceleration * duration);
        let now = body_input(body, duration);
        let input = BodyInput { acceleration, forecast, corrected_before: lacks_since, free: self.free, ..now };
        Ok(match self.is_held {
            // The fluid meets it in the motion that it has, and rapier finds out whether what holds it still does.
            true => BodyInput { inverse_mass: 0.0, inverse_inertia: Mat3::ZERO, acceleration: Vec3::ZERO, ..input },
            false => input,
        })
    }

    /// The latest known impulse, as for a tick of `duration`.
    fn forecast(&self, duration: f32) -> Impulse {
        match self.latest {
            None => Impulse::default(),
            Some((impulse, known)) if known == duration => impulse,
            Some((impulse, known)) => scaled(impulse, duration / known),
        }
    }

    /// Takes the true impulse of a tick.
    ///
    /// Between [`begin_tick`](Self::begin_tick) and [`apply_forecast`](Self::apply_forecast) the tick's own impulse
    /// replaces the forecast (lockstep). For an earlier tick the body gets what the forecast lacked: the momentum and,
    /// if it is free, the displacement since, as if both had come in time.
    ///
    /// # Errors
    /// A tick out of order, an impulse that is not finite, a step not completed, a body that is gone.
    pub fn receive(&mut self, tick: u64, impulse: Impulse, bodies: &mut RigidBodySet) -> Result<(), CouplingError> {
        let body = bodies.get_mut(self.handle).ok_or(CouplingError::NoSuchBody(self.handle))?;
        self.check_due("receive", |phase| !matches!(phase, Phase::Complete(_)))?;
        if !impulse.linear.is_finite() || !impulse.angular.is_finite() {
            return Err(CouplingError::NotFinite { tick });
        }
        let since = self.in_flight.elapsed_before(self.tick);
        let Some(record) = self.in_flight.pop_if(tick) else {
            return Err(CouplingError::UnexpectedImpulse { given: tick, expected: self.corrected_before() });
        };
        self.latest = Some((impulse, record.duration));
        self.ledger.deliver(impulse);
        let was_asleep = body.is_sleeping();
        if self.habit.note(self.wake, impulse, record.duration, body) {
            body.wake_up(true);
        }
        if tick == self.tick {
            self.phase = Phase::Apply(impulse);
            return Ok(());
        }
        let error = impulse - record.forecast;
        self.ledger.withdraw(record.forecast);
        if record.is_held && (!was_asleep || body.is_sleeping()) {
            // What held it against the forecast would have held it against the impulse. What wakes it has yet to be tried.
            self.ledger.held.add(error);
            return Ok(());
        }
        kick(body, error, &mut self.ledger);
        self.hold.add(error);
        if self.free && !body.is_sleeping() {
            // In its own tick an impulse displaces half as far as in a later one.
            let time = since - 0.5 * record.duration;
            let properties = body.mass_properties();
            let shift = error.linear * properties.effective_inv_mass * time;
            let turn = properties.effective_world_inv_inertia * error.angular * time;
            displace(body, shift, turn);
        }
        Ok(())
    }

    /// Gives the body its momentum before rapier's step: half of the forecast if it is free, or else all of it, so
    /// that contacts and joints answer to it.
    ///
    /// # Errors
    /// No tick begun, a body that is gone.
    pub fn apply_forecast(&mut self, bodies: &mut RigidBodySet) -> Result<(), CouplingError> {
        let body = bodies.get_mut(self.handle).ok_or(CouplingError::NoSuchBody(self.handle))?;
        let Phase::Apply(impulse) = self.phase else { return self.check_due("apply_forecast", |_| false) };
        let now = if self.free { scaled(impulse, 0.5) - self.overshoot } else { impulse };
        self.hold.add(impulse);
        kick(body, now, &mut self.ledger);
        self.phase = Phase::Complete(impulse - now);
        Ok(())
    }

    /// Gives the body what is left of the forecast. Call it right after rapier's step.
    ///
    /// # Errors
    /// The forecast not applied, a body that is gone.
    pub fn complete(&mut self, bodies: &mut RigidBodySet) -> Result<(), CouplingError> {
        let body = bodies.get_mut(self.handle).ok_or(CouplingError::NoSuchBody(self.handle))?;
        let Phase::Complete(rest) = self.phase else { return self.check_due("complete", |_| false) };
        // Late, what holds it has to be there still when the impulse comes, and to have no momentum of its own.
        let is_late = self.in_flight.newest().is_some_and(|record| record.tick == self.tick);
        let may_be_held = !self.free && body.is_dynamic() && (self.is_anchored || !is_late);
        self.is_held = may_be_held && self.hold.holds(body);
        kick(body, rest, &mut self.ledger);
        self.hold = Hold::since(body);
        if let Some(record) = self.in_flight.newest_mut().filter(|record| record.tick == self.tick) {
            record.is_held = self.is_held;
            self.ledger.advance(record.forecast);
        }
        self.tick += 1;
        self.phase = Phase::Begin;
        Ok(())
    }

    fn check_due(&self, call: &'static str, allows: impl Fn(Phase) -> bool) -> Result<(), CouplingError> {
        let allowed = match self.phase {
            phase if allows(phase) => return Ok(()),
            Phase::Begin => "begin_tick",
            Phase::Apply(_) => "apply_forecast",
            Phase::Complete(_) => "complete",
        };
        Err(CouplingError::OutOfOrder { call, allowed })
    }
}

fn scaled(impulse: Impulse, factor: f32) -> Impulse {
    Impulse { linear: impulse.linear * factor, angular: impulse.angular * factor }
}
