//! Density, pressure and acceleration of the shipped shaders against the reference, for every kernel and equation of
//! state; and proof that this would notice a wrong constant.

use freshet_core::periodic::Periodic;
use freshet_core::prelude::*;
use freshet_core::viscosity::ViscosityModel;
use freshet_gpu::{GpuOptions, GpuSolver, NeighbourMemory};

use crate::common::{INSTANT, dam_break, place, random_vector, solver, solver_with, tick};
use crate::reference::{expected, walls};

/// Particles as they are in a moving fluid, at walls and away from them, on both sides of cell boundaries and of zero,
/// where the grid wraps; pairs at 0.9999, 1 and 1.0001 of the support radius; and a group a whole grid away, which shares
/// its cells with the first.
fn moving_fluid(plan: &Plan) -> (Vec<Vec3>, Vec<Vec3>) {
    let d = plan.parameters.spacing;
    let radius = plan.parameters.support_radius;
    let mut positions = Vec::new();
    for i in 0..6 {
        for j in 0..5 {
            for k in 0..5 {
                let jitter = 0.3 * d * random_vector(positions.len(), 1);
                positions.push(Vec3::new(i as f32 - 1.5, j as f32 + 0.5, k as f32 - 1.5) * d + jitter);
            }
        }
    }
    let period = plan.grid.dimensions().as_vec3() * plan.grid.cell_size;
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        let group: Vec<Vec3> = positions[..20].iter().map(|&x| x + axis * period).collect();
        positions.extend(group);
    }
    let lonely = Vec3::new(0.7, 1.3, 0.2);
    for (index, ratio) in [0.9999, 1.0, 1.0001].into_iter().enumerate() {
        let base = lonely + Vec3::Y * 4.0 * radius * index as f32;
        positions.push(base);
        positions.push(base + Vec3::X * ratio * radius);
        positions.push(base + Vec3::new(0.6, 0.0, 0.8) * ratio * radius);
    }
    let velocities = (0..positions.len()).map(|index| 2.0 * random_vector(index, 2)).collect();
    (positions, velocities)
}

/// The plan's own particles, each off its place, some beyond the ends of periods.
fn stirred(plan: &Plan) -> (Vec<Vec3>, Vec<Vec3>) {
    let jitter = |index: usize| 0.5 * plan.parameters.spacing * random_vector(index, 1);
    let positions = plan.positions.iter().enumerate().map(|(index, &x)| x + jitter(index)).collect();
    (positions, (0..plan.positions.len()).map(|index| 2.0 * random_vector(index, 2)).collect())
}

/// A channel along x between two plates, that repeats itself along x and z: 4 and 5.5 support radii.
fn channel() -> FluidScene {
    let d = 0.05;
    let half = Vec3::new(4.0, 5.0, 5.5) * d;
    let plate = Boundary::new(BoundaryShape::Plane { half_extents: [half.x, half.z] }, Vec3::ZERO);
    let upside_down = Quat::from_rotation_x(std::f32::consts::PI);
    let lid = Boundary { center: Vec3::Y * 2.0 * half.y, rotation: upside_down, ..plate.clone() };
    let mut scene = FluidScene {
        gravity: Vec3::X,
        volumes: vec![Volume::block(half, Vec3::Y * half.y)],
        boundaries: vec![plate, lid.with_velocity(Vec3::new(0.7, 0.0, 0.3))],
        periodic: Periodic { x: Some((-half.x, half.x)), y: None, z: Some((-half.z, half.z)) },
        ..FluidScene::with_spacing(d)
    };
    scene.material.dynamic_viscosity = 50.0;
    scene.settings.viscosity_model = Some(ViscosityModel::Morris1997);
    scene.settings.expected_speed = Some(1.0);
    scene
}

