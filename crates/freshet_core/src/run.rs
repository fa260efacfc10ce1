//! Drives a scene tick by tick: turns emitters and the clock into [`StepInput`]s.

use std::collections::VecDeque;
use std::ops::Range;

use crate::emitter::EmitterFlow;
use crate::plan::Plan;
use crate::snapshot::Snapshot;
use crate::step::{BodyInput, Command, StepInput, StepReport};

/// Simulated time as far as it is known to who sends the ticks.
///
/// Reports may be late, and a tick may cover less than it was asked to, or make up for what others left over.
#[derive(Clone, Debug, Default)]
pub struct SimulatedClock {
    known: f64,
    /// Ticks that were sent and not heard of, and their durations, s.
    in_flight: VecDeque<(u64, f64)>,
}

impl SimulatedClock {
    /// Stands at `time`, s, with no tick in flight.
    pub fn at(time: f64) -> Self {
        Self { known: time, in_flight: VecDeque::new() }
    }

    /// Simulated time at the start of the coming tick, s, if those in flight cover what they were asked to.
    pub fn time(&self) -> f64 {
        self.known + self.in_flight.iter().map(|(_, duration)| duration).sum::<f64>()
    }

    /// What the coming tick of `duration` seconds is expected to cover, in simulated time, s.
    ///
    /// It ends no more than [`StepInput::MAX_DURATION`] after the last time known. Time carried over from earlier ticks is not
    /// expected to be made up for.
    pub fn span(&self, duration: f32) -> Range<f64> {
        let start = self.time();
        start..(start + f64::from(duration)).min(self.known + f64::from(StepInput::MAX_DURATION))
    }

    /// Notes a tick that is sent.
    pub fn send(&mut self, tick: u64, duration: f32) {
        self.in_flight.push_back((tick, f64::from(duration)));
    }

    /// Learns what a tick covered. Reports come in the order of their ticks.
    pub fn hear(&mut self, report: &StepReport) {
        self.known += report.simulated;
        self.in_flight.retain(|(tick, _)| *tick > report.tick);
    }
}

/// Makes the inputs of a scene's ticks, with the layers its emitters send.
///
/// Emitters follow simulated time, so the run must hear each tick's report; one that hears nothing sends layers for the
/// first second only.
#[derive(Clone, Debug, Default)]
pub struct SceneRun {
    tick: u64,
    clock: SimulatedClock,
    /// Simulated time of the last layer before a snapshot, s; none once emitters have gone on from there.
    resumed: Option<f64>,
    /// One for each emitter of the plan that there was a tick with.
    flows: Vec<EmitterFlow>,
}

impl SceneRun {
    /// Begins at tick 0 and time 0.
    pub fn new() -> Self {
        Self::default()
    }

    /// Continues from a snapshot: emitters go on in phase.
    pub fn resume(snapshot: &Snapshot) -> Self {
        Self {
            tick: snapshot.tick,
            clock: SimulatedClock::at(snapshot.time),
            resumed: snapshot.emitted,
            flows: Vec::new(),
        }
    }

    /// Simulated time at the start of the next tick, s, as far as it is known: see [`SimulatedClock::time`].
    pub fn time(&self) -> f64 {
        self.clock.time()
    }

    /// Number of the next tick.
    pub fn tick(&self) -> u64 {
        self.tick
    }

    /// The input of the next tick of `duration` seconds. Its report goes to [`hear`](Self::hear), before the next tick or up to
    /// a few ticks later.
    pub fn next(&mut self, plan: &Plan, duration: f32, bodies: Vec<BodyInput>) -> StepInput {
        let (spacing, span) = (plan.parameters.spacing, self.clock.span(duration));
        let from = self.resumed.take().map_or(span.start, f64::next_up);
        let mut commands = Vec::new();
        for (index, emitter) in plan.emitters.iter().enumerate() {
            if self.flows.len() == index {
                self.flows.push(EmitterFlow::in_phase(emitter.interval(spacing), from));
            }
            commands.extend(emitter.layers(spacing, &mut self.flows[index], &span).into_iter().map(Command::Spawn));
        }
        let input = StepInput { tick: self.tick, duration, bodies, commands };
        self.clock.send(self.tick, duration);
        self.tick += 1;
        input
    }

    /// Learns how much time a tick really covered. Reports come in the order of their ticks.
    pub fn hear(&mut self, report: &StepReport) {
        self.clock.hear(report);
    }
}
