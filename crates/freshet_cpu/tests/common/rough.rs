//! Friction of walls that move: scenes, and what must come of them on any backend.

use freshet_core::prelude::*;
use glam::DVec3;

/// Both solvers that have friction, how much of the speed of a wall what sticks to it may lack, m/s, and the acceleration of a wall with which it goes
/// along, over that of gravity: less than friction at rest holds, 0.6, by half: solved pressures vary by a third while densities are within what is allowed. Particles on an equation
/// of state bounce, and slide while they press too little: what brings them back is friction of what slides, 0.2.
fn solvers() -> [(PressureSolver, f32, f32); 2] {
    let solved = PressureSolver::DivergenceFree(DivergenceFree::default());
    [(PressureSolver::WeaklyCompressible, 1e-2, 0.15), (solved, 1e-4, 0.3)]
}

/// A layer of particles on a plane without end.
fn layer(pressure_solver: PressureSolver) -> FluidScene {
    let half = Vec3::new(0.1, 0.01, 0.1);
    let mut scene = FluidScene {
        volumes: vec![Volume::block(half, Vec3::Y * half.y)],
        boundaries: vec![Boundary::new(BoundaryShape::Plane { half_extents: [half.x, half.z] }, Vec3::ZERO)],
        periodic: Periodic { x: Some((-half.x, half.x)), y: None, z: Some((-half.z, half.z)) },
        ..FluidScene::with_spacing(0.02)
    };
    scene.settings.pressure_solver = pressure_solver;
    scene.settings.artificial_viscosity = 0.0;
    scene.settings.expected_speed = Some(2.0);
    scene
}

/// The mean velocity along x of the particles that started nearer to the middle than this, m/s.
fn speed(solver: &mut dyn FluidSolver, within: f32) -> f32 {
    let state = solver.snapshot().unwrap();
    let start = &solver.plan().positions;
    let inner = |&(&id, _): &(&u32, &Vec3)| start[id as usize].x.abs() < within;
    let speeds: Vec<f32> = state.ids.iter().zip(&state.velocities).filter(inner).map(|(_, v)| v.x).collect();
    speeds.iter().sum::<f32>() / speeds.len() as f32
}

/// A layer comes to rest on a belt that stands, and then the belt runs: it gets faster by `mu g` until it has the belt's speed, and keeps that.
pub fn assert_a_belt_carries(open: &mut dyn FnMut(&FluidScene) -> Box<dyn FluidSolver>) {
    for (pressure_solver, creep, along) in solvers() {
        let mut scene = layer(pressure_solver);
        scene.boundaries[0].friction = Friction { at_rest: 0.6, sliding: 0.2 };
        let mut solver = open(&scene);
        let (mut tick, duration) = (0, 2e-3);
        let mut run = |solver: &mut dyn FluidSolver, ticks| {
            for _ in 0..ticks {
                solver.step(&StepInput { tick, duration, ..StepInput::default() }).unwrap();
                tick += 1;
            }
            speed(solver, 1.0)
        };
        run(&mut *solver, 250);
        scene.boundaries[0].velocity = Vec3::X;
        solver.reconfigure(Plan::new(&scene).unwrap()).unwrap();
        let speeds = [50, 100, 150, 150].map(|ticks| run(&mut *solver, ticks));
        println!("{pressure_solver:?}: {speeds:?}");
        let [early, later, there, still] = speeds;
        let found = (later - early) / 0.2;
        assert!((found / (0.2 * 9.81) - 1.0).abs() < 0.03, "{pressure_solver:?}: {found} m/s2");
        assert!((there - 1.0).abs() < creep && (still - 1.0).abs() < creep, "{pressure_solver:?}: {speeds:?}");
        // A belt that itself gets faster, in steps that friction takes within a tick.
        for step in 1..=50 {
            scene.boundaries[0].velocity = Vec3::X * (1.0 + along * 9.81 * duration * step as f32);
            solver.reconfigure(Plan::new(&scene).unwrap()).unwrap();
            run(&mut *solver, 1);
        }
        let (found, belt) = (speed(&mut *solver, 1.0), scene.boundaries[0].velocity.x);
        println!("{pressure_solver:?}: {found} m/s on a belt of {belt} m/s");
        assert!((found - belt).abs() < 3.0 * creep, "{pressure_solver:?}: {found} m/s on a belt of {belt} m/s");
    }
}

