//! No kernel makes a block at rest explode (Enneking 2018, section 7.3): as `freshet_cpu`'s test of that name, with its bounds.

use freshet_core::prelude::*;

use crate::common::{solver, tick};

#[test]
fn no_kernel_makes_a_block_at_rest_explode() {
    for kernel in KernelKind::WITH_GRADIENT {
        let mut scene = FluidScene {
            volumes: vec![Volume::block(Vec3::splat(0.15), Vec3::splat(0.15))],
            boundaries: vec![Boundary::open_box(Vec3::new(0.3, 0.4, 0.3), Vec3::new(0.15, 0.2, 0.15))],
            ..FluidScene::with_spacing(0.05)
        };
        scene.settings.kernel = kernel;
        let mut solver = solver(&scene);
        // Kinetic energy over that of the block's depth.
        let (mut most, mut last) = (0.0f32, 0.0);
        for number in 0..60 {
            let report = solver.step(&tick(number, 1.0 / 60.0)).unwrap();
            assert_eq!((report.particles, report.removed), (216, 0), "{kernel:?}");
            let velocities = solver.read(Field::Velocity).unwrap().vectors().unwrap();
            last = velocities.iter().map(|v| v.length_squared()).sum::<f32>() / (216.0 * 9.81 * 0.3);
            most = most.max(last);
        }
        assert!(most < 0.3 && last < 2e-3, "{kernel:?}: {most} at most, {last} at the end");
    }
}

/// As `freshet_cpu`'s test of settled particles, in a vessel of 0.2 m without weight.
#[test]
fn particles_that_settled_start_without_noise() {
    let fastest = |relaxation: Option<Relaxation>| {
        let vessel = BoundaryShape::Sphere { radius: 0.2, fluid: FluidSide::Inside };
        let mut scene = FluidScene {
            gravity: Vec3::ZERO,
            volumes: vec![Volume { velocity: Vec3::X * 1e-4, ..Volume::ball(0.2, Vec3::ZERO) }],
            boundaries: vec![Boundary::new(vessel, Vec3::ZERO)],
            ..FluidScene::with_spacing(0.04)
        };
        scene.settings.expected_speed = Some(3.0);
        scene.settings.relaxation = relaxation;
        let mut solver = solver(&scene);
        let start = solver.snapshot().unwrap();
        assert!(start.is_start() && start.velocities == solver.plan().velocities);
        assert_eq!(solver.plan().notes.iter().any(|note| note.contains("settled in")), relaxation.is_some());
        (0..5).map(|number| solver.step(&tick(number, 0.01)).unwrap().max_speed).fold(0.0, f32::max)
    };
    let (without, with) = (fastest(None), fastest(Some(Relaxation { calm: 3e-3, ..Relaxation::default() })));
    assert!(without > 2.0 && with < 0.02, "{with} m/s, without {without} m/s");
}
