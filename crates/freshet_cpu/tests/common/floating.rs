//! Scenes of bodies in an incompressible fluid, and what must come of them on any backend. Beside it stands `reference`.

use std::f32::consts::PI;

use freshet_core::prelude::*;
use freshet_core::snapshot::BodyPose;
use glam::DVec3;

use super::reference::{Reference, disturbed};

/// A scene solved for by divergence-free SPH.
pub fn incompressible(mut scene: FluidScene, solver: DivergenceFree) -> FluidScene {
    scene.settings.pressure_solver = PressureSolver::DivergenceFree(solver);
    scene
}

/// A hollow ball about its centre.
pub fn ball(scene: &FluidScene, radius: f32) -> Body {
    let samples = scene.wall_layer().unwrap().sphere_surface(radius).unwrap();
    let solids = vec![Solid::ball(radius, Vec3::ZERO)];
    Body { name: "ball".to_owned(), samples, solids, ..Body::default() }
}

/// A column of 0.25 m in an open box, and a body for each input.
pub fn column_with(bodies: usize, tolerance: f32) -> FluidScene {
    let scene = FluidScene {
        volumes: vec![Volume::block(Vec3::splat(0.125), Vec3::Y * 0.125)],
        boundaries: vec![Boundary::open_box(Vec3::new(0.25, 0.375, 0.25), Vec3::Y * 0.1875)],
        ..FluidScene::with_spacing(0.025)
    };
    let mut small = ball(&scene, 0.04);
    // The centre of mass is not that of the ball, so that the fluid turns it.
    small.samples.iter_mut().for_each(|sample| *sample += Vec3::new(0.005, 0.0, 0.01));
    small.solids.clear();
    let settings = DivergenceFree { compression: tolerance, divergence: tolerance, max_iterations: 5000 };
    let mut scene = incompressible(FluidScene { bodies: vec![small; bodies], ..scene }, settings);
    scene.settings.artificial_viscosity = 0.0;
    scene
}

/// A body that the fluid cannot move, one that it can, and one that next to nothing weighs; the first two share particles.
pub fn three_bodies() -> Vec<BodyInput> {
    let lopsided = Mat3::from_cols(Vec3::new(9e3, 1e3, 0.0), Vec3::new(1e3, 6e3, -5e2), Vec3::new(0.0, -5e2, 8e3));
    vec![
        BodyInput {
            position: Vec3::new(-0.05, 0.08, 0.01),
            linear_velocity: Vec3::new(0.3, 0.0, -0.1),
            angular_velocity: Vec3::new(0.0, 4.0, -2.0),
            ..BodyInput::default()
        },
        BodyInput {
            position: Vec3::new(0.045, 0.1, 0.0),
            rotation: Quat::from_rotation_x(0.7),
            linear_velocity: Vec3::new(-0.2, -0.3, 0.0),
            angular_velocity: Vec3::new(3.0, 0.0, 1.0),
            inverse_mass: 1.0 / 0.2,
            inverse_inertia: lopsided,
            acceleration: Vec3::new(0.0, -9.81, 0.0),
            ..BodyInput::default()
        },
        BodyInput {
            position: Vec3::new(0.0, 0.2, -0.05),
            inverse_mass: 1.0 / 0.005,
            inverse_inertia: 30.0 * lopsided,
            acceleration: Vec3::new(0.0, -9.81, 0.0),
            ..BodyInput::default()
        },
    ]
}

/// The column with the three bodies, solved for closely.
pub fn disturbed_column(kernel: KernelKind) -> FluidScene {
    let mut scene = column_with(3, 1e-5);
    scene.settings.kernel = kernel;
    scene
}

