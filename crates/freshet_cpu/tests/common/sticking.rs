//! Fluid that sticks to bodies: scenes, and what must come of them on any backend.

use freshet_core::kernel::Kernel;
use freshet_core::prelude::*;
use freshet_core::snapshot::BodyPose;
use glam::DVec3;

/// A block of a viscous fluid without gravity or walls.
fn block(kernel: KernelKind) -> FluidScene {
    let d = 0.05;
    let mut scene = FluidScene {
        gravity: Vec3::ZERO,
        volumes: vec![Volume::block(Vec3::splat(0.25), Vec3::ZERO)],
        ..FluidScene::with_spacing(d)
    };
    scene.material.dynamic_viscosity = 30.0;
    scene.settings.kernel = kernel;
    scene.settings.artificial_viscosity = 0.0;
    scene.settings.viscosity_model = Some(ViscosityModel::Morris1997);
    scene.settings.expected_speed = Some(2.0);
    scene
}

/// The scene of [`sticking_errors`]: two balls whose samples share particles in a gas next to nothing of which is under pressure.
pub fn sticking_scene(kernel: KernelKind) -> FluidScene {
    let mut scene = block(kernel);
    scene.settings.equation_of_state = Some(EquationOfState::IdealGas { stiffness: 1e-6 });
    scene.settings.allow_compressible = true;
    let layer = scene.wall_layer().unwrap();
    let ball = |name: &str, radius| Body {
        name: name.to_owned(),
        samples: layer.sphere_surface(radius).unwrap(),
        ..Body::default()
    };
    scene.bodies = vec![ball("small", 0.1), ball("large", 0.15)];
    scene
}

fn two_bodies() -> Vec<BodyInput> {
    vec![
        BodyInput {
            position: Vec3::new(-0.12, 0.02, 0.01),
            linear_velocity: Vec3::new(0.3, 0.0, -0.1),
            angular_velocity: Vec3::new(0.0, 4.0, -2.0),
            ..BodyInput::default()
        },
        BodyInput {
            position: Vec3::new(0.145, 0.1, 0.0),
            rotation: Quat::from_rotation_x(0.7),
            linear_velocity: Vec3::new(-0.2, -0.3, 0.0),
            angular_velocity: Vec3::new(3.0, 0.0, 1.0),
            ..BodyInput::default()
        },
    ]
}

