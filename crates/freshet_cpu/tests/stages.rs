//! The stages against sums over all pairs in double precision, with the kernels of `freshet_core`.

use freshet_core::kernel::Kernel;
use freshet_core::plan::{PlannedBoundary, StageKind};
use freshet_core::prelude::*;
use freshet_cpu::{CpuOptions, CpuSolver, InstructionSet};
use glam::DVec3;

/// A block that fills the floor of a closed box.
fn scene(kernel: KernelKind, alpha: f32) -> FluidScene {
    let mut scene = FluidScene {
        volumes: vec![Volume::block(Vec3::splat(0.3), Vec3::new(0.3, 0.3, 0.3))],
        boundaries: vec![
            Boundary::closed_box(Vec3::new(0.6, 0.8, 0.6), Vec3::new(0.3, 0.4, 0.3))
                .with_viscous_faces([false, true, true, false, false, true]),
        ],
        ..FluidScene::with_spacing(0.1)
    };
    scene.settings.kernel = kernel;
    scene.settings.artificial_viscosity = alpha;
    // Room for the pairs that are added.
    scene.settings.max_particles = Some(1000);
    scene
}

/// A channel between a wall at rest and one that moves along x, repeating itself along x and z, full of a fluid that sticks.
fn channel(kernel: KernelKind, alpha: f32) -> FluidScene {
    let (size, center) = (Vec3::new(0.8, 0.6, 0.9), Vec3::new(0.4, 0.3, 0.0));
    let open = [true, true, false, true, true, true];
    let floor = BoundaryShape::Container { half_extents: size / 2.0, open };
    let lid = BoundaryShape::Plane { half_extents: [0.4, 0.45] };
    let lid =
        Boundary { rotation: Quat::from_rotation_x(std::f32::consts::PI), ..Boundary::new(lid, center.with_y(0.6)) };
    let mut scene = FluidScene {
        gravity: Vec3::new(3.0, 0.0, 0.0),
        volumes: vec![Volume::block(size / 2.0, center)],
        boundaries: vec![Boundary::new(floor, center), lid.with_velocity(Vec3::new(0.5, 0.0, -0.25))],
        periodic: Periodic { x: Some((0.0, 0.8)), y: None, z: Some((-0.45, 0.45)) },
        ..FluidScene::with_spacing(0.1)
    };
    scene.material.dynamic_viscosity = 40.0;
    scene.settings.kernel = kernel;
    scene.settings.artificial_viscosity = alpha;
    scene.settings.viscosity_model = Some(ViscosityModel::Morris1997);
    scene.settings.expected_speed = Some(2.0);
    scene.settings.max_particles = Some(1000);
    scene
}

/// The block's particles off their lattice, and three pairs at 0.9999, 1 and 1.0001 of the support radius far away from
/// it, across the wrap of the grid.
fn jittered(plan: &Plan) -> Snapshot {
    let mut state = 7u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 16_777_216.0 - 0.5
    };
    let mut snapshot = Snapshot { gravity: plan.parameters.gravity, ..Snapshot::default() };
    for &position in &plan.positions {
        snapshot.positions.push(position + 0.04 * Vec3::new(random(), random(), random()));
        snapshot.velocities.push(2.0 * Vec3::new(random(), random(), random()));
    }
    for (index, factor) in [0.9999, 1.0, 1.0001].into_iter().enumerate() {
        // Powers of two, so that the distances are exact.
        let at = Vec3::new(0.0, 2.0 * index as f32 - 4.0, 5.0);
        snapshot.positions.extend([at, at - Vec3::X * (plan.parameters.support_radius * factor)]);
        snapshot.velocities.extend([Vec3::ZERO, Vec3::X]);
    }
    let count = snapshot.positions.len() as u32;
    snapshot.ids = (0..count).collect();
    snapshot.next_id = count;
    snapshot.remaining_lives = vec![f32::INFINITY; count as usize];
    snapshot
}

