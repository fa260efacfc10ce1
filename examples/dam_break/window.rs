//! In a window.

use bevy::prelude::*;
use bevy_egui::{
    EguiPlugin, EguiPrimaryContextPass, input::egui_wants_any_keyboard_input, input::egui_wants_any_pointer_input,
};
use bevy_freshet::prelude::*;

use crate::arguments::Arguments;
use crate::camera::{Orbit, steer};
use crate::controls::{Help, keys_of_color, keys_of_scene, keys_of_time};
use crate::scene::Setup;
use crate::stage::{Stage, build, build_surroundings};
use crate::trouble::{Trouble, listen};

/// Opens the window; returns when it is closed, with what has gone wrong until then.
pub fn run(arguments: &Arguments, setup: Setup) -> Result<(), String> {
    let window = Window { title: "Freshet: dam break".to_owned(), ..default() };
    let stage =
        Stage { setup, backend: arguments.backend, mode: FluidMode::Pipelined, coloring: FluidColoring::default() };
    let trouble = Trouble::default();
    let exit = App::new()
        .add_plugins(DefaultPlugins.set(WindowPlugin { primary_window: Some(window), ..default() }))
        .add_plugins((EguiPlugin::default(), FreshetPlugins::default()))
        .insert_resource(stage)
        .insert_resource(trouble.clone())
        .init_resource::<Help>()
        .add_systems(Last, listen)
        .add_systems(Startup, (set_up, build_surroundings))
        .add_systems(
            Update,
            (
                steer.run_if(not(egui_wants_any_pointer_input)),
                (keys_of_time, keys_of_color, keys_of_scene).run_if(not(egui_wants_any_keyboard_input)),
            ),
        )
        .add_systems(EguiPrimaryContextPass, crate::panel::show)
        .run();
    trouble.result()?;
    if exit.is_error() { Err("the app failed; what it said stands above".to_owned()) } else { Ok(()) }
}

fn set_up(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    stage: Res<Stage>,
    trouble: Res<Trouble>,
    mut exits: MessageWriter<AppExit>,
) {
    let orbit = Orbit::around(&stage.setup);
    commands.spawn((Camera3d::default(), orbit.transform(), orbit));
    if let Err(message) = build(&mut commands, &mut meshes, &mut materials, &stage) {
        trouble.note(message);
        exits.write(AppExit::error());
    }
}
