//! What follows from a new plan: an engine is started, told, or exchanged; new particles are poured.

use bevy::prelude::*;
use freshet_core::plan::{LeftOut, Plan};
use freshet_core::scene::MAX_PARTICLES;
use freshet_core::snapshot::Snapshot;
use freshet_core::step::Command;

use super::backend::Hardware;
use super::collecting::wait_for_all;
use super::movers::{Mover, MovingWall};
use super::problems::Problem;
use super::recipe::Recipe;
use super::room::Occupied;
use super::state::DomainState;
use crate::components::domain::FluidBackend;
use crate::components::stats::FluidStats;
use crate::engine::{Engine, Order};

/// Has a plan executed. The recipe is what was planned: its volumes are those of the plan.
pub(crate) fn carry_out(
    domain: Entity,
    mut plan: Plan,
    recipe: &Recipe,
    backend: FluidBackend,
    (state, stats): (&mut DomainState, &mut FluidStats),
    hardware: &Hardware,
) {
    state.body_entities = recipe.bodies.iter().map(|(entity, _)| *entity).collect();
    let samples =
        |index: usize| plan.bodies.get(state.body_entities.len() + index).map_or(&[][..], |body| &body.samples);
    let movers = recipe.movers.iter().enumerate();
    state.movers = movers.map(|(i, mover)| MovingWall::new(mover, samples(i), &state.movers)).collect();
    let walls = recipe.walls.iter().map(|wall| wall.boundary.clone());
    state.boundaries = walls.chain(recipe.movers.iter().map(Mover::boundary)).collect();
    state.layer = plan.parameters.wall_layer().ok();
    if let (Some(watch), Some(layer)) = (&mut state.watch, &state.layer) {
        watch.set_walls(layer, &state.boundaries);
        let first = state.boundaries.len() - state.movers.len();
        (first..).zip(&state.movers).for_each(|(index, mover)| mover.go_on(index, watch));
    }
    state.emitters = recipe.sources.iter().map(|source| source.entity).collect();
    stats.notes.clone_from(&plan.notes);
    stats.notes.extend(recipe.movers.iter().filter_map(Mover::note));
    state.problems.extend(left_out(&plan, recipe));
    let Some(old) = &state.plan else {
        state.engine = start(domain, backend, &plan, None, (state, stats), hardware);
        state.gravity = plan.parameters.gravity;
        for (volume, &(_, count)) in recipe.fresh.iter().zip(&plan.volume_ids) {
            state.pours.start(volume.entity, count);
        }
        stats.particles = plan.positions.len() as u32;
        stats.capacity = plan.max_particles;
        state.plan = Some(without_particles(&plan));
        return;
    };
    let alive = u64::from(stats.particles) + state.pours.unknown();
    keep_what_is_there(&mut plan, old, recipe, (state.pours.claimed(), alive));
    let bare = without_particles(&plan);
    let is_new = *old != bare;
    if state.backend != Some(backend) {
        exchange(domain, backend, &bare, (state, stats), hardware);
    } else if is_new && let Some(engine) = &mut state.engine {
        engine.send(Order::Reconfigure(Box::new(bare.clone())));
    }
    if !recipe.fresh.is_empty() {
        pour(domain, &plan, recipe, state, stats);
    }
    if state.gravity != recipe.gravity {
        state.gravity = recipe.gravity;
        state.commands.push(Command::SetGravity(recipe.gravity));
    }
    stats.capacity = bare.max_particles;
    state.plan = Some(bare);
}

/// Adds the fluid of a plan to the fluid that is there, where that leaves room.
fn pour(domain: Entity, plan: &Plan, recipe: &Recipe, state: &mut DomainState, stats: &mut FluidStats) {
    // What is known of the ticks sent may remove particles.
    wait_for_all(domain, state, stats);
    let Some(engine) = &mut state.engine else { return };
    let occupied = match Occupied::of(engine, &state.commands, plan.parameters.spacing) {
        Ok(occupied) => occupied,
        Err(error) => {
            state.problems.push(Problem::new(domain, "FluidDomain", format!("no fluid can be added: {error}")));
            return;
        }
    };
    for (fresh, &(first, count)) in recipe.fresh.iter().zip(&plan.volume_ids) {
        let particles = occupied.rest_of(plan, first as usize..(first + count) as usize);
        let room = particles.positions.len() as u32;
        if room < count {
            let message = format!(
                "{} of {count} particles are left out: there is fluid at their place; allowed: half a spacing from it",
                count - room
            );
            state.problems.push(Problem::new(fresh.entity, "FluidVolume", message));
        }
        if room > 0 {
            state.pours.spawn(state.tick, Some(fresh.entity), room);
            state.commands.push(Command::Spawn(particles));
        }
    }
}