struct Reference {
    density: Vec<f64>,
    pressure: Vec<f64>,
    acceleration: Vec<DVec3>,
}

fn reference(plan: &Plan, state: &Snapshot) -> Reference {
    let p = &plan.parameters;
    let kernel = Kernel::new(p.kernel, p.support_radius).unwrap();
    let (mass, rest, h) = (f64::from(p.particle_mass), f64::from(p.rest_density), f64::from(p.smoothing_length));
    let x: Vec<DVec3> = state.positions.iter().map(|x| x.as_dvec3()).collect();
    let v: Vec<DVec3> = state.velocities.iter().map(|v| v.as_dvec3()).collect();
    let PlannedBoundary { positions, volumes, viscous, .. } = &plan.boundary;
    assert!(viscous.contains(&true));
    let near = |apart: DVec3| {
        let lengths = plan.grid.periodic.lengths().as_dvec3();
        DVec3::from([0, 1, 2].map(|axis| match lengths[axis] {
            0.0 => apart[axis],
            length => apart[axis] - length * (apart[axis] / length).round(),
        }))
    };
    let walls: Vec<(DVec3, f64, bool)> = positions
        .iter()
        .zip(volumes)
        .zip(viscous)
        .map(|((x, &v), &viscous)| (x.as_dvec3(), f64::from(v), viscous))
        .collect();
    let of_width = |width: f64| Kernel::new(p.kernel, (f64::from(p.support_radius) * width) as f32).unwrap();
    let of_pressure = Kernel::new(p.pressure_kernel, p.support_radius).unwrap();
    let density_with = |at: DVec3, kernel_of: &dyn Fn(usize) -> Kernel| {
        let fluid: f64 = x.iter().enumerate().map(|(b, other)| kernel_of(b).value(near(at - other).length())).sum();
        let wall: f64 = walls.iter().map(|(other, volume, _)| volume * kernel.value(near(at - other).length())).sum();
        (mass * fluid + rest * wall) / f64::from(p.density_calibration)
    };
    // From the formulas of freshet_core::variable_support.
    let widest = f64::from(p.widest_support);
    let width: Vec<f64> = x
        .iter()
        .map(|&at| {
            (0..4).fold(1.0, |width, _| (rest / density_with(at, &|_| of_width(width))).cbrt().clamp(1.0, widest))
        })
        .collect();
    let of_pair = |a: usize, b: usize| of_width(0.5 * (width[a] + width[b]));
    let density: Vec<f64> = (0..x.len()).map(|a| density_with(x[a], &|b| of_pair(a, b))).collect();
    let pressure: Vec<f64> = density.iter().map(|&rho| p.pressure_law.pressure(rest, rho)).collect();
    let term: Vec<f64> = pressure.iter().zip(&density).map(|(p, rho)| p / (rho * rho)).collect();
    let pi = |apart: DVec3, moving: DVec3, mean_density: f64| {
        let mu = h * moving.dot(apart) / (apart.length_squared() + 0.01 * h * h);
        -f64::from(p.artificial_viscosity) * f64::from(p.sound_speed) * mu / mean_density
    };
    let mu = f64::from(p.dynamic_viscosity);
    let of_viscosity = |r: f64| match p.viscosity_kernel {
        // Half of Mueller's Laplacian (2003, eq. 22).
        KernelKind::Viscosity => {
            let radius = f64::from(p.support_radius);
            -22.5 / (std::f64::consts::PI * radius.powi(6)) * (radius - r).max(0.0)
        }
        kind => Kernel::new(kind, p.support_radius).unwrap().derivative_over_r(r),
    };
    let calibration = match p.has_own_viscosity_kernel() {
        true => f64::from(p.viscous_calibration / p.viscous_share),
        false => f64::from(p.gradient_calibration),
    };
    let acceleration = (0..x.len())
        .map(|a| {
            let (mut sum, mut physical) = (DVec3::ZERO, DVec3::ZERO);
            // W = 105/(4 pi H^7) (H - r)^4 (Clavet et al. 2005, Pirovano 2011).
            let radius = f64::from(p.support_radius);
            let steep = |r: f64| -105.0 / (std::f64::consts::PI * radius.powi(7)) * (radius - r).max(0.0).powi(3) / r;
            for b in 0..x.len() {
                let (apart, moving) = (near(x[a] - x[b]), v[a] - v[b]);
                let viscous = pi(apart, moving, 0.5 * (density[a] + density[b]));
                let slope = match p.pressure_kernel == p.kernel {
                    true => of_pair(a, b).derivative_over_r(apart.length()),
                    false => of_pressure.derivative_over_r(apart.length()),
                };
                let push = match p.pressure_force {
                    PressureForce::Monaghan => term[a] + term[b],
                    PressureForce::Mueller => (pressure[a] + pressure[b]) / (density[a] * density[b]),
                };
                // Monaghan 2000.
                let both = term[a] > 0.0 && term[b] > 0.0;
                let tension = f64::from(p.tensile_correction) * (-term[a].min(0.0) - term[b].min(0.0));
                let repels = if both { 0.01 * (term[a] + term[b]) } else { tension };
                let ratio = of_pressure.value(apart.length()) / of_pressure.value(f64::from(p.spacing));
                let repels = if p.tensile_correction > 0.0 { repels * ratio.powi(4) } else { 0.0 };
                sum += mass * (push + viscous + repels) * slope * apart;
                if a != b {
                    sum += mass * 2.0 * f64::from(p.near_pressure) / rest * steep(apart.length()) * apart;
                }
                let weight = apart.length_squared() / (apart.length_squared() + 0.01 * h * h);
                let slope = if p.has_own_viscosity_kernel() { of_viscosity(apart.length()) } else { slope };
                let morris = mass * 2.0 * mu / (density[a] * density[b]) * slope * weight * moving;
                physical += if a == b { DVec3::ZERO } else { morris / f64::from(p.viscous_calibration) };
            }
            let (mut strength, mut slopes, mut wall_velocity) = (0.0, DVec3::ZERO, DVec3::ZERO);
            for (k, &(wall, volume, viscous)) in walls.iter().enumerate() {
                let apart = near(x[a] - wall);
                let slope = volume * of_pressure.derivative_over_r(apart.length());
                let drag = if viscous && mu == 0.0 { pi(apart, v[a], density[a]) } else { 0.0 };
                sum += rest * (term[a] + drag) * slope * apart;
                if viscous {
                    let slope = volume * of_viscosity(apart.length());
                    strength += slope;
                    slopes += slope * apart;
                    wall_velocity += slope * plan.boundary.velocities.get(k).map_or(DVec3::ZERO, |v| v.as_dvec3());
                }
            }
            if mu > 0.0 && strength < 0.0 {
                let distance = slopes.length() / -strength - f64::from(p.boundary_depth);
                let rate = mu * rest / density[a].powi(2) * slopes.length() / calibration;
                physical -= rate * (v[a] - wall_velocity / strength) / distance.max(0.25 * f64::from(p.spacing));
            }
            p.gravity.as_dvec3() + physical - sum / f64::from(p.gradient_calibration)
        })
        .collect();
    Reference { density, pressure, acceleration }
}

