//! In a window.

use bevy::prelude::*;
use bevy_egui::EguiPrimaryContextPass;
use bevy_egui::input::{egui_wants_any_keyboard_input, egui_wants_any_pointer_input};
use bevy_rapier3d::prelude::PhysicsSet;
use freshet_examples::camera::{Orbit, steer};
use freshet_examples::{daylight, window};

use crate::arguments::Arguments;
use crate::game::{self, Builder, Game, Levels};
use crate::hud::{self, Wish};
use crate::level::Level;
use crate::pointer;
use crate::site::{self, Method};

/// Opens the window; returns when it is closed, with what has gone wrong until then.
pub fn run(mut app: App, arguments: &Arguments, levels: Vec<Level>) -> Result<(), String> {
    window::furnish(&mut app, "Freshet: sluice");
    let method = Method { particles: arguments.particles, backend: arguments.backend };
    game::furnish(&mut app, levels, arguments.level - 1, method);
    app.init_resource::<Wish>()
        .add_systems(Startup, (build, set_up))
        .add_systems(
            Update,
            (
                (steer, pointer::press.pipe(pointer::act)).run_if(not(egui_wants_any_pointer_input)),
                (pointer::press_keys, hud::press_keys).run_if(not(egui_wants_any_keyboard_input)),
                pointer::show_ghost,
                hud::carry_out,
            )
                .chain(),
        )
        .add_systems(EguiPrimaryContextPass, (hud::show, hud::show_numbers).chain());
    if arguments.autoplay {
        app.add_systems(FixedUpdate, game::autoplay.before(PhysicsSet::SyncBackend));
    }
    window::run(app)
}

/// From the front, a little from the right and from above, and from afar, as a section is drawn.
pub fn camera((low, high): (Vec3, Vec3)) -> impl Bundle {
    const FIELD_OF_VIEW: f32 = 0.42;
    let size = high - low;
    let target = (low + high) / 2.0 + Vec3::Y * 0.07 * size.y;
    let buttons = [MouseButton::Right, MouseButton::Middle];
    let distance = 0.66 * size.y.max(0.56 * size.x) / (FIELD_OF_VIEW / 2.0).tan();
    let orbit = Orbit { target, distance, yaw: 0.12, pitch: 0.17, buttons };
    let lens = Projection::Perspective(PerspectiveProjection { fov: FIELD_OF_VIEW, ..default() });
    (daylight::camera(2.0 * size.length()), lens, orbit.transform(), orbit)
}

fn build(mut builder: Builder) {
    builder.rebuild();
}

fn set_up(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    (levels, game): (Res<Levels>, Res<Game>),
) {
    let bounds = site::bounds(&levels.0[game.level]);
    commands.spawn(camera(bounds));
    daylight::spawn(&mut commands, &mut meshes, &mut materials, bounds);
}
