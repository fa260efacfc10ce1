//! Kernels against quadrature, differences and the numbers that the derivation gave.

use std::f64::consts::PI;

use freshet_core::kernel::{
    Kernel, KernelKind, MAX_SUPPORT_RADIUS, neighbours_in_support, support_radius_for_neighbours,
};
use glam::{DVec3, Vec3, vec3};

/// Support radii that are no round numbers, far from one, so that a wrong power of H shows.
const RADII: [f32; 3] = [0.037, 1.3, 21.0];

fn every(kinds: &[KernelKind]) -> impl Iterator<Item = Kernel> {
    kinds.iter().flat_map(|&kind| RADII.map(|radius| Kernel::new(kind, radius).unwrap()))
}

fn radius_of(kernel: &Kernel) -> f64 {
    f64::from(kernel.support_radius())
}

/// The integral over the ball, by Simpson's rule with 6000 panels: a multiple of 6, so that the seams of the splines fall on
/// its nodes. At r = 0 the integrand has the factor r^2 and is taken as 0, also where the kernel is infinite.
fn ball_integral(radius: f64, f: impl Fn(f64) -> f64) -> f64 {
    let panels = 6000;
    let step = radius / f64::from(panels);
    let sum: f64 = (1..=panels)
        .map(|i| {
            let r = step * f64::from(i);
            let weight = if i == panels {
                1.0
            } else if i % 2 == 1 {
                4.0
            } else {
                2.0
            };
            weight * 4.0 * PI * r * r * f(r)
        })
        .sum();
    sum * step / 3.0
}

#[test]
fn every_kernel_integrates_to_one() {
    for kernel in every(&KernelKind::ALL) {
        let integral = ball_integral(radius_of(&kernel), |r| kernel.value(r));
        // Simpson's error at this step is below 1e-12 for all of them; a constant typed with five figures would fail.
        assert!((integral - 1.0).abs() < 1e-9, "{}: {integral}", kernel.kind().name());
    }
}

#[test]
fn the_constant_of_the_cut_gaussian_is_the_documented_one() {
    let kernel = Kernel::new(KernelKind::Gaussian, 1.0).unwrap();
    // The documentation gives five figures.
    assert!((kernel.value(0.0) - 4.8632 * (1.0 - (-9.0_f64).exp())).abs() < 1e-4);
}

#[test]
fn derivatives_match_central_differences() {
    for kernel in every(&KernelKind::ALL) {
        let radius = radius_of(&kernel);
        let step = 1e-5 * radius;
        // From 0.03 H, where the infinite viscosity kernel is still resolved, to just inside the support; off the seams.
        for q in (0..200).map(|i| 0.0301 + 0.00484 * f64::from(i)) {
            let r = q * radius;
            let difference = (kernel.value(r + step) - kernel.value(r - step)) / (2.0 * step);
            // Truncation is of the order of (step/r)^2 = 1e-7 of the largest derivative met, rounding 1e-11.
            let scale = kernel.derivative(r).abs().max(1e-2 * kernel.value(0.5 * radius) / radius);
            let error = (difference - kernel.derivative(r)).abs() / scale;
            assert!(error < 1e-5, "{} at q = {q}: {difference} and {}", kernel.kind().name(), kernel.derivative(r));
            let over_r = kernel.derivative_over_r(r) * r;
            assert!((over_r - kernel.derivative(r)).abs() <= 1e-12 * scale, "{} at q = {q}", kernel.kind().name());
        }
    }
}

#[test]
fn laplacians_match_differences_of_the_gradient() {
    for kernel in every(&KernelKind::ALL) {
        let radius = radius_of(&kernel);
        let step = 1e-5 * radius;
        for q in (0..200).map(|i| 0.0301 + 0.00484 * f64::from(i)) {
            let r = q * radius;
            // (1/r^2) d/dr (r^2 W')
            let flux = |r: f64| r * r * kernel.derivative(r);
            let difference = (flux(r + step) - flux(r - step)) / (2.0 * step * r * r);
            // Where the Laplacian passes through zero its two parts cancel: measure against the larger part.
            let scale = kernel.laplacian(r).abs().max((kernel.derivative_over_r(r) * 2.0).abs());
            // Off by at most the third derivative times step^2, and the shape of the splines' seams.
            let error = (difference - kernel.laplacian(r)).abs()
                / scale.max(1e-3 * kernel.value(0.5 * radius) / radius.powi(2));
            assert!(error < 1e-4, "{} at q = {q}: {difference} and {}", kernel.kind().name(), kernel.laplacian(r));
        }
    }
}

