//! Without a window: pictures, a summary, a plot.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use bevy::app::PluginsState;
use bevy::camera::RenderTarget;
use bevy::log::LogPlugin;
use bevy::prelude::*;
use bevy::render::pipelined_rendering::PipelinedRenderingPlugin;
use bevy::render::render_resource::{PipelineCache, PollType, TextureFormat};
use bevy::render::renderer::{RenderAdapterInfo, RenderDevice};
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured};
use bevy::render::{RenderApp, RenderPlugin};
use bevy::time::TimeUpdateStrategy;
use bevy::window::ExitCondition;
use bevy::winit::WinitPlugin;
use bevy_freshet::prelude::*;
use freshet_core::field::FieldData;
use indicatif::{ProgressBar, ProgressStyle};

use crate::arguments::{Arguments, TICKS_PER_SECOND};
use crate::camera::Orbit;
use crate::front::front;
use crate::scene::Setup;
use crate::stage::{Stage, build, build_surroundings};
use crate::summary::{Sample, Summary};
use crate::trouble::{Trouble, listen};

const SIZE: UVec2 = UVec2::new(1280, 720);
/// Updates until pipelines must be ready; they compile in a few.
const PATIENCE: u32 = 600;
/// Updates until the last picture must have come; it is two late.
const PICTURE_PATIENCE: u32 = 60;

/// Frames at the end by which drawing is timed apart from simulating.
const STILL_FRAMES: u32 = 10;

/// What the run has found.
#[derive(Resource, Default, Clone)]
struct Findings(Arc<Mutex<Summary>>);

impl Findings {
    fn update<T>(&self, change: impl FnOnce(&mut Summary) -> T) -> T {
        change(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// What the camera draws to.
#[derive(Resource)]
struct Canvas(Handle<Image>);

/// A bar on the terminal.
pub fn progress(length: u64) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:40.cyan/blue} {pos}/{len} {msg} [{elapsed} < {eta}]");
    let bar = ProgressBar::new(length);
    if let Ok(style) = style { bar.with_style(style) } else { bar }
}

/// Simulates and writes.
pub fn run(arguments: &Arguments, setup: Setup) -> Result<(), String> {
    let begin = Instant::now();
    let folder = &arguments.out;
    let findings = Findings::default();
    findings.update(|summary| {
        summary.spacing = setup.spacing;
        summary.least_time_scale = 1.0;
    });
    // Waited for, so that drawing does not take the cores from the solver whose time is measured.
    let stage =
        Stage { setup, backend: arguments.backend, mode: FluidMode::Lockstep, coloring: FluidColoring::default() };
    let trouble = Trouble::default();
    let mut app = app(stage, findings.clone(), trouble.clone());
    let adapter = app.world().get_resource::<RenderAdapterInfo>().map(|info| info.name.clone());
    findings.update(|summary| summary.adapter = adapter.unwrap_or_default());

    let pictures = picture_ticks(arguments.ticks(), arguments.pictures);
    let bar = progress(pictures.len() as u64);
    wait_for_pipelines(&mut app)?;
    if trouble.result().is_err() {
        // Without the scene there is nothing to draw.
        return trouble.result();
    }
    let mut done = 0;
    for (picture, &ticks) in pictures.iter().enumerate() {
        app.insert_resource(TimeUpdateStrategy::FixedTimesteps(ticks - done));
        done = ticks;
        shoot(&mut app, folder.join(format!("frame_{picture:04}.png")));
        update(&mut app)?;
        bar.inc(1);
        bar.set_message(
            findings.update(|summary| format!("{} particles, {:.2} s", summary.particles, summary.simulated)),
        );
    }
    app.insert_resource(TimeUpdateStrategy::FixedTimesteps(0));
    for _ in 0..PICTURE_PATIENCE {
        update(&mut app)?;
        if findings.update(|summary| summary.pictures as usize == pictures.len()) || trouble.result().is_err() {
            break;
        }
    }
    if findings.update(|summary| summary.pictures as usize == pictures.len()) {
        let still = still_frames(&mut app)?;
        findings.update(|summary| summary.still_frames = still);
    }
    bar.finish_and_clear();
    let mut summary = findings.update(|summary| summary.clone());
    summary.wall = begin.elapsed().as_secs_f64();
    summary.write(folder)?;
    trouble.result()?;
    let missing = pictures.len() - summary.pictures as usize;
    if missing > 0 {
        return Err(format!("{}: {missing} of {} pictures are missing", folder.display(), pictures.len()));
    }
    Ok(())
}

/// At which ticks there are pictures: one at the start (the fluid is there from the first tick on), and one at the end.
fn picture_ticks(ticks: u32, pictures_per_second: u32) -> Vec<u32> {
    let regular = (0..).map(|picture| (picture * TICKS_PER_SECOND / pictures_per_second).max(1));
    let mut pictures: Vec<u32> = regular.take_while(|tick| *tick < ticks).collect();
    pictures.push(ticks);
    pictures.dedup();
    pictures
}

fn app(stage: Stage, findings: Findings, trouble: Trouble) -> App {
    let mut app = App::new();
    app.add_plugins(
        DefaultPlugins
            .set(WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() })
            .set(RenderPlugin { synchronous_pipeline_compilation: true, ..default() })
            .set(LogPlugin { filter: "warn".to_owned(), ..default() })
            .disable::<WinitPlugin>()
            .disable::<PipelinedRenderingPlugin>(),
    )
    .add_plugins(FreshetPlugins::default())
    .insert_resource(Time::<Fixed>::from_hz(f64::from(TICKS_PER_SECOND)))
    .insert_resource(TimeUpdateStrategy::FixedTimesteps(0))
    // Between two pictures there may be more than the quarter of a second to which Bevy limits an update.
    .insert_resource(Time::<Virtual>::from_max_delta(Duration::MAX))
    .insert_resource(stage)
    .insert_resource(findings)
    .insert_resource(trouble)
    .add_systems(Startup, (set_up, build_surroundings))
    .add_systems(FixedUpdate, note_figures.after(FreshetSystems::Step))
    .add_systems(Last, listen)
    .add_observer(note_front);
    while app.plugins_state() == PluginsState::Adding {
        std::thread::sleep(Duration::from_millis(1));
    }
    app.finish();
    app.cleanup();
    app
}

