//! Drives a scene tick by tick: turns emitters and the clock into [`StepInput`]s.

use crate::plan::Plan;
use crate::step::{BodyInput, Command, StepInput};

/// Makes the inputs of a scene's ticks, with the layers its emitters send.
#[derive(Clone, Debug)]
pub struct SceneRun {
    tick: u64,
    time: f64,
}

impl SceneRun {
    /// Begins at tick 0 and time 0.
    pub fn new() -> Self {
        Self::at(0, 0.0)
    }

    /// Continues from a tick and a time, s, as a snapshot holds them.
    pub fn at(tick: u64, time: f64) -> Self {
        Self { tick, time }
    }

    /// Time at the start of the next tick, s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Number of the next tick.
    pub fn tick(&self) -> u64 {
        self.tick
    }

    /// The input of the next tick of `duration` seconds.
    pub fn next(&mut self, plan: &Plan, duration: f32, bodies: Vec<BodyInput>) -> StepInput {
        let mut commands = Vec::new();
        for emitter in &plan.emitters {
            let particles = emitter.emit(plan.parameters.spacing, self.time, f64::from(duration));
            if !particles.positions.is_empty() {
                commands.push(Command::Spawn(particles));
            }
        }
        let input = StepInput { tick: self.tick, duration, bodies, commands };
        self.tick += 1;
        self.time += f64::from(duration);
        input
    }
}

impl Default for SceneRun {
    fn default() -> Self {
        Self::new()
    }
}
