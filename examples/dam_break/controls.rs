//! The keys.

use bevy::prelude::*;
use bevy_freshet::prelude::*;

use crate::stage::{OnStage, Stage, build};

/// What each key does, for the help.
pub const KEYS: [(&str, &str); 7] = [
    ("Space", "pause or go on"),
    ("N", "one tick, while paused"),
    ("R", "start again"),
    ("C", "colour by another field"),
    ("+ / -", "more or fewer particles"),
    ("mouse, WASD, QE", "turn (left), move (right), come closer (wheel)"),
    ("H", "this help"),
];

/// What colours can mean, in the order of the key.
const COLORINGS: [(FluidField, FluidGradient); 7] = [
    (FluidField::Speed, FluidGradient::Water),
    (FluidField::Pressure, FluidGradient::Turbo),
    (FluidField::Density, FluidGradient::Diverging),
    (FluidField::Acceleration, FluidGradient::Heat),
    (FluidField::Position, FluidGradient::Viridis),
    (FluidField::Speed, FluidGradient::Turbo),
    (FluidField::Id, FluidGradient::Turbo),
];

/// Whether the help is shown.
#[derive(Resource, Default)]
pub struct Help(pub bool);

/// Pauses, steps, shows help.
pub fn keys_of_time(
    keys: Res<ButtonInput<KeyCode>>,
    mut virtual_time: ResMut<Time<Virtual>>,
    mut fixed: ResMut<Time<Fixed>>,
    mut help: ResMut<Help>,
) {
    if keys.just_pressed(KeyCode::Space) {
        if virtual_time.is_paused() {
            virtual_time.unpause();
        } else {
            virtual_time.pause();
        }
    }
    if keys.just_pressed(KeyCode::KeyN) && virtual_time.is_paused() {
        // The fixed schedule runs on what has accumulated, paused or not.
        let tick = fixed.timestep();
        fixed.accumulate_overstep(tick);
    }
    if keys.just_pressed(KeyCode::KeyH) {
        help.0 = !help.0;
    }
}

/// Changes colours.
pub fn keys_of_color(
    keys: Res<ButtonInput<KeyCode>>,
    mut stage: ResMut<Stage>,
    mut fluids: Query<&mut FluidAppearance>,
    mut chosen: Local<usize>,
) {
    if keys.just_pressed(KeyCode::KeyC) {
        *chosen = (*chosen + 1) % COLORINGS.len();
        let (field, gradient) = COLORINGS[*chosen];
        stage.coloring = FluidColoring { field, gradient, range: None };
        for mut appearance in &mut fluids {
            appearance.coloring = stage.coloring.clone();
        }
    }
}

/// Starts again, with more or fewer particles.
pub fn keys_of_scene(
    mut commands: Commands,
    keys: Res<ButtonInput<KeyCode>>,
    mut stage: ResMut<Stage>,
    on_stage: Query<Entity, With<OnStage>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let more = keys.any_just_pressed([KeyCode::NumpadAdd, KeyCode::Equal]);
    let fewer = keys.any_just_pressed([KeyCode::NumpadSubtract, KeyCode::Minus]);
    if more || fewer {
        let Some(setup) = stage.setup.scaled(if more { 1.5 } else { 1.0 / 1.5 }) else {
            warn!("the scene comes from a file, which says how many particles there are");
            return;
        };
        stage.setup = setup;
    } else if !keys.just_pressed(KeyCode::KeyR) {
        return;
    }
    for entity in &on_stage {
        commands.entity(entity).despawn();
    }
    if let Err(message) = build(&mut commands, &mut meshes, &mut materials, &stage) {
        error!("{message}");
    }
}