#[test]
fn a_channel_that_repeats_itself_with_a_viscous_fluid_gives_the_forces_of_the_reference() {
    for artificial_viscosity in [0.0, 0.03] {
        let settings = Settings { artificial_viscosity, ..channel().settings };
        check(&FluidScene { settings, ..channel() });
    }
    for (patch, index) in [
        (("sample.viscous_weight * slope", "sample.viscous_weight * slope * 1.01"), 2),
        (("- (exchange * slope) * velocity", "- (1.002 * exchange * slope) * velocity"), 2),
        (("gap /= fields::parameters.cells_per_radius.yz", "gap *= 2.0"), 0),
        (("round(x * fields::parameters.inverse_period)", "round(0.6 * x * fields::parameters.inverse_period)"), 0),
    ] {
        let mut solver = solver_with(&channel(), GpuOptions { patch: Some(patch), ..Default::default() });
        let found = errors(&mut solver)[index];
        assert!(found > TOLERANCES[index], "{patch:?} makes an error of {found:e} only");
    }
}

#[test]
fn what_leaves_a_period_comes_back_at_its_other_end() {
    let mut solver = solver(&channel());
    let (positions, _) = stirred(solver.plan());
    let ids: Vec<u32> = (0..positions.len() as u32).collect();
    place(&mut solver, &ids, &positions, &vec![Vec3::new(5.0, 0.0, -3.0); ids.len()]);
    for number in 0..10 {
        let report = solver.step(&tick(number, 1.0 / 60.0)).unwrap();
        assert_eq!((report.removed, report.particles), (0, ids.len() as u32), "{report:?}");
    }
    let periodic = solver.plan().grid.periodic;
    let found = solver.read(Field::Position).unwrap().vectors().unwrap();
    assert!(found.iter().all(|&x| periodic.wrap(x) == x));
}

/// The largest errors of density (relative to itself), pressure (relative to itself and to what twice the density would
/// add at its slope) and acceleration (relative to the sum of its terms' sizes).
fn errors(solver: &mut GpuSolver) -> [f64; 3] {
    let plan = solver.plan().clone();
    let (positions, velocities) = if plan.grid.periodic.any() { stirred(&plan) } else { moving_fluid(&plan) };
    let ids: Vec<u32> = (0..positions.len() as u32).collect();
    place(solver, &ids, &positions, &velocities);
    let report = solver.step(&tick(0, INSTANT)).unwrap();
    assert_eq!((report.particles, report.substeps), (ids.len() as u32, 1));

    let order = solver.read(Field::Id).unwrap().integers().unwrap();
    let mut by_id = |field| solver.read(field).unwrap().sorted_by_id(&order);
    let density = by_id(Field::Density).scalars().unwrap();
    let pressure = by_id(Field::Pressure).scalars().unwrap();
    let acceleration = by_id(Field::Acceleration).vectors().unwrap();
    let p = &plan.parameters;
    let rest = f64::from(p.rest_density);
    let law = |density: f64| p.pressure_law.equation.pressure(rest, density);
    let mut worst = [0.0f64; 3];
    for (a, wanted) in expected(&plan, &positions, &velocities, &walls(&plan)).iter().enumerate() {
        let slope = (law(1.0001 * wanted.density) - law(wanted.density)) / 1e-4;
        let found = [
            (f64::from(density[a]) - wanted.density).abs() / wanted.density,
            (f64::from(pressure[a]) - wanted.pressure).abs() / (slope + wanted.pressure.abs()),
            (acceleration[a].as_dvec3() - wanted.acceleration).length() / wanted.magnitude,
        ];
        for (worst, found) in worst.iter_mut().zip(found) {
            assert!(found.is_finite(), "particle {a}: {wanted:?}");
            *worst = worst.max(found);
        }
    }
    worst
}

/// Sums of some forty terms in single precision are good to 1e-5, and so is a pressure as good as its density; a stiff
/// law makes a hundred times that of it where the pressure is small against the stiffness, and so do forces.
const TOLERANCES: [f64; 3] = [1e-5, 1e-5, 3e-4];

/// The same for the Gaussian: llvmpipe's exp() is good to 1e-5, and so are many GPUs'.
const GAUSSIAN_TOLERANCES: [f64; 3] = [3e-5, 3e-5, 1e-2];

/// With textures, as software drivers have it, and with buffers, as hardware does.
fn check(scene: &FluidScene) {
    let gaussian = scene.settings.kernel == KernelKind::Gaussian;
    let tolerances = if gaussian { GAUSSIAN_TOLERANCES } else { TOLERANCES };
    for neighbours in [NeighbourMemory::Textures, NeighbourMemory::Buffers] {
        let found = errors(&mut solver_with(scene, GpuOptions { neighbours, ..Default::default() }));
        for ((found, tolerance), what) in found.into_iter().zip(tolerances).zip(["density", "pressure", "acceleration"])
        {
            let settings = &scene.settings;
            assert!(
                found < tolerance,
                "{neighbours:?}, {settings:?}: {what} is off by {found:e}, allowed {tolerance:e}"
            );
        }
    }
}