/// What of the volumes starts in walls, a problem for each pair of them.
fn left_out(plan: &Plan, recipe: &Recipe) -> Vec<Problem> {
    let asked = |volume: usize| {
        let left_out = plan.left_out.iter().filter(|one| one.volume == volume);
        plan.volume_ids[volume].1 + left_out.map(|one| one.inside + one.crowded).sum::<u32>()
    };
    let problem = |one: &LeftOut| {
        let wall = &recipe.walls[one.boundary];
        let message = format!(
            "{} of {} particles are left out: {} have their centre inside the {} of entity {}, {} are nearer to it than half a spacing",
            one.inside + one.crowded,
            asked(one.volume),
            one.inside,
            wall.component,
            wall.entity,
            one.crowded
        );
        Problem::new(recipe.fresh[one.volume].entity, "FluidVolume", message)
    };
    plan.left_out.iter().map(problem).collect()
}

/// A plan as it is kept and compared: the particles of its start are with the solver, notes are for the user.
fn without_particles(plan: &Plan) -> Plan {
    let (positions, velocities) = (Vec::new(), Vec::new());
    Plan {
        positions,
        velocities,
        pressures: Vec::new(),
        excesses: Vec::new(),
        volume_ids: Vec::new(),
        left_out: Vec::new(),
        notes: Vec::new(),
        ..plan.clone()
    }
}

/// The new scene holds new fluid only: room, bounds and lifetimes must serve the old as well.
fn keep_what_is_there(plan: &mut Plan, old: &Plan, recipe: &Recipe, (claimed, alive): (u64, u64)) {
    if recipe.settings.max_particles.is_none() {
        let new = plan.positions.len() as u64;
        let most = (u64::from(plan.max_particles) + claimed).max(new + alive);
        plan.max_particles = most.min(u64::from(MAX_PARTICLES)) as u32;
    }
    if recipe.settings.bounds.is_none() {
        plan.parameters.bounds_min = plan.parameters.bounds_min.min(old.parameters.bounds_min);
        plan.parameters.bounds_max = plan.parameters.bounds_max.max(old.parameters.bounds_max);
    }
    let lengths = |plan: &Plan| (plan.grid.cell_size, plan.grid.support_radius);
    if lengths(old) == lengths(plan) && old.grid.cells() > plan.grid.cells() {
        plan.grid = old.grid;
    }
    plan.lifetimes |= old.lifetimes;
    // The solver is told of gravity by command.
    plan.parameters.gravity = old.parameters.gravity;
}

/// Another backend continues from the state of the one before.
fn exchange(
    domain: Entity,
    backend: FluidBackend,
    plan: &Plan,
    (state, stats): (&mut DomainState, &mut FluidStats),
    hardware: &Hardware,
) {
    let Some(engine) = &mut state.engine else { return };
    match engine.snapshot() {
        Ok(snapshot) => {
            wait_for_all(domain, state, stats);
            state.engine = start(domain, backend, plan, Some(&snapshot), (state, stats), hardware);
        }
        Err(error) => {
            let message = format!("backend: it stays, because the state cannot be taken over: {error}");
            state.problems.push(Problem::new(domain, "FluidDomain", message));
            state.backend = Some(backend);
        }
    }
}

/// Starts an engine; on the CPU where the GPU lacks something.
fn start(
    domain: Entity,
    backend: FluidBackend,
    plan: &Plan,
    snapshot: Option<&Snapshot>,
    (state, stats): (&mut DomainState, &mut FluidStats),
    hardware: &Hardware,
) -> Option<Engine> {
    // The wish, not what comes of it, so that it is not tried again every tick.
    state.backend = Some(backend);
    stats.backend = backend;
    let mut result = hardware.start(backend, plan.clone(), snapshot);
    if backend == FluidBackend::Gpu
        && let Err(error) = &result
    {
        let message = format!("backend: Gpu is not possible here, using Cpu: {error}");
        state.problems.push(Problem::new(domain, "FluidDomain", message));
        stats.backend = FluidBackend::Cpu;
        result = hardware.start(FluidBackend::Cpu, plan.clone(), snapshot);
    }
    result
        .map_err(|error| {
            stats.stopped = Some(error.to_string());
            state.problems.push(Problem::new(domain, "FluidDomain", error));
            state.stopped = true;
        })
        .ok()
}
