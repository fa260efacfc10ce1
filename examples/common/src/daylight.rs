//! Sun, sky and ground, and a camera that sees them.

use bevy::camera::visibility::NoFrustumCulling;
use bevy::light::{CascadeShadowConfigBuilder, NotShadowCaster};
use bevy::prelude::*;

/// Colour of the sky above, and where it meets the ground.
const ZENITH: Color = Color::srgb(0.09, 0.33, 0.72);
const HORIZON: Color = Color::srgb(0.80, 0.89, 0.95);

/// A camera for scenes that are so large, m: what lies far beyond them fades into the horizon.
pub fn camera(size: f32) -> impl Bundle {
    let falloff = FogFalloff::Linear { start: 3.0 * size, end: 16.0 * size };
    (Camera3d::default(), DistanceFog { color: HORIZON, falloff, ..default() })
}

/// Spawns what is around a scene that lies between two corners; the ground is at the lower one.
pub fn spawn(
    commands: &mut Commands,
    meshes: &mut Assets<Mesh>,
    materials: &mut Assets<StandardMaterial>,
    (low, high): (Vec3, Vec3),
) {
    let size = (high - low).length();
    let center = (low + high) / 2.0;
    commands.insert_resource(ClearColor(HORIZON));
    commands.insert_resource(GlobalAmbientLight {
        color: Color::srgb(0.80, 0.90, 1.0),
        brightness: 850.0,
        ..default()
    });
    let cascades = CascadeShadowConfigBuilder {
        num_cascades: 2,
        first_cascade_far_bound: 1.5 * size,
        maximum_distance: 4.0 * size,
        ..default()
    };
    commands.spawn((
        DirectionalLight {
            illuminance: 9_000.0,
            color: Color::srgb(1.0, 0.95, 0.86),
            shadow_maps_enabled: true,
            ..default()
        },
        cascades.build(),
        Transform::default().looking_to(Vec3::new(-0.5, -1.0, -0.62), Vec3::Y),
    ));
    commands.spawn((
        Mesh3d(meshes.add(Circle::new(40.0 * size).mesh().resolution(64))),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: Color::srgb(0.27, 0.33, 0.24),
            perceptual_roughness: 0.95,
            reflectance: 0.15,
            ..default()
        })),
        Transform::from_xyz(center.x, low.y, center.z).looking_to(Vec3::NEG_Y, Vec3::Z),
    ));
    commands.spawn((
        Mesh3d(meshes.add(dome(30.0 * size))),
        MeshMaterial3d(materials.add(StandardMaterial {
            unlit: true,
            fog_enabled: false,
            cull_mode: None,
            ..default()
        })),
        NotShadowCaster,
        NoFrustumCulling,
        Transform::from_xyz(center.x, low.y, center.z),
    ));
}

/// A ball around everything, coloured by height.
fn dome(radius: f32) -> Mesh {
    let mut mesh = Sphere::new(radius).mesh().uv(32, 64);
    let (zenith, horizon) = (LinearRgba::from(ZENITH), LinearRgba::from(HORIZON));
    let colors: Option<Vec<[f32; 4]>> = mesh.attribute(Mesh::ATTRIBUTE_POSITION).and_then(|positions| {
        let heights = positions.as_float3()?.iter().map(|position| (position[1] / radius).clamp(0.0, 1.0));
        Some(heights.map(|height| horizon.mix(&zenith, height.powf(0.35)).to_f32_array()).collect())
    });
    if let Some(colors) = colors {
        mesh.insert_attribute(Mesh::ATTRIBUTE_COLOR, colors);
    }
    mesh
}
