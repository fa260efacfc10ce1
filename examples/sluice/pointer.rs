//! The pointer and the keys: gates and crates.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_rapier3d::prelude::*;

use crate::crates::boards;
use crate::game::{Game, Hands, Levels, Phase};
use crate::gates::Gate;
use crate::level::Action;
use crate::paint::Paints;

/// Keys of gates.
const DIGITS: [KeyCode; 9] = [
    KeyCode::Digit1,
    KeyCode::Digit2,
    KeyCode::Digit3,
    KeyCode::Digit4,
    KeyCode::Digit5,
    KeyCode::Digit6,
    KeyCode::Digit7,
    KeyCode::Digit8,
    KeyCode::Digit9,
];

/// A crate where it would be placed.
#[derive(Component)]
pub struct Ghost {
    /// Edge of what is drawn, m.
    size: f32,
}

/// What lies under the pointer.
#[derive(SystemParam)]
pub struct Pointer<'w, 's> {
    windows: Query<'w, 's, &'static Window>,
    cameras: Query<'w, 's, (&'static Camera, &'static GlobalTransform), With<Camera3d>>,
    physics: ReadRapierContext<'w, 's>,
    gates: Query<'w, 's, (&'static Gate, &'static Collider, &'static GlobalTransform)>,
}

impl Pointer<'_, '_> {
    fn ray(&self) -> Option<Ray3d> {
        let cursor = self.windows.single().ok()?.cursor_position()?;
        let (camera, pose) = self.cameras.single().ok()?;
        camera.viewport_to_world(pose, cursor).ok()
    }

    /// The gate that it points at.
    fn gate(&self) -> Option<usize> {
        let ray = self.ray()?;
        let hit = |(_, collider, pose): &(&Gate, &Collider, &GlobalTransform)| {
            let (_, turn, place) = pose.to_scale_rotation_translation();
            collider.cast_ray(place, turn, ray.origin, *ray.direction, f32::MAX, true).is_some()
        };
        self.gates.iter().find(hit).map(|(gate, ..)| gate.number)
    }

    /// Where it meets the middle of the channel.
    fn place(&self) -> Option<Vec2> {
        let ray = self.ray()?;
        let distance = ray.intersect_plane(Vec3::ZERO, InfinitePlane3d::new(Vec3::Z))?;
        Some(ray.get_point(distance).truncate())
    }

    /// Whether a crate of this edge finds room there.
    fn has_room(&self, place: Vec2, size: f32) -> bool {
        let Ok(physics) = self.physics.single() else { return false };
        // Panes are nearer than the rest.
        let shape = Collider::cuboid(size / 2.0, size / 2.0, 0.05);
        let mut is_free = true;
        let filter = QueryFilter::default();
        physics.intersect_shape(place.extend(0.0), Quat::IDENTITY, shape.raw.as_ref(), filter, |_| {
            is_free = false;
            false
        });
        is_free
    }
}

/// Left button: a gate, or a crate.
pub fn press(
    buttons: Res<ButtonInput<MouseButton>>,
    pointer: Pointer,
    (game, levels): (Res<Game>, Res<Levels>),
) -> Option<Action> {
    if !buttons.just_pressed(MouseButton::Left) {
        return None;
    }
    let size = levels.0[game.level].crates.size;
    let gate = pointer.gate().map(Action::Gate);
    gate.or_else(|| pointer.place().filter(|place| pointer.has_room(*place, size)).map(Action::Crate))
}

/// Does what was pointed at.
pub fn act(action: In<Option<Action>>, mut hands: Hands) {
    if let Some(action) = *action {
        hands.act(action);
    }
}

/// Number keys: gates.
pub fn press_keys(keys: Res<ButtonInput<KeyCode>>, mut hands: Hands) {
    for (number, key) in DIGITS.into_iter().enumerate() {
        if keys.just_pressed(key) {
            hands.act(Action::Gate(number));
        }
    }
}

/// Shows where a crate would be placed, red where it cannot.
pub fn show_ghost(
    mut commands: Commands,
    pointer: Pointer,
    (game, levels, paints): (Res<Game>, Res<Levels>, Res<Paints>),
    mut meshes: ResMut<Assets<Mesh>>,
    mut ghosts: Query<(Entity, &mut Ghost, &mut Transform, &mut Visibility, &Children)>,
    mut painted: Query<&mut MeshMaterial3d<StandardMaterial>>,
) {
    let size = levels.0[game.level].crates.size;
    let Ok((ghost, drawn, mut pose, mut visibility, parts)) = ghosts.single_mut() else {
        let ghost = commands.spawn((Ghost { size }, Transform::default(), Visibility::Hidden)).id();
        for (mesh, pose, _) in boards(size) {
            commands.spawn((Mesh3d(meshes.add(mesh)), MeshMaterial3d(paints.ghost.clone()), pose, ChildOf(ghost)));
        }
        return;
    };
    if drawn.size != size {
        commands.entity(ghost).despawn();
        return;
    }
    let is_wanted = game.phase == Phase::Playing && game.crates > 0 && pointer.gate().is_none();
    let place = pointer.place().filter(|_| is_wanted);
    visibility.set_if_neq(if place.is_some() { Visibility::Inherited } else { Visibility::Hidden });
    let Some(place) = place else { return };
    pose.translation = place.extend(0.0);
    let paint = if pointer.has_room(place, size) { &paints.ghost } else { &paints.refused };
    for part in parts {
        if let Ok(mut painted) = painted.get_mut(*part) {
            painted.set_if_neq(MeshMaterial3d(paint.clone()));
        }
    }
}