/// How accelerations, and forces and torques on the bodies, differ from sums over all pairs in double precision, each over what is allowed.
/// The solver is one of [`sticking_scene`].
pub fn sticking_errors(solver: &mut dyn FluidSolver) -> [f64; 3] {
    let plan = solver.plan().clone();
    let bodies = two_bodies();
    let mut state = 7u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 16_777_216.0 - 0.5
    };
    let mut vector = |scale: f32| scale * Vec3::new(random(), random(), random());
    let inside = |x: &Vec3| bodies.iter().zip([0.1, 0.15]).any(|(body, radius)| x.distance(body.position) < radius);
    let positions: Vec<Vec3> = plan.positions.iter().map(|&x| x + vector(0.004)).filter(|x| !inside(x)).collect();
    let velocities: Vec<Vec3> = positions.iter().map(|_| vector(1.0)).collect();
    let count = positions.len() as u32;
    // They have been there before: what is new swells.
    let there = |body: &BodyInput| Some(BodyPose { position: body.position, rotation: body.rotation, swollen: 1.0 });
    let snapshot = Snapshot {
        tick: 1,
        poses: bodies.iter().map(there).collect(),
        next_id: count,
        ids: (0..count).collect(),
        positions: positions.clone(),
        velocities: velocities.clone(),
        remaining_lives: vec![f32::INFINITY; count as usize],
        ..Snapshot::default()
    };
    solver.restore(&snapshot).unwrap();
    // Velocities change by a millionth of themselves.
    let duration = 1e-7;
    let report = solver.step(&StepInput { tick: 1, duration, bodies: bodies.clone(), ..StepInput::default() }).unwrap();
    assert_eq!((report.substeps, report.removed, report.particles), (1, 0, count));
    let ids = solver.read(Field::Id).unwrap().integers().unwrap();
    let by_id = |field, solver: &mut dyn FluidSolver| solver.read(field).unwrap().sorted_by_id(&ids);
    let pressures = by_id(Field::Pressure, solver).scalars().unwrap();
    assert!(pressures.iter().all(|&pressure| pressure < 0.01), "else more than viscosity would be compared");
    let accelerations = by_id(Field::Acceleration, solver).vectors().unwrap();

    let p = &plan.parameters;
    let kernel = Kernel::new(p.kernel, p.support_radius).unwrap();
    let (mass, rest, h) = (f64::from(p.particle_mass), f64::from(p.rest_density), f64::from(p.smoothing_length));
    let mu = f64::from(p.dynamic_viscosity);
    let x: Vec<DVec3> = positions.iter().map(|x| x.as_dvec3()).collect();
    let v: Vec<DVec3> = velocities.iter().map(|v| v.as_dvec3()).collect();
    let samples: Vec<Vec<(DVec3, f64)>> = (plan.bodies.iter().zip(&bodies))
        .map(|(planned, body)| {
            let at = |s: &Vec3| body.position.as_dvec3() + body.rotation.as_dquat() * s.as_dvec3();
            planned.samples.iter().map(at).zip(planned.volumes.iter().map(|&volume| f64::from(volume))).collect()
        })
        .collect();
    let density: Vec<f64> = (x.iter())
        .map(|at| {
            let fluid: f64 = x.iter().map(|other| kernel.value(at.distance(*other))).sum();
            let rigid: f64 =
                samples.iter().flatten().map(|(other, volume)| volume * kernel.value(at.distance(*other))).sum();
            (mass * fluid + rest * rigid) / f64::from(p.density_calibration)
        })
        .collect();
    let (mut of_fluid, mut shared, mut loads) = (0.0f64, 0, [[DVec3::ZERO; 2]; 2]);
    for a in 0..x.len() {
        let mut expected = DVec3::ZERO;
        for b in (0..x.len()).filter(|&b| b != a) {
            let r = x[a].distance(x[b]);
            let factor = 2.0 * mu * mass / (density[a] * density[b]) * r * r / (r * r + 0.01 * h * h);
            expected += factor * kernel.derivative_over_r(r) * (v[a] - v[b]) / f64::from(p.viscous_calibration);
        }
        // Of each body `s` and `D`.
        let sums = samples.iter().map(|samples| {
            samples.iter().fold((0.0, DVec3::ZERO), |(s, slope), (at, volume)| {
                let weight = volume * -kernel.derivative_over_r(x[a].distance(*at));
                (s + weight, slope + weight * (x[a] - at))
            })
        });
        let sums: Vec<(f64, DVec3)> = sums.collect();
        shared += usize::from(sums.iter().all(|(s, _)| *s > 0.0));
        let (body, &(s, slope)) = sums.iter().enumerate().max_by(|a, b| a.1.0.total_cmp(&b.1.0)).unwrap();
        if s > 0.0 {
            let y = (slope.length() / s - f64::from(p.boundary_depth)).max(0.25 * f64::from(p.spacing));
            let rate = mu * rest / (density[a] * density[a]) * slope.length() / y / f64::from(p.gradient_calibration);
            let arm = x[a] - bodies[body].position.as_dvec3();
            let surface = bodies[body].linear_velocity.as_dvec3() + bodies[body].angular_velocity.as_dvec3().cross(arm);
            let drag = rate * (surface - v[a]);
            expected += drag;
            loads[body][0] -= mass * drag;
            loads[body][1] -= mass * arm.cross(drag);
        }
        of_fluid = of_fluid.max(accelerations[a].as_dvec3().distance(expected) / (1e-3 * expected.length().max(20.0)));
    }
    assert!(shared > 5, "{shared} particles touch both bodies");
    let (mut of_forces, mut of_torques): (f64, f64) = (0.0, 0.0);
    for ([force, torque], given) in loads.into_iter().zip(&report.bodies) {
        assert!(force.length() > 10.0 && torque.length() > 1.0, "{force} N, {torque} N m");
        let [linear, angular] = [given.linear, given.angular].map(|impulse| impulse.as_dvec3() / f64::from(duration));
        of_forces = of_forces.max(linear.distance(force) / (1e-4 * force.length()));
        of_torques = of_torques.max(angular.distance(torque) / (1e-4 * torque.length()));
    }
    [of_fluid, of_forces, of_torques]
}