/// A tick of zero length evaluates the stages and moves nothing.
fn evaluate(plan: &Plan, state: &Snapshot, options: CpuOptions) -> CpuSolver {
    let mut solver = CpuSolver::new(plan.clone(), options).unwrap();
    solver.restore(state).unwrap();
    solver.step(&StepInput::default()).unwrap();
    solver
}

fn read(solver: &mut CpuSolver, field: Field) -> FieldData {
    let ids = solver.read(Field::Id).unwrap().integers().unwrap();
    solver.read(field).unwrap().sorted_by_id(&ids)
}

fn assert_agrees(plan: &Plan, instruction_set: InstructionSet) {
    let (kernel, state) = (plan.parameters.kernel, jittered(plan));
    let expected = reference(plan, &state);
    let mut solver = evaluate(plan, &state, CpuOptions { threads: Some(2), instruction_set, ..CpuOptions::default() });
    let density = read(&mut solver, Field::Density).scalars().unwrap();
    let pressure = read(&mut solver, Field::Pressure).scalars().unwrap();
    let acceleration = read(&mut solver, Field::Acceleration).vectors().unwrap();
    let stiffest = expected.pressure.iter().copied().fold(0.0, f64::max);
    let largest = expected.acceleration.iter().map(|a| a.length()).fold(0.0, f64::max);
    for i in 0..density.len() {
        // Single precision sums of some thirty terms: 1e-5 of the whole, and a little more where terms cancel.
        let error = (f64::from(density[i]) - expected.density[i]).abs();
        assert!(error < 1e-5 * 1000.0, "{kernel:?} density {i}: {} not {}", density[i], expected.density[i]);
        let error = (f64::from(pressure[i]) - expected.pressure[i]).abs();
        assert!(error < 1e-4 * stiffest, "{kernel:?} pressure {i}: {} not {}", pressure[i], expected.pressure[i]);
        let error = (acceleration[i].as_dvec3() - expected.acceleration[i]).length();
        assert!(error < 1e-4 * largest, "{kernel:?} {i}: {} not {}", acceleration[i], expected.acceleration[i]);
    }
}

