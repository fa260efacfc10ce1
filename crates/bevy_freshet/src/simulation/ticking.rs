//! Sends the ticks.

use bevy::prelude::*;
use freshet_core::step::{BodyInput, Command, StepInput};

use super::collecting::wait_for_all;
use super::gather::{rigid_frame, to_emitter};
use super::state::{DomainState, SentTick};
use crate::components::domain::FluidMode;
use crate::components::emitter::FluidEmitter;
use crate::components::stats::FluidStats;
use crate::engine::Order;

/// How long an emitter has been flowing, s: consecutive layers are a spacing apart whatever the ticks are.
#[derive(Component, Clone, Copy, Default)]
pub(crate) struct EmitterClock(f64);

/// Sends a tick to every domain that has fluid; in lockstep, waits for it.
pub(crate) fn send_ticks(
    time: Res<Time>,
    mut domains: Query<(Entity, &mut DomainState, &mut FluidStats)>,
    mut emitters: Query<(&FluidEmitter, &mut EmitterClock)>,
    transforms: TransformHelper,
) {
    let duration = time.delta_secs();
    for (entity, mut state, mut stats) in &mut domains {
        let state = &mut *state;
        let (Some(engine), Some(plan), false) = (&mut state.engine, &state.plan, state.stopped) else { continue };
        for source in state.recipe.iter().flat_map(|recipe| &recipe.sources) {
            let (Ok((emitter, mut clock)), Ok(pose)) =
                (emitters.get_mut(source.entity), rigid_frame(&transforms, source.entity))
            else {
                continue;
            };
            let emitter_now = to_emitter(emitter, state.frame.inverse() * pose);
            // A refused emitter is in the recipe, as it was asked for.
            if !emitter.enabled || emitter_now.validate().is_err() {
                continue;
            }
            let particles = emitter_now.emit(plan.parameters.spacing, clock.0, f64::from(duration));
            clock.0 += f64::from(duration);
            if !particles.positions.is_empty() {
                state.pours.spawn(state.tick, None, particles.positions.len() as u32);
                state.commands.push(Command::Spawn(particles));
            }
        }
        // Without the coupling, or for a body it has lost, a body stands still at the origin of its samples.
        let mut bodies = std::mem::take(&mut state.body_inputs);
        bodies.resize(plan.bodies.len(), BodyInput::default());
        let commands = std::mem::take(&mut state.commands);
        engine.send(Order::Tick(StepInput { tick: state.tick, duration, bodies, commands }));
        state.sent.push_back(SentTick { tick: state.tick, bodies: state.body_entities.clone() });
        state.tick += 1;
        stats.ticks_in_flight = state.sent.len() as u64;
        if state.mode == FluidMode::Lockstep {
            wait_for_all(entity, state, &mut stats);
        }
    }
}
