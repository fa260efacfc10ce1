//! In a window.

use bevy::prelude::*;
use bevy_egui::EguiPrimaryContextPass;
use bevy_egui::input::egui_wants_any_pointer_input;
use bevy_freshet::prelude::*;
use bevy_rapier3d::prelude::PhysicsSet;
use freshet_examples::camera::{Orbit, steer};
use freshet_examples::{daylight, window};

use crate::arguments::Arguments;
use crate::panel::{self, Wishes};
use crate::pointer;
use crate::pool::{self, Pool};

/// Opens the window; returns when it is closed, with what has gone wrong until then.
pub fn run(mut app: App, arguments: &Arguments) -> Result<(), String> {
    window::furnish(&mut app, "Freshet: floating bodies");
    app.insert_resource(Pool::new(arguments.particles, arguments.backend, FluidMode::Pipelined))
        .init_resource::<Wishes>()
        .init_resource::<pointer::Picked>()
        .init_resource::<pointer::Grip>()
        .add_systems(Startup, set_up)
        .add_systems(
            Update,
            (
                steer.run_if(not(egui_wants_any_pointer_input)),
                (pointer::press.run_if(not(egui_wants_any_pointer_input)), pointer::follow, pointer::show_ghost)
                    .chain(),
                pointer::highlight,
                panel::carry_out,
            ),
        )
        .add_systems(FixedUpdate, pointer::pull.before(PhysicsSet::SyncBackend))
        .add_systems(EguiPrimaryContextPass, panel::show);
    window::run(app)
}

fn set_up(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    pool: Res<Pool>,
) {
    let bounds = pool::bounds();
    let orbit = Orbit { buttons: [MouseButton::Right, MouseButton::Middle], ..Orbit::around(bounds) };
    commands.spawn((daylight::camera(pool::SIZE.length()), orbit.transform(), orbit));
    daylight::spawn(&mut commands, &mut meshes, &mut materials, bounds);
    pool::spawn(&mut commands, &mut meshes, &mut materials, &pool);
    pointer::spawn_ghost(&mut commands, &mut materials);
}
