//! In a window.

use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};

use bevy::prelude::*;
use bevy::winit::WinitPlugin;
use bevy_egui::EguiPlugin;
use bevy_freshet::prelude::*;

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

/// Plugins, and a window of this name.
pub fn furnish(app: &mut App, title: &str) {
    let window = Window { title: title.to_owned(), ..default() };
    let plugins = DefaultPlugins.set(WindowPlugin { primary_window: Some(window), ..default() });
    app.add_plugins(plugins.disable::<WinitPlugin>())
        .add_plugins((EguiPlugin::default(), FreshetPlugins::default()))
        .init_resource::<Trouble>()
        .add_systems(Last, listen);
}

/// Opens the window; returns when it is closed, with what has gone wrong until then.
pub fn run(mut app: App) -> Result<(), String> {
    let trouble = app.world().resource::<Trouble>().clone();
    let exit = app.run();
    trouble.result()?;
    if exit.is_error() { Err("the app failed; what it said stands above".to_owned()) } else { Ok(()) }
}
