//! The pointer: drops bodies, picks them, drags them.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_freshet::prelude::*;
use bevy_rapier3d::prelude::*;

use crate::bodies::{Dropping, Floater, Paint};
use crate::panel::Wishes;
use crate::pool::{self, Pool};

/// How stiff the pull is: a light body follows the pointer within about a tenth of a second.
const RATE: f32 = 12.0;
/// Most acceleration it gives, m/s2.
const STRONGEST: f32 = 120.0;

/// The body whose readings are shown.
#[derive(Resource, Default)]
pub struct Picked(pub Option<Entity>);

/// The body being dragged.
#[derive(Resource, Default)]
pub struct Grip(Option<Hold>);

struct Hold {
    body: Entity,
    /// Where it is held, in its own axes, m.
    anchor: Vec3,
    /// Where that should be, m.
    target: Vec3,
}

/// What would be dropped.
#[derive(Component)]
pub struct Ghost;

/// The ray under the pointer.
#[derive(SystemParam)]
pub struct Pointer<'w, 's> {
    windows: Query<'w, 's, &'static Window>,
    cameras: Query<'w, 's, (&'static Camera, &'static GlobalTransform), With<Camera3d>>,
}

impl Pointer<'_, '_> {
    fn ray(&self) -> Option<(Ray3d, Dir3)> {
        let cursor = self.windows.single().ok()?.cursor_position()?;
        let (camera, pose) = self.cameras.single().ok()?;
        Some((camera.viewport_to_world(pose, cursor).ok()?, pose.forward()))
    }

    /// Where a body of this size is dropped: above the water that the pointer is at.
    fn drop_point(&self, pool: &Pool, size: f32) -> Option<Vec3> {
        let (ray, _) = self.ray()?;
        let distance = ray.intersect_plane(Vec3::Y * pool.depth, InfinitePlane3d::new(Vec3::Y))?;
        let point = ray.get_point(distance);
        let room = (pool::SIZE / 2.0).with_y(f32::INFINITY);
        if point.abs().cmpgt(room).any() {
            return None;
        }
        let inside = room - 0.6 * size;
        Some(point.clamp(-inside, inside).with_y(pool.depth + size))
    }
}

/// The left button picks and grips a body, or drops one.
pub fn press(
    buttons: Res<ButtonInput<MouseButton>>,
    pointer: Pointer,
    physics: ReadRapierContext,
    floaters: Query<&GlobalTransform, With<Floater>>,
    domains: Query<Entity, With<FluidDomain>>,
    wishes: Res<Wishes>,
    pool: Res<Pool>,
    (mut picked, mut grip): (ResMut<Picked>, ResMut<Grip>),
    mut dropping: Dropping,
) {
    if !buttons.just_pressed(MouseButton::Left) {
        return;
    }
    let (Some((ray, _)), Ok(physics), Ok(domain)) = (pointer.ray(), physics.single(), domains.single()) else { return };
    let is_floater = |entity| floaters.contains(entity);
    let filter = QueryFilter::only_dynamic().predicate(&is_floater);
    if let Some((body, distance)) = physics.cast_ray(ray.origin, *ray.direction, f32::MAX, true, filter) {
        let target = ray.get_point(distance);
        let Ok(pose) = floaters.get(body) else { return };
        let anchor = pose.affine().inverse().transform_point3(target);
        picked.0 = Some(body);
        grip.0 = Some(Hold { body, anchor, target });
    } else if let Some(position) = pointer.drop_point(&pool, wishes.floater.size) {
        picked.0 = Some(dropping.drop(domain, wishes.floater, position, ()));
    }
}

/// The held point goes with the pointer, as far from the eye as it was.
pub fn follow(
    buttons: Res<ButtonInput<MouseButton>>,
    pointer: Pointer,
    mut grip: ResMut<Grip>,
    mut forces: Query<&mut ExternalForce>,
) {
    let Some(hold) = &mut grip.0 else { return };
    if buttons.pressed(MouseButton::Left) && forces.contains(hold.body) {
        let Some((ray, forward)) = pointer.ray() else { return };
        if let Some(distance) = ray.intersect_plane(hold.target, InfinitePlane3d { normal: forward }) {
            hold.target = ray.get_point(distance);
        }
        return;
    }
    if let Ok(mut force) = forces.get_mut(hold.body) {
        *force = ExternalForce::default();
    }
    grip.0 = None;
}

