//! Reads the components of one domain.

use std::collections::HashSet;

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use freshet_core::emitter::Emitter;
use freshet_core::error::InvalidInput;
use freshet_core::material::Material;
use freshet_core::scene::{Boundary, BoundaryShape, Friction, Shape, Volume};

use super::movers::Mover;
use super::pours::Poured;
use super::problems::Problem;
use super::recipe::{FreshVolume, Recipe, Source, Wall};
use super::state::BodySamples;
use super::walls::stretch::stretched_frame;
use super::walls::{Found, WallAssets, WallShapes};
use crate::components::boundary::{FluidBoundary, FluidBoundaryShape};
use crate::components::container::FluidContainer;
use crate::components::domain::FluidDomain;
use crate::components::emitter::FluidEmitter;
use crate::components::material::Fluid;
use crate::components::membership::FluidInDomain;
use crate::components::volume::{FluidShape, FluidVolume};
use crate::components::wall::FluidWallMotion;

/// Deviation of a scale from 1 that still counts as none; rounding in a hierarchy makes about 1e-6.
const NO_SCALE: f32 = 1e-3;

type Member = Option<&'static FluidInDomain>;

/// All that can belong to a domain.
#[derive(SystemParam)]
pub(crate) struct Sources<'w, 's> {
    volumes: Query<'w, 's, (Entity, &'static FluidVolume, &'static Fluid, Member, Option<&'static Poured>)>,
    emitters: Query<'w, 's, (Entity, &'static FluidEmitter, &'static Fluid, Member)>,
    containers: Query<'w, 's, (Entity, &'static FluidContainer, Member)>,
    boundaries: Query<'w, 's, (Entity, Ref<'static, FluidBoundary>, Member)>,
    bodies: Query<'w, 's, (Entity, &'static BodySamples, Member)>,
    transforms: TransformHelper<'w, 's>,
    assets: WallAssets<'w>,
}

/// The rigid frame of an entity in the world, or what is wrong with it.
pub(crate) fn rigid_frame(transforms: &TransformHelper, entity: Entity) -> Result<Isometry3d, String> {
    let transform = transforms.compute_global_transform(entity).map_err(|error| error.to_string())?;
    let (scale, rotation, translation) = transform.to_scale_rotation_translation();
    // A comparison with not-a-number is false: it counts as scaled.
    let unscaled = (scale - 1.0).abs().max_element() <= NO_SCALE;
    if !unscaled || !translation.is_finite() || !rotation.is_finite() {
        return Err(format!(
            "Transform: scale {scale}, translation {translation} is not allowed; allowed: scale 1, finite numbers"
        ));
    }
    Ok(Isometry3d::new(translation, rotation.normalize()))
}

impl Sources<'_, '_> {
    /// Things that do not say which domain they belong to, where there are several.
    pub(crate) fn ambiguous(&self, domains: usize) -> Vec<Problem> {
        let mut problems = Vec::new();
        let mut check = |entity, component, member: Option<&FluidInDomain>| {
            if domains > 1 && member.is_none() {
                let message = format!("FluidInDomain: none is not allowed; allowed: one of the {domains} domains");
                problems.push(Problem::new(entity, component, message));
            }
        };
        self.volumes.iter().for_each(|(entity, _, _, member, _)| check(entity, "FluidVolume", member));
        self.emitters.iter().for_each(|(entity, _, _, member)| check(entity, "FluidEmitter", member));
        self.containers.iter().for_each(|(entity, _, member)| check(entity, "FluidContainer", member));
        self.boundaries.iter().for_each(|(entity, _, member)| check(entity, "FluidBoundary", member));
        self.bodies.iter().for_each(|(entity, _, member)| check(entity, "FluidBody", member));
        problems
    }

    /// The frame of a domain.
    pub(crate) fn frame(&self, domain: Entity) -> Result<Isometry3d, String> {
        rigid_frame(&self.transforms, domain)
    }

    /// Samples of a body.
    pub(crate) fn body(&self, entity: Entity) -> Option<&BodySamples> {
        self.bodies.get(entity).ok().map(|(_, samples, _)| samples)
    }

    /// What the components of a domain ask for. `only`: there is no other domain. `all`: pour poured volumes again.
    pub(crate) fn recipe(
        &self,
        domain: Entity,
        settings: &FluidDomain,
        (frame, gravity): (Isometry3d, Vec3),
        (only, all): (bool, bool),
        motions: &mut Motions,
        shapes: &mut WallShapes,
        problems: &mut Vec<Problem>,
    ) -> Recipe {
        let belongs = |member: Option<&FluidInDomain>| member.map_or(only, |member| member.0 == domain);
        let to_domain = frame.inverse();
        let mut gather = Gather { sources: self, to_domain, material: None, motions, problems };

        let mut fresh = Vec::new();
        let mut volumes: Vec<_> = self.volumes.iter().filter(|item| belongs(item.3)).collect();
        // What is there already says what the fluid is.
        volumes.sort_by_key(|item| (item.4.is_none(), item.0.index_u32()));
        for (entity, volume, fluid, _, poured) in volumes {
            let usable = gather.is_of_the_fluid(entity, "FluidVolume", fluid);
            let done = poured.is_some_and(|poured| {
                poured.domain == domain && !all && poured.refused.as_ref().is_none_or(|refused| refused == volume)
            });
            if usable
                && !done
                && let Some(pose) = gather.pose(entity, "FluidVolume")
            {
                fresh.push(FreshVolume { entity, volume: to_volume(volume, pose, to_domain) });
            }
        }
        let mut sources = Vec::new();
        let mut emitters: Vec<_> = self.emitters.iter().filter(|item| belongs(item.3)).collect();
        emitters.sort_by_key(|item| item.0.index_u32());
        for (entity, emitter, fluid, _) in emitters {
            if gather.is_of_the_fluid(entity, "FluidEmitter", fluid)
                && let Some(pose) = gather.pose(entity, "FluidEmitter")
            {
                sources.push(Source { entity, emitter: to_emitter(emitter, pose) });
            }
        }
        let (mut walls, mut waits_for) = (Walls::default(), Vec::new());
        for (entity, container, _) in self.containers.iter().filter(|item| belongs(item.2)) {
            let shape = BoundaryShape::Container { half_extents: container.size / 2.0, open: container.open };
            gather.wall(entity, "FluidContainer", shape, &container.into(), &mut walls);
        }
        for (entity, boundary, _) in self.boundaries.iter().filter(|item| belongs(item.2)) {
            match boundary.shape.to_model() {
                Some(shape) => gather.wall(entity, "FluidBoundary", shape, &Surface::from(&*boundary), &mut walls),
                None => gather.made_wall(entity, &boundary, shapes, &mut walls, &mut waits_for),
            }
        }
        // Queries follow archetypes; sorted, the same scene is the same however it was put together.
        let Walls { mut still, mut movers } = walls;
        still.sort_by_key(|wall| wall.entity.index_u32());
        movers.sort_by_key(|mover| mover.entity.index_u32());
        waits_for.sort_by_key(|entity| entity.index_u32());
        let mut bodies: Vec<_> = self
            .bodies
            .iter()
            .filter(|item| belongs(item.2))
            .map(|(entity, samples, _)| (entity, samples.version))
            .collect();
        bodies.sort_by_key(|body| body.0.index_u32());

        let material = gather.material.map_or_else(Material::water, |(_, material)| material);
        let gravity = frame.rotation.inverse() * gravity;
        let (spacing, settings) = (settings.spacing, Recipe::settings(settings));
        let walls = still;
        Recipe { spacing, settings, material, gravity, walls, movers, sources, bodies, fresh, waits_for }
    }
}

/// What a domain knows of how its walls move.
pub(crate) struct Motions<'a> {
    /// As last planned.
    before: &'a [Wall],
    moved: &'a mut HashSet<Entity>,
    placed: &'a HashSet<Entity>,
}

impl<'a> Motions<'a> {
    /// Walls that have moved since the last planning count as moving, if they have not been placed.
    pub(crate) fn new(before: Option<&'a Recipe>, moved: &'a mut HashSet<Entity>, placed: &'a HashSet<Entity>) -> Self {
        Self { before: before.map_or(&[], |recipe| &recipe.walls), moved, placed }
    }

    /// Whether a wall moves.
    fn moves(&mut self, motion: FluidWallMotion, wall: &Wall) -> bool {
        if motion == FluidWallMotion::Still {
            self.moved.remove(&wall.entity);
            return false;
        }
        if self.stood(wall).is_some_and(|before| wall.is_moved_from(before)) {
            self.moved.insert(wall.entity);
        }
        motion == FluidWallMotion::Moving || self.moved.contains(&wall.entity)
    }

    /// The same wall as it stood in the last planning, if it has not been placed since.
    fn stood(&self, wall: &Wall) -> Option<&'a Wall> {
        let is_same = |before: &&Wall| before.entity == wall.entity && before.boundary.shape == wall.boundary.shape;
        self.before.iter().find(is_same).filter(|_| !self.placed.contains(&wall.entity))
    }
}

/// What boundaries and containers have in common.
struct Surface {
    viscous_faces: [bool; 6],
    friction: Friction,
    /// In the wall's own axes.
    velocity: Vec3,
    motion: FluidWallMotion,
}

impl From<&FluidBoundary> for Surface {
    fn from(&FluidBoundary { viscous_faces, friction, velocity, motion, .. }: &FluidBoundary) -> Self {
        Self { viscous_faces, friction: friction.into(), velocity, motion }
    }
}

impl From<&FluidContainer> for Surface {
    fn from(&FluidContainer { viscous_faces, friction, velocity, motion, .. }: &FluidContainer) -> Self {
        Self { viscous_faces, friction: friction.into(), velocity, motion }
    }
}

#[derive(Default)]
struct Walls {
    still: Vec<Wall>,
    movers: Vec<Mover>,
}

struct Gather<'a, 'w, 's, 'm> {
    sources: &'a Sources<'w, 's>,
    to_domain: Isometry3d,
    material: Option<(Entity, Material)>,
    motions: &'a mut Motions<'m>,
    problems: &'a mut Vec<Problem>,
}

impl Gather<'_, '_, '_, '_> {
    fn pose(&mut self, entity: Entity, component: &'static str) -> Option<Isometry3d> {
        match rigid_frame(&self.sources.transforms, entity) {
            Ok(frame) => Some(self.to_domain * frame),
            Err(message) => {
                self.problems.push(Problem::new(entity, component, message));
                None
            }
        }
    }

    fn wall(
        &mut self,
        entity: Entity,
        component: &'static str,
        shape: BoundaryShape,
        surface: &Surface,
        walls: &mut Walls,
    ) {
        if let Some(pose) = self.pose(entity, component) {
            self.place((entity, component), shape, surface, (pose, None), walls);
        }
    }

    /// Puts a wall among those that stand or among those that move.
    fn place(
        &mut self,
        (entity, component): (Entity, &'static str),
        shape: BoundaryShape,
        &Surface { viscous_faces, friction, velocity, motion }: &Surface,
        (pose, stretch): (Isometry3d, Option<Mat3>),
        walls: &mut Walls,
    ) {
        let (center, rotation) = (pose.translation.into(), pose.rotation);
        // A rotation would make not-a-number of infinity, and the message would be wrong.
        let turned = if velocity.is_finite() { rotation * velocity } else { velocity };
        let boundary = Boundary { rotation, viscous_faces, friction, velocity: turned, ..Boundary::new(shape, center) };
        let wall = Wall { entity, component, boundary };
        if !self.motions.moves(motion, &wall) {
            walls.still.push(wall);
            return;
        }
        if velocity != Vec3::ZERO {
            let error = InvalidInput::new("velocity", velocity, "zero of a wall that moves (motion: Still keeps it)");
            self.problems.push(Problem::new(entity, component, error));
        }
        let from = self.motions.stood(&wall).map(Wall::pose);
        let (shape, is_auto) = (wall.boundary.shape, motion == FluidWallMotion::Auto);
        walls.movers.push(Mover { entity, component, shape, friction, stretch, pose, from, is_auto });
    }

    /// A wall whose shape is made of a mesh, heights or an image.
    fn made_wall(
        &mut self,
        entity: Entity,
        boundary: &Ref<FluidBoundary>,
        shapes: &mut WallShapes,
        walls: &mut Walls,
        waits_for: &mut Vec<Entity>,
    ) {
        let transforms = &self.sources.transforms;
        let frame = match boundary.shape {
            FluidBoundaryShape::Mesh { .. } | FluidBoundaryShape::ConvexHull { .. } => {
                stretched_frame(transforms, entity).map(|(frame, stretch)| (frame, Some(stretch)))
            }
            _ => rigid_frame(transforms, entity).map(|frame| (frame, None)),
        };
        let found = frame.map(|(frame, stretch)| {
            let made = shapes.find(entity, boundary, stretch.unwrap_or(Mat3::IDENTITY), &self.sources.assets);
            ((self.to_domain * frame, stretch), made)
        });
        let wrong = match found {
            Ok((pose, Found::Shape(shape))) => {
                self.place((entity, "FluidBoundary"), shape, &Surface::from(&**boundary), pose, walls);
                return;
            }
            Ok((_, Found::Waits)) => {
                waits_for.push(entity);
                return;
            }
            Ok((_, Found::Wrong(message))) | Err(message) => message,
        };
        self.problems.push(Problem::new(entity, "FluidBoundary", wrong));
    }

    /// The first volume or emitter says what the domain's fluid is; others must agree.
    fn is_of_the_fluid(&mut self, entity: Entity, component: &'static str, fluid: &Fluid) -> bool {
        let material = fluid.to_material();
        match &self.material {
            None => {
                self.material = Some((entity, material));
                true
            }
            Some((_, first)) if *first == material => true,
            Some((other, first)) => {
                let message = format!(
                    "Fluid: {} is not allowed; allowed: {}, as in entity {other} of the same domain",
                    material.name, first.name
                );
                self.problems.push(Problem::new(entity, component, message));
                false
            }
        }
    }
}

fn to_volume(volume: &FluidVolume, pose: Isometry3d, to_domain: Isometry3d) -> Volume {
    let shape = match volume.shape {
        FluidShape::Cuboid { half_size } => Shape::Box { half_extents: half_size },
        FluidShape::Sphere { radius } => Shape::Sphere { radius },
    };
    // A rotation would make not-a-number of infinity, and the message would be wrong.
    let velocity = if volume.velocity.is_finite() { to_domain.rotation * volume.velocity } else { volume.velocity };
    Volume {
        shape,
        center: pose.translation.into(),
        rotation: pose.rotation,
        velocity,
        hydrostatic: volume.hydrostatic,
    }
}

/// An emitter at a pose in the domain's frame; it flows along its forward axis, -z.
pub(crate) fn to_emitter(emitter: &FluidEmitter, pose: Isometry3d) -> Emitter {
    Emitter {
        center: pose.translation.into(),
        direction: pose.rotation * Vec3::NEG_Z,
        radius: emitter.radius,
        speed: emitter.speed,
        lifetime: emitter.lifetime,
    }
}
