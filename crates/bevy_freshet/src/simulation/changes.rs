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
    /// Adds the stamps of this moment. Where bodies and walls that move are is not in a recipe.
    fn collect(&self, stamps: &mut Vec<Stamp>, moves: impl Fn(Entity) -> bool) {
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
            if !moves(entity) {
                self.collect_poses(entity, stamps);
            }
        }
        for (entity, boundary, member) in &self.boundaries {
            stamps.push((entity, [at(&boundary), maybe_at(&member), None, None]));
            if !moves(entity) {
                self.collect_poses(entity, stamps);
            }
        }
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
    stamps
        .collect(&mut now, |entity| states.iter().any(|state| state.movers.iter().any(|mover| mover.entity == entity)));
    *before != *now
        || gravity.is_changed()
        || hardware.is_changed()
        || shapes.has_news()
        || states.iter().any(|state| state.has_unsaid_problems || state.asks_for_planning)
}

#[cfg(test)]
mod tests {
    use bevy::ecs::entity_disabling::Disabled;
    use bevy::time::TimeUpdateStrategy;

    use super::super::FluidSimulationPlugin;
    use super::super::problems::{Problem, Problems};
    use super::*;
    use crate::components::boundary_mesh::FluidMesh;
    use crate::components::stats::FluidStats;
    use crate::components::wall::FluidWallMotion;

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
            Self::with(|_| {})
        }

        /// The same with something done after Bevy's plugins and before Freshet's.
        fn with(change: impl FnOnce(&mut App)) -> Self {
            let mut app = App::new();
            app.add_plugins(MinimalPlugins);
            change(&mut app);
            app.add_plugins(FluidSimulationPlugin);
            app.insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
            let world = app.world_mut();
            let domain = world.spawn(FluidDomain::with_spacing(0.1)).id();
            world.spawn((FluidContainer::open_box(1.0, 1.0, 0.5), Transform::from_xyz(0.5, 0.5, 0.25)));
            let water =
                world.spawn((FluidVolume::from(Cuboid::new(0.3, 0.3, 0.5)), Transform::from_xyz(0.15, 0.15, 0.25)));
            let water = water.id();
            let parent = world.spawn(Transform::from_xyz(0.8, 0.0, 0.25)).id();
            let wall = world.spawn((still(FluidBoundary::cuboid(0.1, 0.5, 0.5)), ChildOf(parent))).id();
            let mut scene = Self { app, domain, parent, wall, water };
            assert!(scene.plannings(4) > 0);
            scene
        }

        /// How many shapes have been made of meshes so far.
        fn conversions(&self) -> u32 {
            self.app.world().resource::<WallShapes>().conversions()
        }

        /// What is wrong at the moment.
        fn problems(&self) -> Vec<Problem> {
            self.app.world().resource::<Problems>().current().to_vec()
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

    /// One that is planned anew whenever it changes.
    fn still(boundary: FluidBoundary) -> FluidBoundary {
        FluidBoundary { motion: FluidWallMotion::Still, ..boundary }
    }

    /// A box somewhat off the tank's walls.
    fn block() -> Mesh {
        Cuboid::new(0.1, 0.5, 0.3).into()
    }

    #[test]
    fn a_mesh_is_made_into_a_wall_once_and_again_when_it_changes() {
        let mut scene = Scene::with(|app| {
            app.add_plugins(AssetPlugin::default()).init_asset::<Mesh>();
        });
        let add = |scene: &mut Scene, mesh: Mesh| scene.app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh);
        let mesh = add(&mut scene, block());
        // What is no wall may come and change.
        let other = add(&mut scene, block());
        let wall = scene.wall;
        let at = Transform::from_xyz(0.0, 0.3, 0.0);
        scene.app.world_mut().entity_mut(wall).insert((still(FluidBoundary::mesh(mesh.clone())), at));
        assert_eq!(scene.plannings(1), 1);
        // It was made before its event came, and is looked at once more then.
        scene.plannings(4);
        let begin = scene.conversions();
        assert!((1..=2).contains(&begin), "{begin}");
        let is_still = |scene: &mut Scene| assert_eq!(scene.plannings(4), 0);
        is_still(&mut scene);
        scene.app.world_mut().resource_mut::<Assets<Mesh>>().get_mut(&other).unwrap().translate_by(Vec3::X);
        add(&mut scene, block());
        is_still(&mut scene);
        assert_eq!(scene.conversions(), begin);

        // Something else is touched; the wall moves; others are made of the same mesh.
        scene.is_planned_after("another setting", |world, [domain, ..]| {
            world.get_mut::<FluidDomain>(*domain).unwrap().max_substeps = 500;
        });
        scene.is_planned_after("a wall that turns", |world, [_, parent, ..]| {
            let turned = Quat::from_euler(EulerRot::XYZ, 0.1, 0.2, 0.3);
            world.entity_mut(*parent).insert(Transform::from_xyz(0.8, 0.0, 0.25).with_rotation(turned));
        });
        scene.is_planned_after("a second wall", |world, [_, parent, ..]| {
            let beside = Transform::from_xyz(0.0, 0.9, 0.0);
            world.spawn((FluidBoundary::mesh(mesh.clone()), beside, ChildOf(*parent)));
        });
        assert_eq!(scene.conversions(), begin);

        scene.is_planned_after("a wall that grows", |world, [_, _, wall, _]| {
            world.entity_mut(*wall).insert(at.with_scale(Vec3::new(1.0, 0.9, 1.1)));
        });
        assert_eq!(scene.conversions(), begin + 1);
        scene.is_planned_after("a hull", |world, [_, _, wall, _]| {
            world.entity_mut(*wall).insert((still(FluidBoundary::convex_hull(mesh.clone())), at));
        });
        assert_eq!(scene.conversions(), begin + 2);

        // One mesh, two walls of it: a mesh and a hull. The event comes in the tick after.
        scene.app.world_mut().resource_mut::<Assets<Mesh>>().get_mut(&mesh).unwrap().translate_by(0.01 * Vec3::Y);
        assert!(scene.plannings(2) > 0, "a mesh that changes goes unnoticed");
        scene.plannings(2);
        assert_eq!(scene.conversions(), begin + 4);
        is_still(&mut scene);

        // One that is not there yet: the domain is not planned while it waits, and is when it comes.
        let domain = scene.domain;
        let stats = |scene: &Scene| scene.app.world().get::<FluidStats>(domain).unwrap().clone();
        let late = scene.app.world_mut().resource_mut::<Assets<Mesh>>().reserve_handle();
        scene.is_planned_after("a wall that is not there yet", |world, [_, _, wall, _]| {
            world.entity_mut(*wall).insert(still(FluidBoundary::mesh(late.clone())));
        });
        let waiting = stats(&scene);
        assert_eq!(waiting.waiting_for, [wall]);
        is_still(&mut scene);
        assert_eq!((stats(&scene).ticks, scene.conversions()), (waiting.ticks, begin + 4));
        scene.app.world_mut().resource_mut::<Assets<Mesh>>().insert(&late, block()).unwrap();
        assert!(scene.plannings(2) > 0, "a mesh that comes goes unnoticed");
        is_still(&mut scene);
        assert!(stats(&scene).waiting_for.is_empty() && stats(&scene).ticks > waiting.ticks);
        assert_eq!(scene.conversions(), begin + 5);

        // What has gone leaves the wall.
        scene.app.world_mut().resource_mut::<Assets<Mesh>>().remove(&mesh);
        scene.app.world_mut().resource_mut::<Assets<Mesh>>().remove(&late);
        is_still(&mut scene);
        scene.is_planned_after("another setting", |world, [domain, ..]| {
            world.get_mut::<FluidDomain>(*domain).unwrap().max_substeps = 400;
        });
        assert!(stats(&scene).waiting_for.is_empty());
        assert_eq!(scene.conversions(), begin + 5);
        assert!(scene.problems().is_empty(), "{:?}", scene.problems());
    }

    #[test]
    fn a_server_without_assets_has_walls_of_triangles_and_heights() {
        let mut scene = Scene::new();
        let triangles = |height| FluidMesh::Triangles {
            vertices: vec![Vec3::ZERO, Vec3::X, Vec3::Z, Vec3::new(0.3, height, 0.3)],
            triangles: vec![[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]],
        };
        let begin = scene.conversions();
        assert_eq!(begin, 0);
        for (count, boundary) in (1..).zip([
            FluidBoundary::mesh(triangles(0.5)),
            FluidBoundary::mesh(triangles(0.4)),
            FluidBoundary::convex_hull(triangles(0.5)),
            FluidBoundary::height_field(Vec2::ONE, UVec2::splat(2), vec![0.0, 0.1, 0.1, 0.2]),
        ]) {
            scene.is_planned_after("another wall", |world, [_, _, wall, _]| {
                world.entity_mut(*wall).insert((still(boundary), Transform::from_xyz(-0.2, 0.0, 0.0)));
            });
            assert_eq!(scene.conversions(), count);
            scene.is_planned_after("another gravity", |world, _| {
                world.resource_mut::<DefaultGravity>().0.y -= 0.1;
            });
            assert_eq!(scene.conversions(), count);
            assert!(scene.problems().is_empty(), "{:?}", scene.problems());
        }
        let (wall, domain) = (scene.wall, scene.domain);
        let ticks = |scene: &Scene| scene.app.world().get::<FluidStats>(domain).unwrap().ticks;
        scene.app.world_mut().entity_mut(wall).insert(FluidBoundary::mesh(Handle::default()));
        let before = ticks(&scene);
        scene.plannings(8);
        let problems = scene.problems();
        assert_eq!(problems.len(), 1, "{problems:?}");
        assert_eq!((problems[0].entity, problems[0].component), (wall, "FluidBoundary"));
        assert!(problems[0].message.starts_with("shape.mesh: ") && problems[0].message.contains("AssetPlugin"));
        assert!(ticks(&scene) > before, "the rest goes on");
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
    fn walls_that_move_are_not_planned_while_they_do() {
        let mut scene = Scene::new();
        let plans = |scene: &Scene| scene.app.world().get::<FluidStats>(scene.domain).unwrap().plannings;
        assert_eq!(plans(&scene), 1);
        let (parent, wall) = (scene.parent, scene.wall);
        let shift = |scene: &mut Scene, entity: Entity| {
            scene.app.world_mut().get_mut::<Transform>(entity).unwrap().translation.x += 0.01;
        };
        // From the start.
        scene.is_planned_after("a wall that is to move", |world, [_, _, wall, _]| {
            world.get_mut::<FluidBoundary>(*wall).unwrap().motion = FluidWallMotion::Moving;
        });
        assert_eq!(plans(&scene), 2);
        for entity in [wall, parent, wall, parent] {
            shift(&mut scene, entity);
            assert_eq!(scene.plannings(1), 0);
        }
        // With the first move, of its parent too; what is put elsewhere each time; and again from the beginning.
        scene.is_planned_after("a wall that stands", |world, [_, _, wall, _]| {
            world.get_mut::<FluidBoundary>(*wall).unwrap().motion = FluidWallMotion::Still;
        });
        scene.is_planned_after("a wall that may move", |world, [_, _, wall, _]| {
            world.get_mut::<FluidBoundary>(*wall).unwrap().motion = FluidWallMotion::Auto;
        });
        assert_eq!(plans(&scene), 3, "one that stands is the same");
        shift(&mut scene, parent);
        scene.plannings(3);
        for entity in [wall, parent, wall, parent] {
            shift(&mut scene, entity);
            assert_eq!(scene.plannings(1), 0);
        }
        assert_eq!(plans(&scene), 4);
        // A scale it may not have takes it out of the fluid, until it is as before.
        for scale in [2.0, 1.0] {
            scene.app.world_mut().get_mut::<Transform>(wall).unwrap().scale = Vec3::splat(scale);
            assert!(scene.plannings(3) > 0, "a scale goes unnoticed");
            assert_eq!(scene.problems().len(), usize::from(scale > 1.0));
        }
        assert_eq!(plans(&scene), 6);
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
            world.entity_mut(*wall).insert(still(FluidBoundary::cuboid(0.1, 0.4, 0.5)));
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
