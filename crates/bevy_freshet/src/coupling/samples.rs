//! Samples the surfaces of bodies.

use bevy::prelude::*;
use bevy_rapier3d::prelude::{RapierRigidBodyHandle, WriteRapierContext};
use bevy_rapier3d::rapier::dynamics::RigidBody;
use bevy_rapier3d::rapier::geometry::ColliderSet;
use bevy_rapier3d::rapier::math::Pose;
use freshet_core::scene::FluidScene;
use freshet_rapier::{body_from_rigid_body, quasi_fluid_from_rigid_body};

use super::fitness::Uncoupled;
use crate::components::body::{FluidBody, FluidBodySampling};
use crate::components::domain::FluidDomain;
use crate::components::layers::FluidLayers;
use crate::components::membership::FluidInDomain;
use crate::components::problem::report;
use crate::components::settings::{FluidFidelity, FluidKernel, FluidSettings};
use crate::simulation::state::BodySamples;

/// What samples depend on; they are made anew when it changes.
#[derive(Component, Clone, Debug, PartialEq)]
pub(crate) struct SampledFrom {
    sampling: FluidBodySampling,
    spacing: f32,
    fidelity: Option<FluidFidelity>,
    kernel: FluidKernel,
    pressure_kernel: Option<FluidKernel>,
    support_ratio: f32,
    /// In the body's own frame, m: samples are relative to it, and another mass of one of several colliders moves it.
    center_of_mass: Vec3,
    /// For each collider where its shape is in memory (shapes are never changed in place while shared), whether it is
    /// solid, and its pose on the body.
    colliders: Vec<(usize, bool, Option<Pose>)>,
}

impl SampledFrom {
    fn new(fluid_body: &FluidBody, body: &RigidBody, colliders: &ColliderSet, domain: &FluidDomain) -> Self {
        let colliders = body.colliders().iter().filter_map(|&handle| colliders.get(handle)).map(|collider| {
            let address = std::ptr::from_ref(collider.shape()).cast::<()>() as usize;
            (address, collider.is_enabled() && !collider.is_sensor(), collider.position_wrt_parent().copied())
        });
        let FluidSettings { fidelity, kernel, pressure_kernel, support_ratio, .. } = domain.settings;
        let (center_of_mass, colliders) = (body.local_center_of_mass(), colliders.collect());
        let sampling = fluid_body.sampling;
        let spacing = domain.spacing;
        Self { sampling, spacing, fidelity, kernel, pressure_kernel, support_ratio, center_of_mass, colliders }
    }
}

type Bodies<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        &'static RapierRigidBodyHandle,
        Option<&'static FluidInDomain>,
        Option<&'static SampledFrom>,
        Option<&'static BodySamples>,
        Option<&'static Name>,
        Option<&'static FluidLayers>,
        &'static FluidBody,
    ),
    Without<Uncoupled>,
>;

/// Samples bodies that are new or have changed; those that no fluid touches have none.
pub(crate) fn sample_bodies(
    mut commands: Commands,
    bodies: Bodies,
    stale: Query<Entity, (With<BodySamples>, Without<FluidBody>)>,
    domains: Query<(&FluidDomain, Option<&FluidLayers>)>,
    mut rapier: WriteRapierContext,
) {
    for entity in &stale {
        commands.entity(entity).try_remove::<(BodySamples, SampledFrom)>();
    }
    let Ok(mut context) = rapier.single_mut() else { return };
    for (entity, handle, member, sampled_from, samples, name, layers, fluid_body) in &bodies {
        let domain = member.map_or_else(|| domains.single().ok(), |member| domains.get(member.0).ok());
        let Some((domain, of_fluid)) = domain else { continue };
        if !layers.copied().unwrap_or_default().touches(of_fluid.copied().unwrap_or_default()) {
            if sampled_from.is_some() {
                commands.entity(entity).try_remove::<(BodySamples, SampledFrom)>();
            }
            continue;
        }
        let colliders = &context.colliders.colliders;
        let Some(body) = context.rigidbody_set.bodies.get_mut(handle.0) else { continue };
        if sampled_from == Some(&SampledFrom::new(fluid_body, body, colliders, domain)) {
            continue;
        }
        // Rapier does this in its next step; the samples are relative to the centre of mass now.
        body.recompute_mass_properties_from_colliders(colliders);
        let from = SampledFrom::new(fluid_body, body, colliders, domain);
        let name = name.map_or_else(|| format!("entity {entity}"), |name| name.to_string());
        let scene = FluidScene { settings: domain.settings.to_settings(), ..FluidScene::with_spacing(domain.spacing) };
        // What is wrong with the domain is said by the planning.
        let Ok(layer) = scene.wall_layer() else { continue };
        let sampled = match fluid_body.sampling {
            FluidBodySampling::SingleLayer => body_from_rigid_body(&name, body, colliders, &layer),
            FluidBodySampling::QuasiFluid => quasi_fluid_from_rigid_body(&name, body, colliders, &layer),
        };
        match sampled {
            Ok(body) => {
                let version = samples.map_or(0, |samples| samples.version + 1);
                commands.entity(entity).try_insert((BodySamples { body, version }, from));
            }
            Err(error) => {
                report(&mut commands, entity, "FluidBody", format!("Collider: {error}"));
                commands.entity(entity).try_remove::<BodySamples>().try_insert(from);
            }
        }
    }
}