#[test]
fn every_kernel_and_instruction_set_agrees_with_sums_over_all_pairs() {
    for kernel in KernelKind::WITH_GRADIENT {
        for (alpha, instruction_set) in [(0.05, InstructionSet::Widest), (0.0, InstructionSet::Scalar)] {
            let plan = Plan::new(&scene(kernel, alpha)).unwrap();
            assert!(plan.boundary.viscous.contains(&false));
            assert_agrees(&plan, instruction_set);
            assert_agrees(&Plan::new(&channel(kernel, alpha)).unwrap(), instruction_set);
        }
    }
}

#[test]
fn near_pressure_agrees_too() {
    for (alpha, instruction_set) in [(0.05, InstructionSet::Widest), (0.0, InstructionSet::Scalar)] {
        for mut scene in [scene(KernelKind::WendlandC2, alpha), channel(KernelKind::Spiky, alpha)] {
            scene.settings.near_pressure = 0.05;
            let plan = Plan::new(&scene).unwrap();
            assert!(plan.parameters.near_pressure > 0.0);
            assert_agrees(&plan, instruction_set);
        }
    }
}

/// With tensions and without, and with each viscosity.
#[test]
fn tensile_correction_agrees_too() {
    for (alpha, clamp, instruction_set) in [
        (0.05, false, InstructionSet::Widest),
        (0.0, false, InstructionSet::Scalar),
        (0.0, true, InstructionSet::Widest),
    ] {
        for mut scene in [scene(KernelKind::WendlandC2, alpha), channel(KernelKind::CubicSpline, alpha)] {
            scene.settings.tensile_correction = 0.2;
            scene.settings.clamp_negative_pressure = clamp;
            let plan = Plan::new(&scene).unwrap();
            assert_agrees(&plan, instruction_set);
            let mut without = plan.clone();
            without.parameters.tensile_correction = 0.0;
            let state = jittered(&plan);
            let [one, other] = [&plan, &without].map(|plan| reference(plan, &state).acceleration);
            let largest = one.iter().map(|a| a.length()).fold(0.0, f64::max);
            let apart = one.iter().zip(&other).map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max);
            assert!(apart > 1e-3 * largest, "{apart} of {largest}");
        }
    }
}