#[test]
fn the_laplacian_at_the_centre_is_three_times_the_slope_over_r() {
    use KernelKind::*;
    for kernel in every(&[Gaussian, CubicSpline, QuinticSpline, Quartic, WendlandC2, WendlandNotch, Poly6]) {
        let (laplacian, slope) = (kernel.laplacian(0.0), kernel.derivative_over_r(0.0));
        // True of every smooth function of r alone; only rounding remains.
        assert!((laplacian - 3.0 * slope).abs() < 1e-12 * laplacian.abs(), "{}", kernel.kind().name());
        // And the limit is reached without a jump: the next terms are of order q.
        let near = kernel.derivative_over_r(1e-6 * radius_of(&kernel));
        assert!((near / slope - 1.0).abs() < 1e-5, "{}", kernel.kind().name());
    }
}

#[test]
fn poly6_laplacian_is_the_derived_one() {
    // P 2.44 without its leading -r.
    let kernel = Kernel::new(KernelKind::Poly6, 1.3).unwrap();
    let h = radius_of(&kernel);
    for r in [0.0, 0.3, 0.85, 1.2] {
        let expected = -945.0 / (32.0 * PI * h.powi(9)) * (h * h - r * r) * (3.0 * h * h - 7.0 * r * r);
        assert!((kernel.laplacian(r) - expected).abs() < 1e-12 * expected.abs(), "r = {r}");
    }
}

#[test]
fn viscosity_laplacian_is_positive_and_integrates_to_15_over_h_squared() {
    for kernel in every(&[KernelKind::Viscosity]) {
        let radius = radius_of(&kernel);
        let integral = ball_integral(radius, |r| kernel.laplacian(r));
        // A cubic integrand: Simpson's rule is exact.
        assert!((integral * radius * radius / 15.0 - 1.0).abs() < 1e-12);
        assert!((0..1000).all(|i| kernel.laplacian(radius * 0.001 * f64::from(i)) > 0.0));
        assert_eq!(kernel.laplacian(radius), 0.0);
        let at_centre = 45.0 / (PI * radius.powi(5));
        assert!((kernel.laplacian(0.0) / at_centre - 1.0).abs() < 1e-12);
        assert_eq!(kernel.value(0.0), f64::INFINITY);
    }
}

#[test]
fn everything_is_exactly_zero_at_and_beyond_the_support() {
    for kernel in every(&KernelKind::ALL) {
        let radius = radius_of(&kernel);
        for r in [radius, radius * (1.0 + f64::EPSILON), 1.0001 * radius, 1.5 * radius, 100.0 * radius, f64::INFINITY] {
            let all = [kernel.value(r), kernel.derivative(r), kernel.derivative_over_r(r), kernel.laplacian(r)];
            assert_eq!(all, [0.0; 4], "{} at {r}", kernel.kind().name());
        }
        assert_eq!(kernel.gradient(Vec3::X * kernel.support_radius()), Vec3::ZERO);
        // Just inside: finite, and down to nothing as every kernel is continuous there. Steepest is the cut Gaussian, by
        // 1e-4 * 18 exp(-9) * A / H^3, which is 4e-6 of W(0).
        let edge = kernel.value(0.9999 * radius).abs();
        assert!(edge < 1e-5 * kernel.value(0.01 * radius), "{}", kernel.kind().name());
    }
}

#[test]
fn kernels_fall_from_the_centre_outwards() {
    for kernel in every(&KernelKind::ALL) {
        let radius = radius_of(&kernel);
        for q in (1..1000).map(|i| 0.001 * f64::from(i)) {
            let (value, slope) = (kernel.value(q * radius), kernel.derivative(q * radius));
            if kernel.kind() == KernelKind::Quartic && q > 0.8 {
                // The quartic dips below zero; its documentation says by how much.
                assert!(value > -0.0025 * kernel.value(0.0) && (q < 0.9001 || slope > 0.0), "q = {q}");
            } else {
                assert!(value > 0.0 && slope < 0.0, "{} at q = {q}: {value}, {slope}", kernel.kind().name());
            }
        }
    }
}

