//! Rapier: its place in the schedule, walls as colliders, bodies that the fluid pushes and that push it.

mod contacts;
mod exchange;
mod fitness;
mod frames;
mod samples;
mod walls;

use bevy::ecs::message::Messages;
use bevy::prelude::*;
use bevy_rapier3d::plugin::{NoUserData, PhysicsSet, RapierPhysicsPlugin, TimestepMode};
use bevy_rapier3d::prelude::{CollisionEvent, DefaultRapierContext, RapierConfiguration};

use crate::components::domain::FluidDomain;
use crate::simulation::sets::FreshetSystems;
use crate::simulation::state::DefaultGravity;

/// Couples fluids with rapier, in the fixed schedule.
///
/// Adds rapier there with a fixed time step, if the app has not added it before. An app that adds its own must do so
/// `in_fixed_schedule()`, or a [`FluidProblem`](crate::components::problem::FluidProblem) says so and bodies and fluid pass
/// through each other; and should do so with `TimestepMode::Fixed`, or they keep different times. Bodies must be in
/// rapier's default context.
pub struct FluidCouplingPlugin {
    /// Whether rapier is added if it is missing.
    pub adds_rapier: bool,
}

impl Default for FluidCouplingPlugin {
    fn default() -> Self {
        Self { adds_rapier: true }
    }
}

impl Plugin for FluidCouplingPlugin {
    fn build(&self, app: &mut App) {
        // Rapier's plugin is another type for each kind of hooks, but makes the same resources.
        if self.adds_rapier && !app.world().contains_resource::<Messages<CollisionEvent>>() {
            if !app.world().contains_resource::<TimestepMode>() {
                let dt = Time::<Fixed>::default().timestep().as_secs_f32();
                // Rapier looks for it when it is added.
                app.insert_resource(TimestepMode::Fixed { dt, substeps: 1 });
            }
            app.add_plugins(RapierPhysicsPlugin::<NoUserData>::default().in_fixed_schedule())
                // Rapier reads it in its step; a system of the app may have changed the fixed time step before.
                .add_systems(FixedUpdate, follow_the_fixed_step.before(PhysicsSet::SyncBackend));
        }
        app.init_resource::<fitness::StepsIn>()
            .register_required_components::<FluidDomain, exchange::DomainCoupling>()
            .add_observer(walls::remove_collider)
            .add_systems(
                FixedUpdate,
                (
                    // Rapier's SyncBackend makes colliders of what is inserted here.
                    walls::make_colliders.before(PhysicsSet::SyncBackend),
                    // Bodies are in rapier's sets after its SyncBackend, and planning needs their samples.
                    (follow_gravity, (fitness::uncouple_bodies, samples::sample_bodies).chain())
                        .after(PhysicsSet::SyncBackend)
                        .before(FreshetSystems::Plan),
                    exchange::begin_tick.in_set(FreshetSystems::Prepare),
                    exchange::apply_forecast.in_set(FreshetSystems::Apply),
                    exchange::complete.in_set(FreshetSystems::Complete),
                ),
            );
    }

    fn finish(&self, app: &mut App) {
        let steps_in = fitness::StepsIn::of(app.world().resource::<Schedules>());
        app.insert_resource(steps_in);
    }
}

fn follow_the_fixed_step(time: Res<Time>, mut mode: ResMut<TimestepMode>) {
    let TimestepMode::Fixed { dt, .. } = *mode else { return };
    if dt != time.delta_secs()
        && let TimestepMode::Fixed { dt, .. } = &mut *mode
    {
        *dt = time.delta_secs();
    }
}

fn follow_gravity(
    rapier: Query<&RapierConfiguration, With<DefaultRapierContext>>,
    mut gravity: ResMut<DefaultGravity>,
) {
    if let Ok(configuration) = rapier.single()
        && gravity.0 != configuration.gravity
    {
        gravity.0 = configuration.gravity;
    }
}