/// A layer on a plate that moves: with it below `mu_s g`, and by `mu_k g` where the plate is faster; and what the plate gets is what the fluid has.
pub fn assert_a_plate_carries(open: &mut dyn FnMut(&FluidScene) -> Box<dyn FluidSolver>) {
    for (pressure_solver, creep, along) in solvers() {
        for (over_g, expected) in [(along, along), (0.8, 0.2)] {
            let mut scene = layer(pressure_solver);
            scene.periodic = Periodic::default();
            // Two panes without friction keep it from spreading to the sides.
            let missing = [true, true, true, true, false, false];
            let panes = BoundaryShape::Container { half_extents: Vec3::new(1.0, 0.1, 0.04), open: missing };
            scene.boundaries = vec![Boundary::new(panes, Vec3::Y * 0.1)];
            scene.volumes = vec![Volume::block(Vec3::new(0.5, 0.01, 0.04), Vec3::Y * 0.01)];
            let plate = BoundaryShape::Plane { half_extents: [0.8, 0.12] };
            let friction = Friction { at_rest: 0.6, sliding: 0.2 };
            let plate = Body::of_shape("plate", plate, &scene.wall_layer().unwrap()).unwrap();
            scene.bodies = vec![Body { friction, at_once: true, ..plate }];
            let mut solver = open(&scene);
            let mass = f64::from(solver.plan().parameters.particle_mass);
            let (acceleration, duration, rest) = (over_g * 9.81, 0.01, 30u64);
            let (mut given, mut speeds) = (DVec3::ZERO, Vec::new());
            for tick in 0..rest + 30 {
                let time = tick.saturating_sub(rest) as f32 * duration;
                // From where it was left: nothing takes it elsewhere.
                let left = solver.snapshot().unwrap().poses.first().copied().flatten();
                let body = BodyInput {
                    position: left.map_or(Vec3::ZERO, |pose| pose.position),
                    linear_velocity: Vec3::X * (acceleration * time),
                    acceleration: if tick < rest { Vec3::ZERO } else { Vec3::X * acceleration },
                    inverse_mass: 0.0,
                    inverse_inertia: Mat3::ZERO,
                    ..BodyInput::default()
                };
                let input = StepInput { tick, duration, bodies: vec![body], ..StepInput::default() };
                given += solver.step(&input).unwrap().bodies[0].linear.as_dvec3();
                // What starts at the ends spreads.
                speeds.push(speed(&mut *solver, 0.3));
            }
            let [begun, early, late] = [0, 10, 30].map(|tick: u64| speeds[(rest + tick) as usize - 1]);
            let found = (late - early) / 0.2;
            let what = format!("{pressure_solver:?}, {over_g} g: {begun}, {early}, {late} m/s, {found} m/s2");
            println!("{what}");
            let error = match over_g == expected {
                true => (late - acceleration * 0.3).abs() / (2.0 * creep),
                false => (found / (expected * 9.81) - 1.0).abs() / 0.03,
            };
            assert!(begun.abs() < creep && error < 1.0, "{what}");
            let state = solver.snapshot().unwrap();
            // Panes of samples are not quite smooth.
            let fluid: f64 = state.velocities.iter().map(|v| mass * f64::from(v.x)).sum();
            assert!((fluid + given.x).abs() < 3e-3 * fluid, "{fluid} N s of the fluid, {given} of the plate");
        }
    }
}