#[test]
fn gradients_are_odd_and_point_to_the_centre() {
    for kernel in every(&KernelKind::WITH_GRADIENT) {
        let radius = kernel.support_radius();
        for direction in [vec3(0.3, -0.2, 0.5), vec3(-0.01, 0.02, 0.0), vec3(0.0, 0.0, 0.7), vec3(-0.4, -0.4, -0.4)] {
            let x_ab = direction * radius;
            let gradient = kernel.gradient(x_ab);
            assert_eq!(gradient, -kernel.gradient(-x_ab), "{}", kernel.kind().name());
            assert_eq!(kernel.value(x_ab.length().into()), kernel.value((-x_ab).length().into()));
            // Along x_ab, of the size of the derivative, inwards; single precision leaves 1e-6.
            let expected = x_ab.normalize() * kernel.derivative(x_ab.as_dvec3().length()) as f32;
            assert!((gradient - expected).length() <= 1e-6 * expected.length(), "{}", kernel.kind().name());
            assert!(gradient.dot(x_ab) < 0.0);
        }
    }
}

#[test]
fn gradients_match_central_differences_in_space() {
    for kernel in every(&KernelKind::WITH_GRADIENT) {
        let radius = radius_of(&kernel);
        let at = glam::DVec3::new(0.31, -0.22, 0.4) * radius;
        let step = 1e-5 * radius;
        let difference = |axis: glam::DVec3| {
            (kernel.value((at + axis * step).length()) - kernel.value((at - axis * step).length())) / (2.0 * step)
        };
        let expected =
            glam::DVec3::new(difference(glam::DVec3::X), difference(glam::DVec3::Y), difference(glam::DVec3::Z));
        let gradient = kernel.gradient(at.as_vec3()).as_dvec3();
        // The position is rounded to single precision: 6e-8 times the curvature.
        assert!((gradient - expected).length() < 2e-6 * expected.length(), "{}", kernel.kind().name());
    }
}

#[test]
fn two_particles_on_one_spot_have_no_gradient() {
    for kernel in every(&KernelKind::ALL) {
        assert_eq!(kernel.gradient(Vec3::ZERO), Vec3::ZERO, "{}", kernel.kind().name());
        // The smallest distance there is must not overflow on its way.
        assert!(
            kernel.gradient(Vec3::X * 1e-30 * kernel.support_radius()).is_finite()
                || kernel.kind() == KernelKind::Viscosity
        );
    }
}

#[test]
fn not_a_number_is_passed_on() {
    for kernel in every(&KernelKind::ALL) {
        assert!(kernel.value(f64::NAN).is_nan() && kernel.derivative(f64::NAN).is_nan());
        assert!(kernel.derivative_over_r(f64::NAN).is_nan() && kernel.laplacian(f64::NAN).is_nan());
    }
}

#[test]
fn lattice_sums_are_the_derived_ones() {
    let sum = |kind, ratio: f32| Kernel::new(kind, 0.05 * ratio).unwrap().lattice_sum(0.05);
    // METHODS, "Density", at H = 2 d, printed with three decimals.
    assert!((sum(KernelKind::CubicSpline, 2.0) - 1.000).abs() < 6e-4);
    assert!((sum(KernelKind::WendlandC2, 2.0) - 1.034).abs() < 6e-4);
    assert!((sum(KernelKind::Poly6, 2.0) - 1.010).abs() < 6e-4);
    assert!((sum(KernelKind::Spiky, 2.0) - 1.236).abs() < 6e-4);
}

