//! Bodies of three layers of quasi-fluid: scenes, and what must come of them on any backend.

use freshet_core::kernel::Kernel;
use freshet_core::prelude::*;
use freshet_core::snapshot::BodyPose;
use glam::DVec3;

/// Three layers of a ball.
pub fn quasi_fluid_ball(scene: &FluidScene, radius: f32) -> Body {
    let layer = scene.wall_layer().unwrap();
    let sampled = |layer: freshet_core::sampling::wall_layer::WallLayer| Body {
        name: "ball".to_owned(),
        samples: layer.sphere_surface(radius).unwrap(),
        solids: vec![Solid::ball(radius, Vec3::ZERO)],
        ..Body::default()
    };
    Body::quasi_fluid(layer.quasi_fluid().map(sampled), layer.spacing())
}

/// The scene of [`quasi_fluid_errors`]: a block of a gas, which pushes everywhere, a ball of quasi-fluid and one of a single layer.
pub fn quasi_fluid_scene(kernel: KernelKind) -> FluidScene {
    let mut scene = FluidScene {
        gravity: Vec3::ZERO,
        volumes: vec![Volume::block(Vec3::splat(0.25), Vec3::ZERO)],
        ..FluidScene::with_spacing(0.05)
    };
    scene.settings.kernel = kernel;
    scene.settings.artificial_viscosity = 0.0;
    scene.settings.expected_speed = Some(2.0);
    scene.settings.equation_of_state = Some(EquationOfState::IdealGas { stiffness: 1.0 });
    scene.settings.allow_compressible = true;
    let samples = scene.wall_layer().unwrap().sphere_surface(0.1).unwrap();
    scene.bodies = vec![quasi_fluid_ball(&scene, 0.15), Body { name: "single".to_owned(), samples, ..Body::default() }];
    scene
}

/// How accelerations, and forces and torques on the bodies, differ from sums over all pairs in double precision, each over what is allowed.
/// The solver is one of [`quasi_fluid_scene`].
pub fn quasi_fluid_errors(solver: &mut dyn FluidSolver) -> [f64; 3] {
    let plan = solver.plan().clone();
    let at = |position: Vec3, turn: f32| BodyInput {
        position,
        rotation: Quat::from_rotation_x(turn),
        ..BodyInput::default()
    };
    let bodies = [at(Vec3::new(0.24, 0.08, -0.03), 0.7), at(Vec3::new(-0.2, 0.2, 0.1), 0.0)];
    let mut state = 7u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 16_777_216.0 - 0.5
    };
    let mut vector = |scale: f32| scale * Vec3::new(random(), random(), random());
    let inside = |x: &Vec3| bodies.iter().zip([0.16, 0.1]).any(|(body, radius)| x.distance(body.position) < radius);
    let positions: Vec<Vec3> = plan.positions.iter().map(|&x| x + vector(0.01)).filter(|x| !inside(x)).collect();
    let count = positions.len() as u32;
    // They have been there before: what is new swells.
    let there = |body: &BodyInput| Some(BodyPose { position: body.position, rotation: body.rotation, swollen: 1.0 });
    let snapshot = Snapshot {
        tick: 1,
        poses: bodies.iter().map(there).collect(),
        next_id: count,
        ids: (0..count).collect(),
        velocities: vec![Vec3::ZERO; positions.len()],
        remaining_lives: vec![f32::INFINITY; positions.len()],
        positions: positions.clone(),
        ..Snapshot::default()
    };
    solver.restore(&snapshot).unwrap();
    let duration = 1e-7;
    let input = StepInput { tick: 1, duration, bodies: bodies.to_vec(), ..StepInput::default() };
    let report = solver.step(&input).unwrap();
    assert_eq!((report.substeps, report.removed, report.particles), (1, 0, count));
    let ids = solver.read(Field::Id).unwrap().integers().unwrap();
    let accelerations = solver.read(Field::Acceleration).unwrap().sorted_by_id(&ids).vectors().unwrap();

    let p = &plan.parameters;
    let kernel = Kernel::new(p.kernel, p.support_radius).unwrap();
    let (mass, rest) = (f64::from(p.particle_mass), f64::from(p.rest_density));
    let (values, slopes) = (f64::from(p.density_calibration), f64::from(p.gradient_calibration));
    let term = |density: f64| p.pressure_law.pressure(rest, density) / (density * density);
    let x: Vec<DVec3> = positions.iter().map(|x| x.as_dvec3()).collect();
    let samples: Vec<Vec<(DVec3, f64)>> = (plan.bodies.iter().zip(&bodies))
        .map(|(planned, body)| {
            let at = |s: &Vec3| body.position.as_dvec3() + body.rotation.as_dquat() * s.as_dvec3();
            planned.samples.iter().map(at).zip(planned.volumes.iter().map(|&volume| f64::from(volume))).collect()
        })
        .collect();
    let fluid = |at: DVec3| mass * x.iter().map(|other| kernel.value(at.distance(*other))).sum::<f64>() / values;
    let rigid = |at: DVec3, samples: &[(DVec3, f64)]| {
        rest * samples.iter().map(|(other, volume)| volume * kernel.value(at.distance(*other))).sum::<f64>() / values
    };
    let terms: Vec<f64> =
        x.iter().map(|&at| term(fluid(at) + rigid(at, &samples[0]) + rigid(at, &samples[1]))).collect();
    let own_terms = [
        samples[0].iter().map(|&(at, _)| term(fluid(at) + rigid(at, &samples[0]))).collect::<Vec<f64>>(),
        vec![0.0; samples[1].len()],
    ];
    let (mut of_fluid, mut loads) = (0.0f64, [[DVec3::ZERO; 2]; 2]);
    for a in 0..x.len() {
        let (mut expected, mut size) = (DVec3::ZERO, 0.0);
        let mut add = |strength: f64, at: DVec3| {
            let part = -strength / slopes * kernel.derivative_over_r(x[a].distance(at)) * (x[a] - at);
            expected += part;
            size += part.length();
            part
        };
        for b in (0..x.len()).filter(|&b| b != a) {
            add(mass * (terms[a] + terms[b]), x[b]);
        }
        for (body, (samples, own_terms)) in samples.iter().zip(&own_terms).enumerate() {
            for (&(at, volume), own_term) in samples.iter().zip(own_terms) {
                let part = add(rest * volume * (terms[a] + own_term), at);
                let center = bodies[body].position.as_dvec3();
                loads[body][0] -= mass * part;
                loads[body][1] -= mass * (at - center).cross(part);
            }
        }
        of_fluid = of_fluid.max(accelerations[a].as_dvec3().distance(expected) / (1e-5 * size));
    }
    let (mut of_forces, mut of_torques): (f64, f64) = (0.0, 0.0);
    for ([force, torque], given) in loads.into_iter().zip(&report.bodies) {
        assert!(force.length() > 0.1, "{force} N, {torque} N m");
        let [linear, angular] = [given.linear, given.angular].map(|impulse| impulse.as_dvec3() / f64::from(duration));
        of_forces = of_forces.max(linear.distance(force) / (1e-4 * force.length()));
        of_torques = of_torques.max(angular.distance(torque) / (1e-4 * 0.1 * force.length()));
    }
    [of_fluid, of_forces, of_torques]
}

