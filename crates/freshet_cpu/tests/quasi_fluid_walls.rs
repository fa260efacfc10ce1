//! Walls of quasi-fluid: against sums over all pairs in double precision, and what has to come of them.

mod common;

use common::solver;
use freshet_core::prelude::*;
use glam::DVec3;

const D: f32 = 0.05;

/// A block of gas, which pushes everywhere, in an open box on a plate, one corner of which is the origin.
fn tank(walls: QuasiFluid, alpha: f32, mu: f32) -> FluidScene {
    let size = Vec3::new(8.0, 6.0, 7.0) * D;
    let mut scene = FluidScene {
        gravity: Vec3::ZERO,
        volumes: vec![Volume::block(size / 2.0, size / 2.0)],
        boundaries: vec![Boundary::open_box(size + 4.0 * D * Vec3::Y, size / 2.0 + 2.0 * D * Vec3::Y)],
        ..FluidScene::with_spacing(D)
    };
    let settings = &mut scene.settings;
    settings.wall_method = WallMethod::QuasiFluid(walls);
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

/// Accelerations by id, without moving anything.
fn accelerations(scene: &FluidScene, state: &Snapshot) -> Vec<DVec3> {
    let mut solver = solver(scene, 2);
    solver.restore(state).unwrap();
    solver.step(&StepInput::default()).unwrap();
    let ids = solver.read(Field::Id).unwrap().integers().unwrap();
    let found = solver.read(Field::Acceleration).unwrap().sorted_by_id(&ids).vectors().unwrap();
    found.into_iter().map(|a| a.as_dvec3()).collect()
}

#[test]
fn walls_push_and_drag_as_their_formulas_say() {
    for (walls, alpha, mu) in [
        (QuasiFluid::Adapted, 0.0, 0.0),
        (QuasiFluid::PLAIN, 0.0, 0.0),
        (QuasiFluid::PLAIN, 0.3, 0.0),
        (QuasiFluid::PLAIN, 0.0, 20.0),
    ] {
        let scene = tank(walls, alpha, mu);
        let mut start = solver(&scene, 2);
        let plan = start.plan().clone();
        let mut state = start.snapshot().unwrap();
        let mut random = 7u32;
        let mut next = || {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (random >> 8) as f32 / 16_777_216.0 - 0.5
        };
        for (position, velocity) in state.positions.iter_mut().zip(&mut state.velocities) {
            *position += 0.4 * D * Vec3::new(next(), next(), next());
            *velocity = Vec3::new(next(), next(), next());
        }
        let found = accelerations(&scene, &state);

        let p = &plan.parameters;
        let kernel = p.kernel().unwrap();
        let (mass, rest, s) =
            (f64::from(p.particle_mass), f64::from(p.rest_density), f64::from(walls.relative_density()));
        let (values, slopes) = (f64::from(p.density_calibration), f64::from(p.gradient_calibration));
        let x: Vec<DVec3> = state.positions.iter().map(|x| x.as_dvec3()).collect();
        let v: Vec<DVec3> = state.velocities.iter().map(|v| v.as_dvec3()).collect();
        let samples = &plan.boundary.positions;
        let samples: Vec<(DVec3, f64)> =
            samples.iter().zip(&plan.boundary.volumes).map(|(x, &volume)| (x.as_dvec3(), f64::from(volume))).collect();
        let fluid = |at: DVec3| mass * x.iter().map(|other| kernel.value(at.distance(*other))).sum::<f64>() / values;
        let walls_at = |at: DVec3| {
            rest * samples.iter().map(|(other, volume)| volume * kernel.value(at.distance(*other))).sum::<f64>()
                / values
        };
        let densities: Vec<f64> = x.iter().map(|&at| fluid(at) + walls_at(at)).collect();
        let terms: Vec<f64> = densities.iter().map(|rho| p.pressure_law.pressure(rest, *rho) / (rho * rho)).collect();
        let sample_terms: Vec<f64> = (samples.iter())
            .map(|&(at, _)| {
                let density = fluid(at) + walls_at(at);
                p.pressure_law.pressure(rest, density / s) / (density * density)
            })
            .collect();
        let h = f64::from(p.smoothing_length);
        let softened = |r: DVec3| r.length_squared() + 0.01 * h * h;
        let drag = f64::from(p.artificial_viscosity) * f64::from(p.sound_speed) * h;
        let mu_pair = 2.0 * mu_of(p) * slopes / f64::from(p.viscous_calibration);
        let mut worst: f64 = 0.0;
        for a in 0..x.len() {
            let (mut expected, mut size) = (DVec3::ZERO, 1e-3);
            let mut add = |part: DVec3| {
                expected += part;
                size += part.length();
            };
            for b in (0..x.len()).filter(|&b| b != a) {
                let (r, u) = (x[a] - x[b], v[a] - v[b]);
                let slope = mass / slopes * kernel.derivative_over_r(r.length());
                let pi = -2.0 * drag * u.dot(r) / (softened(r) * (densities[a] + densities[b]));
                add(-slope * (terms[a] + terms[b] + pi) * r);
                add(slope * mu_pair * r.length_squared() / (softened(r) * densities[a] * densities[b]) * u);
            }
            let (mut strength, mut away) = (0.0, DVec3::ZERO);
            for (k, &(at, volume)) in samples.iter().enumerate() {
                let r = x[a] - at;
                let slope = rest * volume / slopes * kernel.derivative_over_r(r.length());
                let viscous = plan.boundary.viscous[k];
                let pi = if viscous && mu == 0.0 { -drag * v[a].dot(r) / (softened(r) * densities[a]) } else { 0.0 };
                add(-slope * (terms[a] + sample_terms[k] + pi) * r);
                if viscous {
                    strength -= slope;
                    away -= slope * r;
                }
            }
            if strength > 0.0 {
                let y = (away.length() / strength - 0.5 * f64::from(D)).max(0.25 * f64::from(D));
                add(-2.0 * mu_of(p) / s / densities[a].powi(2) * away.length() / y * v[a]);
            }
            worst = worst.max(found[a].distance(expected) / (1e-5 * size));
        }
        assert!(worst < 1.0, "{walls:?}, alpha {alpha}, mu {mu}: {worst}");
    }
}

fn mu_of(parameters: &freshet_core::plan::Parameters) -> f64 {
    f64::from(parameters.dynamic_viscosity)
}

/// Fluid on the lattice that samples go on with has the density at rest up to the walls, in edges and corners too.
#[test]
fn a_tank_on_the_lattice_is_as_dense_at_its_walls_as_inside() {
    let size = Vec3::new(8.0, 8.0, 8.0) * D;
    let mut scene = FluidScene {
        gravity: Vec3::ZERO,
        volumes: vec![Volume::block(size / 2.0, Vec3::ZERO)],
        boundaries: vec![Boundary::closed_box(size, Vec3::ZERO)],
        ..FluidScene::with_spacing(D)
    };
    scene.settings.wall_method = WallMethod::QuasiFluid(QuasiFluid::Adapted);
    let mut solver = solver(&scene, 2);
    solver.step(&StepInput::default()).unwrap();
    let densities = solver.read(Field::Density).unwrap().scalars().unwrap();
    let worst = densities.iter().map(|density| (density / 1000.0 - 1.0).abs()).fold(0.0, f32::max);
    assert!(worst < 0.02, "{worst}");
}

/// The source's figure 3.9: water stands off a plain wall that is denser than it is, and none off an adapted one.
#[test]
fn water_comes_near_adapted_walls_and_stands_off_plain_ones() {
    let gaps = [QuasiFluid::Adapted, QuasiFluid::PLAIN].map(|walls| {
        let base = 8.0 * D;
        let mut scene = FluidScene {
            volumes: vec![Volume::block(Vec3::new(base, base, base) / 2.0, Vec3::Y * base / 2.0)],
            boundaries: vec![Boundary::open_box(Vec3::new(base, 1.5 * base, base), Vec3::Y * 0.75 * base)],
            ..FluidScene::with_spacing(D)
        };
        scene.settings.wall_method = WallMethod::QuasiFluid(walls);
        scene.settings.relaxation = Some(Relaxation { under_gravity: true, ..Relaxation::default() });
        let mut solver = solver(&scene, 2);
        for tick in 0..30 {
            let report = solver.step(&StepInput { tick, duration: 1.0 / 60.0, ..StepInput::default() }).unwrap();
            assert_eq!(report.particles, 512);
        }
        let mut heights: Vec<f32> = solver.snapshot().unwrap().positions.iter().map(|x| x.y / D).collect();
        heights.sort_by(f32::total_cmp);
        heights[..64].iter().sum::<f32>() / 64.0
    });
    let [adapted, plain] = gaps;
    assert!((adapted - 0.5).abs() < 0.1 && plain > adapted + 0.1 && plain < 0.9, "{gaps:?} spacings");
}
