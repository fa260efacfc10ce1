//! Notices what changed and has it planned.

use bevy::prelude::*;
use freshet_core::step::Command;

use super::attempt::plan_without_the_wrong;
use super::backend::Hardware;
use super::collecting::wait_for_all;
use super::gather::{Motions, Sources};
use super::orders::carry_out;
use super::pours::Poured;
use super::problems::{Problem, Problems};
use super::recipe::Recipe;
use super::state::{DefaultGravity, DomainState};
use super::walls::WallShapes;
use crate::components::domain::{FluidBackend, FluidDomain};
use crate::components::stats::FluidStats;
use crate::components::volume::FluidVolume;

/// Brings every domain's plan up to date with its components. Runs when something was touched.
pub(crate) fn plan_domains(
    mut commands: Commands,
    mut domains: Query<(Entity, &FluidDomain, &mut DomainState, &mut FluidStats)>,
    volumes: Query<&FluidVolume>,
    sources: Sources,
    hardware: Hardware,
    default_gravity: Res<DefaultGravity>,
    mut problems: ResMut<Problems>,
    mut shapes: ResMut<WallShapes>,
) {
    shapes.begin();
    let count = domains.iter().len();
    let mut current = sources.ambiguous(count);
    for (entity, domain, mut state, mut stats) in &mut domains {
        state.has_unsaid_problems = false;
        state.asks_for_planning = false;
        let frame = match sources.frame(entity) {
            Ok(frame) => frame,
            Err(message) => {
                current.push(Problem::new(entity, "FluidDomain", message));
                continue;
            }
        };
        state.frame = frame;
        state.mode = domain.mode;
        let gravity = domain.gravity.unwrap_or(default_gravity.0);
        let backend = hardware.choose(domain.backend);
        let state = &mut *state;
        let mut motions = Motions::new(state.recipe.as_ref(), &mut state.moved, &state.placed);
        let which = (count == 1, false);
        let mut recipe =
            sources.recipe(entity, domain, (frame, gravity), which, &mut motions, &mut shapes, &mut current);
        if stats.waiting_for != recipe.waits_for {
            stats.waiting_for.clone_from(&recipe.waits_for);
        }
        let waits = !recipe.waits_for.is_empty();
        if waits && !state.waits {
            // What the fluid did to bodies reaches them before they are let go.
            wait_for_all(entity, state, &mut stats);
        }
        state.waits = waits;
        if !waits {
            // One that is gone and comes again stands.
            let walls = recipe.walls.iter().map(|wall| wall.entity);
            let there: Vec<Entity> = walls.chain(recipe.movers.iter().map(|mover| mover.entity)).collect();
            state.moved.retain(|entity| there.contains(entity));
        }
        if waits {
            current.extend(state.problems.iter().cloned());
            continue;
        }

        let has_fluid =
            state.engine.is_some() || state.stopped || !recipe.fresh.is_empty() || !recipe.sources.is_empty();
        let is_served = state.recipe.as_ref().is_some_and(|planned| recipe.is_served_by(planned))
            && state.backend.is_none_or(|running| running == backend);
        if has_fluid && !is_served {
            if state.stopped {
                // Its particles are lost: the domain starts from all its volumes again.
                let which = (count == 1, true);
                let mut motions = Motions::new(state.recipe.as_ref(), &mut state.moved, &state.placed);
                recipe =
                    sources.recipe(entity, domain, (frame, gravity), which, &mut motions, &mut shapes, &mut Vec::new());
            }
            for (volume, refused) in replan(entity, recipe, backend, (state, &mut stats), &sources, &hardware) {
                let refused = if refused { volumes.get(volume).ok().cloned() } else { None };
                commands.entity(volume).try_insert(Poured { domain: entity, refused });
            }
        } else if state.engine.is_some() && recipe.gravity != state.gravity && recipe.gravity.is_finite() {
            state.gravity = recipe.gravity;
            state.commands.push(Command::SetGravity(recipe.gravity));
        }
        state.placed.clear();
        current.extend(state.problems.iter().cloned());
    }
    shapes.drop_unused();
    problems.update(current, &mut commands);
}

/// Plans a recipe and orders what follows. Returns the volumes dealt with, and whether they were refused.
fn replan(
    domain: Entity,
    mut recipe: Recipe,
    backend: FluidBackend,
    (state, stats): (&mut DomainState, &mut FluidStats),
    sources: &Sources,
    hardware: &Hardware,
) -> Vec<(Entity, bool)> {
    if state.stopped {
        let moved = std::mem::take(&mut state.moved);
        *state = DomainState { frame: state.frame, mode: state.mode, moved, ..default() };
        stats.stopped = None;
    }
    state.problems.clear();
    let has_bodies_of = |planned: &Recipe| planned.bodies == recipe.bodies && recipe.has_movers_of(planned);
    if state.recipe.as_ref().is_some_and(|planned| !has_bodies_of(planned)) {
        // Solvers know bodies by their place in the plan, also those of ticks in flight.
        wait_for_all(domain, state, stats);
    }
    let mut asked = recipe.clone();
    let mut dealt_with = Vec::new();
    if let Some(plan) = plan_without_the_wrong(domain, &mut recipe, state, sources, &mut dealt_with) {
        stats.plannings += 1;
        carry_out(domain, plan, &recipe, backend, (state, stats), hardware);
        dealt_with.extend(recipe.fresh.iter().map(|fresh| (fresh.entity, false)));
    }
    // Whatever came of it, the same recipe is not tried twice. Volumes dealt with will not be in the next one.
    asked.fresh.retain(|fresh| !dealt_with.iter().any(|(entity, _)| *entity == fresh.entity));
    state.recipe = Some(asked);
    dealt_with
}
