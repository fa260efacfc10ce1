//! Without a window: plays one level to its end.

use bevy::prelude::*;
use bevy_freshet::prelude::*;
use bevy_rapier3d::prelude::PhysicsSet;
use freshet_examples::daylight;
use freshet_examples::headless::{self, advance, find_adapter, spawn_camera, start};
use freshet_examples::trouble::Trouble;

use crate::arguments::Arguments;
use crate::game::{self, Builder, Game, Levels, Phase};
use crate::level::Level;
use crate::site::{self, Method};
use crate::window;

/// Ticks in an update; the end is noticed after them.
const STRIDE: u32 = 10;

/// Plays, and prints how it ended.
pub fn run(arguments: &Arguments, levels: Vec<Level>) -> Result<(), String> {
    let adapter = find_adapter();
    if let (Err(error), true) = (&adapter, arguments.picture.is_some() || arguments.backend == FluidBackend::Gpu) {
        return Err(format!("no GPU adapter: {error}"));
    }
    // Pictures apart, nothing is to be drawn; but without Bevy's renderer there is no GPU to simulate on.
    let draws = adapter.is_ok() && (arguments.picture.is_some() || arguments.backend != FluidBackend::Cpu);
    let method = Method { particles: arguments.particles, backend: arguments.backend };
    let mut app = App::new();
    headless::furnish(&mut app, draws);
    game::furnish(&mut app, levels, arguments.level - 1, method);
    app.add_systems(Startup, begin);
    if arguments.autoplay {
        app.add_systems(FixedUpdate, game::autoplay.before(PhysicsSet::SyncBackend));
    }
    if arguments.picture.is_some() {
        app.add_systems(Startup, spawn_view);
    }
    start(&mut app)?;
    while app.world().resource::<Game>().phase == Phase::Playing {
        advance(&mut app, STRIDE)?;
        app.world().resource::<Trouble>().result()?;
    }
    print_summary(&mut app);
    match &arguments.picture {
        Some(path) => headless::picture(&mut app, path),
        None => Ok(()),
    }
}

fn begin(mut builder: Builder) {
    builder.rebuild();
    builder.begin();
}

fn spawn_view(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
    (levels, game): (Res<Levels>, Res<Game>),
) {
    let bounds = site::bounds(&levels.0[game.level]);
    let still = Camera { is_active: false, ..default() };
    spawn_camera(&mut commands, &mut images, (still, window::camera(bounds)));
    daylight::spawn(&mut commands, &mut meshes, &mut materials, bounds);
}

fn print_summary(app: &mut App) {
    let mut stats = app.world_mut().query::<&FluidStats>();
    let stats = stats.iter(app.world()).next().cloned().unwrap_or_default();
    let (game, levels) = (app.world().resource::<Game>(), app.world().resource::<Levels>());
    let level = &levels.0[game.level];
    println!(
        "{{\n  \"level\": {:?},\n  \"outcome\": {:?},\n  \"score\": {},\n  \"time_s\": {:.3},\n  \"litres\": {:.2},\n  \
         \"turns\": {:.3},\n  \"crates_left\": {},\n  \"backend\": \"{}\",\n  \"particles\": {},\n  \"removed\": {},\n  \
         \"litres_there\": {:.2}\n}}",
        level.name,
        game.phase.name(),
        game.score(level),
        game.time,
        game.litres,
        game.turns,
        game.crates,
        format!("{:?}", stats.backend).to_lowercase(),
        stats.particles,
        stats.removed,
        game.there,
    );
}
