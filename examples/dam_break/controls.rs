//! The keys.

use bevy::input::keyboard::Key;
use bevy::prelude::*;
use bevy_freshet::prelude::*;
use freshet_examples::trouble::Trouble;

use crate::stage::{OnStage, SURFACE, Stage, build};

/// What each key does, for the help.
pub const KEYS: [(&str, &str); 8] = [
    ("Space", "pause or go on"),
    ("N", "one tick, while paused"),
    ("R", "start again"),
    ("C", "colour by another field"),
    ("V", "draw spheres or a surface"),
    ("+ / -", "more or fewer particles"),
    ("mouse, WASD, QE", "turn (left), move (right), come closer (wheel)"),
    ("H", "this help"),
];

/// The keys that are always shown.
pub const KEY_LINE: &str =
    "Space: pause | N: one tick | R: start again | C: colour | V: surface | + / -: more or fewer particles | H: help";

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

/// Changes colours, and what is drawn.
pub fn keys_of_looks(
    keys: Res<ButtonInput<KeyCode>>,
    mut stage: ResMut<Stage>,
    mut fluids: Query<&mut FluidAppearance>,
    mut chosen: Local<usize>,
) {
    if keys.just_pressed(KeyCode::KeyC) {
        *chosen = (*chosen + 1) % COLORINGS.len();
        let (field, gradient) = COLORINGS[*chosen];
        stage.coloring = FluidColoring { field, gradient, range: None };
    }
    if keys.just_pressed(KeyCode::KeyV) {
        stage.style = if stage.style == FluidStyle::Spheres { SURFACE } else { FluidStyle::Spheres };
    }
    for mut appearance in &mut fluids {
        appearance.set_if_neq(stage.appearance());
    }
}

/// Starts again, with more or fewer particles.
pub fn keys_of_scene(
    mut commands: Commands,
    (keys, typed): (Res<ButtonInput<KeyCode>>, Res<ButtonInput<Key>>),
    mut stage: ResMut<Stage>,
    trouble: Res<Trouble>,
    on_stage: Query<Entity, With<OnStage>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    if let Some(factor) = wanted_factor(&keys, &typed) {
        match stage.setup.scaled(factor) {
            Ok(setup) => stage.setup = setup,
            Err(message) => {
                warn!("{message}");
                return;
            }
        }
    } else if !keys.just_pressed(KeyCode::KeyR) {
        return;
    }
    for entity in &on_stage {
        commands.entity(entity).despawn();
    }
    if let Err(message) = build(&mut commands, &mut meshes, &mut materials, &stage) {
        trouble.note(message);
    }
}

/// More or fewer particles: by what is written on the key, and otherwise by where it is on a US keyboard.
fn wanted_factor(keys: &ButtonInput<KeyCode>, typed: &ButtonInput<Key>) -> Option<f32> {
    const MORE: f32 = 1.5;
    let types = |texts: &[&str]| texts.iter().any(|text| typed.just_pressed(Key::Character((*text).into())));
    if types(&["+", "="]) {
        Some(MORE)
    } else if types(&["-", "_"]) {
        Some(1.0 / MORE)
    } else if keys.any_just_pressed([KeyCode::NumpadAdd, KeyCode::Equal]) {
        Some(MORE)
    } else if keys.any_just_pressed([KeyCode::NumpadSubtract, KeyCode::Minus]) {
        Some(1.0 / MORE)
    } else {
        None
    }
}
