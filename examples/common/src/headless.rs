//! Without a window: ticks as fast as they go, and pictures.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use bevy::app::PluginsState;
use bevy::camera::RenderTarget;
use bevy::log::LogPlugin;
use bevy::prelude::*;
use bevy::render::pipelined_rendering::PipelinedRenderingPlugin;
use bevy::render::render_resource::{PipelineCache, PollType, TextureFormat};
use bevy::render::renderer::RenderDevice;
use bevy::render::settings::{RenderCreation, WgpuSettings};
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured};
use bevy::render::{RenderApp, RenderPlugin};
use bevy::time::TimeUpdateStrategy;
use bevy::window::ExitCondition;
use bevy::winit::WinitPlugin;
use bevy_freshet::prelude::*;

use crate::trouble::{Trouble, listen};

/// Fixed ticks in a second.
pub const TICKS_PER_SECOND: u32 = 60;

/// Size of a picture, pixels.
const SIZE: UVec2 = UVec2::new(1280, 720);
/// Updates until pipelines must be ready; they compile in a few.
const PATIENCE: u32 = 600;
/// Updates until the last picture must have come; it is two late.
const PICTURE_PATIENCE: u32 = 60;

/// What the camera draws to.
#[derive(Resource, Clone)]
pub struct Canvas(Handle<Image>);

/// Pictures written so far.
#[derive(Resource, Clone, Default)]
pub struct Pictures(Arc<Mutex<u32>>);

impl Pictures {
    /// How many.
    pub fn written(&self) -> u32 {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Ticks in so many seconds, at least one.
pub fn ticks(seconds: f32) -> u32 {
    (f64::from(seconds) * f64::from(TICKS_PER_SECOND)).round().max(1.0) as u32
}

/// Whether anything can draw; the error is why nothing can. Bevy's renderer gives up the whole app if there is no adapter.
pub fn find_adapter() -> Result<(), String> {
    let device = freshet_gpu::open_device(freshet_gpu::DeviceRequest::default());
    device.map(|_| ()).map_err(|error| error.to_string())
}

/// Plugins, a fixed step, no window. Without a renderer nothing is drawn, and the CPU simulates.
pub fn furnish(app: &mut App, draws: bool) {
    let (render, filter) = if draws {
        (RenderPlugin { synchronous_pipeline_compilation: true, ..default() }, "warn")
    } else {
        let none = WgpuSettings { backends: None, ..default() };
        let render = RenderPlugin { render_creation: RenderCreation::Automatic(Box::new(none)), ..default() };
        // Bevy's other plugins complain that there is none.
        (render, "warn,bevy_render=off,bevy_gizmos_render=off,bevy_gltf=off")
    };
    app.add_plugins(
        DefaultPlugins
            .set(WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() })
            .set(render)
            .set(LogPlugin { filter: filter.to_owned(), ..default() })
            .disable::<WinitPlugin>()
            .disable::<PipelinedRenderingPlugin>(),
    )
    .add_plugins(FreshetPlugins::default())
    .insert_resource(Time::<Fixed>::from_hz(f64::from(TICKS_PER_SECOND)))
    .insert_resource(TimeUpdateStrategy::FixedTimesteps(0))
    // An update may have more ticks than the quarter of a second to which Bevy limits it.
    .insert_resource(Time::<Virtual>::from_max_delta(Duration::MAX))
    .init_resource::<Trouble>()
    .init_resource::<Pictures>()
    .add_systems(Last, listen);
}

/// A camera that draws to what pictures are taken of. With a [`Camera`] that is not active nothing is drawn until [`picture`].
pub fn spawn_camera(commands: &mut Commands, images: &mut Assets<Image>, camera: impl Bundle) {
    let canvas = images.add(Image::new_target_texture(SIZE.x, SIZE.y, TextureFormat::Rgba8UnormSrgb, None));
    commands.spawn((camera, RenderTarget::Image(canvas.clone().into())));
    commands.insert_resource(Canvas(canvas));
}

/// Startup systems, and all pipelines, before the first tick.
pub fn start(app: &mut App) -> Result<(), String> {
    while app.plugins_state() == PluginsState::Adding {
        std::thread::sleep(Duration::from_millis(1));
    }
    app.finish();
    app.cleanup();
    wait_for_pipelines(app)
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

/// One update; an app that wants to exit has failed.
pub fn update(app: &mut App) -> Result<(), String> {
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

/// One update with so many fixed ticks.
pub fn advance(app: &mut App, ticks: u32) -> Result<(), String> {
    app.insert_resource(TimeUpdateStrategy::FixedTimesteps(ticks));
    update(app)
}

/// Takes a picture in the next update, which comes some updates later.
pub fn shoot(app: &mut App, path: PathBuf) {
    let canvas = app.world().resource::<Canvas>().0.clone();
    app.world_mut().spawn(Screenshot::image(canvas)).observe(
        move |captured: On<ScreenshotCaptured>, pictures: Res<Pictures>, trouble: Res<Trouble>| match save(
            &captured.image,
            &path,
        ) {
            Ok(()) => *pictures.0.lock().unwrap_or_else(PoisonError::into_inner) += 1,
            Err(message) => trouble.note(format!("{}: {message}", path.display())),
        },
    );
}

fn save(image: &Image, path: &Path) -> Result<(), String> {
    let picture = image.clone().try_into_dynamic().map_err(|error| error.to_string())?;
    picture.to_rgb8().save(path).map_err(|error| error.to_string())
}

/// Updates without ticks until so many pictures are written, or something has gone wrong.
pub fn wait_for_pictures(app: &mut App, count: u32) -> Result<(), String> {
    let (pictures, trouble) = (app.world().resource::<Pictures>().clone(), app.world().resource::<Trouble>().clone());
    for _ in 0..PICTURE_PATIENCE {
        if pictures.written() == count || trouble.result().is_err() {
            break;
        }
        advance(app, 0)?;
    }
    Ok(())
}

/// A picture of how it is now; nothing is drawn before it by cameras that are not active.
pub fn picture(app: &mut App, path: &Path) -> Result<(), String> {
    app.insert_resource(TimeUpdateStrategy::FixedTimesteps(0));
    let mut cameras = app.world_mut().query::<&mut Camera>();
    cameras.iter_mut(app.world_mut()).for_each(|mut camera| camera.is_active = true);
    wait_for_pipelines(app)?;
    let written = app.world().resource::<Pictures>().written();
    shoot(app, path.to_owned());
    wait_for_pictures(app, written + 1)?;
    app.world().resource::<Trouble>().result()?;
    let is_there = app.world().resource::<Pictures>().written() > written;
    if is_there { Ok(()) } else { Err(format!("{}: no picture came", path.display())) }
}
