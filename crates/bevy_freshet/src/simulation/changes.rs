//! Notices whether anything a recipe is made of was touched: components are read again only then.

use bevy::ecs::change_detection::Tick;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use super::backend::Hardware;
use super::pours::Poured;
use super::state::{BodySamples, DefaultGravity, DomainState};
use super::walls::WallShapes;
use crate::components::boundary::FluidBoundary;
use crate::components::container::FluidContainer;
use crate::components::domain::FluidDomain;
use crate::components::emitter::FluidEmitter;
use crate::components::material::Fluid;
use crate::components::membership::FluidInDomain;
use crate::components::volume::FluidVolume;

type Member = Option<Ref<'static, FluidInDomain>>;

/// An entity, and when its components were written last; none where it has no such component.
type Stamp = (Entity, [Option<Tick>; 4]);

/// What was written when, of everything that [`Sources`](super::gather::Sources) reads. Two equal lists of stamps mean that
/// nothing was spawned, despawned, changed, added, removed, moved or given another parent between them.
#[derive(SystemParam)]
pub(crate) struct Stamps<'w, 's> {
    domains: Query<'w, 's, (Entity, Ref<'static, FluidDomain>)>,
    volumes:
        Query<'w, 's, (Entity, Ref<'static, FluidVolume>, Ref<'static, Fluid>, Member, Option<Ref<'static, Poured>>)>,
    emitters: Query<'w, 's, (Entity, Ref<'static, FluidEmitter>, Ref<'static, Fluid>, Member)>,
    containers: Query<'w, 's, (Entity, Ref<'static, FluidContainer>, Member)>,
    boundaries: Query<'w, 's, (Entity, Ref<'static, FluidBoundary>, Member)>,
    bodies: Query<'w, 's, (Entity, Ref<'static, BodySamples>, Member)>,
    poses: Query<'w, 's, (Ref<'static, Transform>, Option<&'static ChildOf>)>,
}

impl Stamps<'_, '_> {
    /// Adds the stamps of this moment.
    fn collect(&self, stamps: &mut Vec<Stamp>) {
        for (entity, domain) in &self.domains {
            stamps.push((entity, [at(&domain), None, None, None]));
            self.collect_poses(entity, stamps);
        }
        for (entity, volume, fluid, member, poured) in &self.volumes {
            stamps.push((entity, [at(&volume), at(&fluid), maybe_at(&member), maybe_at(&poured)]));
            self.collect_poses(entity, stamps);
        }
        for (entity, emitter, fluid, member) in &self.emitters {
            stamps.push((entity, [at(&emitter), at(&fluid), maybe_at(&member), None]));
            self.collect_poses(entity, stamps);
        }
        for (entity, container, member) in &self.containers {
            stamps.push((entity, [at(&container), maybe_at(&member), None, None]));
            self.collect_poses(entity, stamps);
        }
        for (entity, boundary, member) in &self.boundaries {
            stamps.push((entity, [at(&boundary), maybe_at(&member), None, None]));
            self.collect_poses(entity, stamps);
        }
        // Where bodies are is not in a recipe.
        for (entity, samples, member) in &self.bodies {
            stamps.push((entity, [at(&samples), maybe_at(&member), None, None]));
        }
    }

    /// Of an entity and its ancestors.
    fn collect_poses(&self, entity: Entity, stamps: &mut Vec<Stamp>) {
        let mut next = Some(entity);
        while let Some(entity) = next {
            let pose = self.poses.get(entity).ok();
            stamps.push((entity, [pose.as_ref().and_then(|(pose, _)| at(pose)), None, None, None]));
            next = pose.and_then(|(_, child)| child).map(ChildOf::parent);
        }
    }
}

fn at<T>(component: &Ref<T>) -> Option<Tick> {
    Some(component.last_changed())
}

fn maybe_at<T>(component: &Option<Ref<T>>) -> Option<Tick> {
    component.as_ref().and_then(at)
}

/// Run condition: whether recipes may differ from those of the last tick.
pub(crate) fn is_anything_touched(
    stamps: Stamps,
    states: Query<&DomainState>,
    gravity: Res<DefaultGravity>,
    hardware: Hardware,
    shapes: Res<WallShapes>,
    mut before: Local<Vec<Stamp>>,
    mut now: Local<Vec<Stamp>>,
) -> bool {
    std::mem::swap(&mut *before, &mut *now);
    now.clear();
    stamps.collect(&mut now);
    *before != *now
        || gravity.is_changed()
        || hardware.is_changed()
        || shapes.has_news()
        || states.iter().any(|state| state.has_unsaid_problems)
}

#[cfg(test)]
mod tests {
    use bevy::ecs::entity_disabling::Disabled;
    use bevy::time::TimeUpdateStrategy;

    use super::super::FluidSimulationPlugin;
    use super::super::problems::Problems;
    use super::*;

    /// A tank of water as a server has it, and a wall whose parent is `parent`.
    struct Scene {
        app: App,
        domain: Entity,
        parent: Entity,
        wall: Entity,
        water: Entity,
    }

    impl Scene {
        fn new() -> Self {
            let mut app = App::new();
            app.add_plugins((MinimalPlugins, FluidSimulationPlugin));
            app.insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
            let world = app.world_mut();
            let domain = world.spawn(FluidDomain::with_spacing(0.1)).id();
            world.spawn((FluidContainer::open_box(1.0, 1.0, 0.5), Transform::from_xyz(0.5, 0.5, 0.25)));
            let water =
                world.spawn((FluidVolume::from(Cuboid::new(0.3, 0.3, 0.5)), Transform::from_xyz(0.15, 0.15, 0.25)));
            let water = water.id();
            let parent = world.spawn(Transform::from_xyz(0.8, 0.0, 0.25)).id();
            let wall = world.spawn((FluidBoundary::cuboid(0.1, 0.5, 0.5), ChildOf(parent))).id();
            let mut scene = Self { app, domain, parent, wall, water };
            assert!(scene.plannings(4) > 0);
            scene
        }

        /// In how many of so many ticks components were read and planned: then, and only then, problems are brought up to date.
        fn plannings(&mut self, ticks: u32) -> u32 {
            let updated =
                |app: &App| app.world().get_resource_ref::<Problems>().map(|problems| problems.last_changed());
            let mut count = 0;
            for _ in 0..ticks {
                let before = updated(&self.app);
                self.app.update();
                count += u32::from(updated(&self.app) != before);
            }
            count
        }

        /// Something is planned after the change, and nothing any more soon after.
        fn is_planned_after(&mut self, what: &str, change: impl FnOnce(&mut World, &[Entity; 4])) {
            let entities = [self.domain, self.parent, self.wall, self.water];
            change(self.app.world_mut(), &entities);
            assert_eq!(self.plannings(1), 1, "{what} goes unnoticed");
            self.plannings(2);
            assert_eq!(self.plannings(3), 0, "{what} is planned again and again");
        }
    }

    #[test]
    fn a_still_scene_is_not_planned() {
        let mut scene = Scene::new();
        assert_eq!(scene.plannings(8), 0);
        // What is no fluid may move.
        let other = scene.app.world_mut().spawn(Transform::default()).id();
        for _ in 0..4 {
            scene.app.world_mut().entity_mut(other).insert(Transform::from_xyz(1.0, 2.0, 3.0));
            assert_eq!(scene.plannings(1), 0);
        }
    }

    #[test]
    fn whatever_is_touched_is_planned_in_the_next_tick() {
        let mut scene = Scene::new();
        scene.is_planned_after("a wall that moves", |world, [_, _, wall, _]| {
            world.entity_mut(*wall).insert(Transform::from_xyz(0.05, 0.0, 0.0));
        });
        scene.is_planned_after("a parent that moves", |world, [_, parent, ..]| {
            world.entity_mut(*parent).insert(Transform::from_xyz(0.75, 0.0, 0.25));
        });
        scene.is_planned_after("a wall that leaves its parent", |world, [_, _, wall, _]| {
            world.entity_mut(*wall).remove::<ChildOf>();
        });
        scene.is_planned_after("a wall of another shape", |world, [_, _, wall, _]| {
            world.entity_mut(*wall).insert(FluidBoundary::cuboid(0.1, 0.4, 0.5));
        });
        scene.is_planned_after("a wall that joins a domain", |world, [domain, _, wall, _]| {
            world.entity_mut(*wall).insert(FluidInDomain(*domain));
        });
        scene.is_planned_after("a wall that leaves a domain", |world, [_, _, wall, _]| {
            world.entity_mut(*wall).remove::<FluidInDomain>();
        });
        scene.is_planned_after("a wall that is disabled", |world, [_, _, wall, _]| {
            world.entity_mut(*wall).insert(Disabled);
        });
        scene.is_planned_after("a wall that is enabled", |world, [_, _, wall, _]| {
            world.entity_mut(*wall).remove::<Disabled>();
        });
        scene.is_planned_after("a wall that is despawned", |world, [_, _, wall, _]| {
            world.despawn(*wall);
        });
        scene.is_planned_after("another fluid", |world, [.., water]| {
            world.entity_mut(*water).insert(Fluid::oil());
        });
        scene.is_planned_after("another setting", |world, [domain, ..]| {
            world.get_mut::<FluidDomain>(*domain).unwrap().max_substeps = 500;
        });
        scene.is_planned_after("a domain that moves", |world, [domain, ..]| {
            world.entity_mut(*domain).insert(Transform::from_xyz(1.0, 0.0, 0.0));
        });
        scene.is_planned_after("another gravity", |world, _| {
            world.resource_mut::<DefaultGravity>().0 = Vec3::NEG_Y;
        });
        scene.is_planned_after("water that is despawned", |world, [.., water]| {
            world.despawn(*water);
        });
        scene.is_planned_after("new water", |world, _| {
            world.spawn((FluidVolume::from(Sphere::new(0.2)), Transform::from_xyz(0.5, 0.8, 0.25)));
        });
        scene.is_planned_after("a jet", |world, _| {
            world.spawn((FluidEmitter::disc(0.1, 1.0, 1.0), Transform::from_xyz(0.5, 0.8, 0.25)));
        });
    }
}