/// A spring from the held point to the pointer, damped critically, as strong as it may be with the step: in fixed ticks.
pub fn pull(
    grip: Res<Grip>,
    time: Res<Time>,
    mut bodies: Query<(&Transform, &Velocity, &ReadMassProperties, &mut ExternalForce)>,
) {
    let Some(hold) = &grip.0 else { return };
    let Ok((pose, velocity, mass, mut force)) = bodies.get_mut(hold.body) else { return };
    let center = pose.transform_point(mass.local_center_of_mass);
    let arm = pose.transform_point(hold.anchor) - center;
    let point_velocity = velocity.linear + velocity.angular.cross(arm);
    let (stiffness, damping, dt) = (RATE * RATE, 2.0 * RATE, time.delta_secs());
    // Implicit Euler's step, with which a spring of any stiffness is stable.
    let wanted = (hold.target - center - arm) * stiffness - point_velocity * (damping + dt * stiffness);
    let acceleration = (wanted / (1.0 + dt * damping + dt * dt * stiffness)).clamp_length_max(STRONGEST);
    // A point off the centre is more easily moved than the whole.
    let pulled = 0.5 * mass.mass * acceleration;
    let weight = mass.mass * 9.81 * Vec3::Y;
    *force = ExternalForce { force: pulled + weight, torque: arm.cross(pulled) };
}

/// Shows what would be dropped, and where.
pub fn show_ghost(
    mut commands: Commands,
    pointer: Pointer,
    pool: Res<Pool>,
    (wishes, grip): (Res<Wishes>, Res<Grip>),
    mut ghosts: Query<(Entity, &mut Transform, &mut Visibility, &MeshMaterial3d<StandardMaterial>), With<Ghost>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut shown: Local<Option<Floater>>,
) {
    let Ok((ghost, mut pose, mut visibility, material)) = ghosts.single_mut() else { return };
    let floater = wishes.floater;
    let place = pointer.drop_point(&pool, floater.size).filter(|_| grip.0.is_none());
    visibility.set_if_neq(if place.is_some() { Visibility::Inherited } else { Visibility::Hidden });
    let Some(place) = place else { return };
    *pose = Transform::from_translation(place).with_rotation(floater.shape.attitude());
    if *shown != Some(floater) {
        *shown = Some(floater);
        commands.entity(ghost).despawn_children();
        for (mesh, place) in floater.shape.meshes(floater.size, pool.spacing) {
            commands.spawn((Mesh3d(meshes.add(mesh)), material.clone(), place, ChildOf(ghost)));
        }
    }
}

/// Spawns what [`show_ghost`] shows.
pub fn spawn_ghost(commands: &mut Commands, materials: &mut Assets<StandardMaterial>) {
    let material = materials.add(StandardMaterial {
        base_color: Color::srgba(1.0, 1.0, 1.0, 0.3),
        alpha_mode: AlphaMode::Blend,
        ..default()
    });
    commands.spawn((Ghost, MeshMaterial3d(material), Transform::default(), Visibility::Hidden));
}

/// What is picked glows.
pub fn highlight(
    picked: Res<Picked>,
    bodies: Query<(Entity, &Children), With<Floater>>,
    paints: Query<&MeshMaterial3d<StandardMaterial>, With<Paint>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    for (body, parts) in &bodies {
        let glow = if picked.0 == Some(body) { LinearRgba::rgb(0.10, 0.09, 0.06) } else { LinearRgba::BLACK };
        let Some(paint) = paints.iter_many(parts).next() else { continue };
        if materials.get(paint).is_some_and(|material| material.emissive != glow)
            && let Some(mut material) = materials.get_mut(paint)
        {
            material.emissive = glow;
        }
    }
}