#[test]
fn lattice_sums_equal_the_sum_over_every_node() {
    // Without the octants, which is how the library counts, and with the gradient of a linear field for G.
    let (d, slope) = (0.05_f32, Vec3::new(1.0, -2.0, 0.5));
    for kind in KernelKind::WITH_GRADIENT {
        let kernel = Kernel::new(kind, 2.3 * d).unwrap();
        let (mut sum, mut gradient) = (0.0, glam::DVec3::ZERO);
        for (i, j, k) in (-3..=3).flat_map(|i| (-3..=3).flat_map(move |j| (-3..=3).map(move |k| (i, j, k)))) {
            let x_b = vec3(i as f32, j as f32, k as f32) * d;
            sum += kernel.value(x_b.as_dvec3().length()) * f64::from(d).powi(3);
            gradient += kernel.gradient(-x_b).as_dvec3() * f64::from(slope.dot(x_b)) * f64::from(d).powi(3);
        }
        // Node positions are single precision.
        assert!((kernel.lattice_sum(d) - sum).abs() < 1e-6, "{}: {sum}", kind.name());
        let expected = slope.as_dvec3() * kernel.lattice_gradient_sum(d);
        assert!((gradient - expected).length() < 1e-5, "{}: {gradient} and {expected}", kind.name());
    }
}

#[test]
fn lattice_sums_tend_to_one() {
    for kind in KernelKind::ALL {
        let kernel = Kernel::new(kind, 1.0).unwrap();
        // A particle's own term of the spiky kernel at H = 20 d is 15/pi/8000 = 6e-4; the lattice makes up for it to 1e-4.
        let (s, g) = (kernel.lattice_sum(0.05), kernel.lattice_gradient_sum(0.05));
        if kind != KernelKind::Viscosity {
            assert!((s - 1.0).abs() < 1e-3, "{}: S = {s}", kind.name());
            assert!((g - 1.0).abs() < 1e-3, "{}: G = {g}", kind.name());
        }
        // The limit on fineness keeps this quick.
        assert!(kind == KernelKind::Viscosity || (kernel.lattice_sum(1e-30) - 1.0).abs() < 1e-5, "{}", kind.name());
    }
    let kernel = Kernel::new(KernelKind::WendlandC2, 1.0).unwrap();
    // Nobody else within reach: the particle's own term is left.
    assert_eq!(kernel.lattice_sum(2.0), 8.0 * kernel.value(0.0));
    assert_eq!(kernel.lattice_gradient_sum(2.0), 0.0);
    for spacing in [0.0, -1.0, f32::NAN] {
        assert!(kernel.lattice_sum(spacing).is_nan() && kernel.lattice_gradient_sum(spacing).is_nan());
    }
}

#[test]
fn the_table_of_lattice_sums() {
    // S and G at H = 2 d and 2.5 d, as documents quote them; the sums themselves are checked above, node by node.
    let table = [
        (KernelKind::Gaussian, [1.0770, 0.8454, 1.0061, 0.9797]),
        (KernelKind::CubicSpline, [1.0000, 1.0200, 0.9985, 0.9819]),
        (KernelKind::QuinticSpline, [1.0457, 0.8640, 1.0007, 0.9936]),
        (KernelKind::Quadratic, [1.0961, 0.9775, 1.0230, 0.9974]),
        (KernelKind::Quartic, [1.0082, 1.0706, 1.0082, 0.9386]),
        (KernelKind::WendlandC2, [1.0338, 0.9823, 1.0134, 0.9793]),
        (KernelKind::Poly6, [1.0098, 1.0649, 0.9954, 0.9613]),
        (KernelKind::Spiky, [1.2359, 0.9563, 1.0962, 0.9498]),
    ];
    for (kind, expected) in table {
        let [two, two_and_a_half] = [0.1, 0.125].map(|radius| Kernel::new(kind, radius).unwrap());
        let d = 0.05;
        let measured = [
            two.lattice_sum(d),
            two.lattice_gradient_sum(d),
            two_and_a_half.lattice_sum(d),
            two_and_a_half.lattice_gradient_sum(d),
        ];
        // Printed with four decimals.
        assert!(measured.iter().zip(expected).all(|(a, b)| (a - b).abs() < 6e-5), "{}: {measured:.4?}", kind.name());
    }
}

#[test]
fn support_radius_and_neighbour_count_are_inverses() {
    // 4 pi / 3 * 8 = 33.51 at H = 2 d.
    let count = neighbours_in_support(0.05, 0.1).unwrap();
    assert!((count - 33.510).abs() < 1e-3, "{count}");
    for n in [1.0, 33.51, 60.0, 1000.0] {
        let radius = support_radius_for_neighbours(0.02, n).unwrap();
        let back = neighbours_in_support(0.02, radius).unwrap();
        // The radius is rounded to 6e-8, its cube three times that.
        assert!((back / n - 1.0).abs() < 1e-6, "{n}: {back}");
    }
}

