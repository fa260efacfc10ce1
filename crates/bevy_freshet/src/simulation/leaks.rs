//! Counts what goes through walls, in domains that ask for it.

use bevy::prelude::*;
use freshet_core::field::{Field, FieldData};
use freshet_core::leaks::LeakWatch;
use freshet_core::solver::SolverError;

use super::collecting::wait_for_all;
use super::problems::Problem;
use super::state::DomainState;
use crate::components::domain::FluidDomain;
use crate::components::stats::FluidStats;
use crate::engine::Engine;

/// Share of a tick below which walls that move are ahead of the fluid.
const ON_TIME: f32 = 0.999;

/// Looks at all particles, after the tick has been sent, and waits for it.
pub(crate) fn count_leaks(mut domains: Query<(Entity, &FluidDomain, &mut DomainState, &mut FluidStats)>) {
    for (entity, domain, mut state, mut stats) in &mut domains {
        if !domain.count_leaks {
            if state.watch.is_some() || stats.leaks.is_some() {
                state.watch = None;
                stats.leaks = None;
            }
            continue;
        }
        if stats.leaks.is_none() {
            stats.leaks = Some(0);
        }
        if !state.runs() {
            continue;
        }
        wait_for_all(entity, &mut state, &mut stats);
        if let Err(error) = look(&mut state, &mut stats) {
            state.complain(Problem::new(entity, "FluidDomain", format!("count_leaks: {error}")));
        }
    }
}

fn look(state: &mut DomainState, stats: &mut FluidStats) -> Result<(), SolverError> {
    let DomainState { engine: Some(engine), layer: Some(layer), watch, boundaries, movers, .. } = state else {
        return Ok(());
    };
    // Walls come first, then those that move.
    let first = boundaries.len() - movers.len().min(boundaries.len());
    if !movers.is_empty() && stats.time_scale < ON_TIME {
        return Ok(());
    }
    let is_first = watch.is_none();
    let watch = watch.get_or_insert_with(|| LeakWatch::new(layer, boundaries));
    for (index, mover) in (first..).zip(movers) {
        mover.show(index, watch, is_first);
    }
    let (ids, positions) = particles(engine)?;
    let new = watch.look(&ids, &positions);
    stats.leaks = Some(stats.leaks.unwrap_or(0) + u64::from(new));
    Ok(())
}

fn particles(engine: &mut Engine) -> Result<(Vec<u32>, Vec<Vec3>), SolverError> {
    let ids = engine.read(Field::Id)?.integers().unwrap_or_default();
    let positions = engine.read(Field::Position).map(FieldData::vectors)?.unwrap_or_default();
    Ok((ids, positions))
}