#[test]
fn every_kernel_gives_the_forces_of_the_reference() {
    for kernel in KernelKind::WITH_GRADIENT {
        let settings = Settings { kernel, ..Default::default() };
        check(&FluidScene { settings, ..dam_break(0.05) });
    }
}

/// As Mueller et al. 2003 have them, and others.
#[test]
fn kernels_of_terms_give_the_forces_of_the_reference() {
    use KernelKind::{Poly6, QuinticSpline, Spiky, Viscosity, WendlandC2};
    for (kernel, pressure, viscosity, alpha) in [
        (Poly6, Some(Spiky), Some(Viscosity), 0.0),
        (WendlandC2, None, Some(Viscosity), 0.03),
        (QuinticSpline, Some(WendlandC2), Some(QuinticSpline), 0.03),
    ] {
        for mut scene in [dam_break(0.05), channel()] {
            scene.settings.kernel = kernel;
            scene.settings.pressure_kernel = pressure;
            scene.settings.viscosity_kernel = viscosity.filter(|_| scene.settings.viscosity_model.is_some());
            scene.settings.artificial_viscosity = alpha;
            scene.settings.near_pressure = 0.2 * alpha;
            scene.settings.tensile_correction = alpha;
            check(&scene);
        }
    }
    let mut scene = channel();
    scene.settings.viscosity_kernel = Some(Viscosity);
    let patch = ("return -3.0 * max(1.0 - q, 0.0);", "return -3.01 * max(1.0 - q, 0.0);");
    let mut solver = solver_with(&scene, GpuOptions { patch: Some(patch), ..Default::default() });
    let found = errors(&mut solver)[2];
    assert!(found > TOLERANCES[2], "{patch:?} makes an error of {found:e} only");
}

#[test]
fn every_equation_of_state_gives_the_forces_of_the_reference() {
    for (equation, clamp_negative_pressure) in [
        (EquationOfState::IdealGas { stiffness: 900.0 }, false),
        (EquationOfState::Desbrun { stiffness: 900.0 }, true),
        (EquationOfState::Harada { reference_pressure: 2000.0, stiffness: 900.0 }, false),
        (EquationOfState::Tait { sound_speed: 30.0, exponent: 7.0 }, false),
        (EquationOfState::Tait { sound_speed: 30.0, exponent: 3.5 }, true),
        (EquationOfState::Linear { sound_speed: 30.0 }, false),
    ] {
        let settings = Settings {
            equation_of_state: Some(equation),
            clamp_negative_pressure,
            allow_compressible: true,
            ..Default::default()
        };
        check(&FluidScene { settings, ..dam_break(0.05) });
    }
}

#[test]
fn wider_supports_and_fluids_without_walls_or_viscosity_do_too() {
    // H = 3.2 d: rows hold more particles than a word of hits has bits.
    let wide = Settings { support: Support::Ratio(3.2), ..Default::default() };
    check(&FluidScene { settings: wide, ..dam_break(0.05) });
    let plain = Settings { artificial_viscosity: 0.0, ..Default::default() };
    check(&FluidScene { settings: plain.clone(), ..dam_break(0.05) });
    check(&FluidScene { settings: plain, boundaries: Vec::new(), ..dam_break(0.05) });
}