#[test]
fn a_ball_holds_as_many_lattice_points_as_it_says() {
    // P 4.1 counts the particle itself; averaged over where the centre lies in a cell.
    let radius = support_radius_for_neighbours(1.0, 60.0).unwrap();
    let (mut total, steps) = (0, 12);
    for cell in 0..steps * steps * steps {
        let shift = vec3((cell % steps) as f32, (cell / steps % steps) as f32, (cell / steps / steps) as f32) + 0.5;
        let centre = shift / steps as f32;
        for node in 0..512 {
            let node = vec3((node % 8) as f32, (node / 8 % 8) as f32, (node / 64) as f32) - 3.0;
            total += usize::from(node.distance(centre) < radius);
        }
    }
    let mean = total as f32 / (steps * steps * steps) as f32;
    // Midpoints of 12^3 cells: the count of 60 comes out to 0.1.
    assert!((mean - 60.0).abs() < 0.3, "{mean}");
}

#[test]
fn bad_inputs_are_refused_with_the_field() {
    for radius in [f32::NAN, f32::INFINITY, 0.0, -1.0, 1e-9, 2.0 * MAX_SUPPORT_RADIUS] {
        let error = Kernel::new(KernelKind::WendlandC2, radius).unwrap_err();
        assert_eq!(error.field, "support_radius");
    }
    for bad in [f32::NAN, 0.0, -1.0, f32::INFINITY] {
        assert_eq!(support_radius_for_neighbours(bad, 33.0).unwrap_err().field, "spacing");
        assert_eq!(support_radius_for_neighbours(0.1, bad).unwrap_err().field, "neighbours");
        assert_eq!(neighbours_in_support(bad, 0.1).unwrap_err().field, "spacing");
        assert_eq!(neighbours_in_support(0.1, bad).unwrap_err().field, "support_radius");
    }
}

#[test]
fn lists_and_names_are_complete() {
    let names: std::collections::BTreeSet<_> = KernelKind::ALL.iter().map(|kind| kind.name()).collect();
    assert_eq!(names.len(), 10);
    assert!(KernelKind::ALL.iter().filter(|&&kind| kind != KernelKind::Viscosity).eq(&KernelKind::WITH_GRADIENT));
    assert_eq!(KernelKind::default(), KernelKind::WendlandC2);
}

/// Against sums over every node of the lattice that is really strained, by two per cent either way.
#[test]
fn shear_moduli_are_those_of_strained_lattices() {
    let d = 0.1_f32;
    let smooth = [
        KernelKind::WendlandC2,
        KernelKind::WendlandNotch,
        KernelKind::Gaussian,
        KernelKind::QuinticSpline,
        KernelKind::Spiky,
    ];
    for (kind, ratio) in smooth.into_iter().flat_map(|kind| [2.05, 2.3].map(|ratio| (kind, ratio))) {
        let kernel = Kernel::new(kind, ratio * d).unwrap();
        let sum = |strained: &dyn Fn(DVec3) -> DVec3| -> f64 {
            let nodes = (-3..=3).flat_map(|k| (-3..=3).flat_map(move |j| (-3..=3).map(move |i| [i, j, k])));
            nodes.map(|node| kernel.value(strained(f64::from(d) * DVec3::from(node.map(f64::from))).length())).sum()
        };
        let start = sum(&|x| x);
        let grown = |gamma: f64| sum(&|x| x * (1.0 + gamma));
        let gradient = (grown(-1e-4) - grown(1e-4)) / (6e-4 * start);
        let gamma = 0.02_f64;
        let shear = |gamma: f64| {
            let size = (1.0 - 0.25 * gamma * gamma).powf(-1.0 / 3.0);
            sum(&|x| size * DVec3::new(x.x + 0.5 * gamma * x.y, x.y + 0.5 * gamma * x.x, x.z))
        };
        let stretch = |gamma: f64| sum(&|x| x * DVec3::new(1.0 + 0.5 * gamma, 1.0 / (1.0 + 0.5 * gamma), 1.0));
        let wanted = [&shear as &dyn Fn(f64) -> f64, &stretch]
            .map(|strained| (strained(gamma) + strained(-gamma) - 2.0 * start) / (gamma * gamma * start * gradient));
        let found = kernel.lattice_shear(d);
        for (found, wanted) in found.into_iter().zip(wanted) {
            assert!(
                (found - wanted).abs() < 2e-3 + 0.02 * wanted.abs(),
                "{} at {ratio} d: {found}, {wanted}",
                kind.name()
            );
        }
    }
    assert!(Kernel::new(KernelKind::WendlandC2, 1.0).unwrap().lattice_shear(-1.0)[0].is_nan());
}

