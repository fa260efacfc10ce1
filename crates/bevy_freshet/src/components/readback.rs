//! Values of particles, for the app.

use bevy::prelude::*;
use freshet_core::field::FieldData;

use crate::rendering::appearance::FluidField;

/// Reads fields of all particles of the domain it stands on, and delivers them as [`FluidReadbackComplete`].
///
/// It waits for the fluid, which costs the pipelining of that tick: for tools, tests and scenes that need it rarely.
#[derive(Component, Clone, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
pub struct FluidReadback {
    /// Which fields.
    pub fields: Vec<FluidField>,
    /// Every how many ticks; 0 counts as 1.
    pub every: u32,
}

impl FluidReadback {
    /// Reads these fields at every tick.
    pub fn new(fields: impl Into<Vec<FluidField>>) -> Self {
        Self { fields: fields.into(), every: 1 }
    }
}

/// Values of particles after a tick; sent to the domain.
#[derive(EntityEvent, Clone, Debug)]
pub struct FluidReadbackComplete {
    /// The domain.
    pub entity: Entity,
    /// Number of the tick.
    pub tick: u64,
    /// The values, in the order of the fields asked for; particles in the solver's order, the same in each.
    pub data: Vec<(FluidField, FieldData)>,
}

impl FluidReadbackComplete {
    /// The values of one of the fields asked for.
    pub fn get(&self, field: FluidField) -> Option<&FieldData> {
        self.data.iter().find(|(other, _)| *other == field).map(|(_, data)| data)
    }
}
