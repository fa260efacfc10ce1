//! Without a window: pictures, a summary, a plot.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use bevy::prelude::*;
use bevy::render::renderer::RenderAdapterInfo;
use bevy_freshet::prelude::*;
use freshet_core::field::FieldData;
use freshet_examples::camera::Orbit;
use freshet_examples::headless::{
    Pictures, TICKS_PER_SECOND, advance, furnish, shoot, spawn_camera, start, ticks, update, wait_for_pictures,
};
use freshet_examples::trouble::Trouble;
use indicatif::{ProgressBar, ProgressStyle};

use crate::arguments::Arguments;
use crate::front::front;
use crate::scene::Setup;
use crate::stage::{Stage, build, build_surroundings};
use crate::summary::{Sample, Summary};

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
    let stage = Stage {
        setup,
        backend: arguments.backend,
        mode: FluidMode::Lockstep,
        coloring: FluidColoring::default(),
        style: arguments.style,
    };
    let mut app = App::new();
    furnish(&mut app, true);
    app.insert_resource(stage)
        .insert_resource(findings.clone())
        .add_systems(Startup, (set_up, build_surroundings))
        .add_systems(FixedUpdate, note_figures.after(FreshetSystems::Step))
        .add_observer(note_front);
    start(&mut app)?;
    let adapter = app.world().get_resource::<RenderAdapterInfo>().map(|info| info.name.clone());
    findings.update(|summary| summary.adapter = adapter.unwrap_or_default());
    let (trouble, written) = (app.world().resource::<Trouble>().clone(), app.world().resource::<Pictures>().clone());
    if trouble.result().is_err() {
        // Without the scene there is nothing to draw.
        return trouble.result();
    }

    let pictures = picture_ticks(ticks(arguments.seconds), arguments.pictures);
    let bar = progress(pictures.len() as u64);
    let mut done = 0;
    for (picture, &ticks) in pictures.iter().enumerate() {
        shoot(&mut app, folder.join(format!("frame_{picture:04}.png")));
        advance(&mut app, ticks - done)?;
        done = ticks;
        bar.inc(1);
        bar.set_message(
            findings.update(|summary| format!("{} particles, {:.2} s", summary.particles, summary.simulated)),
        );
    }
    wait_for_pictures(&mut app, pictures.len() as u32)?;
    if written.written() as usize == pictures.len() {
        let still = still_frames(&mut app)?;
        findings.update(|summary| summary.still_frames = still);
    }
    bar.finish_and_clear();
    let mut summary = findings.update(|summary| summary.clone());
    summary.wall = begin.elapsed().as_secs_f64();
    summary.pictures = written.written();
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

fn set_up(
    mut commands: Commands,
    mut images: ResMut<Assets<Image>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    stage: Res<Stage>,
    trouble: Res<Trouble>,
) {
    spawn_camera(&mut commands, &mut images, (Camera3d::default(), Orbit::around(stage.setup.bounds).transform()));
    match build(&mut commands, &mut meshes, &mut materials, &stage) {
        Ok(domain) => {
            commands.entity(domain).insert(FluidReadback::new([FluidField::Position]));
        }
        Err(message) => trouble.note(message),
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