fn set_up(
    mut commands: Commands,
    mut images: ResMut<Assets<Image>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    stage: Res<Stage>,
    trouble: Res<Trouble>,
) {
    let canvas = images.add(Image::new_target_texture(SIZE.x, SIZE.y, TextureFormat::Rgba8UnormSrgb, None));
    let orbit = Orbit::around(&stage.setup);
    commands.spawn((Camera3d::default(), RenderTarget::Image(canvas.clone().into()), orbit.transform()));
    commands.insert_resource(Canvas(canvas));
    match build(&mut commands, &mut meshes, &mut materials, &stage) {
        Ok(domain) => {
            commands.entity(domain).insert(FluidReadback::new([FluidField::Position]));
        }
        Err(message) => trouble.note(message),
    }
}

/// One update; an app that wants to exit has failed.
fn update(app: &mut App) -> Result<(), String> {
    app.update();
    // A software driver draws on the cores the solver needs: finished first, or the solver's time would be measured too long.
    let drawn = app.world().get_resource::<RenderDevice>().map(|device| device.poll(PollType::wait_indefinitely()));
    if let Some(Err(error)) = drawn {
        return Err(error.to_string());
    }
    match app.should_exit() {
        None => Ok(()),
        Some(_) => Err("the renderer failed; what it said stands above".to_owned()),
    }
}

/// Wall times of frames in which nothing is simulated, s. Bevy draws the whole scene anew in each, the fluid as it is at the end.
fn still_frames(app: &mut App) -> Result<Vec<f64>, String> {
    let mut times = Vec::new();
    for _ in 0..STILL_FRAMES {
        let begin = Instant::now();
        update(app)?;
        times.push(begin.elapsed().as_secs_f64());
    }
    Ok(times)
}

/// Updates until nothing waits to be compiled.
fn wait_for_pipelines(app: &mut App) -> Result<(), String> {
    // The first updates ask for pipelines.
    for _ in 0..4 {
        update(app)?;
    }
    for _ in 0..PATIENCE {
        let is_ready = app
            .get_sub_app(RenderApp)
            .and_then(|render| render.world().get_resource::<PipelineCache>())
            .is_none_or(|cache| cache.waiting_pipelines().next().is_none());
        if is_ready {
            return Ok(());
        }
        update(app)?;
    }
    Err("pipelines did not become ready".to_owned())
}

fn shoot(app: &mut App, path: PathBuf) {
    let canvas = app.world().resource::<Canvas>().0.clone();
    app.world_mut().spawn(Screenshot::image(canvas)).observe(
        move |captured: On<ScreenshotCaptured>, findings: Res<Findings>, trouble: Res<Trouble>| match save(
            &captured.image,
            &path,
        ) {
            Ok(()) => findings.update(|summary| summary.pictures += 1),
            Err(message) => trouble.note(format!("{}: {message}", path.display())),
        },
    );
}

fn save(image: &Image, path: &Path) -> Result<(), String> {
    let picture = image.clone().try_into_dynamic().map_err(|error| error.to_string())?;
    picture.to_rgb8().save(path).map_err(|error| error.to_string())
}

fn note_figures(domains: Query<&FluidStats, Changed<FluidStats>>, findings: Res<Findings>) {
    for stats in &domains {
        findings.update(|summary| {
            summary.backend = format!("{:?}", stats.backend).to_lowercase();
            summary.particles = stats.particles;
            if stats.ticks == 0 {
                return;
            }
            summary.simulated = stats.time;
            summary.ticks = stats.ticks;
            summary.solver += f64::from(stats.milliseconds) / 1e3;
            summary.substeps += u64::from(stats.substeps);
            summary.least_time_scale = summary.least_time_scale.min(stats.time_scale);
            summary.mean_compression = summary.mean_compression.max(stats.mean_compression);
            summary.max_compression = summary.max_compression.max(stats.max_compression);
            summary.max_speed = summary.max_speed.max(stats.max_speed);
            summary.removed = stats.removed;
        });
    }
}

fn note_front(read: On<FluidReadbackComplete>, domains: Query<&FluidStats>, findings: Res<Findings>) {
    if let Some(FieldData::Vector(positions)) = read.get(FluidField::Position)
        && let Ok(stats) = domains.get(read.entity)
    {
        findings.update(|summary| {
            if let Some(front) = front(positions, summary.spacing) {
                summary.fronts.push(Sample { time: stats.time, front });
            }
        });
    }
}