/// A fluid that is thin here and dense there; with walls, with what pairs have beside pressures, across the end of a period.
#[test]
fn supports_of_different_widths_give_the_forces_of_the_reference() {
    let wide = |mut scene: FluidScene, widest: f32| {
        scene.settings.widest_support = widest;
        scene
    };
    let mut plain = dam_break(0.05);
    plain.boundaries.clear();
    plain.settings.artificial_viscosity = 0.0;
    plain.settings.kernel = KernelKind::CubicSpline;
    let mut viscous = channel();
    let long = |ends: (f32, f32)| (1.3 * ends.0, 1.3 * ends.1);
    viscous.periodic = Periodic { x: viscous.periodic.x.map(long), y: None, z: viscous.periodic.z.map(long) };
    viscous.settings.near_pressure = 0.02;
    for scene in [wide(dam_break(0.05), 1.6), wide(plain, 2.0), wide(viscous, 1.3)] {
        check(&scene);
    }
    for (patch, index) in [
        (("let square = inverse_width * inverse_width;", "let square = 1.01 * inverse_width * inverse_width;"), 2),
        (("fluid / (width * width * width) + samples", "1.02 * fluid / (width * width * width) + samples"), 0),
        (("0.5 * (width + fields::parameters.widest_support)", "0.8 * width"), 2),
    ] {
        let scene = wide(dam_break(0.05), 1.6);
        let mut solver = solver_with(&scene, GpuOptions { patch: Some(patch), ..Default::default() });
        let found = errors(&mut solver)[index];
        assert!(found > TOLERANCES[index], "{patch:?} makes an error of {found:e} only");
    }
    let named = |solver: &GpuSolver| {
        let schedule = solver.schedule();
        [
            schedule.passes.iter().any(|pass| pass.name == "support"),
            schedule.buffers.iter().any(|buffer| buffer.name == "widths"),
            solver.shader("density").unwrap().contains("width"),
        ]
    };
    assert_eq!(named(&solver(&dam_break(0.05))), [false; 3]);
    assert_eq!(named(&solver(&wide(dam_break(0.05), 1.6))), [true; 3]);
}

#[test]
fn near_pressure_repels_as_in_the_reference() {
    let with = |mut scene: FluidScene| {
        scene.settings.near_pressure = 0.05;
        scene
    };
    let plain = Settings { artificial_viscosity: 0.0, kernel: KernelKind::CubicSpline, ..Default::default() };
    for scene in [with(dam_break(0.05)), with(channel()), with(FluidScene { settings: plain, ..dam_break(0.05) })] {
        check(&scene);
    }
    let patch = Some(("-4.0 * left", "-4.1 * left"));
    let found = errors(&mut solver_with(&with(dam_break(0.05)), GpuOptions { patch, ..Default::default() }))[2];
    assert!(found > TOLERANCES[2], "a wrong constant makes an error of {found:e} only");
    let has = |scene: &FluidScene| solver(scene).shader("acceleration").unwrap().contains("near_slope");
    assert!(has(&with(dam_break(0.05))) && !has(&dam_break(0.05)), "only a plan that has it has it in its shader");
}

#[test]
fn tension_is_corrected_as_in_the_reference() {
    let with = |mut scene: FluidScene| {
        scene.settings.tensile_correction = 0.2;
        scene.settings.clamp_negative_pressure = false;
        scene
    };
    let plain = Settings { artificial_viscosity: 0.0, kernel: KernelKind::CubicSpline, ..Default::default() };
    for scene in [with(dam_break(0.05)), with(channel()), with(FluidScene { settings: plain, ..dam_break(0.05) })] {
        check(&scene);
    }
    for patch in
        [("let pulls = -own", "let pulls = -1.1 * own"), ("0.01 * (own.pressure_term", "0.02 * (own.pressure_term")]
    {
        let options = GpuOptions { patch: Some(patch), ..Default::default() };
        let found = errors(&mut solver_with(&with(dam_break(0.05)), options))[2];
        assert!(found > TOLERANCES[2], "{patch:?} makes an error of {found:e} only");
    }
    let has = |scene: &FluidScene| solver(scene).shader("acceleration").unwrap().contains("fn tensile");
    assert!(has(&with(dam_break(0.05))) && !has(&dam_break(0.05)), "only a plan that has it has it in its shader");
}

