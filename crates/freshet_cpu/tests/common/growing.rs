//! Scenes of bodies that come into a fluid, and what must come of them on any backend.

use std::f32::consts::PI;

use freshet_core::prelude::*;
use glam::DVec3;

const SPACING: f32 = 0.05;
const TICK: f32 = 1.0 / 60.0;

/// A pool 12 spacings wide and deep.
pub fn pool(pressure_solver: PressureSolver) -> FluidScene {
    let mut scene = FluidScene {
        volumes: vec![Volume::block(Vec3::splat(0.3), Vec3::Y * 0.3)],
        boundaries: vec![Boundary::open_box(Vec3::new(0.6, 1.6, 0.6), Vec3::Y * 0.8)],
        ..FluidScene::with_spacing(SPACING)
    };
    scene.settings.pressure_solver = pressure_solver;
    scene
}

/// A ball of this radius, m; its name is that of every other.
pub fn ball(scene: &FluidScene, radius: f32) -> Body {
    let samples = scene.wall_layer().unwrap().sphere_surface(radius).unwrap();
    Body { name: "ball".to_owned(), samples, solids: vec![Solid::ball(radius, Vec3::ZERO)], ..Body::default() }
}

/// What a tick is told of a ball that nothing moves.
pub fn held(position: Vec3) -> BodyInput {
    BodyInput { position, ..BodyInput::default() }
}

/// Ticks of a sixtieth of a second. Returns the largest speed of a particle after any of them, m/s.
fn fastest(solver: &mut dyn FluidSolver, ticks: std::ops::Range<u64>, body: BodyInput) -> f32 {
    let mut fastest = 0f32;
    for tick in ticks {
        let bodies = vec![BodyInput { placed: body.placed && tick % 100 == 0, ..body }];
        let report = solver.step(&StepInput { tick, duration: TICK, bodies, commands: Vec::new() }).unwrap();
        assert_eq!((report.removed, report.unsolved), (0, 0), "{report:?}");
        let velocities = solver.snapshot().unwrap().velocities;
        fastest = velocities.iter().map(|velocity| velocity.length()).fold(fastest, f32::max);
    }
    fastest
}

/// How deep below the surface of a ball a particle is, m; negative if none is in it.
fn deepest(solver: &mut dyn FluidSolver, radius: f32, position: Vec3) -> f32 {
    let positions = solver.snapshot().unwrap().positions;
    positions.iter().map(|x| radius - x.distance(position)).fold(f32::NEG_INFINITY, f32::max)
}

/// The largest speed that a ball of this radius may give, m/s: its surface goes outwards with the push-out speed, and what it
/// displaces at its largest lifts the water beside it. Both together, and twice that where a surge meets a free surface.
fn bound(plan: &Plan, radius: f32) -> f32 {
    let speed = plan.parameters.push_out_speed();
    let lift = 4.0 * PI * radius * radius * speed / (0.36 - PI * radius * radius);
    2.0 * (speed + lift)
}

/// A ball in the middle of a full pool that is twice as large from one tick to the next pushes the water out, gently, and so does one
/// that is put there out of the air. Each has so many ticks for it.
pub fn assert_bodies_push_fluid_out_gently(solver: &mut dyn FluidSolver, scene: &FluidScene, ticks: u64) {
    let (center, radius) = (Vec3::Y * 0.3, 0.2);
    let calm = fastest(solver, 0..20, held(center));
    let grown = FluidScene { bodies: vec![ball(scene, radius)], ..scene.clone() };
    solver.reconfigure(Plan::new(&grown).unwrap()).unwrap();
    let particles = solver.snapshot().unwrap().ids.len();
    let limit = bound(solver.plan(), radius);
    let thrown = fastest(solver, 20..20 + ticks, held(center));
    let inside = deepest(solver, radius, center);
    println!("calm {calm} m/s, grown {thrown} of {limit} m/s, {inside} m inside");
    assert!(thrown < limit && inside < 0.1 * SPACING, "{thrown} of {limit} m/s, {inside} m inside");
    // Up into the air, and back into the water, which has closed.
    fastest(solver, 101..101 + ticks, held(Vec3::Y * 1.3));
    assert_eq!(solver.snapshot().unwrap().poses[0].unwrap().swollen, 1.0);
    let center = center + 0.3 * SPACING;
    let thrown = fastest(solver, 200..200 + ticks, BodyInput { placed: true, ..held(center) });
    let inside = deepest(solver, radius, center);
    println!("put {thrown} of {limit} m/s, {inside} m inside");
    assert!(thrown < limit && inside < 0.1 * SPACING, "{thrown} of {limit} m/s, {inside} m inside");
    assert_eq!(solver.snapshot().unwrap().ids.len(), particles);
}

/// A body that is put into the air is whole a few substeps later, and one that is put into the fluid takes the time that its radius
/// needs.
pub fn assert_bodies_swell_as_long_as_they_push(solver: &mut dyn FluidSolver) {
    let swollen = |solver: &mut dyn FluidSolver| solver.snapshot().unwrap().poses[0].unwrap().swollen;
    fastest(solver, 0..1, held(Vec3::Y * 1.3));
    assert_eq!(swollen(solver), 1.0, "it was there at the start");
    fastest(solver, 100..101, BodyInput { placed: true, ..held(Vec3::new(0.02, 1.2, 0.0)) });
    fastest(solver, 101..104, held(Vec3::new(0.02, 1.2, 0.0)));
    assert_eq!(swollen(solver), 1.0, "nothing is in its way");
    fastest(solver, 200..201, BodyInput { placed: true, ..held(Vec3::Y * 0.3) });
    let plan = solver.plan();
    let share = plan.parameters.push_out_speed() * TICK / plan.bodies[0].swelling_reach;
    assert!((swollen(solver) - share).abs() < 1e-3, "{} instead of {share}", swollen(solver));
}

/// Momentum that a ball gets which appears in a block of water without gravity, and what the water loses, N s.
pub fn exchanged_with_what_appears(solver: &mut dyn FluidSolver, scene: &FluidScene) -> [DVec3; 2] {
    let momentum = |solver: &mut dyn FluidSolver| -> DVec3 {
        let mass = f64::from(solver.plan().parameters.particle_mass);
        solver.snapshot().unwrap().velocities.iter().map(|v| mass * v.as_dvec3()).sum()
    };
    solver.step(&StepInput { tick: 0, duration: TICK, ..StepInput::default() }).unwrap();
    let with = FluidScene { bodies: vec![ball(scene, 0.15)], ..scene.clone() };
    solver.reconfigure(Plan::new(&with).unwrap()).unwrap();
    let (before, mut given) = (momentum(solver), DVec3::ZERO);
    for tick in 1..20 {
        let bodies = vec![held(Vec3::new(0.15, 0.2, 0.05))];
        let report = solver.step(&StepInput { tick, duration: TICK, bodies, commands: Vec::new() }).unwrap();
        given += report.bodies[0].linear.as_dvec3();
    }
    [given, before - momentum(solver)]
}

/// A block of water without gravity and walls.
pub fn free_block(pressure_solver: PressureSolver) -> FluidScene {
    let mut scene = FluidScene { gravity: Vec3::ZERO, boundaries: Vec::new(), ..pool(pressure_solver) };
    scene.settings.expected_speed = Some(2.0);
    scene
}
