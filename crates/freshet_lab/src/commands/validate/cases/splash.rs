//! Water thrown at bodies in empty space, with impulses that come now early, now late: nothing but momentum is kept.

use freshet_core::field::Field;
use freshet_core::scene::{FluidScene, Volume};
use glam::Vec3;
use rapier3d::dynamics::RigidBodyBuilder;
use rapier3d::geometry::ColliderBuilder;
use rapier3d::pipeline::PhysicsWorld;

use super::super::{Case, Job, Level, Study, Trace};
use crate::afloat::{Afloat, DIAMETER, TICK};
use crate::error::LabError;
use crate::method::Method;
use crate::progress::Progress;
use crate::verdict::{Bound, Check};

/// The case.
pub const CASE: Case = Case {
    name: "splash",
    about: "water thrown at a light and a heavy ball and a cube without walls or weight, by DFSPH, up to three ticks late and hitching: momentum of all",
    run: |job| STUDY.run(job),
};

const STUDY: Study = Study {
    name: "splash",
    title: "Water thrown at bodies, without walls and weight",
    measure: "drift of the momentum over fluid mass times impact speed",
    bound: 1e-4,
    coarse_bound: Some(1e-4),
    smooth: false,
    resolutions: [6, 10, 16],
    quick: &[6],
    axes: ["time (s)", "momentum of the bodies / that of all"],
    simulate,
};

/// Edge of the water's cube over D, and how fast it comes, m/s.
const WATER: f32 = 2.0;
const SPEED: f32 = 4.0;
/// Densities over the water's, and places over D: the cube stands behind a ball, which is thrown at it.
const BODIES: [(f32, Vec3); 3] =
    [(0.1, Vec3::new(1.8, 0.5, 0.3)), (5.0, Vec3::new(1.8, -0.55, -0.2)), (0.5, Vec3::new(3.1, 0.5, 0.3))];
/// Time to simulate, s.
const END: f64 = 0.6;
/// How late the impulses of a tick are, over and over: frames that hitch.
const LATE: [u64; 7] = [2, 2, 3, 3, 1, 2, 0];

fn simulate(job: &Job, resolution: u32, progress: &mut Progress) -> Result<Level, LabError> {
    let edge = WATER * DIAMETER;
    let block =
        Volume { velocity: Vec3::X * SPEED, hydrostatic: false, ..Volume::block(Vec3::splat(edge / 2.0), Vec3::ZERO) };
    let mut scene = Method::DivergenceFree.on(FluidScene {
        name: "splash".to_owned(),
        volumes: vec![block],
        gravity: Vec3::ZERO,
        ..FluidScene::with_spacing(DIAMETER / resolution as f32)
    });
    scene.settings.expected_speed = Some(SPEED);
    // Nothing that is squeezed out between bodies gets so far: what leaves the bounds takes its momentum along.
    scene.settings.bounds = Some((Vec3::splat(-20.0), Vec3::splat(20.0)));
    let mut world = PhysicsWorld::new();
    world.gravity = Vec3::ZERO;
    world.integration_parameters.dt = TICK as f32;
    let handles = [0, 1, 2].map(|index| {
        let (ratio, place) = BODIES[index];
        let half = 0.5 * DIAMETER;
        let shape = if index == 2 { ColliderBuilder::cuboid(half, half, half) } else { ColliderBuilder::ball(half) };
        let body = RigidBodyBuilder::dynamic().translation(place * DIAMETER).can_sleep(false);
        world.insert(body, shape.density(1000.0 * ratio)).0
    });
    let mut afloat = Afloat::open(job, scene, world, &handles, 0)?;
    let start = afloat.momentum_of_fluid()? + afloat.momentum_of_bodies();
    let ticks = (END / TICK).round() as u32;
    let (mut points, mut fastest) = (Vec::new(), 0.0f32);
    for tick in 1..=ticks {
        // In the end all has arrived.
        let late = if tick == ticks { 0 } else { LATE[tick as usize % LATE.len()] };
        afloat.set_latency(job, late);
        afloat.tick()?;
        points.push((f64::from(tick) * TICK, afloat.momentum_of_bodies().x / start.x, f64::NAN));
        fastest = afloat.scalars(Field::Speed)?.into_iter().fold(fastest, f32::max);
        progress.at(f64::from(tick) / f64::from(ticks));
    }
    let bodies = afloat.momentum_of_bodies();
    let end = afloat.momentum_of_fluid()? + bodies;
    let checks = vec![
        // Else nothing was hit, and nothing was tested.
        Check::new("momentum of the bodies over that of all", bodies.x / start.x, "", Bound::AtLeast(0.05)),
        Check::new("speed of the cube, which only a ball hits, m/s", cube_speed(&afloat), "", Bound::AtLeast(0.1)),
    ];
    Ok(Level {
        resolution,
        particles: afloat.particles()?,
        error: (end - start).length() / start.length(),
        traces: vec![Trace { name: "bodies".to_owned(), points }],
        checks,
        remarks: vec![format!("fastest particle {fastest:.1} m/s")],
        account: afloat.account().clone(),
    })
}

fn cube_speed(afloat: &Afloat) -> f64 {
    f64::from(afloat.body(2).linvel().length())
}
