//! A cube without gravity and without clamped pressures: its own tension rounds it off (Pirovano 2011, section 5.3.1), and double
//! density relaxation keeps its particles from clumping, as it does there.

use freshet_core::plan::Plan;
use freshet_core::scene::{FluidScene, Volume};
use glam::Vec3;

use super::super::{Case, Job, Level, Study, Trace};
use crate::drive::Drive;
use crate::error::LabError;
use crate::measure::spacing::{nearest_distances, pair_distances};
use crate::progress::Progress;
use crate::verdict::{Bound, Check};

/// The case.
pub const CASE: Case = Case {
    name: "relaxing-cube",
    about: "a cube without gravity rounds itself off for 5 s without clumping (P 5.3.1): distances of its particles",
    run: |job| STUDY.run(job),
};

const STUDY: Study = Study {
    name: "relaxing-cube",
    title: "Distances of pairs in a cube that has relaxed for 5 s",
    measure: "particles nearer than 0.7 d to another",
    bound: 0.01,
    coarse_bound: None,
    smooth: false,
    resolutions: [8, 12, 16],
    quick: &[6, 8],
    axes: ["distance / d", "pairs / pairs of the same density at random"],
    simulate,
};

/// Edge of the cube, m.
const EDGE: f32 = 1.0;
/// Speed that sets the stiffness, m/s: sound crosses the cube fifty times.
const SPEED: f32 = 1.0;
/// Near pressure over the square of the speed of sound: with none, 85 to 92 % of the particles clump.
const NEAR_PRESSURE: f32 = 0.01;
/// Alpha: with the default of 0.03 the first shrinking of the surface throws a few particles out of the smallest cube.
const VISCOSITY: f32 = 0.1;
/// Time to relax, s.
const END: f64 = 5.0;
/// Duration of a tick, s.
const TICK: f64 = 0.05;
/// What counts as clumped, spacings.
const CLUMPED: f32 = 0.7;

fn scene(resolution: u32) -> FluidScene {
    let mut scene = FluidScene {
        gravity: Vec3::ZERO,
        volumes: vec![Volume::block(Vec3::splat(EDGE / 2.0), Vec3::ZERO)],
        ..FluidScene::with_spacing(EDGE / resolution as f32)
    };
    scene.settings.clamp_negative_pressure = false;
    scene.settings.near_pressure = NEAR_PRESSURE;
    scene.settings.artificial_viscosity = VISCOSITY;
    scene.settings.expected_speed = Some(SPEED);
    scene
}

fn simulate(job: &Job, resolution: u32, progress: &mut Progress) -> Result<Level, LabError> {
    let plan = Plan::new(&scene(resolution))?;
    let spacing = plan.parameters.spacing;
    let roundness_before = roundness(&plan.positions);
    let mut drive = Drive::open(job.backend, plan, job.threads.count(), Vec::new())?;
    let ticks = (END / TICK).round() as u32;
    for tick in 1..=ticks {
        drive.tick(TICK)?;
        progress.at(f64::from(tick) / f64::from(ticks));
    }
    let positions = drive.positions()?;
    let nearest = nearest_distances(&positions, 2.0 * spacing);
    let clumped = nearest.iter().filter(|&&distance| distance < CLUMPED * spacing).count();
    let points = distribution(&positions, spacing);
    // That it has moved at all: a cube's corners are 1.73 times as far out as the middles of its faces, a ball's nowhere.
    let rounder = roundness(&positions) / roundness_before;
    let checks = vec![Check::new(
        "furthest over mean distance from the centre, now over start",
        rounder,
        "",
        Bound::Below(0.95),
    )];
    Ok(Level {
        resolution,
        particles: positions.len(),
        error: clumped as f64 / positions.len() as f64,
        traces: vec![Trace { name: "pairs".to_owned(), points }],
        checks,
        remarks: Vec::new(),
        account: drive.account().clone(),
    })
}

/// Largest over mean distance from the centre.
fn roundness(positions: &[Vec3]) -> f64 {
    let count = positions.len() as f32;
    let centre = positions.iter().sum::<Vec3>() / count;
    let distances = || positions.iter().map(|position| position.distance(centre));
    f64::from(distances().fold(0.0, f32::max) / (distances().sum::<f32>() / count))
}

/// Pairs in shells a twentieth of a spacing thick, over those that particles a spacing apart would have at random.
fn distribution(positions: &[Vec3], spacing: f32) -> Vec<(f64, f64, f64)> {
    const SHELL: f64 = 0.05;
    const SHELLS: usize = 60;
    let mut counts = [0u32; SHELLS];
    for distance in pair_distances(positions, SHELL as f32 * SHELLS as f32 * spacing * 0.9999) {
        counts[((f64::from(distance / spacing)) / SHELL) as usize] += 1;
    }
    let shell = |(index, count): (usize, &u32)| {
        let radius = (index as f64 + 0.5) * SHELL;
        let random = 0.5 * positions.len() as f64 * 4.0 * std::f64::consts::PI * radius * radius * SHELL;
        (radius, f64::from(*count) / random, f64::NAN)
    };
    counts.iter().enumerate().map(shell).collect()
}
