//! No kernel makes a block at rest explode: in a thesis whose stability this is about (Enneking 2018, section 7.3) the quintic and the
//! quadratic kernel did.

mod common;

use common::{run, solver};
use freshet_core::prelude::*;

/// Water that fills a box up to three quarters.
fn scene(kernel: KernelKind, pressure_solver: PressureSolver) -> FluidScene {
    let mut scene = FluidScene {
        volumes: vec![Volume::block(Vec3::splat(0.15), Vec3::splat(0.15))],
        boundaries: vec![Boundary::open_box(Vec3::new(0.3, 0.4, 0.3), Vec3::new(0.15, 0.2, 0.15))],
        ..FluidScene::with_spacing(0.05)
    };
    scene.settings.kernel = kernel;
    scene.settings.pressure_solver = pressure_solver;
    scene
}

/// Kinetic over potential energy, the most of a second of ticks and that after it, and how far the surface ends from where it began, in
/// spacings.
fn unrest(scene: &FluidScene) -> [f32; 3] {
    let mut solver = solver(scene, 2);
    let (mut most, mut last, mut count) = (0.0f32, 0.0, 0);
    for _ in 0..60 {
        count = run(&mut solver, 1)[0].particles as usize;
        let velocities = solver.read(Field::Velocity).unwrap().vectors().unwrap();
        let mean = velocities.iter().map(|v| v.length_squared()).sum::<f32>() / velocities.len() as f32;
        // 1/2 v^2 over g D/2.
        last = mean / (9.81 * 0.3);
        most = most.max(last);
    }
    let plan = solver.plan();
    assert_eq!(count, plan.positions.len());
    let top = |positions: &[Vec3]| {
        let mut heights: Vec<f32> = positions.iter().map(|x| x.y).collect();
        heights.sort_by(f32::total_cmp);
        heights[heights.len() - 36..].iter().sum::<f32>() / 36.0
    };
    let (before, spacing) = (top(&plan.positions), plan.parameters.spacing);
    let after = top(&solver.snapshot().unwrap().positions);
    [most, last, (after - before).abs() / spacing]
}

#[test]
fn no_kernel_makes_a_block_at_rest_explode() {
    // The worst are 0.21, 9e-4 and 0.67, and of the solved pressures 0.023, 2.2e-3 and 0.72.
    for (pressure_solver, allowed) in [
        (PressureSolver::WeaklyCompressible, [0.3, 2e-3, 0.75]),
        (PressureSolver::DivergenceFree(DivergenceFree::default()), [0.04, 4e-3, 0.75]),
    ] {
        for kernel in KernelKind::WITH_GRADIENT {
            let found = unrest(&scene(kernel, pressure_solver));
            let calm = found.iter().zip(allowed).all(|(&found, allowed)| found < allowed);
            assert!(calm, "{kernel:?}, {pressure_solver:?}: {found:?}, allowed {allowed:?}");
        }
    }
}
