//! Bodies of three layers of quasi-fluid, against sums over all pairs in double precision, and what must come of them.

mod common;
#[path = "common/quasi_fluid.rs"]
mod quasi_fluid;

use common::solver;
use freshet_core::prelude::*;
use quasi_fluid::{
    assert_a_quasi_fluid_ball_gets_what_the_fluid_loses, quasi_fluid_ball, quasi_fluid_errors, quasi_fluid_scene,
};

#[test]
fn samples_have_pressures_of_their_own_and_exchange_them() {
    for kernel in [KernelKind::WendlandC2, KernelKind::CubicSpline] {
        let found = quasi_fluid_errors(&mut solver(&quasi_fluid_scene(kernel), 2));
        assert!(found.iter().all(|&error| error < 1.0), "{kernel:?}: {found:?}");
    }
}

#[test]
fn a_ball_gets_what_the_fluid_loses() {
    assert_a_quasi_fluid_ball_gets_what_the_fluid_loses(&mut |scene| Box::new(solver(scene, 2)));
}

/// A box on the fluid's lattice is fluid but for its name: with the fluid around it its samples have the density at rest.
#[test]
fn a_box_among_particles_at_rest_is_as_dense_as_they_are() {
    let scene = FluidScene::with_spacing(0.05);
    let layers = scene.wall_layer().unwrap().quasi_fluid().map(|layer| Body {
        samples: layer.box_surface(Vec3::splat(0.15)).unwrap(),
        solids: vec![Solid::block(Vec3::splat(0.15), Vec3::ZERO)],
        ..Body::default()
    });
    let body = Body::quasi_fluid(layers, 0.05);
    assert_eq!(body.sampling, BodySampling::QuasiFluid { layers: [152, 56, 8] });
    let plan = Plan::new(&FluidScene { bodies: vec![body], ..scene }).unwrap();
    let (planned, kernel) = (&plan.bodies[0], plan.parameters.kernel().unwrap());
    let steps = (-10..10).map(|i| (i as f32 + 0.5) * 0.05);
    let lattice = steps.clone().flat_map(|x| {
        steps.clone().flat_map({
            let steps = steps.clone();
            move |y| {
                let steps = steps.clone();
                steps.map(move |z| Vec3::new(x, y, z))
            }
        })
    });
    let around: Vec<Vec3> = lattice.filter(|x| x.abs().max_element() > 0.15).collect();
    let mut worst: f64 = 0.0;
    for (sample, own) in planned.samples.iter().zip(&planned.own_densities) {
        let fluid: f64 = around.iter().map(|x| kernel.value(f64::from(x.distance(*sample)))).sum();
        let density = f64::from(*own) + fluid * 0.05f64.powi(3) / f64::from(plan.parameters.density_calibration);
        worst = worst.max((density - 1.0).abs());
    }
    println!("{worst}");
    assert!(worst < 0.1, "{worst}");
}

#[test]
fn what_does_not_go_with_quasi_fluid_is_refused() {
    let refused = |change: fn(&mut FluidScene)| {
        let mut scene = quasi_fluid_scene(KernelKind::WendlandC2);
        change(&mut scene);
        Plan::new(&scene).unwrap_err().to_string()
    };
    let error = refused(|scene| {
        scene.settings.equation_of_state = None;
        scene.settings.pressure_solver = PressureSolver::DivergenceFree(DivergenceFree::default());
    });
    assert!(error.contains("bodies[0].sampling") && error.contains("pressure_solver"), "{error}");
    let error = refused(|scene| scene.settings.widest_support = 2.0);
    assert!(error.contains("widest_support"), "{error}");
    let error = refused(|scene| {
        scene.settings.viscosity_model = Some(ViscosityModel::Morris1997);
    });
    assert!(error.contains("viscosity_model"), "{error}");
    let error = refused(|scene| scene.bodies[0].sampling = BodySampling::QuasiFluid { layers: [1, 2, 3] });
    assert!(error.contains("bodies[0].sampling.layers"), "{error}");
    // A plan without has no pass for it.
    let mut scene = quasi_fluid_scene(KernelKind::WendlandC2);
    assert!(Plan::new(&scene).unwrap().has(StageKind::BodyDensity));
    scene.bodies.remove(0);
    assert!(!Plan::new(&scene).unwrap().has(StageKind::BodyDensity));
    assert!(quasi_fluid_ball(&scene, 0.1).samples.len() > 60);
}
