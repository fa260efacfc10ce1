//! Without a window: a body of each shape, and how it floats.

use bevy::prelude::*;
use bevy_freshet::prelude::*;
use bevy_rapier3d::prelude::ReadMassProperties;
use freshet_examples::camera::Orbit;
use freshet_examples::daylight;
use freshet_examples::headless::{self, advance, find_adapter, spawn_camera, start, ticks};
use freshet_examples::trouble::Trouble;

use crate::arguments::Arguments;
use crate::bodies::{Dropping, Floater};
use crate::figures::{Record, Watch, json, note_level, record};
use crate::pool::{self, Pool};
use crate::shape::Shape;

/// What is dropped, and how dense it is, kg/m3.
const DROPPED: [(Shape, f32); 8] = [
    (Shape::Ball, 200.0),
    (Shape::Cube, 500.0),
    (Shape::Cylinder, 600.0),
    (Shape::Capsule, 350.0),
    (Shape::Cone, 400.0),
    (Shape::Cross, 500.0),
    (Shape::Boat, 1200.0),
    (Shape::Ball, 3000.0),
];
/// m.
const SIZE: f32 = 0.36;
/// How long bodies are looked at, at the end, s.
const LOOK: f32 = 1.0;

/// Simulates, and prints figures.
pub fn run(arguments: &Arguments) -> Result<(), String> {
    let adapter = find_adapter();
    if let (Err(error), true) = (&adapter, arguments.picture.is_some() || arguments.backend == FluidBackend::Gpu) {
        return Err(format!("no GPU adapter: {error}"));
    }
    // Pictures apart, nothing is to be drawn; but without Bevy's renderer there is no GPU to simulate on.
    let draws = adapter.is_ok() && (arguments.picture.is_some() || arguments.backend != FluidBackend::Cpu);
    let mut app = App::new();
    headless::furnish(&mut app, draws);
    app.insert_resource(Pool::new(arguments.particles, arguments.backend, FluidMode::Lockstep))
        .init_resource::<Watch>()
        .add_systems(FixedUpdate, record.after(FreshetSystems::Complete))
        .add_observer(note_level)
        .add_systems(Startup, (spawn_scene, drop_bodies).chain());
    if arguments.picture.is_some() {
        app.add_systems(Startup, spawn_view);
    }
    start(&mut app)?;
    let (all, last) = (ticks(arguments.seconds), ticks(LOOK.min(arguments.seconds)));
    advance(&mut app, all - last)?;
    let mut domains = app.world_mut().query_filtered::<Entity, With<FluidDomain>>();
    let domain = domains.single(app.world()).map_err(|error| error.to_string())?;
    app.world_mut().entity_mut(domain).insert(FluidReadback::new([FluidField::Position]));
    app.world_mut().resource_mut::<Watch>().is_on = true;
    advance(&mut app, last)?;
    app.world().resource::<Trouble>().result()?;
    print_summary(&mut app, domain)?;
    match &arguments.picture {
        Some(path) => headless::picture(&mut app, path),
        None => Ok(()),
    }
}

fn spawn_scene(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    pool: Res<Pool>,
) {
    pool::spawn(&mut commands, &mut meshes, &mut materials, &pool);
}

fn spawn_view(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) {
    let bounds = pool::bounds();
    let still = Camera { is_active: false, ..default() };
    let camera = (still, daylight::camera(pool::SIZE.length()), Orbit::around(bounds).transform());
    spawn_camera(&mut commands, &mut images, camera);
    daylight::spawn(&mut commands, &mut meshes, &mut materials, bounds);
}

/// In two rows.
fn drop_bodies(mut dropping: Dropping, domains: Query<Entity, With<FluidDomain>>, pool: Res<Pool>) -> Result {
    let (domain, columns) = (domains.single()?, DROPPED.len() / 2);
    for (index, (shape, density)) in DROPPED.into_iter().enumerate() {
        let cell = Vec2::new((index % columns) as f32 + 0.5, (index / columns) as f32 + 0.5);
        let place = (cell / Vec2::new(columns as f32, 2.0) - 0.5) * Vec2::new(pool::SIZE.x, pool::SIZE.z);
        let position = Vec3::new(place.x, pool.depth + 0.8 * SIZE, place.y);
        dropping.drop(domain, Floater { shape, size: SIZE, density }, position, Record::default());
    }
    Ok(())
}

fn print_summary(app: &mut App, domain: Entity) -> Result<(), String> {
    let (watch, pool) = (*app.world().resource::<Watch>(), *app.world().resource::<Pool>());
    let stats = app.world().get::<FluidStats>(domain).ok_or("the domain has gone")?.clone();
    let mut bodies = app.world_mut().query::<(&Floater, &Record, &ReadMassProperties, &Transform)>();
    let bodies = bodies.iter(app.world()).map(|(floater, record, mass, pose)| (*floater, *record, *mass, *pose));
    println!(
        "{{\n  \"backend\": \"{}\",\n  \"particles\": {},\n  \"spacing_m\": {:.5},\n  \"simulated_s\": {:.4},\n  \"removed\": {},\n  \
         \"level_m\": {:.4},\n  \"max_speed_m_s\": {:.3},\n  \"bodies\": [\n{}\n  ]\n}}",
        format!("{:?}", stats.backend).to_lowercase(),
        stats.particles,
        pool.spacing,
        stats.time,
        stats.removed,
        watch.level,
        watch.max_speed,
        json(bodies),
    );
    Ok(())
}
