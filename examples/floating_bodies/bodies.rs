//! The bodies: rapier's, with the fluid's component beside it.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_freshet::prelude::*;
use bevy_rapier3d::prelude::*;

use crate::pool::Pool;
use crate::shape::Shape;

/// Least and most density, kg/m3.
pub const DENSITIES: std::ops::RangeInclusive<f32> = 50.0..=5000.0;
/// The largest body, m.
pub const LARGEST: f32 = 0.6;

/// What a body is.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct Floater {
    /// Its shape.
    pub shape: Shape,
    /// m.
    pub size: f32,
    /// kg/m3.
    pub density: f32,
}

/// On what is a part of a body that is drawn.
#[derive(Component)]
pub struct Paint;

/// Spawns bodies.
#[derive(SystemParam)]
pub struct Dropping<'w, 's> {
    commands: Commands<'w, 's>,
    meshes: ResMut<'w, Assets<Mesh>>,
    materials: ResMut<'w, Assets<StandardMaterial>>,
    pool: Res<'w, Pool>,
}

impl Dropping<'_, '_> {
    /// Spawns a body in a domain, with more components; its centre is at `position`.
    pub fn drop(&mut self, domain: Entity, floater: Floater, position: Vec3, more: impl Bundle) -> Entity {
        let Floater { shape, size, density } = floater;
        let paint = self.materials.add(StandardMaterial {
            base_color: color(density),
            metallic: if density > 2000.0 { 0.7 } else { 0.0 },
            perceptual_roughness: if density > 2000.0 { 0.4 } else { 0.55 },
            ..default()
        });
        let body = (
            RigidBody::Dynamic,
            shape.collider(size, self.pool.spacing),
            ColliderMassProperties::Mass(density * shape.volume(size, self.pool.spacing)),
            FluidBody::default(),
            FluidInDomain(domain),
        );
        let pose = Transform::from_translation(position).with_rotation(shape.attitude());
        let body = (floater, body, pose, Visibility::default(), ExternalForce::default(), more);
        let body = self.commands.spawn(body).id();
        for (mesh, place) in shape.meshes(size, self.pool.spacing) {
            let mesh = Mesh3d(self.meshes.add(mesh));
            self.commands.spawn((Paint, mesh, MeshMaterial3d(paint.clone()), place, ChildOf(body)));
        }
        body
    }
}

/// Cork, wood, plastic, stone, iron: the darker, the denser.
fn color(density: f32) -> Color {
    const COLORS: [(f32, [f32; 3]); 6] = [
        (50.0, [0.96, 0.90, 0.74]),
        (300.0, [0.95, 0.72, 0.30]),
        (600.0, [0.93, 0.45, 0.13]),
        (950.0, [0.75, 0.16, 0.14]),
        (1500.0, [0.45, 0.12, 0.24]),
        (5000.0, [0.16, 0.17, 0.20]),
    ];
    let above = COLORS.iter().position(|(other, _)| *other >= density).unwrap_or(COLORS.len() - 1).max(1);
    let ((low, from), (high, to)) = (COLORS[above - 1], COLORS[above]);
    let share = ((density / low).ln() / (high / low).ln()).clamp(0.0, 1.0);
    let mixed = Vec3::from(from).lerp(Vec3::from(to), share);
    Color::srgb(mixed.x, mixed.y, mixed.z)
}