#[test]
fn the_other_form_of_the_pressure_force_is_that_of_the_reference() {
    let with = |mut scene: FluidScene| {
        scene.settings.pressure_force = PressureForce::Mueller;
        scene
    };
    let plain = Settings { artificial_viscosity: 0.0, kernel: KernelKind::CubicSpline, ..Default::default() };
    for scene in [with(dam_break(0.05)), with(channel()), with(FluidScene { settings: plain, ..dam_break(0.05) })] {
        check(&scene);
    }
    let patch = Some(("* harder / (own.density", "* 1.1 * harder / (own.density"));
    let found = errors(&mut solver_with(&with(dam_break(0.05)), GpuOptions { patch, ..Default::default() }))[2];
    assert!(found > TOLERANCES[2], "a wrong constant makes an error of {found:e} only");
    let has = |scene: &FluidScene| solver(scene).shader("acceleration").unwrap().contains("harder");
    assert!(has(&with(dam_break(0.05))) && !has(&dam_break(0.05)), "only a plan that has it has it in its shader");
}

/// The largest error of what particles move with beside their velocity, over what rounding of their positions makes of it.
fn drift_error(solver: &mut GpuSolver) -> f64 {
    let plan = solver.plan().clone();
    let p = &plan.parameters;
    let (before, velocities) = if plan.grid.periodic.any() { stirred(&plan) } else { moving_fluid(&plan) };
    let before: Vec<Vec3> = before.into_iter().map(|x| plan.grid.periodic.wrap(x)).collect();
    let ids: Vec<u32> = (0..before.len() as u32).collect();
    place(solver, &ids, &before, &velocities);
    let dt = 2e-4;
    let report = solver.step(&tick(0, dt)).unwrap();
    assert_eq!((report.particles, report.substeps), (ids.len() as u32, 1), "{report:?}");
    let order = solver.read(Field::Id).unwrap().integers().unwrap();
    let mut by_id = |field| solver.read(field).unwrap().sorted_by_id(&order);
    let density = by_id(Field::Density).scalars().unwrap();
    let after = by_id(Field::Position).vectors().unwrap();
    let velocity = by_id(Field::Velocity).vectors().unwrap();
    let kernel = p.kernel().unwrap();
    let period = plan.grid.periodic.lengths().as_dvec3();
    let difference = |a: Vec3, b: Vec3| {
        let mut x = a.as_dvec3() - b.as_dvec3();
        for axis in (0..3).filter(|&axis| period[axis] > 0.0) {
            x[axis] -= period[axis] * (x[axis] / period[axis]).round();
        }
        x
    };
    let (mut worst, mut largest) = (0.0f64, 0.0f64);
    for a in 0..before.len() {
        // Monaghan 1989, eq. 2.6.
        let pair = |b: usize| {
            let mean = 0.5 * (f64::from(density[a]) + f64::from(density[b]));
            let weight = f64::from(p.particle_mass / p.density_calibration) / mean;
            weight * kernel.value(difference(before[a], before[b]).length()) * (velocity[b] - velocity[a]).as_dvec3()
        };
        let expected = f64::from(p.xsph) * (0..before.len()).map(pair).sum::<glam::DVec3>();
        let found = difference(after[a], before[a]) / f64::from(dt) - velocity[a].as_dvec3();
        let rounding = 1.2e-7 * f64::from(before[a].abs().max_element().max(1.0)) / f64::from(dt);
        worst = worst.max((found - expected).length() / rounding);
        largest = largest.max(expected.length());
    }
    assert!(largest > 0.5, "{largest}");
    worst
}

#[test]
fn xsph_moves_particles_as_in_the_reference() {
    // Soft, so that pairs as close as these take no short steps.
    let with = |mut scene: FluidScene| {
        scene.settings.xsph = 0.7;
        (scene.settings.sound_speed, scene.settings.allow_compressible) = (Some(0.3), true);
        scene
    };
    let wide = Settings { support: Support::Ratio(3.2), artificial_viscosity: 0.0, ..Default::default() };
    // Leapfrog moves particles with the velocities that they have after the substep, too.
    let leapfrog = Settings { integrator: Integrator::Leapfrog, ..Default::default() };
    let scenes = [
        with(dam_break(0.05)),
        with(channel()),
        with(FluidScene { settings: wide, ..dam_break(0.05) }),
        with(FluidScene { settings: leapfrog, ..dam_break(0.05) }),
    ];
    for (scene, neighbours) in
        scenes.iter().zip([NeighbourMemory::Textures, NeighbourMemory::Buffers].into_iter().cycle())
    {
        let found = drift_error(&mut solver_with(scene, GpuOptions { neighbours, ..Default::default() }));
        assert!(found < 2.0, "{:?}: {found} times what rounding makes", scene.settings);
    }
    let patch = Some(("/ (own.density + motion.w)", "/ (own.density + 1.02 * motion.w)"));
    let found = drift_error(&mut solver_with(&scenes[0], GpuOptions { patch, ..Default::default() }));
    assert!(found > 4.0, "a wrong constant makes an error of {found} roundings only");
    let has = |scene: &FluidScene| {
        let solver = solver(scene);
        let schedule = solver.schedule();
        let buffers = schedule.buffers.iter().any(|buffer| buffer.name == "drifts");
        assert_eq!(solver.shader("integrate").unwrap().contains("drift"), buffers);
        assert_eq!(schedule.passes.iter().any(|pass| pass.name == "xsph"), buffers);
        buffers
    };
    assert!(has(&scenes[0]) && !has(&dam_break(0.05)), "only a plan that asks for it has pass and buffer");
}

