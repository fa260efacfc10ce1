//! What things look like.

use bevy::prelude::*;

/// Materials of a level, made once.
#[derive(Resource, Clone)]
pub struct Paints {
    pub stone: Handle<StandardMaterial>,
    pub plaster: Handle<StandardMaterial>,
    pub wood: Handle<StandardMaterial>,
    pub dark_wood: Handle<StandardMaterial>,
    pub iron: Handle<StandardMaterial>,
    pub red: Handle<StandardMaterial>,
    pub tiles: Handle<StandardMaterial>,
    pub mark: Handle<StandardMaterial>,
    pub ghost: Handle<StandardMaterial>,
    pub refused: Handle<StandardMaterial>,
}

impl Paints {
    /// Makes all of them.
    pub fn new(materials: &mut Assets<StandardMaterial>) -> Self {
        let mut paint = |red, green, blue, perceptual_roughness, metallic| {
            let base_color = Color::srgb(red, green, blue);
            materials.add(StandardMaterial { base_color, perceptual_roughness, metallic, ..default() })
        };
        Self {
            stone: paint(0.46, 0.43, 0.40, 0.9, 0.0),
            plaster: paint(0.80, 0.74, 0.64, 0.95, 0.0),
            wood: paint(0.80, 0.56, 0.30, 0.7, 0.0),
            dark_wood: paint(0.36, 0.22, 0.12, 0.75, 0.0),
            iron: paint(0.22, 0.23, 0.25, 0.45, 0.8),
            red: paint(0.78, 0.16, 0.12, 0.5, 0.0),
            tiles: paint(0.28, 0.56, 0.55, 0.6, 0.0),
            mark: paint(0.98, 0.80, 0.20, 0.5, 0.0),
            ghost: materials.add(glass(Color::srgba(1.0, 0.85, 0.55, 0.45))),
            refused: materials.add(glass(Color::srgba(1.0, 0.15, 0.10, 0.45))),
        }
    }
}

fn glass(base_color: Color) -> StandardMaterial {
    StandardMaterial { base_color, alpha_mode: AlphaMode::Blend, ..default() }
}
