//! Delivers values of particles.

use bevy::prelude::*;

use super::problems::Problem;
use super::state::DomainState;
use crate::components::readback::{FluidReadback, FluidReadbackComplete};

/// Reads what is asked for, after the tick has been sent.
pub(crate) fn read_fields(mut commands: Commands, mut domains: Query<(Entity, &FluidReadback, &mut DomainState)>) {
    for (entity, readback, mut state) in &mut domains {
        let Some(tick) = state.tick.checked_sub(1) else { continue };
        if tick % u64::from(readback.every.max(1)) != 0 || !state.runs() {
            continue;
        }
        let Some(engine) = &mut state.engine else { continue };
        let data: Result<Vec<_>, _> =
            readback.fields.iter().map(|&field| Ok((field, engine.read(field.into())?))).collect();
        match data {
            Ok(data) => commands.trigger(FluidReadbackComplete { entity, tick, data }),
            Err::<_, freshet_core::solver::SolverError>(error) => {
                state.complain(Problem::new(entity, "FluidReadback", error));
            }
        }
    }
}
