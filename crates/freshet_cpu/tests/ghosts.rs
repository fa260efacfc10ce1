//! Images of the fluid in plane walls: against sums over all images in double precision, and what has to come of them.

mod common;

use common::solver;
use freshet_core::prelude::*;
use glam::DVec3;

const D: f32 = 0.05;

/// The box's size, m.
fn size() -> Vec3 {
    Vec3::new(8.0, 6.0, 7.0) * D
}

/// A closed box full of gas, which pushes everywhere, one corner of which is the origin; three of its faces are viscous.
fn tank(alpha: f32, mu: f32) -> FluidScene {
    let walls = Boundary::closed_box(size(), size() / 2.0);
    let mut scene = FluidScene {
        gravity: Vec3::ZERO,
        volumes: vec![Volume::block(size() / 2.0, size() / 2.0)],
        boundaries: vec![walls.with_viscous_faces([true, false, true, false, true, false])],
        ..FluidScene::with_spacing(D)
    };
    let settings = &mut scene.settings;
    settings.wall_method = WallMethod::Ghosts;
    settings.artificial_viscosity = alpha;
    settings.expected_speed = Some(2.0);
    settings.equation_of_state = Some(EquationOfState::IdealGas { stiffness: 1.0 });
    settings.allow_compressible = true;
    if mu > 0.0 {
        settings.viscosity_model = Some(ViscosityModel::Morris1997);
        scene.material.dynamic_viscosity = mu;
    }
    scene
}

/// Place and velocity of what is behind the faces of the tank that are next to the corners: mirrored along each axis at one face or none.
fn images(x: DVec3, v: DVec3) -> Vec<(DVec3, DVec3)> {
    let size = size().as_dvec3();
    let mut all = vec![(x, v)];
    for axis in 0..3 {
        for (x, v) in all.clone() {
            // The lower faces are viscous.
            let (mut low, mut high, mut slips) = (x, x, v);
            low[axis] = -x[axis];
            high[axis] = 2.0 * size[axis] - x[axis];
            slips[axis] = -v[axis];
            all.extend([(low, -v), (high, slips)]);
        }
    }
    all
}

#[test]
fn images_press_and_drag_as_particles_do() {
    for (alpha, mu) in [(0.0, 0.0), (0.3, 0.0), (0.0, 20.0)] {
        let mut solver = solver(&tank(alpha, mu), 2);
        let plan = solver.plan().clone();
        let mut state = solver.snapshot().unwrap();
        let mut random = 7u32;
        let mut next = || {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (random >> 8) as f32 / 16_777_216.0 - 0.5
        };
        for (position, velocity) in state.positions.iter_mut().zip(&mut state.velocities) {
            *position += 0.4 * D * Vec3::new(next(), next(), next());
            *velocity = Vec3::new(next(), next(), next());
        }
        solver.restore(&state).unwrap();
        let report = solver.step(&StepInput::default()).unwrap();
        let ids = solver.read(Field::Id).unwrap().integers().unwrap();
        let mut by_id = |field| solver.read(field).unwrap().sorted_by_id(&ids);
        let found = by_id(Field::Acceleration).vectors().unwrap();
        let found_density = by_id(Field::Density).scalars().unwrap();

        let p = &plan.parameters;
        let kernel = p.kernel().unwrap();
        let (mass, rest) = (f64::from(p.particle_mass), f64::from(p.rest_density));
        let (values, slopes) = (f64::from(p.density_calibration), f64::from(p.gradient_calibration));
        let of_all = state.positions.iter().zip(&state.velocities);
        let all: Vec<Vec<(DVec3, DVec3)>> = of_all.map(|(x, v)| images(x.as_dvec3(), v.as_dvec3())).collect();
        let density = |at: DVec3| {
            let near = all.iter().flatten().map(|(x, _)| kernel.value(at.distance(*x)));
            mass / values * near.sum::<f64>()
        };
        let densities: Vec<f64> = all.iter().map(|images| density(images[0].0)).collect();
        let terms: Vec<f64> = densities.iter().map(|rho| p.pressure_law.pressure(rest, *rho) / (rho * rho)).collect();
        let h = f64::from(p.smoothing_length);
        let drag = f64::from(p.artificial_viscosity) * f64::from(p.sound_speed) * h;
        let exchange = 2.0 * f64::from(p.dynamic_viscosity) * slopes / f64::from(p.viscous_calibration);
        let mut worst: f64 = 0.0;
        for (a, own) in all.iter().enumerate() {
            assert!((f64::from(found_density[a]) / densities[a] - 1.0).abs() < 2e-6, "density of {a}");
            let (mut expected, mut size) = (DVec3::ZERO, 1e-3);
            for (b, images) in all.iter().enumerate() {
                for (index, &(x, v)) in images.iter().enumerate().filter(|&(index, _)| a != b || index > 0) {
                    let (r, u) = (own[0].0 - x, own[0].1 - v);
                    let softened = r.length_squared() + 0.01 * h * h;
                    let slope = mass / slopes * kernel.derivative_over_r(r.length());
                    let pi = -2.0 * drag * u.dot(r) / (softened * (densities[a] + densities[b]));
                    let by_mu = exchange * r.length_squared() / (softened * densities[a] * densities[b]);
                    let part = slope * (by_mu * u - (terms[a] + terms[b] + pi) * r);
                    expected += part;
                    size += part.length();
                    assert!(index == 0 || r.length() > 0.0);
                }
            }
            worst = worst.max(found[a].as_dvec3().distance(expected) / (1e-5 * size));
        }
        assert!(worst < 1.0, "alpha {alpha}, mu {mu}: {worst}");
        let most = densities.iter().fold(0.0f64, |most, &density| most.max(density));
        assert!((f64::from(report.max_compression) - (most / rest - 1.0)).abs() < 1e-4, "{}", report.max_compression);
    }
}

