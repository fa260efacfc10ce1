//! What the coupling needs of rapier: that it steps in the fixed schedule, and that bodies are in its default context.

use bevy::ecs::schedule::NodeId;
use bevy::prelude::*;
use bevy_rapier3d::plugin::PhysicsSet;
use bevy_rapier3d::prelude::{DefaultRapierContext, RapierContextEntityLink};

use super::samples::SampledFrom;
use crate::components::body::FluidBody;
use crate::components::problem::report;
use crate::simulation::state::BodySamples;

/// The schedules in which rapier steps.
#[derive(Resource, Default)]
pub(crate) struct StepsIn(Vec<String>);

impl StepsIn {
    /// Looks for rapier's step in all schedules.
    pub(crate) fn of(schedules: &Schedules) -> Self {
        let steps = schedules.iter().filter(|(_, schedule)| {
            let graph = schedule.graph();
            let set = graph.system_sets.get_key(PhysicsSet::StepSimulation.intern());
            // The plugin orders itself around the set, so it is known to the fixed schedule even if nothing is in it.
            set.is_some_and(|set| graph.hierarchy().neighbors(NodeId::Set(set)).next().is_some())
        });
        Self(steps.map(|(label, _)| format!("{label:?}")).collect())
    }

    fn problem(&self) -> Option<String> {
        let fixed = format!("{FixedUpdate:?}");
        let found = match self.0.as_slice() {
            [only] if *only == fixed => return None,
            [] => "no schedule".to_owned(),
            names => names.join(" and "),
        };
        Some(format!(
            "RapierPhysicsPlugin: {found} is not allowed; allowed: {fixed}, by RapierPhysicsPlugin::<NoUserData>::default()\
             .in_fixed_schedule()"
        ))
    }
}

/// On a body that cannot be coupled.
#[derive(Component)]
pub(crate) struct Uncoupled;

type Bodies<'w, 's> =
    Query<'w, 's, (Entity, Option<&'static RapierContextEntityLink>, Has<Uncoupled>), With<FluidBody>>;

/// Takes bodies out of the fluid as long as they cannot be coupled. What is wrong with all of them is said once.
pub(crate) fn uncouple_bodies(
    mut commands: Commands,
    bodies: Bodies,
    contexts: Query<Entity, With<DefaultRapierContext>>,
    steps_in: Res<StepsIn>,
    mut said: Local<Option<String>>,
) {
    let count = contexts.iter().len();
    let of_all = steps_in.problem().or_else(|| {
        let message = || format!("DefaultRapierContext: {count} of them is not allowed; allowed: one");
        (count != 1).then(message)
    });
    if of_all.is_none() {
        *said = None;
    }
    let default = contexts.single().ok();
    for (entity, link, is_uncoupled) in &bodies {
        let is_elsewhere = link.is_some_and(|link| default.is_some_and(|default| link.0 != default));
        let problem = match (&of_all, link) {
            (Some(problem), _) if said.as_ref() != Some(problem) => {
                *said = Some(problem.clone());
                of_all.clone()
            }
            (None, Some(link)) if is_elsewhere && !is_uncoupled => Some(format!(
                "RapierContextEntityLink: {} is not allowed; allowed: the entity with DefaultRapierContext",
                link.0
            )),
            _ => None,
        };
        if let Some(problem) = problem {
            report(&mut commands, entity, "FluidBody", problem);
        }
        match (of_all.is_some() || is_elsewhere, is_uncoupled) {
            (true, false) => {
                commands.entity(entity).try_insert(Uncoupled).try_remove::<(BodySamples, SampledFrom)>();
            }
            (false, true) => {
                commands.entity(entity).try_remove::<Uncoupled>();
            }
            _ => {}
        }
    }
}