/// How a substep of 1 ms from a disturbed state differs from what it should be, each over what is allowed: velocities from those that
/// the pressures reported make of them; impulses, and where bodies are, from what these do to them; what is left of the divergence,
/// in the mean of all particles; not solved at all is infinite. The solver is one of [`disturbed_column`].
pub fn substep_errors(solver: &mut dyn FluidSolver) -> [f64; 4] {
    let plan = solver.plan().clone();
    let kernel = plan.parameters.kernel;
    let (start, bodies) = (disturbed(&plan), three_bodies());
    // They have been there before: what is new swells.
    let there = |body: &BodyInput| BodyPose { position: body.position, rotation: body.rotation, swollen: 1.0 };
    let poses = bodies.iter().map(|body| Some(there(body))).collect();
    solver.restore(&Snapshot { tick: 1, poses, ..start.clone() }).unwrap();
    let duration = 1e-3;
    let report = solver.step(&StepInput { tick: 1, duration, bodies: bodies.clone(), ..StepInput::default() }).unwrap();
    assert_eq!((report.substeps, report.removed), (1, 0), "{kernel:?}");
    let end = solver.snapshot().unwrap();
    if report.unsolved > 0 || end.ids.len() != start.ids.len() {
        return [f64::INFINITY; 4];
    }

    let reference = Reference::new(&plan, &start.positions, &bodies);
    let dt = f64::from(duration);
    let velocities: Vec<DVec3> = end.velocities.iter().map(|v| v.as_dvec3()).collect();
    let pressures: Vec<f64> = end.pressures.iter().map(|&p| f64::from(p)).collect();
    assert!(pressures.iter().all(|&pressure| pressure >= 0.0));
    let (mut of_fluid, mut of_impulses, mut of_poses): (f64, f64, f64) = (0.0, 0.0, 0.0);
    for (i, acceleration) in reference.accelerations(&pressures).iter().enumerate() {
        let expected = start.velocities[i].as_dvec3() + dt * (plan.parameters.gravity.as_dvec3() + *acceleration);
        let allowed = 1e-4 * dt * acceleration.length().max(10.0) + 1e-6;
        of_fluid = of_fluid.max(velocities[i].distance(expected) / allowed);
    }
    let mut motions = Vec::new();
    for (index, [force, torque]) in reference.loads(&pressures).into_iter().enumerate() {
        let (body, impulse, pose) = (&bodies[index], report.bodies[index], end.poses[index].unwrap());
        assert!(force.length() > 0.1 && torque.length() > 1e-4, "{index}: {force} N, {torque} N m");
        let [linear, angular] = [impulse.linear.as_dvec3(), impulse.angular.as_dvec3()];
        of_impulses = of_impulses.max(linear.distance(dt * force) / (1e-4 * dt * force.length()));
        of_impulses = of_impulses.max(angular.distance(dt * torque) / (1e-3 * dt * torque.length()));
        let acceleration = f64::from(body.inverse_mass) * force + body.acceleration.as_dvec3();
        let velocity = body.linear_velocity.as_dvec3() + dt * acceleration;
        let spin = body.angular_velocity.as_dvec3() + dt * (body.inverse_inertia.as_dmat3() * torque);
        let way = (pose.position - body.position).as_dvec3();
        of_poses = of_poses.max(way.distance(dt * velocity) / 1e-6);
        motions.push([velocity, spin]);
    }
    // The way of the fastest in a first substep is that of its velocity.
    let fastest = start.velocities.iter().map(|v| v.length()).fold(0.0, f32::max);
    let fastest = bodies.iter().map(|body| body.linear_velocity.length()).fold(fastest, f32::max);
    let way = (fastest * duration / plan.parameters.longest_way()).min(1.0);
    let share = DivergenceFree::share(way);
    let most = plan.parameters.most_by_velocity(dt as f32);
    let densities = reference.densities();
    let rates = reference.rates(&velocities, &motions);
    // Without the bodies' motion it would not be solved at all.
    let standing = reference.rates(&velocities, &[[DVec3::ZERO; 2]; 3]);
    let (mut wrong, mut wrong_if_standing) = (0.0, 0.0);
    for (i, pressure) in pressures.iter().enumerate() {
        let source = f64::from(DivergenceFree::source((densities[i] - 1.0) as f32, share, most));
        let measure = |left: f64| if *pressure > 0.0 { left.abs() } else { left.max(0.0) } / densities.len() as f64;
        wrong += measure(source + dt * rates[i]);
        wrong_if_standing += measure(source + dt * standing[i]);
    }
    let asked = f64::from(1e-5 * way);
    println!("{kernel:?}: {wrong:e} left, {asked:e} asked for, {wrong_if_standing:e} with standing bodies, {report:?}");
    assert!(wrong_if_standing > 30.0 * asked, "{wrong_if_standing}");
    [of_fluid, of_impulses, of_poses, wrong / (1.5 * asked)]
}