/// Momentum of a block of water that hits a ball of quasi-fluid: what the fluid loses the ball gets.
pub fn assert_a_quasi_fluid_ball_gets_what_the_fluid_loses(open: &mut dyn FnMut(&FluidScene) -> Box<dyn FluidSolver>) {
    let mut scene = FluidScene { gravity: Vec3::ZERO, ..FluidScene::with_spacing(0.05) };
    scene.volumes = vec![Volume { velocity: Vec3::X, ..Volume::block(Vec3::splat(0.15), Vec3::new(-0.35, 0.02, 0.0)) }];
    scene.bodies = vec![quasi_fluid_ball(&scene, 0.15)];
    let mut solver = open(&scene);
    let particle = f64::from(solver.plan().parameters.particle_mass);
    let momentum = |solver: &mut dyn FluidSolver| -> DVec3 {
        solver.snapshot().unwrap().velocities.iter().map(|v| particle * v.as_dvec3()).sum()
    };
    let before = momentum(&mut *solver);
    let mass = 700.0 * 4.0 / 3.0 * std::f32::consts::PI * 0.15f32.powi(3);
    let mut ball = BodyInput {
        inverse_mass: 1.0 / mass,
        inverse_inertia: Mat3::IDENTITY * (2.5 / (mass * 0.0225)),
        ..BodyInput::default()
    };
    let mut given = DVec3::ZERO;
    for tick in 0..20 {
        let input = StepInput { tick, duration: 0.01, bodies: vec![ball], ..StepInput::default() };
        let report = solver.step(&input).unwrap();
        let pose = solver.snapshot().unwrap().poses[0].unwrap();
        ball.linear_velocity += report.bodies[0].linear * ball.inverse_mass;
        ball.angular_velocity += ball.inverse_inertia * report.bodies[0].angular;
        (ball.position, ball.rotation) = (pose.position, pose.rotation);
        given += report.bodies[0].linear.as_dvec3();
    }
    let change = momentum(&mut *solver) - before;
    assert!(given.x > 1.0, "{given} N s");
    assert!((change + given).length() < 1e-4 * given.length(), "{change} and {given} N s");
}
