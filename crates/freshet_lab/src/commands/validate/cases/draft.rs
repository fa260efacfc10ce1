//! Balls and cubes afloat: how deep they lie, against Archimedes.

use rapier3d::dynamics::RigidBodyBuilder;
use rapier3d::geometry::{ColliderBuilder, SharedShape};

use super::super::{Case, Job, Level, Study, Trace};
use crate::afloat::{DIAMETER, TICK, Tank};
use crate::drive::Account;
use crate::error::LabError;
use crate::measure::statistics::mean;
use crate::progress::Progress;
use crate::reference::archimedes;
use crate::verdict::{Bound, Check};

/// The case.
pub const CASE: Case = Case {
    name: "draft",
    about: "balls and upright cubes of 0.2, 0.5 and 0.8 times the water's density afloat, by DFSPH, two ticks late: draft; Archimedes",
    run: |job| STUDY.run(job),
};

const STUDY: Study = Study {
    name: "draft",
    title: "Draft of balls and cubes, in a tank 4 D wide and 3 D deep",
    measure: "largest error of the draft over D",
    bound: 0.03,
    coarse_bound: Some(0.03),
    smooth: false,
    resolutions: [6, 10, 16],
    quick: &[6],
    axes: ["time (s)", "draft / D"],
    simulate,
};

/// Density over the water's, and the quick form's: `float` has the ball of half of it.
const RATIOS: [&[f64]; 2] = [&[0.2, 0.5, 0.8], &[0.2, 0.8]];
/// Time to simulate, s, and the quick form's.
const END: [f64; 2] = [8.0, 2.0];
/// Ticks until rapier hears of an impulse.
const LATENCY: u64 = 2;

/// A shape as wide as D, its volume over D^3, and its draft over D.
struct Floater {
    name: &'static str,
    shape: fn() -> SharedShape,
    volume: f64,
    draft: fn(f64) -> f64,
    submerged: fn(f64) -> f64,
}

const FLOATERS: [Floater; 2] = [
    Floater {
        name: "ball",
        shape: || SharedShape::ball(DIAMETER / 2.0),
        volume: std::f64::consts::PI / 6.0,
        draft: archimedes::draft_of_ball,
        submerged: |draft| draft * draft * (3.0 - 2.0 * draft),
    },
    Floater {
        name: "cube",
        shape: || SharedShape::cuboid(DIAMETER / 2.0, DIAMETER / 2.0, DIAMETER / 2.0),
        volume: 1.0,
        draft: archimedes::draft_of_cube,
        submerged: |draft| draft,
    },
];

fn simulate(job: &Job, resolution: u32, progress: &mut Progress) -> Result<Level, LabError> {
    let (mut error, mut traces, mut checks, mut remarks) = (0.0f64, Vec::new(), Vec::new(), Vec::new());
    let (mut account, mut particles) = (Account::default(), 0);
    let ratios = RATIOS[usize::from(job.quick)];
    let runs: Vec<(&Floater, f64)> =
        FLOATERS.iter().flat_map(|floater| ratios.iter().map(move |&ratio| (floater, ratio))).collect();
    for (index, &(floater, ratio)) in runs.iter().enumerate() {
        let mut part = |fraction: f64| progress.at((index as f64 + fraction) / runs.len() as f64);
        let run = float(job, resolution, floater, ratio, &mut part)?;
        let what = format!("{} of {ratio}", floater.name);
        error = error.max(run.by_volume.abs());
        checks.push(Check::new(
            format!("{what}: draft below the measured surface less Archimedes', over D"),
            run.by_surface * 100.0,
            "%",
            Bound::Within(-3.0, 3.0),
        ));
        remarks.push(format!("{what}: {:+.2} % of D by volume", run.by_volume * 100.0));
        traces.push(Trace { name: what, points: run.points });
        particles = run.particles;
        account = account.with(&run.account);
    }
    Ok(Level { resolution, particles, error, traces, checks, remarks, account })
}

struct Run {
    /// Drafts less Archimedes', over D.
    by_volume: f64,
    by_surface: f64,
    points: Vec<(f64, f64, f64)>,
    particles: usize,
    account: Account,
}

fn float(
    job: &Job,
    resolution: u32,
    floater: &Floater,
    ratio: f64,
    progress: &mut dyn FnMut(f64),
) -> Result<Run, LabError> {
    let (tank, edge) = (Tank::for_bodies(resolution), f64::from(DIAMETER));
    let expected = (floater.draft)(ratio);
    let height = tank.depth + (0.5 - expected as f32) * DIAMETER;
    // It is measured upright.
    let body = RigidBodyBuilder::dynamic().translation(glam::Vec3::Y * height).lock_rotations();
    let collider = ColliderBuilder::new((floater.shape)()).density(1000.0 * ratio as f32);
    let mut afloat = tank.with_bodies(job, "draft", [(body, collider)], LATENCY)?;
    let end = END[usize::from(job.quick)];
    let ticks = (end / TICK).round() as u32;
    let (mut by_volume, mut by_surface, mut points) = (Vec::new(), Vec::new(), Vec::new());
    for tick in 1..=ticks {
        afloat.tick()?;
        let height = f64::from(afloat.body(0).translation().y);
        let water = afloat.particles()? as f64 * f64::from(tank.spacing).powi(3);
        let draft = draft_by_volume(floater, water, tank.area(), height / edge);
        points.push((f64::from(tick) * TICK, draft, expected));
        if 2 * tick > ticks {
            by_volume.push(draft - expected);
            let surface = afloat.open_surface(&tank, DIAMETER)?;
            by_surface.push((surface - height) / edge + 0.5 - expected);
        }
        progress(f64::from(tick) / f64::from(ticks));
    }
    Ok(Run {
        by_volume: mean(by_volume).unwrap_or(f64::NAN),
        by_surface: mean(by_surface).unwrap_or(f64::NAN),
        points,
        particles: afloat.particles()?,
        account: afloat.account().clone(),
    })
}

/// Draft over D below the level that `water` m3 and the body's part under it fill, with the body's centre at `height` D.
fn draft_by_volume(floater: &Floater, water: f64, area: f64, height: f64) -> f64 {
    let edge = f64::from(DIAMETER);
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let draft = (low + high) / 2.0;
        let level = (height - 0.5 + draft) * edge;
        let filled = level * area - floater.volume * edge.powi(3) * (floater.submerged)(draft);
        if filled < water { low = draft } else { high = draft }
    }
    (low + high) / 2.0
}