/// A rigid ball that an engine moves in lockstep: what the fluid gives it, it has.
pub struct Ball {
    /// As the engine knows it.
    pub input: BodyInput,
    mass: f32,
}

impl Ball {
    /// One of these: m, kg/m3, m, m/s2.
    pub fn new(radius: f32, density: f32, position: Vec3, gravity: Vec3) -> Self {
        let mass = density * 4.0 / 3.0 * PI * radius.powi(3);
        let inverse_inertia = Mat3::from_diagonal(Vec3::splat(1.0 / (0.4 * mass * radius * radius)));
        let input = BodyInput {
            position,
            inverse_mass: 1.0 / mass,
            inverse_inertia,
            acceleration: gravity,
            ..BodyInput::default()
        };
        Self { input, mass }
    }

    /// A tick of it and the fluid.
    pub fn tick(&mut self, solver: &mut dyn FluidSolver, tick: u64, duration: f32) -> StepReport {
        let bodies = vec![self.input];
        let report = solver.step(&StepInput { tick, duration, bodies, commands: Vec::new() }).unwrap();
        let pose = solver.snapshot().unwrap().poses[0].unwrap();
        let given = report.bodies[0];
        self.input.linear_velocity += given.linear / self.mass + report.simulated as f32 * self.input.acceleration;
        self.input.angular_velocity += self.input.inverse_inertia * given.angular;
        (self.input.position, self.input.rotation) = (pose.position, pose.rotation);
        report
    }
}

/// Momentum, N s.
pub fn momentum(solver: &mut dyn FluidSolver) -> DVec3 {
    let mass = f64::from(solver.plan().parameters.particle_mass);
    solver.snapshot().unwrap().velocities.iter().map(|v| mass * v.as_dvec3()).sum()
}

/// A block of water about to hit a ball, without gravity.
pub fn block_at_ball() -> FluidScene {
    let mut scene = FluidScene { gravity: Vec3::ZERO, ..FluidScene::with_spacing(0.05) };
    scene.volumes = vec![Volume { velocity: Vec3::X, ..Volume::block(Vec3::splat(0.15), Vec3::new(-0.35, 0.02, 0.0)) }];
    scene.bodies = vec![ball(&scene, 0.15)];
    incompressible(scene, DivergenceFree::default())
}

/// What the fluid of [`block_at_ball`] loses, its ball gets.
pub fn assert_a_body_gets_what_the_fluid_loses(solver: &mut dyn FluidSolver) {
    let before = momentum(solver);
    let mut ball = Ball::new(0.15, 700.0, Vec3::ZERO, Vec3::ZERO);
    let mut given = DVec3::ZERO;
    for tick in 0..30 {
        given += ball.tick(solver, tick, 0.01).bodies[0].linear.as_dvec3();
    }
    let lost = before - momentum(solver);
    assert!(given.x > 1.0 && ball.input.linear_velocity.x > 0.1, "the block hit: {given}");
    assert!((lost - given).length() < 1e-5 * given.length(), "{lost} against {given}");
}

