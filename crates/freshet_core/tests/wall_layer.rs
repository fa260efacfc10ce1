//! A single layer of samples stands for a whole wall: density and balance of the fluid in front of it.

use freshet_core::kernel::{Kernel, KernelKind};
use freshet_core::sampling::wall_layer::WallLayer;
use glam::{DVec3, Vec3};

/// Density (in units of rest density) and even-pressure imbalance (in units of what one fluid layer pushes) of a particle half
/// a spacing in front of a plane, at `aside` spacings along it.
fn in_front_of_a_plane(kinds: [KernelKind; 2], ratio: f32, aside: [f32; 2]) -> (f64, f64) {
    let d = 0.1f32;
    let [kernel, pressure] = kinds.map(|kind| Kernel::new(kind, ratio * d).unwrap());
    let layer = WallLayer::of_terms(&kernel, &pressure, d);
    let samples = layer.plane(Vec3::Y, 1.05, 1.05).unwrap();
    let volumes = layer.volumes(&samples);
    let at = Vec3::new(aside[0] * d, 0.5 * d, aside[1] * d).as_dvec3();
    let (mut density, mut push) = (0.0, 0.0);
    for (sample, volume) in samples.iter().zip(volumes) {
        let apart = at - sample.as_dvec3();
        density += f64::from(volume) * kernel.value(apart.length());
        push += f64::from(volume) * pressure.derivative_over_r(apart.length()) * apart.y;
    }
    let m = f64::from(d).powi(3);
    let mut fluid = 0.0;
    for k in 0..5 {
        for j in -5..=5 {
            for i in -5..=5 {
                let apart = DVec3::new(f64::from(i), f64::from(-k), f64::from(j)) * f64::from(d);
                density += m * kernel.value(apart.length());
                fluid += 2.0 * m * pressure.derivative_over_r(apart.length()) * apart.y;
            }
        }
    }
    (density / kernel.lattice_sum(d), (push + fluid) / fluid)
}

#[test]
fn the_first_layer_is_at_rest_density_and_in_balance() {
    for kind in KernelKind::WITH_GRADIENT {
        for ratio in [2.0, 2.5] {
            // Straight in front of a sample, between two and between four: the conditions hold on average along the plane.
            let places =
                [[0.0, 0.0], [0.5, 0.0], [0.0, 0.5], [0.5, 0.5]].map(|a| in_front_of_a_plane([kind; 2], ratio, a));
            let density = places.iter().map(|place| place.0).sum::<f64>() / 4.0;
            let imbalance = places.iter().map(|place| place.1).sum::<f64>() / 4.0;
            assert!((density - 1.0).abs() < 0.03, "{kind:?} {ratio}: density {density}, {places:?}");
            assert!(imbalance.abs() < 0.25, "{kind:?} {ratio}: imbalance {imbalance}, {places:?}");
        }
    }
    // The default kernel, on which everything is measured, closely.
    let (density, imbalance) = in_front_of_a_plane([KernelKind::WendlandC2; 2], 2.0, [0.0, 0.0]);
    assert!((density - 1.0).abs() < 0.005 && imbalance.abs() < 0.05, "{density} {imbalance}");
    let layer = WallLayer::new(&Kernel::new(KernelKind::WendlandC2, 0.2).unwrap(), 0.1);
    assert!((layer.depth - 0.0918).abs() < 1e-4 && (layer.gamma - 7.48).abs() < 0.01, "{layer:?}");
}

#[test]
fn kernels_of_terms_have_a_layer_that_meets_both_conditions() {
    use KernelKind::{CubicSpline, Poly6, QuinticSpline, Spiky, WendlandC2};
    for kinds in [[Poly6, Spiky], [WendlandC2, Spiky], [WendlandC2, CubicSpline], [QuinticSpline, WendlandC2]] {
        for ratio in [2.0, 2.5] {
            let places = [[0.0, 0.0], [0.5, 0.0], [0.0, 0.5], [0.5, 0.5]].map(|a| in_front_of_a_plane(kinds, ratio, a));
            let density = places.iter().map(|place| place.0).sum::<f64>() / 4.0;
            let imbalance = places.iter().map(|place| place.1).sum::<f64>() / 4.0;
            assert!((density - 1.0).abs() < 0.03, "{kinds:?} {ratio}: density {density}, {places:?}");
            assert!(imbalance.abs() < 0.25, "{kinds:?} {ratio}: imbalance {imbalance}, {places:?}");
        }
    }
    // With a layer of the density's kernel alone the push is wrong: the test would notice.
    let [kernel, pressure] = [Poly6, Spiky].map(|kind| Kernel::new(kind, 0.2).unwrap());
    let [alone, both] = [&kernel, &pressure].map(|pressure| WallLayer::of_terms(&kernel, pressure, 0.1));
    assert!(both.depth > alone.depth * 1.1 && both.gamma < WallLayer::MOST_GAMMA, "{alone:?} {both:?}");
    let none = WallLayer::of_terms(&kernel, &Kernel::new(KernelKind::Quartic, 0.2).unwrap(), 0.1);
    assert!(none.gamma > WallLayer::MOST_GAMMA, "{none:?}");
}

#[test]
fn shapes_have_their_samples_at_the_depth_of_the_layer() {
    let d = 0.1f32;
    let layer = WallLayer::new(&Kernel::new(KernelKind::WendlandC2, 2.0 * d).unwrap(), d);
    let near = |a: f32, b: f32| (a - b).abs() < 1e-5;
    let ball = layer.sphere_surface(0.3).unwrap();
    assert!(ball.iter().all(|sample| near(sample.length(), 0.3 - layer.depth)));
    // As many as its visible surface has cells.
    assert!((ball.len() as f32 - 4.0 * std::f32::consts::PI * 9.0).abs() < 2.0, "{}", ball.len());
    let cube = layer.box_surface(Vec3::splat(0.3)).unwrap();
    assert!(cube.iter().all(|sample| near(sample.abs().max_element(), 0.3 - layer.depth)));
    let tank = layer.container(Vec3::splat(0.5), [false; 6]).unwrap();
    assert!(tank.iter().all(|sample| near(sample.abs().max_element(), 0.5 + layer.depth)));
    let plane = layer.plane(Vec3::Z, 1.0, 1.0).unwrap();
    assert!(plane.iter().all(|sample| near(sample.z, -layer.depth)));
    // Bodies thinner than the layer is deep still have samples.
    assert!(
        !layer.sphere_surface(0.08).unwrap().is_empty() && !layer.box_surface(Vec3::splat(0.06)).unwrap().is_empty()
    );
    assert!(layer.sphere_surface(-1.0).is_err() && layer.container(Vec3::NAN, [false; 6]).is_err());
}
