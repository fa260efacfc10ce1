//! The plugin group.

use bevy::app::{PluginGroup, PluginGroupBuilder};

use crate::coupling::FluidCouplingPlugin;
use crate::rendering::FluidRenderPlugin;
use crate::simulation::FluidSimulationPlugin;

/// Everything a game with fluids needs: simulation, coupling with rapier, drawing.
///
/// Each can be left out: `FreshetPlugins::default().build().disable::<FluidRenderPlugin>()`. Add it after Bevy's plugins
/// and after `RapierPhysicsPlugin`, if the app has its own; otherwise it adds rapier in the fixed schedule.
#[derive(Default)]
#[non_exhaustive]
pub struct FreshetPlugins;

impl PluginGroup for FreshetPlugins {
    fn build(self) -> PluginGroupBuilder {
        PluginGroupBuilder::start::<Self>()
            .add(FluidSimulationPlugin)
            .add(FluidCouplingPlugin::default())
            .add(FluidRenderPlugin)
    }
}