/// A pool of 20 spacings a side, 20 deep.
pub fn deep_pool(radius: f32) -> FluidScene {
    let scene = FluidScene {
        volumes: vec![Volume::block(Vec3::splat(0.5), Vec3::Y * 0.5)],
        boundaries: vec![Boundary::open_box(Vec3::new(1.0, 1.6, 1.0), Vec3::Y * 0.8)],
        ..FluidScene::with_spacing(0.05)
    };
    let scene = FluidScene { bodies: vec![ball(&scene, radius)], ..scene };
    incompressible(scene, DivergenceFree::default())
}

/// A blade that turns about its end: where it is fast is not where its centre of mass is said to be.
pub fn blade() -> FluidScene {
    let mut scene = column_with(1, 1e-3);
    scene.volumes.clear();
    scene.settings.max_particles = Some(10);
    scene.bodies[0].samples = (0..20u8).map(|i| Vec3::X * 0.025 * f32::from(i)).collect();
    scene
}

/// Substeps of [`blade`] are short enough for its tip.
pub fn assert_substeps_are_short_enough_for_what_turns(solver: &mut dyn FluidSolver) {
    let (rate, reach) = (10.0, 0.025 * 19.0);
    let bodies = vec![BodyInput { angular_velocity: Vec3::Y * rate, ..BodyInput::default() }];
    let report = solver.step(&StepInput { duration: 1.0 / 60.0, bodies, ..StepInput::default() }).unwrap();
    let way = report.smallest_substep * rate * reach;
    let allowed = solver.plan().parameters.longest_way();
    assert!(way <= 1.001 * allowed, "{way} m in a substep, {report:?}");
}

/// Half of the [`closed_tank`]'s size, m.
const TANK: Vec3 = Vec3::new(0.2, 0.1, 0.1);

/// A closed tank that moves, full of water, without gravity: 1,024 particles.
pub fn closed_tank() -> FluidScene {
    let mut scene = FluidScene {
        gravity: Vec3::ZERO,
        volumes: vec![Volume::block(TANK, Vec3::ZERO)],
        ..FluidScene::with_spacing(0.025)
    };
    scene.settings.expected_speed = Some(2.0);
    let samples = scene.wall_layer().unwrap().container(TANK, [false; 6]).unwrap();
    scene.bodies = vec![Body { name: "tank".to_owned(), samples, ..Body::default() }];
    incompressible(scene, DivergenceFree::default())
}

/// A tank that sets off with 2 m/s2, for a second, and goes on takes its water along: it stays within a fiftieth of a spacing of its place in
/// the tank, which moves by semi-implicit Euler where the fluid moves by the trapezoidal rule.
pub fn assert_a_tank_takes_its_water_along(solver: &mut dyn FluidSolver) {
    const TICK: f32 = 1.0 / 60.0;
    let x_at = |tick: u64| {
        let time = TICK * tick as f32;
        if time < 1.0 { time * time } else { 2.0 * time - 1.0 }
    };
    let count = solver.plan().positions.len() as f32;
    let mean = |read: FieldData| read.vectors().unwrap().iter().map(|v| v.x).sum::<f32>() / count;
    for tick in 0..75 {
        let (x, next) = (x_at(tick), x_at(tick + 1));
        let tank =
            BodyInput { position: Vec3::X * x, linear_velocity: Vec3::X * (next - x) / TICK, ..BodyInput::default() };
        let report = solver.step(&StepInput { tick, duration: TICK, bodies: vec![tank], commands: Vec::new() });
        let report = report.unwrap();
        let behind = next - mean(solver.read(Field::Position).unwrap());
        let slower = (next - x) / TICK - mean(solver.read(Field::Velocity).unwrap());
        assert!(behind.abs() < 5e-4, "{tick}: {behind} m behind");
        assert!(slower.abs() < 0.04, "{tick}: {slower} m/s slower");
        assert!(report.mean_compression < 2e-3 && report.removed == 0, "{tick}: {report:?}");
    }
}
