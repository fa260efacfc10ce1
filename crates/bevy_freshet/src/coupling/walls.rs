//! Containers as colliders.

use bevy::prelude::*;
use bevy_rapier3d::prelude::{Collider, RigidBody};

use crate::components::container::FluidContainer;

/// Thickness of walls over the container's longest edge: a body must not tunnel through in one tick.
const THICKNESS: f32 = 0.1;

/// The collider was made here, so it is removed here.
#[derive(Component)]
pub(crate) struct WallCollider;

pub(crate) fn make_colliders(
    mut commands: Commands,
    containers: Query<(Entity, &FluidContainer, Has<WallCollider>), Changed<FluidContainer>>,
) {
    for (entity, container, has_collider) in &containers {
        match walls(container) {
            Some(collider) => {
                commands.entity(entity).try_insert((RigidBody::Fixed, collider, WallCollider));
            }
            None if has_collider => {
                commands.entity(entity).try_remove::<(RigidBody, Collider, WallCollider)>();
            }
            None => {}
        }
    }
}

pub(crate) fn remove_collider(
    removed: On<Remove, FluidContainer>,
    walls: Query<(), With<WallCollider>>,
    mut commands: Commands,
) {
    if walls.contains(removed.entity) {
        commands.entity(removed.entity).try_remove::<(RigidBody, Collider, WallCollider)>();
    }
}

/// A slab for each face that is there, outside the inner box. None if it has no collider, or is refused by the model.
fn walls(container: &FluidContainer) -> Option<Collider> {
    let half = container.size / 2.0;
    if !container.collider || !half.is_finite() || half.min_element() < 1e-5 || container.open == [true; 6] {
        return None;
    }
    let thickness = THICKNESS * container.size.max_element();
    let mut slabs = Vec::new();
    for (face, _) in container.open.iter().enumerate().filter(|(_, open)| !**open) {
        let axis = face / 2;
        let side = if face % 2 == 0 { -1.0 } else { 1.0 };
        let mut center = Vec3::ZERO;
        center[axis] = side * (half[axis] + thickness / 2.0);
        let mut extents = half;
        for other in (0..3).filter(|other| *other != axis) {
            // Closed corners have no gap, and no wall stands out over an open rim.
            let ends = [2 * other, 2 * other + 1].map(|end| if container.open[end] { 0.0 } else { thickness });
            extents[other] += (ends[0] + ends[1]) / 2.0;
            center[other] = (ends[1] - ends[0]) / 2.0;
        }
        extents[axis] = thickness / 2.0;
        slabs.push((center, Quat::IDENTITY, Collider::cuboid(extents.x, extents.y, extents.z)));
    }
    Some(Collider::compound(slabs))
}
