//! Plans what can be planned: what is wrong is said and left out, so that one bad wall does not stop the fluid.

use bevy::prelude::*;
use freshet_core::error::InvalidInput;
use freshet_core::plan::{Plan, SceneError};
use freshet_core::scene::{Body, FluidScene};

use super::gather::Sources;
use super::movers::MoverBodies;
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
        let wrong = add_movers(&mut scene, recipe, &mut state.mover_bodies);
        if !wrong.is_empty() {
            state.problems.extend(wrong);
            continue;
        }
        let bodies = scene.bodies.len() - recipe.movers.len();
        let error = match plan(scene, state.plan.as_ref()) {
            Ok(mut plan) => {
                state.mover_bodies.keep(&recipe.movers);
                give_room_to_movers(&mut plan, recipe, &mut state.mover_bodies);
                return Some(plan);
            }
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
            Some(("bodies", index)) if (bodies..bodies + recipe.movers.len()).contains(&index) => {
                let mover = recipe.movers.remove(index - bodies);
                Problem::new(mover.entity, mover.component, message)
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

/// Adds walls that move to a scene's bodies. What is wrong with one takes it out of the recipe, and is returned.
fn add_movers(scene: &mut FluidScene, recipe: &mut Recipe, bodies: &mut MoverBodies) -> Vec<Problem> {
    // What is wrong with the scene is said by the planning, without them.
    let Ok(layer) = scene.wall_layer() else {
        scene.bodies.extend(recipe.movers.iter().map(|_| Body::default()));
        return Vec::new();
    };
    let mut wrong = Vec::new();
    recipe.movers.retain(|mover| match bodies.body(mover, &layer) {
        Ok(body) => {
            scene.bodies.push(body);
            true
        }
        Err(error) => {
            let error = InvalidInput { field: in_words(&error.field, mover.component), ..error };
            wrong.push(Problem::new(mover.entity, mover.component, error));
            false
        }
    });
    wrong
}

/// The bounds are around walls that move, too, unless they are given: where a plan's bodies are is not known to it.
fn give_room_to_movers(plan: &mut Plan, recipe: &Recipe, bodies: &mut MoverBodies) {
    let layer = plan.parameters.wall_layer().ok();
    let (None, Some(layer)) = (recipe.settings.bounds, layer) else { return };
    for mover in &recipe.movers {
        let Ok(body) = bodies.body(mover, &layer) else { continue };
        let (low, high) = mover.extent(&body);
        // As a plan does for fluid and walls.
        let reach = 4.0 * (high - low).length();
        plan.parameters.bounds_min = plan.parameters.bounds_min.min(low - reach);
        plan.parameters.bounds_max = plan.parameters.bounds_max.max(high + reach);
    }
}

/// Plans a scene that holds new fluid only, beside the fluid of the plan before.
fn plan(mut scene: FluidScene, before: Option<&Plan>) -> Result<Plan, SceneError> {
    if before.is_some() && !scene.bodies.is_empty() {
        // Fluid that runs has settled; without this a wall could not begin to move.
        scene.settings.relaxation = None;
    }
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
            let component = match culprit {
                Some(("boundaries", index)) => recipe.walls.get(index).map_or("", |wall| wall.component),
                _ => "",
            };
            let field = match (culprit, field.as_str()) {
                (Some(_), size) if size.starts_with("shape.half_extents") => in_words(size, component),
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

/// A field of the model in the words of a component.
fn in_words(field: &str, component: &str) -> String {
    let size = if component == "FluidContainer" { "half of the size" } else { "shape.half_size" };
    field.replacen("shape.half_extents", size, 1)
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
