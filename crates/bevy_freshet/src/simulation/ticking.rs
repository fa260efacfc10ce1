//! Sends the ticks.

use bevy::prelude::*;
use freshet_core::emitter::{Emitter, EmitterFlow};
use freshet_core::step::{BodyInput, Command, StepInput};

use super::collecting::wait_for_all;
use super::gather::{rigid_frame, to_emitter};
use super::movers::MovingWall;
use super::recipe::is_moved;
use super::state::{DomainState, SentTick};
use super::walls::stretch::stretched_frame;
use crate::components::domain::FluidMode;
use crate::components::emitter::FluidEmitter;
use crate::components::stats::FluidStats;
use crate::engine::Order;

/// Run condition: whether the app's time stands still.
pub(crate) fn time_stands_still(time: Res<Time<Virtual>>) -> bool {
    time.delta().is_zero()
}

/// Walls that are moved while time stands still are put where they are.
pub(crate) fn place_walls(mut domains: Query<(Entity, &mut DomainState)>, transforms: TransformHelper) {
    for (domain, mut state) in &mut domains {
        let Ok(frame) = rigid_frame(&transforms, domain) else { continue };
        let DomainState { movers, recipe, placed, .. } = &mut *state;
        movers.iter_mut().for_each(|mover| mover.place(&transforms, frame));
        for wall in recipe.iter().flat_map(|recipe| &recipe.walls) {
            let now = stretched_frame(&transforms, wall.entity).map(|(pose, _)| frame.inverse() * pose);
            if now.is_ok_and(|now| is_moved(wall.pose(), now)) {
                placed.insert(wall.entity);
            }
        }
    }
}

/// Sends a tick to every domain that has fluid; in lockstep, waits for it.
pub(crate) fn send_ticks(
    time: Res<Time>,
    mut domains: Query<(Entity, &mut DomainState, &mut FluidStats)>,
    emitters: Query<&FluidEmitter>,
    transforms: TransformHelper,
) {
    let duration = time.delta_secs();
    for (entity, mut state, mut stats) in &mut domains {
        let state = &mut *state;
        if !state.runs() {
            state.movers.iter_mut().for_each(MovingWall::pause);
            continue;
        }
        let (Some(engine), Some(plan)) = (&mut state.engine, &state.plan) else { continue };
        // Emitters follow simulated time; where it turns out otherwise than expected, the solver puts the layers right.
        let (span, spacing) = (state.clock.span(duration), plan.parameters.spacing);
        let sources = state.recipe.as_ref().map(|recipe| recipe.sources.as_slice()).unwrap_or_default();
        state.flows.retain(|entity, _| sources.iter().any(|source| source.entity == *entity));
        for source in sources {
            let flow = state.flows.entry(source.entity).or_insert_with(|| EmitterFlow::new(span.start));
            let emitter = emitters.get(source.entity).ok().filter(|emitter| emitter.enabled);
            let pose = rigid_frame(&transforms, source.entity).ok();
            let now = emitter.zip(pose).map(|(emitter, pose)| to_emitter(emitter, state.frame.inverse() * pose));
            // A refused emitter is in the recipe, as it was asked for; one that is not refused may have moved out of range. The
            // flow is checked again because a layer of a wrong one would not fit into memory.
            let may_flow = |now: &Emitter| {
                state.emitters.contains(&source.entity) && now.validate().and_then(|()| now.check_flow(spacing)).is_ok()
            };
            let Some(now) = now.filter(may_flow) else {
                flow.pause(span.end);
                continue;
            };
            for layer in now.layers(spacing, flow, &span) {
                state.pours.spawn(state.tick, None, layer.positions.len() as u32);
                state.commands.push(Command::Spawn(layer));
            }
        }
        state.clock.send(state.tick, duration);
        // Without the coupling, or for a body it has lost, a body stands still at the origin of its samples.
        let mut bodies = std::mem::take(&mut state.body_inputs);
        bodies.resize(state.body_entities.len(), BodyInput::default());
        let mut gone_out = Vec::new();
        for mover in &mut state.movers {
            let told = mover.advance(&transforms, state.frame, duration, plan);
            state.asks_for_planning |= told.has_changed;
            gone_out.extend(plan.bodies.get(bodies.len()).and_then(|body| mover.goes_out(plan, &body.samples)));
            bodies.push(told.input);
        }
        bodies.resize(plan.bodies.len(), BodyInput::default());
        let commands = std::mem::take(&mut state.commands);
        engine.send(Order::Tick(StepInput { tick: state.tick, duration, bodies, commands }));
        state.sent.push_back(SentTick { tick: state.tick, bodies: state.body_entities.clone() });
        state.tick += 1;
        gone_out.into_iter().for_each(|problem| state.complain(problem));
        stats.ticks_in_flight = state.sent.len() as u64;
        if state.mode == FluidMode::Lockstep {
            wait_for_all(entity, state, &mut stats);
        }
    }
}
