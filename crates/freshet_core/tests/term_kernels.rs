//! Kernels of terms: what a plan makes of them, and what it refuses.

use freshet_core::kernel::Kernel;
use freshet_core::plan::{Plan, StageKind};
use freshet_core::prelude::*;
use freshet_core::pressure_solver::{DivergenceFree, PressureSolver};
use freshet_core::viscosity::ViscosityModel;
use freshet_core::wall_method::WallMethod;

/// Honey between walls, with the kernels of Mueller et al. 2003.
fn honey() -> FluidScene {
    let mut scene = FluidScene {
        volumes: vec![Volume::block(Vec3::splat(0.5), Vec3::splat(0.5))],
        boundaries: vec![Boundary::closed_box(Vec3::ONE, Vec3::splat(0.5))],
        ..FluidScene::with_spacing(0.1)
    };
    scene.material.dynamic_viscosity = 10.0;
    scene.settings.viscosity_model = Some(ViscosityModel::Morris1997);
    scene.settings.kernel = KernelKind::Poly6;
    scene.settings.pressure_kernel = Some(KernelKind::Spiky);
    scene.settings.viscosity_kernel = Some(KernelKind::Viscosity);
    scene
}

#[test]
fn each_term_is_calibrated_by_its_own_kernel() {
    let plan = Plan::new(&honey()).unwrap();
    let p = &plan.parameters;
    let of = |kind| Kernel::new(kind, 0.2).unwrap();
    assert_eq!(p.density_calibration, of(KernelKind::Poly6).lattice_sum(0.1) as f32);
    assert_eq!(p.gradient_calibration, of(KernelKind::Spiky).lattice_gradient_sum(0.1) as f32);
    assert_eq!(p.viscous_calibration, of(KernelKind::Viscosity).sheared_viscous_sum(0.1) as f32);
    let reason = plan.stages.iter().find(|stage| stage.kind == StageKind::Acceleration).unwrap().reason.as_str();
    assert!(
        reason.contains("pressure_kernel is spiky") && reason.contains("viscosity_kernel is viscosity"),
        "{reason}"
    );
    let printed = plan.to_string();
    assert!(
        printed.contains("spiky kernel of pressure") && printed.contains("viscosity kernel of viscosity"),
        "{printed}"
    );
    // Those that are not asked for are the one there is.
    let mut plain = honey();
    (plain.settings.pressure_kernel, plain.settings.viscosity_kernel) = (None, None);
    let plan = Plan::new(&plain).unwrap();
    let p = &plan.parameters;
    assert_eq!([p.pressure_kernel, p.viscosity_kernel], [KernelKind::Poly6; 2]);
    assert!(!p.has_own_viscosity_kernel() && !plan.to_string().contains("kernel of pressure"));
}

#[test]
fn what_sums_by_one_kernel_refuses_another() {
    let refused = |change: &dyn Fn(&mut FluidScene), words: [&str; 2]| {
        let mut scene = honey();
        change(&mut scene);
        let message = Plan::new(&scene).unwrap_err().to_string();
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    };
    let solver = PressureSolver::DivergenceFree(DivergenceFree::default());
    let pressure = "settings.pressure_kernel: spiky";
    let viscosity = "settings.viscosity_kernel: viscosity";
    let alone =
        |scene: &mut FluidScene| (scene.settings.kernel, scene.settings.pressure_kernel) = (KernelKind::Spiky, None);
    refused(&|scene| scene.settings.pressure_solver = solver, [pressure, "weakly compressible"]);
    refused(&|scene| scene.settings.density = DensityForm::Continuity, [pressure, "carried"]);
    refused(&|scene| scene.settings.wall_method = WallMethod::LennardJones, [pressure, "settings.wall_method"]);
    refused(&|scene| scene.settings.widest_support = 1.5, [pressure, "settings.widest_support"]);
    refused(&|scene| scene.settings.viscosity_model = None, [viscosity, "viscosity_model"]);
    refused(&|scene| (alone(scene), scene.settings.widest_support = 1.5).0, [viscosity, "settings.widest_support"]);
    refused(&|scene| (alone(scene), scene.settings.wall_method = WallMethod::Ghosts).0, [viscosity, "ghost particles"]);
    refused(
        &|scene| scene.settings.pressure_kernel = Some(KernelKind::Viscosity),
        ["settings.pressure_kernel", "Laplacian"],
    );
    refused(&|scene| scene.settings.kernel = KernelKind::Viscosity, ["settings.kernel", "Laplacian"]);
    // No layer has a wall's density by poly6 and its push by the quartic.
    refused(
        &|scene| scene.settings.pressure_kernel = Some(KernelKind::Quartic),
        ["settings.pressure_kernel: quartic", "poly6"],
    );
    // Every solver has viscosity.
    let mut scene = honey();
    alone(&mut scene);
    scene.settings.pressure_solver = solver;
    assert!(Plan::new(&scene).unwrap().parameters.has_own_viscosity_kernel());
}

#[test]
fn half_of_a_laplacian_stands_for_the_slope_of_a_viscous_force() {
    let kernel = Kernel::new(KernelKind::Viscosity, 2.0).unwrap();
    // Mueller et al. 2003, eq. 22: 45/(pi H^6) (H - r).
    let expected = |r: f64| -0.5 * 45.0 / (std::f64::consts::PI * 64.0) * (2.0 - r);
    for r in [0.0, 0.3, 1.0, 1.9] {
        assert!((kernel.viscous_over_r(r) - expected(r)).abs() < 1e-12);
    }
    assert_eq!(kernel.viscous_over_r(2.0), 0.0);
    // The sum over a fine lattice gives v = x^2 its Laplacian, but for the softening of short distances.
    for kind in KernelKind::ALL {
        let kernel = Kernel::new(kind, 2.0).unwrap();
        for found in [kernel.lattice_viscous_sum(0.05), kernel.sheared_viscous_sum(0.05)] {
            assert!((found - 1.0).abs() < 0.03, "{kind:?}: {found}");
        }
    }
    // On two spacings of support only the planes next to it count: in closed form, without softening, 2 x 45/32 (2/3 - 1/2 + 1/6) = 15/16.
    let sheared = kernel.sheared_viscous_sum(1.0);
    assert!((0.98..1.0).contains(&(sheared / 0.9375)), "{sheared}");
    let smooth = Kernel::new(KernelKind::WendlandC2, 2.0).unwrap();
    let (rest, sheared) = (smooth.lattice_viscous_sum(1.0), smooth.sheared_viscous_sum(1.0));
    assert!((rest - sheared).abs() < 0.01, "{rest} {sheared}");
}
