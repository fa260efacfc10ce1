//! The scene as entities: fluid, balls, tank, ground, light.

use bevy::prelude::*;
use bevy_freshet::prelude::*;
use bevy_rapier3d::prelude::{Collider, ColliderMassProperties, RigidBody};

use crate::scene::Setup;

/// What is despawned when the scene starts again.
#[derive(Component)]
pub struct OnStage;

/// The scene being shown.
#[derive(Resource, Clone)]
pub struct Stage {
    /// What is simulated.
    pub setup: Setup,
    /// Where.
    pub backend: FluidBackend,
    /// How.
    pub mode: FluidMode,
    /// What the colours mean.
    pub coloring: FluidColoring,
}

/// Spawns light and ground, which stay.
pub fn build_surroundings(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    stage: Res<Stage>,
) {
    commands.insert_resource(ClearColor(Color::srgb(0.80, 0.86, 0.92)));
    commands.insert_resource(GlobalAmbientLight {
        color: Color::srgb(0.86, 0.93, 1.0),
        brightness: 900.0,
        ..default()
    });
    commands.spawn((
        DirectionalLight {
            illuminance: 7_500.0,
            color: Color::srgb(1.0, 0.96, 0.9),
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::default().looking_to(Vec3::new(-0.45, -1.0, -0.55), Vec3::Y),
    ));
    let (height, extent) = stage.setup.ground();
    let center = (stage.setup.bounds.0 + stage.setup.bounds.1) / 2.0;
    commands.spawn((
        Mesh3d(meshes.add(Plane3d::default().mesh().size(60.0 * extent.x, 60.0 * extent.x))),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: Color::srgb(0.62, 0.68, 0.75),
            perceptual_roughness: 0.9,
            reflectance: 0.2,
            ..default()
        })),
        Transform::from_xyz(center.x, height - 0.06, center.z),
    ));
}

/// Spawns what moves, and the tank. Returns what is wrong with the scene.
pub fn build(
    commands: &mut Commands,
    meshes: &mut Assets<Mesh>,
    materials: &mut Assets<StandardMaterial>,
    stage: &Stage,
) -> Result<Entity, String> {
    let (backend, mode) = (stage.backend, stage.mode);
    let domain = commands
        .spawn_fluid_scene(&stage.setup.scene, |domain| *domain = domain.clone().on(backend).in_mode(mode))
        .map_err(|error| error.to_string())?;
    commands.entity(domain).insert((OnStage, FluidAppearance { coloring: stage.coloring.clone(), ..default() }));
    for (index, ball) in stage.setup.balls.iter().enumerate() {
        let color = [Color::srgb(0.93, 0.42, 0.12), Color::srgb(0.95, 0.75, 0.15)][index % 2];
        commands.spawn((
            OnStage,
            RigidBody::Dynamic,
            Collider::ball(ball.radius),
            ColliderMassProperties::Density(ball.density),
            FluidBody::default(),
            FluidInDomain(domain),
            Mesh3d(
                meshes.add(Sphere::new(ball.radius).mesh().ico(5).unwrap_or_else(|_| Sphere::new(ball.radius).into())),
            ),
            MeshMaterial3d(materials.add(StandardMaterial {
                base_color: color,
                perceptual_roughness: 0.35,
                ..default()
            })),
            Transform::from_translation(ball.position),
        ));
    }
    let frame = materials.add(StandardMaterial {
        base_color: Color::srgb(0.20, 0.24, 0.29),
        perceptual_roughness: 0.4,
        ..default()
    });
    let plate = materials.add(StandardMaterial {
        base_color: Color::srgb(0.86, 0.88, 0.90),
        perceptual_roughness: 0.6,
        ..default()
    });
    for (center, size) in stage.setup.tanks() {
        let base = size * Vec3::new(1.0, 0.0, 1.0) + Vec3::new(0.12, 0.04, 0.12) * size.max_element();
        commands.spawn((
            OnStage,
            Mesh3d(meshes.add(Cuboid::from_size(base))),
            MeshMaterial3d(plate.clone()),
            // The water stands on it.
            Transform::from_translation(center - Vec3::Y * (size.y + base.y + 0.01 * size.max_element()) / 2.0),
        ));
        for (position, size) in edges(size, 0.006 * size.max_element()) {
            commands.spawn((
                OnStage,
                Mesh3d(meshes.add(Cuboid::from_size(size))),
                MeshMaterial3d(frame.clone()),
                Transform::from_translation(center + position),
            ));
        }
    }
    Ok(domain)
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