/// Mueller's form of the pressure force, with each viscosity and without any.
#[test]
fn the_other_form_of_the_pressure_force_agrees_too() {
    for (alpha, instruction_set) in [(0.05, InstructionSet::Widest), (0.0, InstructionSet::Scalar)] {
        for mut scene in [scene(KernelKind::WendlandC2, alpha), channel(KernelKind::CubicSpline, alpha)] {
            scene.settings.pressure_force = PressureForce::Mueller;
            let plan = Plan::new(&scene).unwrap();
            assert_agrees(&plan, instruction_set);
            // The forms are told apart by what the test allows.
            let mut monaghan = plan.clone();
            monaghan.parameters.pressure_force = PressureForce::Monaghan;
            let state = jittered(&plan);
            let [one, other] = [&plan, &monaghan].map(|plan| reference(plan, &state).acceleration);
            let largest = one.iter().map(|a| a.length()).fold(0.0, f64::max);
            let apart = one.iter().zip(&other).map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max);
            assert!(apart > 1e-3 * largest, "{apart} of {largest}");
        }
    }
}

/// As Mueller et al. 2003 have them, and others; without walls' drag, with it and with fluid that sticks.
#[test]
fn kernels_of_terms_agree_too() {
    use KernelKind::{Poly6, QuinticSpline, Spiky, Viscosity, WendlandC2};
    for (kernel, pressure, viscosity, alpha, instruction_set) in [
        (Poly6, Some(Spiky), Some(Viscosity), 0.0, InstructionSet::Widest),
        (Poly6, Some(Spiky), None, 0.05, InstructionSet::Scalar),
        (WendlandC2, None, Some(Viscosity), 0.05, InstructionSet::Scalar),
        (QuinticSpline, Some(WendlandC2), Some(QuinticSpline), 0.05, InstructionSet::Widest),
    ] {
        for mut scene in [scene(kernel, alpha), channel(kernel, alpha)] {
            scene.settings.pressure_kernel = pressure;
            // Enough to count beside the pressures of a stirred fluid.
            scene.material.dynamic_viscosity *= 1e4;
            scene.settings.viscosity_kernel = viscosity.filter(|_| scene.settings.viscosity_model.is_some());
            scene.settings.near_pressure = 0.2 * alpha;
            scene.settings.tensile_correction = alpha;
            let plan = Plan::new(&scene).unwrap();
            assert_agrees(&plan, instruction_set);
            // The kernels are told apart by what the test allows.
            let state = jittered(&plan);
            let mut without = plan.clone();
            without.parameters.viscosity_kernel = plan.parameters.pressure_kernel;
            let [one, other] = [&plan, &without].map(|plan| reference(plan, &state).acceleration);
            let largest = one.iter().map(|a| a.length()).fold(0.0, f64::max);
            let apart = one.iter().zip(&other).map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max);
            assert!(apart > 1e-3 * largest || !plan.parameters.has_own_viscosity_kernel(), "{apart} of {largest}");
        }
    }
}

/// In a fluid that is thin here and dense there.
#[test]
fn supports_of_different_widths_agree_too() {
    for (kernel, alpha, widest, instruction_set) in [
        (KernelKind::WendlandC2, 0.05, 1.7, InstructionSet::Widest),
        (KernelKind::CubicSpline, 0.0, 2.0, InstructionSet::Scalar),
        (KernelKind::QuinticSpline, 0.0, 1.25, InstructionSet::Widest),
    ] {
        for mut scene in [scene(kernel, alpha), channel(kernel, alpha)] {
            scene.settings.widest_support = widest;
            scene.settings.near_pressure = 0.05 * alpha;
            if let Some((low, high)) = &mut scene.periodic.x {
                // Long enough for cells of the widest support.
                (*low, *high) = (*low, *low + (*high - *low) * widest);
            }
            if let Some((low, high)) = &mut scene.periodic.z {
                (*low, *high) = (*low, *low + (*high - *low) * widest);
            }
            let plan = Plan::new(&scene).unwrap();
            assert!(plan.has(StageKind::Support) && plan.parameters.widest_support == widest);
            assert_agrees(&plan, instruction_set);
        }
    }
}

