//! The scene as entities: fluid, balls, tank, ground, light.

use bevy::prelude::*;
use bevy_freshet::prelude::*;
use bevy_rapier3d::prelude::{Collider, ColliderMassProperties, RigidBody};
use freshet_examples::tank;

use crate::scene::Setup;

/// The surface: before a plain background, water as clear as in a pool has hardly an outline.
pub const SURFACE: FluidStyle = FluidStyle::Surface { clarity: 0.15, smoothing: 3.0 };

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
    /// Spheres, or a surface.
    pub style: FluidStyle,
}

impl Stage {
    /// How the fluid looks.
    pub fn appearance(&self) -> FluidAppearance {
        FluidAppearance { coloring: self.coloring.clone(), style: self.style, ..default() }
    }
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
    commands.entity(domain).insert((OnStage, stage.appearance()));
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
    for (center, size) in stage.setup.tanks() {
        for piece in tank::pieces(meshes, materials, center, size) {
            commands.spawn((OnStage, piece));
        }
    }
    Ok(domain)
}
