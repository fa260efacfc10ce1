//! Plans what can be planned: what is wrong is said and left out, so that one bad wall does not stop the fluid.

use bevy::prelude::*;
use freshet_core::error::InvalidInput;
use freshet_core::plan::{Plan, SceneError};
use freshet_core::scene::FluidScene;

use super::gather::Sources;
use super::problems::Problem;
use super::recipe::Recipe;
use super::state::DomainState;

/// Plans a recipe without what is wrong in it, which is taken out of it. None if nothing can be simulated then.
pub(crate) fn plan_without_the_wrong(
    domain: Entity,
    recipe: &mut Recipe,
    state: &mut DomainState,
    sources: &Sources,
    dealt_with: &mut Vec<(Entity, bool)>,
) -> Option<Plan> {
    loop {
        let mut scene = recipe.scene();
        scene.bodies =
            recipe.bodies.iter().filter_map(|(entity, _)| Some(sources.body(*entity)?.body.clone())).collect();
        let error = match plan(scene, state.plan.as_ref()) {
            Ok(plan) => return Some(plan),
            Err(error) => error,
        };
        let (culprit, message) = explain(&error, recipe);
        let problem = match culprit {
            Some(("volumes", index)) if index < recipe.fresh.len() => {
                let entity = recipe.fresh.remove(index).entity;
                dealt_with.push((entity, true));
                Problem::new(entity, "FluidVolume", message)
            }
            Some(("boundaries", index)) if index < recipe.walls.len() => {
                let wall = recipe.walls.remove(index);
                Problem::new(wall.entity, wall.component, message)
            }
            Some(("emitters", index)) if index < recipe.sources.len() => {
                Problem::new(recipe.sources.remove(index).entity, "FluidEmitter", message)
            }
            Some(("bodies", index)) if index < recipe.bodies.len() => {
                Problem::new(recipe.bodies.remove(index).0, "FluidBody", message)
            }
            _ => {
                state.problems.push(Problem::new(domain, "FluidDomain", message));
                return None;
            }
        };
        state.problems.push(problem);
        if state.engine.is_none() && recipe.fresh.is_empty() && recipe.sources.is_empty() {
            return None;
        }
    }
}

/// Plans a scene that holds new fluid only, beside the fluid of the plan before.
fn plan(mut scene: FluidScene, before: Option<&Plan>) -> Result<Plan, SceneError> {
    let plan = Plan::new(&scene)?;
    if let Some(before) = before
        && scene.settings.expected_speed.is_none()
        && plan.parameters.expected_speed < before.parameters.expected_speed
    {
        // The fluid that is there is as fast as it was planned to be.
        scene.settings.expected_speed = Some(before.parameters.expected_speed);
        return Plan::new(&scene);
    }
    Ok(plan)
}

/// What is at fault (a list of the scene and the place in it), and the error in the words of the components.
fn explain(error: &SceneError, recipe: &Recipe) -> (Option<(&'static str, usize)>, String) {
    match error {
        SceneError::Invalid(invalid) => {
            let (culprit, field) = locate(&invalid.field);
            let field = match (culprit, field.as_str()) {
                (Some(("boundaries", index)), "shape.half_extents")
                    if recipe.walls.get(index).is_some_and(|wall| wall.component == "FluidContainer") =>
                {
                    "half of the size".to_owned()
                }
                (Some(_), "shape.half_extents") => "shape.half_size".to_owned(),
                (_, "resolution") => "spacing".to_owned(),
                (_, "settings.max_substeps" | "settings.budget_milliseconds" | "settings.max_particles") => {
                    field.replacen("settings.", "", 1)
                }
                (_, "settings.support") => "settings.support_ratio".to_owned(),
                (_, "center" | "rotation") => format!("Transform.{field}"),
                _ => field,
            };
            (culprit, InvalidInput { field, ..invalid.clone() }.to_string())
        }
        SceneError::Overlap { second, place, .. } => {
            let message =
                format!("it overlaps another volume near {place}; allowed: particles at least half a spacing apart");
            (Some(("volumes", *second)), message)
        }
        other => (None, other.to_string()),
    }
}

/// `volumes[2].shape.radius` is at `("volumes", 2)`, and its field there is `shape.radius`.
fn locate(path: &str) -> (Option<(&'static str, usize)>, String) {
    for list in ["volumes", "boundaries", "emitters", "bodies"] {
        if let Some((index, field)) =
            path.strip_prefix(list).and_then(|rest| rest.strip_prefix('[')).and_then(|rest| rest.split_once(']'))
            && let Ok(index) = index.parse()
        {
            return (Some((list, index)), field.trim_start_matches('.').to_owned());
        }
    }
    (None, path.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_place_of_an_error() {
        assert_eq!(locate("volumes[12].shape.radius"), (Some(("volumes", 12)), "shape.radius".to_owned()));
        assert_eq!(locate("settings.support"), (None, "settings.support".to_owned()));
        assert_eq!(locate("volumes[x].shape"), (None, "volumes[x].shape".to_owned()));
    }
}
