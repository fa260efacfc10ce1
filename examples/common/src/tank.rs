//! A glass tank, as it is drawn: bars along its edges, and a plate that the water stands on.

use bevy::prelude::*;

/// A piece of it.
pub type Piece = (Mesh3d, MeshMaterial3d<StandardMaterial>, Transform);

/// The pieces of a tank whose inside has this centre and size, m.
pub fn pieces(
    meshes: &mut Assets<Mesh>,
    materials: &mut Assets<StandardMaterial>,
    center: Vec3,
    size: Vec3,
) -> Vec<Piece> {
    let frame = materials.add(StandardMaterial {
        base_color: Color::srgb(0.20, 0.24, 0.29),
        perceptual_roughness: 0.4,
        ..default()
    });
    let plate = materials.add(StandardMaterial {
        base_color: Color::srgb(0.33, 0.36, 0.40),
        perceptual_roughness: 0.6,
        ..default()
    });
    let base = size * Vec3::new(1.0, 0.0, 1.0) + Vec3::new(0.12, 0.04, 0.12) * size.max_element();
    let below = (size.y + base.y + 0.01 * size.max_element()) / 2.0;
    let mut pieces = vec![(
        Mesh3d(meshes.add(Cuboid::from_size(base))),
        MeshMaterial3d(plate),
        Transform::from_translation(center - Vec3::Y * below),
    )];
    for (position, size) in edges(size, 0.006 * size.max_element()) {
        pieces.push((
            Mesh3d(meshes.add(Cuboid::from_size(size))),
            MeshMaterial3d(frame.clone()),
            Transform::from_translation(center + position),
        ));
    }
    pieces
}

/// Bars along the twelve edges of a box: centres and sizes.
fn edges(size: Vec3, width: f32) -> Vec<(Vec3, Vec3)> {
    let half = (size + width) / 2.0;
    let mut bars = Vec::new();
    for axis in 0..3 {
        for (u, v) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            let (mut center, mut bar) = (Vec3::ZERO, Vec3::splat(width));
            center[(axis + 1) % 3] = u * half[(axis + 1) % 3];
            center[(axis + 2) % 3] = v * half[(axis + 2) % 3];
            bar[axis] = size[axis] + 2.0 * width;
            bars.push((center, bar));
        }
    }
    bars
}
