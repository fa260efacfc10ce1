//! Finds room for new fluid among the fluid that is there.

use std::collections::HashMap;
use std::ops::Range;

use bevy::prelude::*;
use freshet_core::field::{Field, FieldData};
use freshet_core::plan::Plan;
use freshet_core::solver::SolverError;
use freshet_core::step::{Command, NewParticles};

use crate::engine::Engine;

/// Distance over the spacing below which two particles blow each other apart. Volumes that touch have particles just half a
/// spacing apart, hence not 0.5: the model allows the same between volumes.
const LEAST_DISTANCE: f32 = 0.48;

/// Fluid that stays in the coming tick.
pub(crate) struct Occupied {
    positions: Vec<Vec3>,
    least_distance: f32,
}

impl Occupied {
    /// Waits for the ticks sent, and asks where the particles are. `commands` are those of the coming tick.
    pub(crate) fn of(engine: &mut Engine, commands: &[Command], spacing: f32) -> Result<Self, SolverError> {
        let ids = engine.read(Field::Id)?.integers().unwrap_or_default();
        let positions = engine.read(Field::Position).map(FieldData::vectors)?.unwrap_or_default();
        let is_removed = |id: u32| {
            commands.iter().any(|command| match command {
                Command::RemoveIds { first, count } => (*first..first.saturating_add(*count)).contains(&id),
                _ => false,
            })
        };
        let staying = positions.into_iter().zip(ids).filter(|(_, id)| !is_removed(*id));
        Ok(Self {
            positions: staying.map(|(position, _)| position).collect(),
            least_distance: LEAST_DISTANCE * spacing,
        })
    }

    /// Those particles of a plan that are not too near to one that is there.
    pub(crate) fn rest_of(&self, plan: &Plan, range: Range<usize>) -> NewParticles {
        let new = &plan.positions[range.clone()];
        let margin = Vec3::splat(self.least_distance);
        let low = new.iter().fold(Vec3::INFINITY, |low, position| low.min(*position)) - margin;
        let high = new.iter().fold(Vec3::NEG_INFINITY, |high, position| high.max(*position)) + margin;
        // Relative to the corner, so that cells can be counted in `i32` wherever that is.
        let cell = |position: Vec3| ((position - low) / self.least_distance).floor().as_ivec3();
        let mut cells: HashMap<IVec3, Vec<Vec3>> = HashMap::new();
        for &position in &self.positions {
            if position.cmpge(low).all() && position.cmple(high).all() {
                cells.entry(cell(position)).or_default().push(position);
            }
        }
        let is_free = |position: Vec3| {
            let (center, limit) = (cell(position), self.least_distance * self.least_distance);
            (0..27).all(|i| {
                let neighbour = center + IVec3::new(i % 3, i / 3 % 3, i / 9) - 1;
                cells.get(&neighbour).is_none_or(|there| there.iter().all(|p| p.distance_squared(position) >= limit))
            })
        };
        let free: Vec<usize> = range.filter(|&i| is_free(plan.positions[i])).collect();
        NewParticles {
            positions: free.iter().map(|&i| plan.positions[i]).collect(),
            velocities: free.iter().map(|&i| plan.velocities[i]).collect(),
            lifetime: f32::INFINITY,
            at: None,
        }
    }
}
