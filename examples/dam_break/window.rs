//! In a window.

use bevy::prelude::*;
use bevy_egui::EguiPrimaryContextPass;
use bevy_egui::input::{egui_wants_any_keyboard_input, egui_wants_any_pointer_input};
use bevy_freshet::prelude::*;
use freshet_examples::camera::{Orbit, steer};
use freshet_examples::trouble::Trouble;
use freshet_examples::window;

use crate::arguments::Arguments;
use crate::controls::{Help, keys_of_looks, keys_of_scene, keys_of_time};
use crate::scene::Setup;
use crate::stage::{Stage, build, build_surroundings};

/// Opens the window; returns when it is closed, with what has gone wrong until then.
pub fn run(mut app: App, arguments: &Arguments, setup: Setup) -> Result<(), String> {
    let stage = Stage {
        setup,
        backend: arguments.backend,
        mode: FluidMode::Pipelined,
        coloring: FluidColoring::default(),
        style: arguments.style,
    };
    window::furnish(&mut app, "Freshet: dam break");
    app.insert_resource(stage)
        .init_resource::<Help>()
        .add_systems(Startup, (set_up, build_surroundings))
        .add_systems(
            Update,
            (
                steer.run_if(not(egui_wants_any_pointer_input)),
                (keys_of_time, keys_of_looks, keys_of_scene).run_if(not(egui_wants_any_keyboard_input)),
            ),
        )
        .add_systems(EguiPrimaryContextPass, crate::panel::show);
    window::run(app)
}

fn set_up(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    stage: Res<Stage>,
    trouble: Res<Trouble>,
    mut exits: MessageWriter<AppExit>,
) {
    let orbit = Orbit::around(stage.setup.bounds);
    commands.spawn((Camera3d::default(), orbit.transform(), orbit));
    if let Err(message) = build(&mut commands, &mut meshes, &mut materials, &stage) {
        trouble.note(message);
        exits.write(AppExit::error());
    }
}
