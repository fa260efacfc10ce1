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