/// XSPH's sum over all pairs, with the velocities and densities that the solver left (Monaghan 1989, eq. 2.6).
#[test]
fn xsph_moves_particles_as_sums_over_all_pairs_say() {
    // Leapfrog moves particles with the velocities that they have after the substep, too.
    for (kernel, instruction_set, periodic, integrator) in [
        (KernelKind::WendlandC2, InstructionSet::Widest, false, Integrator::SemiImplicitEuler),
        (KernelKind::WendlandC2, InstructionSet::Widest, false, Integrator::Leapfrog),
        (KernelKind::CubicSpline, InstructionSet::Scalar, false, Integrator::SemiImplicitEuler),
        (KernelKind::Spiky, InstructionSet::Widest, true, Integrator::ModifiedVelocityVerlet),
    ] {
        let mut scene = if periodic { channel(kernel, 0.0) } else { scene(kernel, 0.05) };
        scene.settings.integrator = integrator;
        scene.settings.xsph = 0.7;
        let plan = Plan::new(&scene).unwrap();
        let state = jittered(&plan);
        let mut solver =
            CpuSolver::new(plan.clone(), CpuOptions { threads: Some(2), instruction_set, ..CpuOptions::default() })
                .unwrap();
        solver.restore(&state).unwrap();
        let dt = 2e-4;
        let report = solver.step(&StepInput { duration: dt, ..StepInput::default() }).unwrap();
        assert_eq!((report.substeps, report.particles), (1, state.ids.len() as u32), "{report:?}");
        let positions = read(&mut solver, Field::Position).vectors().unwrap();
        let velocities = read(&mut solver, Field::Velocity).vectors().unwrap();
        let density = read(&mut solver, Field::Density).scalars().unwrap();
        let p = &plan.parameters;
        let smoothing = p.kernel().unwrap();
        let lengths = plan.grid.periodic.lengths();
        let near = |apart: Vec3| {
            let turns = (apart / lengths.max(Vec3::splat(1e-9))).round();
            apart - Vec3::select(lengths.cmpgt(Vec3::ZERO), lengths * turns, Vec3::ZERO)
        };
        let (mut total, mut largest) = (DVec3::ZERO, 0.0f64);
        for a in 0..positions.len() {
            let mut expected = DVec3::ZERO;
            for b in 0..positions.len() {
                let apart = near(state.positions[a] - state.positions[b]).as_dvec3();
                let mean = 0.5 * (f64::from(density[a]) + f64::from(density[b]));
                let weight =
                    smoothing.value(apart.length()) * f64::from(p.particle_mass / p.density_calibration) / mean;
                expected += 0.7 * weight * (velocities[b] - velocities[a]).as_dvec3();
            }
            let moved = near(positions[a] - state.positions[a]).as_dvec3() / f64::from(dt);
            let found = moved - velocities[a].as_dvec3();
            // Positions of a metre are good to 6e-8 m, those of the pairs to 2.4e-7 m.
            let rounding = 1.2e-7 * f64::from(state.positions[a].abs().max_element().max(1.0)) / f64::from(dt);
            let error = (found - expected).length();
            assert!(error < 2.0 * rounding, "{kernel:?} {a}: {found} not {expected}, {error:e} off");
            total += expected;
            largest = largest.max(expected.length());
        }
        assert!(largest > 0.5 && total.length() < 1e-4 * largest, "the centre of mass goes on as before: {total}");
    }
}

