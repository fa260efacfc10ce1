//! Each stability aid in a case that fails without it.

mod common;

use common::{run, solver};
use freshet_core::prelude::*;

/// Two blocks of 0.3 m that meet head on at twice the speed of sound each, without weight and without viscosity; one's lattice is half a
/// spacing off the other's, so that particles come upon gaps. By symmetry nothing of a fluid crosses the plane in the middle.
fn colliding_blocks(xsph: f32) -> FluidScene {
    let off = Vec3::new(0.0, 0.005, 0.005);
    let block = |side: f32| Volume {
        velocity: Vec3::X * -2.0 * side,
        hydrostatic: false,
        ..Volume::block(Vec3::splat(0.15), side * (Vec3::X * 0.16 + off))
    };
    let mut scene =
        FluidScene { gravity: Vec3::ZERO, volumes: vec![block(-1.0), block(1.0)], ..FluidScene::with_spacing(0.02) };
    scene.settings.sound_speed = Some(1.0);
    scene.settings.allow_compressible = true;
    scene.settings.artificial_viscosity = 0.0;
    scene.settings.xsph = xsph;
    scene
}

/// The share of particles that are more than a spacing beyond the middle after 0.05 s, and where the centre of mass is, m.
fn penetration(scene: &FluidScene) -> (f32, Vec3) {
    let mut solver = solver(scene, 2);
    run(&mut solver, 3);
    let (spacing, first) = (solver.plan().parameters.spacing, solver.plan().volume_ids[1].0);
    let snapshot = solver.snapshot().unwrap();
    let beyond = |(&id, x): (&u32, &Vec3)| if id < first { x.x > spacing } else { -x.x > spacing };
    let many = snapshot.ids.iter().zip(&snapshot.positions).filter(|&one| beyond(one)).count();
    let center = snapshot.positions.iter().sum::<Vec3>() / snapshot.ids.len() as f32;
    (many as f32 / snapshot.ids.len() as f32, center)
}

/// Monaghan 1989, "On the problem of penetration in particle methods".
#[test]
fn xsph_keeps_streams_that_meet_from_passing_through_each_other() {
    let (without, _) = penetration(&colliding_blocks(0.0));
    let (half, _) = penetration(&colliding_blocks(0.5));
    let (with, center) = penetration(&colliding_blocks(1.0));
    assert!(without > 0.1, "without it {without} of the particles are on the wrong side");
    assert!(half < 0.3 * without, "with half of it {half}, without {without}");
    assert!(with < 0.02, "with it {with}");
    assert!(center.length() < 1e-4, "pairs move as much to one side as to the other: {center}");
}

/// What XSPH moves particles by is no part of what the pressures are solved for; the next substep finds what it did to densities.
#[test]
fn an_incompressible_fluid_with_xsph_is_compressed_less_than_twice_as_much_as_without() {
    let compression = |xsph: f32| {
        let mut scene = FluidScene {
            volumes: vec![Volume::block(Vec3::splat(0.2), Vec3::splat(0.2))],
            boundaries: vec![Boundary::open_box(Vec3::new(0.8, 0.8, 0.4), Vec3::new(0.4, 0.4, 0.2))],
            ..FluidScene::with_spacing(0.04)
        };
        scene.settings.pressure_solver = PressureSolver::DivergenceFree(DivergenceFree::default());
        scene.settings.xsph = xsph;
        let mut solver = solver(&scene, 2);
        let reports = run(&mut solver, 60);
        assert_eq!(reports.iter().map(|report| report.removed + report.unsolved).sum::<u32>(), 0);
        reports.iter().map(|report| report.mean_compression).sum::<f32>() / reports.len() as f32
    };
    let (without, with) = (compression(0.0), compression(0.5));
    assert!(with < 2.0 * without && with < 3e-3, "{with} with, {without} without");
}

/// A layer of particles on a slope without end, which is steep by tilted gravity.
fn layer_on_a_slope(steepness: f32, friction: Friction) -> FluidScene {
    let half = Vec3::new(0.1, 0.01, 0.1);
    let slope = Boundary::new(BoundaryShape::Plane { half_extents: [half.x, half.z] }, Vec3::ZERO);
    let mut scene = FluidScene {
        gravity: 9.81 * Vec3::new(steepness.sin(), -steepness.cos(), 0.0),
        volumes: vec![Volume::block(half, Vec3::Y * half.y)],
        boundaries: vec![slope.with_viscous_faces([false; 6]).with_friction(friction)],
        periodic: Periodic { x: Some((-half.x, half.x)), y: None, z: Some((-half.z, half.z)) },
        ..FluidScene::with_spacing(0.02)
    };
    scene.settings.expected_speed = Some(2.0);
    scene
}

/// The mean velocity down the slope after half a second, and half a second later, m/s.
fn speeds(scene: &FluidScene) -> [f32; 2] {
    let mut solver = solver(scene, 2);
    [0, 1].map(|_| {
        run(&mut solver, 30);
        let velocities = solver.read(Field::Velocity).unwrap().vectors().unwrap();
        assert_eq!(velocities.len(), 100);
        velocities.iter().map(|v| v.x).sum::<f32>() / 100.0
    })
}

/// Coulomb: a block stays where the slope is less steep than the friction's angle, and else gets faster by `g (sin - mu cos)`.
#[test]
fn a_layer_stays_on_a_slope_below_the_angle_of_friction_and_slides_down_a_steeper_one() {
    let weakly = PressureSolver::WeaklyCompressible;
    let solved = PressureSolver::DivergenceFree(DivergenceFree::default());
    let run = |pressure_solver: PressureSolver, degrees: f32, friction: Friction| {
        let mut scene = layer_on_a_slope(degrees.to_radians(), friction);
        scene.settings.pressure_solver = pressure_solver;
        speeds(&scene)
    };
    // The angle of 0.5 is 26.6 degrees. Particles on an equation of state bounce a little, and slide while they do not press.
    for (pressure_solver, degrees, creep) in [(weakly, 15.0, 1e-2), (solved, 15.0, 1e-5), (solved, 25.0, 1e-5)] {
        let [_, last] = run(pressure_solver, degrees, Friction::coulomb(0.5));
        assert!(last.abs() < creep, "{pressure_solver:?} {degrees}: {last} m/s");
        let [_, slippery] = run(pressure_solver, degrees, Friction::default());
        assert!(slippery > 2.0, "without friction {slippery} m/s");
    }
    // What sticks at first goes on sliding once it slides: 35 degrees are too steep for 0.6, and then it is 0.5 that counts.
    for pressure_solver in [weakly, solved] {
        for (degrees, at_rest) in [(35.0f32, 0.5), (35.0, 0.6), (45.0, 0.5)] {
            let [half, whole] = run(pressure_solver, degrees, Friction { at_rest, sliding: 0.5 });
            let (sin, cos) = degrees.to_radians().sin_cos();
            let (found, expected) = (2.0 * (whole - half), 9.81 * (sin - 0.5 * cos));
            let error = (found / expected - 1.0).abs();
            assert!(error < 0.03, "{pressure_solver:?} {degrees}: {found} not {expected} m/s2, {half} {whole}");
        }
    }
}