/// The largest error of what friction takes of accelerations, relative to them, and how many particles it does not touch, slows down
/// and holds.
fn friction_error(scene: &FluidScene, patch: Option<(&'static str, &'static str)>) -> (f64, [usize; 3]) {
    let plan = Plan::new(scene).unwrap();
    let (positions, mut velocities) = stirred(&plan);
    // Every other one is slow enough to be held.
    velocities.iter_mut().step_by(2).for_each(|v| *v *= 1e-3);
    let positions: Vec<Vec3> = positions.into_iter().map(|x| plan.grid.periodic.wrap(x)).collect();
    let ids: Vec<u32> = (0..positions.len() as u32).collect();
    let dt = 2e-4;
    let result = |solver: &mut GpuSolver| {
        place(solver, &ids, &positions, &velocities);
        assert_eq!(solver.step(&tick(0, dt)).unwrap().substeps, 1);
        let order = solver.read(Field::Id).unwrap().integers().unwrap();
        let mut by_id = |field| solver.read(field).unwrap().sorted_by_id(&order);
        (by_id(Field::Acceleration).vectors().unwrap(), by_id(Field::Density).scalars().unwrap())
    };
    let mut frictionless = scene.clone();
    frictionless.boundaries.iter_mut().for_each(|boundary| boundary.friction = Friction::default());
    let (before, density) = result(&mut solver(&frictionless));
    let (after, _) = result(&mut solver_with(scene, GpuOptions { patch, ..Default::default() }));
    let p = &plan.parameters;
    let (kernel, rest, dt) = (p.kernel().unwrap(), f64::from(p.rest_density), f64::from(dt));
    let period = plan.grid.periodic.lengths().as_dvec3();
    let (mut worst, mut kinds) = (0.0f64, [0; 3]);
    for a in 0..positions.len() {
        let rho = f64::from(density[a]);
        let term = p.pressure_law.pressure(rest, rho).max(0.0) / (rho * rho);
        let mut pushes = [glam::DVec3::ZERO; 2];
        for (k, &at) in plan.boundary.positions.iter().enumerate() {
            let mut x = positions[a].as_dvec3() - at.as_dvec3();
            for axis in (0..3).filter(|&axis| period[axis] > 0.0) {
                x[axis] -= period[axis] * (x[axis] / period[axis]).round();
            }
            let weight = rest * f64::from(plan.boundary.volumes[k] / p.gradient_calibration);
            let push = -weight * term * kernel.derivative_over_r(x.length()) * x;
            for (sum, coefficient) in pushes.iter_mut().zip(plan.boundary.frictions[k]) {
                *sum += f64::from(coefficient) * push;
            }
        }
        let [most, sliding] = pushes.map(glam::DVec3::length);
        let velocity = velocities[a].as_dvec3() + dt * before[a].as_dvec3();
        let along = velocity - pushes[0] * velocity.dot(pushes[0]) / (most * most).max(1e-30);
        let speed = along.length();
        let (kind, expected) = match most {
            0.0 => (0, glam::DVec3::ZERO),
            _ if speed > most * dt => (1, sliding * along / speed),
            _ => (2, along / dt),
        };
        kinds[kind] += 1;
        let found = (before[a] - after[a]).as_dvec3();
        let size = before[a].as_dvec3().length() + most + 1.0;
        worst = worst.max((found - expected).length() / size);
    }
    (worst, kinds)
}

