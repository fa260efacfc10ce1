//! Gates: walls that slide up.

use bevy::prelude::*;
use bevy_freshet::prelude::*;
use bevy_rapier3d::prelude::*;

use crate::level::{Area, DEPTH};
use crate::paint::Paints;
use crate::site::OnSite;

/// How fast they slide, m/s.
const SPEED: f32 = 0.8;

/// A gate.
#[derive(Component)]
pub struct Gate {
    /// Its number; 0 is the first.
    pub number: usize,
    /// Whether it is open, or opens.
    pub is_open: bool,
    /// Where it is closed, m.
    closed: Vec2,
    /// How far it slides, m.
    way: f32,
}

/// Spawns a closed gate.
pub fn spawn(
    commands: &mut Commands,
    meshes: &mut Assets<Mesh>,
    paints: &Paints,
    domain: Entity,
    (number, area): (usize, &Area),
) {
    let (closed, size) = (area.center(), area.size().extend(DEPTH));
    let gate = commands
        .spawn((
            OnSite,
            Gate { number, is_open: false, closed, way: size.y },
            FluidBoundary::cuboid(size.x, size.y, size.z).moving(),
            FluidInDomain(domain),
            RigidBody::KinematicPositionBased,
            Collider::cuboid(size.x / 2.0, size.y / 2.0, size.z / 2.0),
            Mesh3d(meshes.add(Cuboid::from_size(size + Vec3::Z * 0.10))),
            MeshMaterial3d(paints.red.clone()),
            Transform::from_translation(closed.extend(0.0)),
        ))
        .id();
    let rod = Cuboid::new(0.035, size.y + 0.12, 0.035);
    commands.spawn((
        Mesh3d(meshes.add(rod)),
        MeshMaterial3d(paints.iron.clone()),
        Transform::from_xyz(0.0, size.y, 0.0),
        ChildOf(gate),
    ));
    commands.spawn((
        Mesh3d(meshes.add(Cuboid::new(0.07, 0.05, 0.34))),
        MeshMaterial3d(paints.iron.clone()),
        Transform::from_xyz(0.0, 1.5 * size.y + 0.06, 0.0),
        ChildOf(gate),
    ));
}

/// Slides them; in fixed ticks, before rapier and fluid look where walls are.
pub fn slide(time: Res<Time>, mut gates: Query<(&Gate, &mut Transform)>) {
    for (gate, mut pose) in &mut gates {
        let wanted = gate.closed.y + if gate.is_open { gate.way } else { 0.0 };
        let step = SPEED * time.delta_secs();
        let next = pose.translation.y + (wanted - pose.translation.y).clamp(-step, step);
        if next != pose.translation.y {
            pose.translation.y = next;
        }
    }
}
