//! Momentum between fluid and bodies: forecast and corrected when pipelined, exact in lockstep. Only through rapier's body
//! interface: `ExternalForce` and `ExternalImpulse` belong to the user.

use std::collections::HashMap;

use bevy::prelude::*;
use bevy_rapier3d::plugin::context::systemparams::RapierContextMut;
use bevy_rapier3d::prelude::{DefaultRapierContext, RapierConfiguration, RapierRigidBodyHandle, WriteRapierContext};
use bevy_rapier3d::rapier::dynamics::IntegrationParameters;
use freshet_core::step::BodyInput;
use freshet_rapier::{BodyCoupling, CouplingError, RapierView};

use super::contacts::{self, Contacts};
use super::frames::{to_domain, to_world};
use crate::components::problem::report;
use crate::simulation::state::DomainState;

/// The exchange of each body of a domain.
#[derive(Component, Default)]
pub(crate) struct DomainCoupling {
    bodies: HashMap<Entity, BodyCoupling>,
}

/// Corrects bodies for what is known, and says how they are at the start of the tick.
pub(crate) fn begin_tick(
    mut commands: Commands,
    time: Res<Time>,
    mut domains: Query<(&mut DomainState, &mut DomainCoupling)>,
    handles: Query<&RapierRigidBodyHandle>,
    configuration: Query<&RapierConfiguration, With<DefaultRapierContext>>,
    mut contacts: Contacts,
    mut rapier: WriteRapierContext,
) {
    let (Ok(mut context), Ok(configuration)) = (rapier.single_mut(), configuration.single()) else {
        // Bodies begin anew when there is one context again: they cannot make up for the ticks they miss.
        for (mut state, mut coupling) in &mut domains {
            state.pushes.clear();
            coupling.bodies.clear();
        }
        contacts::release(&mut commands, &mut contacts, |_| false);
        return;
    };
    for (mut state, mut coupling) in &mut domains {
        receive(&mut commands, &mut state, &mut coupling, &mut context, &mut contacts);
        if !state.runs() {
            coupling.bodies.clear();
            continue;
        }
        let state = &mut *state;
        coupling.bodies.retain(|entity, _| state.body_entities.contains(entity));
        let parameters = IntegrationParameters { dt: time.delta_secs(), ..context.simulation.integration_parameters };
        let view = RapierView {
            bodies: &context.rigidbody_set.bodies,
            narrow_phase: &context.simulation.narrow_phase,
            impulse_joints: &context.joints.impulse_joints,
            multibody_joints: &context.joints.multibody_joints,
            parameters: &parameters,
            gravity: configuration.gravity,
        };
        state.body_inputs.clear();
        for &entity in &state.body_entities {
            let mut begin = || -> Option<Result<BodyInput, CouplingError>> {
                let handle = handles.get(entity).ok()?.0;
                let body = coupling.bodies.entry(entity).or_insert_with(|| BodyCoupling::new(handle, state.tick));
                if body.handle() != handle {
                    *body = BodyCoupling::new(handle, state.tick);
                }
                Some(body.begin_tick(state.tick, &view))
            };
            let input = match begin() {
                Some(Ok(input)) => to_domain(input, state.frame),
                Some(Err(error)) => {
                    fail(&mut commands, entity, error);
                    coupling.bodies.remove(&entity);
                    BodyInput::default()
                }
                None => BodyInput::default(),
            };
            state.body_inputs.push(input);
        }
    }
    let is_coupled = |body| domains.iter().any(|(_, coupling)| coupling.bodies.contains_key(&body));
    contacts::release(&mut commands, &mut contacts, is_coupled);
}

/// In lockstep, takes the tick's own impulses. Then rapier is told.
pub(crate) fn apply_forecast(
    mut commands: Commands,
    mut domains: Query<(&mut DomainState, &mut DomainCoupling)>,
    mut contacts: Contacts,
    mut rapier: WriteRapierContext,
) {
    let Ok(mut context) = rapier.single_mut() else { return };
    for (mut state, mut coupling) in &mut domains {
        receive(&mut commands, &mut state, &mut coupling, &mut context, &mut contacts);
        drive(&mut commands, &mut coupling, &mut context, BodyCoupling::apply_forecast);
    }
}

/// After rapier's step, the rest.
pub(crate) fn complete(
    mut commands: Commands,
    mut couplings: Query<&mut DomainCoupling>,
    mut rapier: WriteRapierContext,
) {
    let Ok(mut context) = rapier.single_mut() else { return };
    for mut coupling in &mut couplings {
        drive(&mut commands, &mut coupling, &mut context, BodyCoupling::complete);
    }
}

fn receive(
    commands: &mut Commands,
    state: &mut DomainState,
    coupling: &mut DomainCoupling,
    context: &mut RapierContextMut,
    contacts: &mut Contacts,
) {
    let frame = state.frame;
    for pushes in state.pushes.drain(..) {
        for push in pushes.bodies {
            let Some(body) = coupling.bodies.get_mut(&push.body) else { continue };
            let impulse = to_world(push.impulse, frame);
            if let Err(error) = body.receive(pushes.tick, impulse, &mut context.rigidbody_set.bodies) {
                fail(commands, push.body, error);
                coupling.bodies.remove(&push.body);
                continue;
            }
            contacts::take(commands, contacts, push.body, impulse, push.wetted, pushes.simulated);
        }
    }
}

/// Calls all bodies; one that fails begins anew in the next tick.
fn drive(
    commands: &mut Commands,
    coupling: &mut DomainCoupling,
    context: &mut RapierContextMut,
    call: fn(&mut BodyCoupling, &mut bevy_rapier3d::rapier::dynamics::RigidBodySet) -> Result<(), CouplingError>,
) {
    let bodies = &mut context.rigidbody_set.bodies;
    coupling.bodies.retain(|&entity, body| match call(body, bodies) {
        Ok(()) => true,
        Err(error) => {
            fail(commands, entity, error);
            false
        }
    });
}

fn fail(commands: &mut Commands, entity: Entity, error: CouplingError) {
    // A body may be despawned while impulses are under way; that is no error.
    if !matches!(error, CouplingError::NoSuchBody(_)) {
        report(commands, entity, "FluidBody", error);
    }
}