/// What friction takes, from the state and the accelerations that the same scene without it has.
#[test]
fn friction_takes_what_coulomb_says() {
    for (kernel, instruction_set, dt) in
        [(KernelKind::WendlandC2, InstructionSet::Widest, 2e-4), (KernelKind::CubicSpline, InstructionSet::Scalar, 0.0)]
    {
        let mut scene = scene(kernel, 0.05);
        let plain = Plan::new(&scene).unwrap();
        let state = jittered(&plain);
        // Of two kinds, and one wall without.
        scene.boundaries[0].friction = Friction { at_rest: 0.8, sliding: 0.3 };
        let plane = |height: f32| Boundary::new(BoundaryShape::Plane { half_extents: [0.3, 0.3] }, Vec3::Y * height);
        let upside_down = Quat::from_rotation_x(std::f32::consts::PI);
        let lid = Boundary { rotation: upside_down, ..plane(0.66) }.with_friction(Friction::coulomb(1.5));
        scene.boundaries.extend([lid, plane(-0.02)]);
        let plan = Plan { positions: plain.positions.clone(), ..Plan::new(&scene).unwrap() };
        let without = Plan {
            stages: plan.stages.iter().filter(|stage| stage.kind != StageKind::Friction).cloned().collect(),
            ..plan.clone()
        };
        let result = |plan: &Plan| {
            let mut solver =
                CpuSolver::new(plan.clone(), CpuOptions { threads: Some(2), instruction_set, ..CpuOptions::default() })
                    .unwrap();
            solver.restore(&state).unwrap();
            let report = solver.step(&StepInput { duration: dt, ..StepInput::default() }).unwrap();
            assert_eq!(report.substeps, 1, "{report:?}");
            let accelerations = read(&mut solver, Field::Acceleration).vectors().unwrap();
            (accelerations, read(&mut solver, Field::Density).scalars().unwrap())
        };
        let ((before, density), (after, _)) = (result(&without), result(&plan));
        let p = &plan.parameters;
        let (smoothing, dt) = (p.kernel().unwrap(), f64::from(dt));
        let mut kinds = [0; 3];
        for a in 0..before.len() {
            let rho = f64::from(density[a]);
            let pressure = p.pressure_law.pressure(f64::from(p.rest_density), rho).max(0.0);
            let mut pushes = [DVec3::ZERO; 2];
            for (k, at) in plan.boundary.positions.iter().enumerate() {
                let apart = (state.positions[a] - *at).as_dvec3();
                let push = -f64::from(p.rest_density * plan.boundary.volumes[k]) / f64::from(p.gradient_calibration)
                    * pressure
                    / (rho * rho)
                    * smoothing.derivative_over_r(apart.length())
                    * apart;
                for (sum, coefficient) in pushes.iter_mut().zip(plan.boundary.frictions[k]) {
                    *sum += f64::from(coefficient) * push;
                }
            }
            let [most, sliding] = pushes.map(DVec3::length);
            let velocity = state.velocities[a].as_dvec3() + dt * before[a].as_dvec3();
            let along = velocity - pushes[0] * velocity.dot(pushes[0]) / (most * most).max(1e-30);
            let expected = match along.length() {
                _ if most == 0.0 => DVec3::ZERO,
                speed if speed > most * dt => sliding * along / speed,
                _ => along / dt,
            };
            kinds[if most == 0.0 {
                0
            } else if along.length() > most * dt {
                1
            } else {
                2
            }] += 1;
            let found = (before[a] - after[a]).as_dvec3();
            let size = before[a].as_dvec3().length() + expected.length() + velocity.length() * 1e-3 / dt.max(1e-3);
            assert!((found - expected).length() < 2e-4 * size, "{a}: {found} not {expected}");
        }
        assert!(kinds[0] > 10 && kinds[1] > 10 && (kinds[2] > 10 || dt == 0.0), "{kinds:?}");
    }
}

