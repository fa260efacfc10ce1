//! What a tick forecast, kept until its true impulse arrives.

use std::collections::VecDeque;

use freshet_core::step::Impulse;

/// One tick that has begun.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Record {
    pub(crate) tick: u64,
    /// s.
    pub(crate) duration: f32,
    /// Impulse told to the solver and applied in the tick's step.
    pub(crate) forecast: Impulse,
    /// Whether contacts and joints held the body in its motion in the tick's step, so that they took the impulse.
    pub(crate) is_held: bool,
}

/// Ticks whose true impulse is not known, oldest first; the newest may not have been stepped yet.
#[derive(Clone, Debug, Default)]
pub(crate) struct InFlight {
    records: VecDeque<Record>,
}

impl InFlight {
    pub(crate) fn push(&mut self, record: Record) {
        self.records.push_back(record);
    }

    pub(crate) fn oldest(&self) -> Option<&Record> {
        self.records.front()
    }

    pub(crate) fn newest(&self) -> Option<&Record> {
        self.records.back()
    }

    pub(crate) fn newest_mut(&mut self) -> Option<&mut Record> {
        self.records.back_mut()
    }

    /// The oldest of which the body may lack something: none later was held.
    pub(crate) fn oldest_lacking(&self) -> Option<&Record> {
        let held = self.records.iter().rposition(|record| record.is_held).map_or(0, |held| held + 1);
        self.records.get(held)
    }

    /// Takes out the oldest if it is of this tick.
    pub(crate) fn pop_if(&mut self, tick: u64) -> Option<Record> {
        self.records.pop_front_if(|record| record.tick == tick)
    }

    /// Sum of the durations, s, of the ticks before `tick`.
    pub(crate) fn elapsed_before(&self, tick: u64) -> f32 {
        self.records.iter().filter(|record| record.tick < tick).map(|record| record.duration).sum()
    }
}