/// Spray, which has no pressure of its own, and a block in a corner, fast: nothing leaves a closed box.
#[test]
fn nothing_leaves_a_closed_box() {
    let scene_with = |half: Vec3, center: Vec3, velocity: Vec3| {
        let mut scene = FluidScene {
            volumes: vec![Volume { velocity, hydrostatic: false, ..Volume::block(half, center) }],
            boundaries: vec![Boundary::closed_box(size(), size() / 2.0)],
            ..FluidScene::with_spacing(D)
        };
        scene.settings.wall_method = WallMethod::Ghosts;
        scene
    };
    for (half, center, velocity) in [
        (Vec3::splat(0.5 * D), size() / 2.0, Vec3::new(3.0, -4.0, 2.0)),
        (2.0 * Vec3::splat(D), Vec3::splat(2.5 * D), 4.0 * Vec3::NEG_ONE),
    ] {
        let mut solver = solver(&scene_with(half, center, velocity), 2);
        let count = solver.snapshot().unwrap().ids.len();
        for tick in 0..60 {
            let report = solver.step(&StepInput { tick, duration: 0.01, ..StepInput::default() }).unwrap();
            assert_eq!((report.particles as usize, report.removed), (count, 0));
            for x in solver.snapshot().unwrap().positions {
                assert!(x.cmpgt(Vec3::ZERO).all() && x.cmplt(size()).all(), "tick {tick}: {x} of {}", size());
            }
        }
    }
}

#[test]
fn water_on_images_stands_half_a_spacing_off_and_comes_to_rest() {
    let base = 8.0 * D;
    let mut scene = FluidScene {
        volumes: vec![Volume::block(Vec3::splat(base) / 2.0, Vec3::Y * base / 2.0)],
        boundaries: vec![Boundary::open_box(Vec3::new(base, 1.5 * base, base), Vec3::Y * 0.75 * base)],
        ..FluidScene::with_spacing(D)
    };
    scene.settings.wall_method = WallMethod::Ghosts;
    let mut solver = solver(&scene, 2);
    for tick in 0..90 {
        solver.step(&StepInput { tick, duration: 1.0 / 60.0, ..StepInput::default() }).unwrap();
    }
    let state = solver.snapshot().unwrap();
    let mut heights: Vec<f32> = state.positions.iter().map(|x| x.y / D).collect();
    heights.sort_by(f32::total_cmp);
    let gap = heights[..64].iter().sum::<f32>() / 64.0;
    let speed = state.velocities.iter().map(|v| v.length()).sum::<f32>() / 512.0;
    assert!((gap - 0.5).abs() < 0.1 && speed < 0.05, "{gap} spacings, {speed} m/s");
}