#[test]
fn friction_takes_what_coulomb_says() {
    let rough = |mut scene: FluidScene| {
        scene.settings.sound_speed = Some(10.0);
        scene.settings.allow_compressible = true;
        scene.boundaries[0].friction = Friction { at_rest: 0.8, sliding: 0.3 };
        scene.boundaries.iter_mut().skip(1).for_each(|boundary| boundary.velocity = Vec3::ZERO);
        scene
    };
    for scene in [rough(dam_break(0.05)), rough(channel())] {
        let (error, kinds) = friction_error(&scene, None);
        assert!(error < 3e-4 && kinds.iter().all(|&count| count > 10), "{error:e}, {kinds:?}");
    }
    let scene = rough(dam_break(0.05));
    let (error, _) = friction_error(&scene, Some(("coefficients.y * part", "1.02 * coefficients.y * part")));
    assert!(error > 1e-3, "a wrong constant makes an error of {error:e} only");
    let names = |scene: &FluidScene| {
        let solver = solver(scene);
        let schedule = solver.schedule();
        let pass = schedule.passes.iter().any(|pass| pass.name == "friction");
        (pass, schedule.buffers.iter().any(|buffer| buffer.name == "wall_frictions"))
    };
    assert_eq!((names(&scene), names(&dam_break(0.05))), ((true, true), (false, false)));
}

#[test]
fn a_wrong_constant_would_be_noticed() {
    for (patch, index) in [
        (("-20.0 * p * p * p", "-20.4 * p * p * p"), 2),
        (("(4.0 * q + 1.0)", "(4.01 * q + 1.0)"), 0),
        (("ratio - 1.0)", "ratio - 1.001)"), 1),
        (("SQUARED_REACH: f32 = 1.001", "SQUARED_REACH: f32 = 0.8"), 0),
        (("inside.yz);", "inside.yz) * 1.2;"), 0),
    ] {
        let mut solver = solver_with(&dam_break(0.05), GpuOptions { patch: Some(patch), ..Default::default() });
        let found = errors(&mut solver)[index];
        assert!(found > TOLERANCES[index], "{patch:?} makes an error of {found:e} only");
    }
}

/// As in the CPU's `stability_aids`: a gas a seventh as dense as at rest, in which particles have lost each other, with a sound wave as long as the box.
#[test]
fn a_thin_gas_carries_sound_with_wider_supports_only() {
    let wave = |widest_support: f32| {
        let mut scene = FluidScene {
            gravity: Vec3::ZERO,
            periodic: Periodic { x: Some((0.0, 0.8)), y: Some((0.0, 0.4)), z: Some((0.0, 0.4)) },
            ..FluidScene::with_spacing(0.04 / 1.9)
        };
        scene.settings.equation_of_state = Some(EquationOfState::IdealGas { stiffness: 1.0 });
        scene.settings.expected_speed = Some(0.1);
        scene.settings.artificial_viscosity = 0.0;
        scene.settings.widest_support = widest_support;
        scene.settings.max_particles = Some(2000);
        let axis = |count: u16| (0..count).map(|i| (f32::from(i) + 0.5) * 0.04);
        let positions: Vec<Vec3> =
            axis(20).flat_map(|x| axis(10).flat_map(move |y| axis(10).map(move |z| Vec3::new(x, y, z)))).collect();
        let start: Vec<Vec3> =
            positions.iter().map(|x| Vec3::X * 0.02 * (std::f32::consts::TAU * x.x / 0.8).sin()).collect();
        let ids: Vec<u32> = (0..2000).collect();
        let mut solver = solver(&scene);
        place(&mut solver, &ids, &positions, &start);
        // Half a period, L/2c.
        for number in 0..4 {
            solver.step(&tick(number, 0.1)).unwrap();
        }
        let velocities = solver.snapshot().unwrap().velocities;
        let product = |a: &[Vec3]| a.iter().zip(&start).map(|(a, b)| f64::from(a.x * b.x)).sum::<f64>();
        product(&velocities) / product(&start)
    };
    let (without, with) = (wave(1.0), wave(2.0));
    assert!(without > -0.1 && with < -0.9, "{without} of it left without, {with} with");
}
