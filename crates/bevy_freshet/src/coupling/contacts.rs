//! Tells the app what the fluid does to bodies.

use bevy::prelude::*;
use freshet_core::step::Impulse;

use crate::components::contact::{FluidContact, FluidEntered, FluidLeft};
use crate::simulation::state::BodySamples;

pub(crate) type Contacts<'w, 's> = Query<'w, 's, (Entity, &'static mut FluidContact, Option<&'static BodySamples>)>;

/// Takes what the fluid did to a body within `simulated` seconds: an impulse in world axes, and how many samples it reaches.
pub(crate) fn take(
    commands: &mut Commands,
    contacts: &mut Contacts,
    body: Entity,
    impulse: Impulse,
    wetted: u32,
    simulated: f32,
) {
    let Ok((_, contact, sampled)) = contacts.get_mut(body) else { return };
    let samples = sampled.map_or(0, |sampled| sampled.body.samples.len() as u32);
    // The tick may have been that of other samples.
    let wetted = wetted.min(samples);
    let submerged = if samples > 0 { wetted as f32 / samples as f32 } else { 0.0 };
    let mean = |sum: Vec3| if simulated > 0.0 { sum / simulated } else { Vec3::ZERO };
    let least = if contact.in_fluid { FluidContact::LEAVES } else { FluidContact::ENTERS };
    let now = FluidContact {
        force: mean(impulse.linear),
        torque: mean(impulse.angular),
        submerged,
        wetted,
        samples,
        in_fluid: submerged >= least,
    };
    put(commands, body, contact, now);
}

/// Nothing touches bodies that are in no fluid.
pub(crate) fn release(commands: &mut Commands, contacts: &mut Contacts, is_coupled: impl Fn(Entity) -> bool) {
    for (body, contact, _) in contacts.iter_mut().filter(|(body, ..)| !is_coupled(*body)) {
        put(commands, body, contact, FluidContact::default());
    }
}

fn put(commands: &mut Commands, body: Entity, mut contact: Mut<FluidContact>, now: FluidContact) {
    match (contact.in_fluid, now.in_fluid) {
        (false, true) => commands.trigger(FluidEntered { entity: body }),
        (true, false) => commands.trigger(FluidLeft { entity: body }),
        _ => {}
    }
    contact.set_if_neq(now);
}