/// Fluid at rest, and a ball in it that turns and moves: what it loses, the fluid gets. No ball, however light, is made to turn or move
/// faster by what sticks to it.
pub fn assert_a_ball_is_braked(open: &mut dyn FnMut(&FluidScene) -> Box<dyn FluidSolver>) {
    for pressure_solver in
        [PressureSolver::WeaklyCompressible, PressureSolver::DivergenceFree(DivergenceFree::default())]
    {
        for ratio in [0.01, 1.0f32] {
            let mut scene = block(KernelKind::WendlandC2);
            scene.settings.pressure_solver = pressure_solver;
            let radius = 0.15f32;
            let samples = scene.wall_layer().unwrap().sphere_surface(radius).unwrap();
            let solids = vec![Solid::ball(radius, Vec3::ZERO)];
            scene.bodies = vec![Body { name: "ball".to_owned(), samples, solids, ..Body::default() }];
            let mut solver = open(&scene);
            let particle = f64::from(solver.plan().parameters.particle_mass);
            let mass = 1000.0 * ratio * 4.0 / 3.0 * std::f32::consts::PI * radius.powi(3);
            let mut ball = BodyInput {
                linear_velocity: Vec3::new(0.0, 0.02, 0.0),
                angular_velocity: Vec3::new(0.0, 1.0, 0.0),
                inverse_mass: 1.0 / mass,
                inverse_inertia: Mat3::IDENTITY * (2.5 / (mass * radius * radius)),
                ..BodyInput::default()
            };
            let momentum = |solver: &mut dyn FluidSolver| -> DVec3 {
                solver.snapshot().unwrap().velocities.iter().map(|v| particle * v.as_dvec3()).sum()
            };
            let (mut given, mut turned) = (DVec3::ZERO, 0.0);
            for tick in 0..10 {
                let input = StepInput { tick, duration: 0.01, bodies: vec![ball], ..StepInput::default() };
                let report = solver.step(&input).unwrap();
                let pose = solver.snapshot().unwrap().poses[0].unwrap();
                let [before, spun] = [ball.linear_velocity, ball.angular_velocity].map(Vec3::length);
                ball.linear_velocity += report.bodies[0].linear * ball.inverse_mass;
                ball.angular_velocity += ball.inverse_inertia * report.bodies[0].angular;
                (ball.position, ball.rotation) = (pose.position, pose.rotation);
                given += report.bodies[0].linear.as_dvec3();
                turned += f64::from(report.bodies[0].angular.y);
                let what = format!("{pressure_solver:?}, {ratio} times the density, tick {tick}: {ball:?}");
                assert!(ball.angular_velocity.length() <= spun * 1.001, "{what}");
                assert!(ball.linear_velocity.length() <= before.max(0.02) * 1.001, "{what}");
            }
            let lost = momentum(&mut *solver);
            assert!(given.y < -1e-4 && turned < -1e-4, "{given} N s, {turned} N m s");
            let balance = (lost + given).length() / given.length();
            println!("{pressure_solver:?}, {ratio}: {ball:?}, given {given}, balance {balance:e}");
            assert!(balance < 1e-4, "{lost} of the fluid, {given} of the ball");
            assert!(ball.angular_velocity.y < 0.9, "{ball:?}");
        }
    }
}