/// A period has no seam: wherever its ends are, the same fluid feels the same.
#[test]
fn where_a_period_begins_changes_nothing() {
    let accelerations = |from: f32| {
        let mut scene = channel(KernelKind::WendlandC2, 0.0);
        let plan = Plan::new(&scene).unwrap();
        let state = jittered(&plan);
        scene.periodic.x = Some((from, from + 0.8));
        scene.volumes[0].center.x += from;
        for boundary in &mut scene.boundaries {
            boundary.center.x += from;
        }
        let mut solver = evaluate(&Plan::new(&scene).unwrap(), &state, CpuOptions::default());
        read(&mut solver, Field::Acceleration).vectors().unwrap()
    };
    let (here, there) = (accelerations(0.0), accelerations(0.3));
    let largest = here.iter().map(|a| a.length()).fold(0.0, f32::max);
    for (i, (here, there)) in here.iter().zip(&there).enumerate() {
        assert!(here.distance(*there) < 1e-4 * largest, "{i}: {here} and {there}");
    }
}

#[test]
fn at_the_support_radius_there_is_no_neighbour_and_nearer_there_is() {
    let plan = Plan::new(&scene(KernelKind::Quadratic, 0.0)).unwrap();
    let mut state = jittered(&plan);
    let last = state.positions.len() - 1;
    // The quadratic kernel at 0.999 of the radius is 1e-6 of its peak: what single precision can show.
    state.positions[last - 4] = state.positions[last - 5] - Vec3::X * (plan.parameters.support_radius * 0.999);
    let mut solver = evaluate(&plan, &state, CpuOptions::default());
    let density = read(&mut solver, Field::Density).scalars().unwrap();
    let alone = density[last];
    assert_eq!(density[last - 1..], [alone, alone], "beyond the radius");
    assert_eq!(density[last - 3..last - 1], [alone, alone], "exactly at the radius");
    assert!(density[last - 4] > alone && density[last - 5] > alone, "within: {} and {alone}", density[last - 4]);
}

#[test]
fn samples_that_the_fluid_reaches_are_counted() {
    for pressure_solver in
        [PressureSolver::WeaklyCompressible, PressureSolver::DivergenceFree(DivergenceFree::default())]
    {
        // One dips into the fluid, one is above it, and one beyond its side, which repeats itself.
        let mut scene = channel(KernelKind::WendlandC2, 0.0);
        scene.boundaries.clear();
        scene.settings.viscosity_model = None;
        scene.material.dynamic_viscosity = 0.0;
        scene.settings.pressure_solver = pressure_solver;
        let layer = scene.wall_layer().unwrap();
        let body =
            Body::of_shape("ball", BoundaryShape::Sphere { radius: 0.2, fluid: FluidSide::Outside }, &layer).unwrap();
        let body = Body { solids: Vec::new(), ..body };
        scene.bodies = vec![body; 3];
        let places = [Vec3::new(0.4, 0.65, 0.0), Vec3::new(0.4, 1.4, 0.0), Vec3::new(0.05, 0.7, 0.4)];
        let mut solver = CpuSolver::new(Plan::new(&scene).unwrap(), CpuOptions::default()).unwrap();
        let plan = solver.plan().clone();
        let reach = plan.parameters.support_radius;
        let count = |place: Vec3| {
            let is_near = |sample: Vec3, x: Vec3| scene.periodic.nearest(x - place - sample).length() < reach;
            let is_wet = |sample: &&Vec3| plan.positions.iter().any(|&x| is_near(**sample, x));
            plan.bodies[0].samples.iter().filter(is_wet).count() as u32
        };
        let expected = places.map(count);
        assert!(expected[0] > 10 && expected[0] < plan.bodies[0].samples.len() as u32, "{expected:?}");
        assert!(expected[1] == 0 && expected[2] > 10, "{expected:?}");
        let bodies = places.map(|position| BodyInput { position, ..BodyInput::default() }).to_vec();
        let report = solver.step(&StepInput { duration: 1e-9, bodies, ..StepInput::default() }).unwrap();
        assert_eq!(report.wetted, expected, "{pressure_solver:?}");
    }
}
