//! A block dropped into a shallow pool (Krog 2010, section 8.1): volume and momentum.

use freshet_core::field::Field;
use freshet_core::plan::{Plan, SceneError};
use freshet_core::scene::{Body, FluidScene, Volume};
use freshet_core::step::BodyInput;
use glam::{DVec3, Vec3};

use super::super::{Case, Job, Level, Study, Trace};
use crate::drive::Drive;
use crate::error::LabError;
use crate::measure::column::level_from_centre_of_mass;
use crate::measure::statistics::mean;
use crate::progress::Progress;
use crate::scenes::GRAVITY;
use crate::verdict::{Bound, Check};

/// The case.
pub const CASE: Case = Case {
    name: "pool-drop",
    about: "a block dropped into a pool (K 8.1): the level it ends at against its volume, and the momentum ledger",
    run: |job| STUDY.run(job),
};

const STUDY: Study = Study {
    name: "pool-drop",
    title: "A block dropped into a pool",
    measure: "error of the volume",
    bound: 0.01,
    coarse_bound: None,
    smooth: false,
    resolutions: [16, 20, 24],
    quick: &[14],
    axes: ["time (s)", "twice the height of the centre of mass (m)"],
    simulate,
};

/// Edge of the pool's square floor, m.
const POOL: f32 = 1.0;
/// Depth of its water, m.
const DEPTH: f32 = 0.3;
/// Edge of the block, m.
const BLOCK: f32 = 0.4;
/// Height of the walls, m: the splash is 1.5 m high.
const WALLS: f32 = 2.5;
/// Time to simulate, s.
const END: f64 = 6.0;
/// From when on the level is averaged, s.
const SETTLED: f64 = 4.0;
/// Duration of a tick, s.
const TICK: f64 = 0.01;

/// The pool is a body that nothing moves, so that what the water gives it is reported.
fn scene(resolution: u32) -> Result<FluidScene, SceneError> {
    let water = Vec3::new(POOL, DEPTH, POOL);
    let block = Volume::block(Vec3::splat(BLOCK / 2.0), Vec3::Y * (DEPTH + BLOCK));
    let mut scene = FluidScene {
        volumes: vec![Volume::block(water / 2.0, Vec3::Y * DEPTH / 2.0), Volume { hydrostatic: false, ..block }],
        ..FluidScene::with_spacing(POOL / resolution as f32)
    };
    let open = [false, false, false, true, false, false];
    let samples = scene.wall_layer()?.container(Vec3::new(POOL, WALLS, POOL) / 2.0, open)?;
    scene.bodies.push(Body { name: "pool".to_owned(), samples, ..Body::default() });
    Ok(scene)
}

fn simulate(job: &Job, resolution: u32, progress: &mut Progress) -> Result<Level, LabError> {
    let plan = Plan::new(&scene(resolution)?)?;
    let (particles, mass) = (plan.positions.len(), f64::from(plan.parameters.particle_mass));
    // The samplers round to whole particles: what there is counts.
    let full = particles as f64 * f64::from(plan.parameters.spacing).powi(3) / f64::from(POOL * POOL);
    let pool = BodyInput { position: Vec3::Y * WALLS / 2.0, ..BodyInput::default() };
    let mut drive = Drive::open(job.backend, plan, job.threads.count(), vec![pool])?;
    let (mut given, mut exchanged, mut imbalance) = (DVec3::ZERO, 0.0, 0.0f64);
    let mut points = Vec::new();
    let ticks = (END / TICK).round() as u32;
    for tick in 1..=ticks {
        let report = drive.tick(TICK)?;
        let to_pool = report.bodies.first().map_or(DVec3::ZERO, |impulse| impulse.linear.as_dvec3());
        let weight = DVec3::NEG_Y * GRAVITY * mass * particles as f64 * report.simulated;
        given += weight - to_pool;
        exchanged += to_pool.length() + weight.length();
        let momentum = mass * drive.vectors(Field::Velocity)?.iter().map(|v| v.as_dvec3()).sum::<DVec3>();
        imbalance = imbalance.max((momentum - given).length());
        let level = level_from_centre_of_mass(&drive.positions()?);
        points.push((drive.time(), level.unwrap_or(f64::NAN), full));
        progress.at(f64::from(tick) / f64::from(ticks));
    }
    let late = mean(points.iter().filter(|point| point.0 >= SETTLED).map(|point| point.1)).unwrap_or(f64::NAN);
    let checks = vec![Check::new("momentum ledger", imbalance / exchanged, "", Bound::AtMost(1e-4))];
    Ok(Level {
        resolution,
        particles,
        error: (late / full - 1.0).abs(),
        traces: vec![Trace { name: "level".to_owned(), points }],
        checks,
        remarks: Vec::new(),
        account: drive.account().clone(),
    })
}
