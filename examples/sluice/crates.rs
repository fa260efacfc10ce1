//! Crates: heavy bodies that the player places.

use bevy::prelude::*;
use bevy_freshet::prelude::*;
use bevy_rapier3d::prelude::*;

use crate::level::Crates;
use crate::paint::Paints;
use crate::site::OnSite;

/// On a crate.
#[derive(Component)]
pub struct Placed;

/// Places a crate.
pub fn spawn(
    commands: &mut Commands,
    meshes: &mut Assets<Mesh>,
    paints: &Paints,
    domain: Entity,
    (crates, at): (&Crates, Vec2),
) {
    let half = crates.size / 2.0;
    let body = (
        RigidBody::Dynamic,
        Collider::cuboid(half, half, half),
        ColliderMassProperties::Density(crates.density),
        FluidBody::default(),
        FluidInDomain(domain),
    );
    let pose = Transform::from_translation(at.extend(0.0));
    let placed = commands.spawn((OnSite, Placed, body, pose, Visibility::default())).id();
    for (mesh, pose, is_frame) in boards(crates.size) {
        let paint = if is_frame { &paints.dark_wood } else { &paints.wood };
        commands.spawn((Mesh3d(meshes.add(mesh)), MeshMaterial3d(paint.clone()), pose, ChildOf(placed)));
    }
}

/// What a crate of this edge looks like: boards, and whether each belongs to the frame around the others.
pub fn boards(size: f32) -> Vec<(Mesh, Transform, bool)> {
    let (bar, inset) = (0.13 * size, 0.035 * size);
    let mut boards = vec![(Cuboid::from_length(size - 2.0 * inset).into(), Transform::IDENTITY, false)];
    let out = (size - bar) / 2.0;
    for axis in 0..3 {
        for (u, v) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            let (mut place, mut edges) = (Vec3::ZERO, Vec3::splat(bar));
            place[(axis + 1) % 3] = u * out;
            place[(axis + 2) % 3] = v * out;
            edges[axis] = size;
            boards.push((Cuboid::from_size(edges).into(), Transform::from_translation(place), true));
        }
    }
    // A diagonal on the faces that are seen most.
    for (turn, side) in [(1.0, 1.0), (-1.0, -1.0)] {
        let brace = Cuboid::new(1.2 * (size - bar), bar, inset);
        let pose = Transform::from_xyz(0.0, 0.0, side * (size - inset) / 2.0)
            .with_rotation(Quat::from_rotation_z(turn * std::f32::consts::FRAC_PI_4));
        boards.push((brace.into(), pose, true));
    }
    boards
}