/// A fluid has none; the default lattice has, and a support of 2.15 d hardly.
#[test]
fn the_table_of_shear_moduli() {
    let moduli = |kind, ratio: f32| Kernel::new(kind, ratio).unwrap().lattice_shear(1.0);
    let table = [
        (KernelKind::WendlandC2, 2.0, [0.0384, 0.1844]),
        (KernelKind::WendlandC2, 2.15, [0.0255, -0.0051]),
        (KernelKind::CubicSpline, 2.0, [0.0223, 0.0332]),
        (KernelKind::QuinticSpline, 2.7, [-0.0007, 0.0163]),
    ];
    for (kind, ratio, wanted) in table {
        for (found, wanted) in moduli(kind, ratio).into_iter().zip(wanted) {
            assert!((found - wanted).abs() < 1e-3, "{} at {ratio} d: {found}, {wanted}", kind.name());
        }
    }
}

/// What it is made for: particles under pressure have no arrangement that they would rather have.
#[test]
fn the_notched_kernel_sees_no_lattice() {
    let spread = |kind: KernelKind, ratio: f32| {
        let kernel = Kernel::new(kind, ratio).unwrap();
        // Each with one particle in a unit of volume.
        let lattices = [
            (1.0_f64, vec![[0.0; 3]]),
            (2.0_f64.cbrt(), vec![[0.0; 3], [0.5; 3]]),
            (4.0_f64.cbrt(), vec![[0.0; 3], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]]),
        ];
        let sums = lattices.map(|(edge, base)| {
            let cells = (-3..=3)
                .flat_map(|k| (-3..=3).flat_map(move |j| (-3..=3).map(move |i| DVec3::from([i, j, k].map(f64::from)))));
            let places = cells.flat_map(|cell| base.iter().map(move |&place| edge * (cell + DVec3::from(place))));
            places.map(|place| kernel.value(place.length())).sum::<f64>()
        });
        sums.iter().fold(0.0_f64, |most, sum| most.max((sum / sums[0] - 1.0).abs()))
    };
    assert!(spread(KernelKind::WendlandNotch, 2.3) < 2e-4, "{}", spread(KernelKind::WendlandNotch, 2.3));
    assert!(spread(KernelKind::WendlandC2, 2.3) > 3e-3 && spread(KernelKind::WendlandC2, 2.0) > 5e-3);
    let moduli = Kernel::new(KernelKind::WendlandNotch, 2.3).unwrap().lattice_shear(1.0);
    assert!(moduli.iter().all(|modulus| modulus.abs() < 0.02), "{moduli:?}");
}

/// Positive, with a double zero: the Fourier transform `4 pi integral of W r sin(k r)/k`, by Simpson's rule.
#[test]
fn the_transform_of_the_notched_kernel_touches_zero() {
    let kernel = Kernel::new(KernelKind::WendlandNotch, 1.0).unwrap();
    let transform =
        |k: f64| ball_integral(1.0, |r| kernel.value(r) * if k * r == 0.0 { 1.0 } else { (k * r).sin() / (k * r) });
    let notch = 188.5_f64.sqrt();
    let (at_notch, at_zero) = (transform(notch), transform(0.0));
    assert!(at_notch.abs() < 1e-9 && (at_zero - 1.0).abs() < 1e-9, "{at_notch}, {at_zero}");
    for step in 1..600 {
        let k = 0.1 * f64::from(step);
        assert!(transform(k) > -1e-9, "{} at {k}", transform(k));
    }
    assert!(transform(0.9 * notch) > 1e-5 && transform(1.1 * notch) > 1e-6);
}
