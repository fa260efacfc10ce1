//! In a window.

use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};

use bevy::prelude::*;
use bevy::winit::WinitPlugin;
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

/// An app that can open windows; the error is why there can be none: no display, or one that cannot be reached.
pub fn open() -> Result<App, String> {
    let mut app = App::new();
    // Bevy says so by a panic, whose message would stand among ours.
    let hook = take_hook();
    set_hook(Box::new(|_| {}));
    let attempt = catch_unwind(AssertUnwindSafe(|| {
        app.add_plugins(WinitPlugin::default());
    }));
    set_hook(hook);
    attempt.map(|()| app).map_err(|panic| {
        let said = panic.downcast_ref::<String>().map_or("no reason is known", String::as_str);
        // What stands before the cause is a place in the source of the window library.
        let cause = said.rsplit_once("error: ").map_or(said, |(_, cause)| cause);
        cause.lines().next().unwrap_or_default().trim_end_matches(" })").to_owned()
    })
}

/// Opens the window; returns when it is closed, with what has gone wrong until then.
pub fn run(mut app: App, arguments: &Arguments, setup: Setup) -> Result<(), String> {
    let window = Window { title: "Freshet: dam break".to_owned(), ..default() };
    let stage =
        Stage { setup, backend: arguments.backend, mode: FluidMode::Pipelined, coloring: FluidColoring::default() };
    let trouble = Trouble::default();
    let plugins = DefaultPlugins.set(WindowPlugin { primary_window: Some(window), ..default() });
    let exit = app
        .add_plugins(plugins.disable::<WinitPlugin>())
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
