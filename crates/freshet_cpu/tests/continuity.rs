//! Densities that particles carry: the rate against sums over all pairs, exact flows, and what becomes of them between ticks.

use freshet_core::prelude::*;
use freshet_cpu::{CpuOptions, CpuSolver, InstructionSet};
use glam::{DMat3, DVec3, Mat3};

fn solver_of(plan: &Plan, instruction_set: InstructionSet) -> CpuSolver {
    CpuSolver::new(plan.clone(), CpuOptions { threads: Some(2), instruction_set, ..CpuOptions::default() }).unwrap()
}

fn solver(scene: &FluidScene) -> CpuSolver {
    solver_of(&Plan::new(scene).unwrap(), InstructionSet::default())
}

/// A column in a box.
fn column() -> FluidScene {
    let mut scene = FluidScene {
        volumes: vec![Volume::block(Vec3::new(0.2, 0.3, 0.2), Vec3::new(0.2, 0.3, 0.2))],
        boundaries: vec![Boundary::open_box(Vec3::new(0.4, 0.8, 0.4), Vec3::new(0.2, 0.4, 0.2))],
        ..FluidScene::with_spacing(0.05)
    };
    scene.settings.density = DensityForm::Continuity;
    scene.settings.max_particles = Some(1000);
    scene
}

/// The same as a slab that repeats itself along x.
fn slab() -> FluidScene {
    let mut scene = column();
    let open = [true, true, false, true, false, false];
    scene.boundaries = vec![Boundary::new(
        BoundaryShape::Container { half_extents: Vec3::new(0.2, 0.4, 0.2), open },
        Vec3::new(0.2, 0.4, 0.2),
    )];
    scene.periodic = Periodic { x: Some((0.0, 0.4)), y: None, z: None };
    scene
}

fn random() -> impl FnMut() -> f32 {
    let mut state = 7u32;
    move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 16_777_216.0 - 0.5
    }
}

/// The plan's particles with other places, velocities and densities.
fn state(plan: &Plan, places: Vec<Vec3>, velocities: Vec<Vec3>, excesses: Vec<f32>, last_substep: f32) -> Snapshot {
    let count = places.len();
    Snapshot {
        next_id: count as u32,
        gravity: plan.parameters.gravity,
        ids: (0..count as u32).collect(),
        positions: places,
        velocities,
        remaining_lives: vec![f32::INFINITY; count],
        excesses,
        last_substep,
        ..Snapshot::default()
    }
}

fn stirred(plan: &Plan, last_substep: f32) -> Snapshot {
    let mut random = random();
    let mut vector = |scale: f32| scale * Vec3::new(random(), random(), random());
    let places = plan.positions.iter().map(|&x| x + vector(0.02)).collect();
    let velocities = plan.positions.iter().map(|_| vector(4.0)).collect();
    let excesses = plan.positions.iter().map(|_| vector(0.05).x).collect();
    state(plan, places, velocities, excesses, last_substep)
}

/// By the formula of `freshet_core::density_form`, and the sizes of all terms together.
fn expected(plan: &Plan, state: &Snapshot) -> Vec<[f64; 2]> {
    let p = &plan.parameters;
    let kernel = p.kernel().unwrap();
    let dt = f64::from(state.last_substep);
    let lengths = plan.grid.periodic.lengths().as_dvec3();
    let image = |apart: DVec3| {
        DVec3::from([0, 1, 2].map(|axis| match lengths[axis] {
            0.0 => apart[axis],
            length => apart[axis] - length * (apart[axis] / length).round(),
        }))
    };
    let volume = f64::from(p.particle_mass) / f64::from(p.rest_density);
    let walls = || plan.boundary.positions.iter().zip(&plan.boundary.volumes);
    let of = |a: usize| {
        let (x, v) = (state.positions[a].as_dvec3(), state.velocities[a].as_dvec3());
        let term = |weight: f64, other: DVec3, moving: DVec3| {
            let apart = image(x - other);
            let is_near = if apart.length() < f64::from(p.support_radius) { 1.0 } else { 0.0 };
            let between = apart - 0.5 * dt * moving;
            is_near * weight * kernel.derivative_over_r(between.length()) * between.dot(moving)
        };
        let fluid = (0..state.ids.len()).filter(|&b| b != a).map(|b| {
            let moving = v - state.velocities[b].as_dvec3();
            term(volume, state.positions[b].as_dvec3(), moving)
        });
        let terms: Vec<f64> =
            fluid.chain(walls().map(|(wall, &volume)| term(f64::from(volume), wall.as_dvec3(), v))).collect();
        let scale = dt / f64::from(p.gradient_calibration);
        let excess = f64::from(state.excesses[a]) + scale * terms.iter().sum::<f64>();
        [excess.max(f64::from(DensityForm::LEAST_EXCESS)), scale * terms.iter().map(|term| term.abs()).sum::<f64>()]
    };
    (0..state.ids.len()).map(of).collect()
}

fn read(solver: &mut CpuSolver, field: Field) -> Vec<f32> {
    let ids = solver.read(Field::Id).unwrap().integers().unwrap();
    solver.read(field).unwrap().sorted_by_id(&ids).scalars().unwrap()
}

#[test]
fn densities_change_as_sums_over_all_pairs_say() {
    for (kernel, instruction_set) in [
        (KernelKind::WendlandC2, InstructionSet::Widest),
        (KernelKind::CubicSpline, InstructionSet::Scalar),
        (KernelKind::QuinticSpline, InstructionSet::Widest),
    ] {
        for mut scene in [column(), slab()] {
            scene.settings.kernel = kernel;
            let plan = Plan::new(&scene).unwrap();
            let start = stirred(&plan, 1e-3);
            let mut solver = solver_of(&plan, instruction_set);
            solver.restore(&start).unwrap();
            solver.step(&StepInput::default()).unwrap();
            let (density, pressure) = (read(&mut solver, Field::Density), read(&mut solver, Field::Pressure));
            let after = solver.snapshot().unwrap();
            assert_eq!(after.last_substep, 0.0);
            for (a, [excess, size]) in expected(&plan, &start).into_iter().enumerate() {
                // Some thirty terms in single precision.
                let found = f64::from(after.excesses[a]);
                assert!((found - excess).abs() < 1e-8 + 3e-6 * size, "{kernel:?}, {a}: {found} not {excess}");
                let rho = 1000.0 * (1.0 + found);
                assert!((f64::from(density[a]) - rho).abs() < 2e-4, "{kernel:?}, {a}: {} not {rho}", density[a]);
                let p = plan.parameters.pressure_law.pressure(1000.0, f64::from(density[a]));
                assert!(
                    (f64::from(pressure[a]) - p).abs() < 1e-6 * (p + 1.0),
                    "{kernel:?}, {a}: {} not {p}",
                    pressure[a]
                );
            }
            // Nothing has moved: densities stay as they are.
            solver.step(&StepInput { tick: 1, ..StepInput::default() }).unwrap();
            assert_eq!(solver.snapshot().unwrap().excesses, after.excesses);
        }
    }
}

/// A block in nothing, without forces of its own.
fn block() -> FluidScene {
    let mut scene = FluidScene {
        gravity: Vec3::ZERO,
        volumes: vec![Volume { hydrostatic: false, ..Volume::block(Vec3::splat(0.5), Vec3::ZERO) }],
        ..FluidScene::with_spacing(0.1)
    };
    scene.settings.density = DensityForm::AdaptedContinuity;
    scene.settings.expected_speed = Some(1.0);
    scene.settings.artificial_viscosity = 0.0;
    scene
}

/// What a particle in the middle carries after a substep in which all moved with `A x`.
fn after_a_flow(matrix: DMat3, kernel: KernelKind) -> f64 {
    let mut scene = block();
    scene.settings.kernel = kernel;
    let plan = Plan::new(&scene).unwrap();
    let velocities = plan.positions.iter().map(|x| (matrix * x.as_dvec3()).as_vec3()).collect();
    let count = plan.positions.len();
    let start = state(&plan, plan.positions.clone(), velocities, vec![0.0; count], 1e-4);
    let mut solver = solver_of(&plan, InstructionSet::default());
    solver.restore(&start).unwrap();
    solver.step(&StepInput::default()).unwrap();
    let middle = plan.positions.iter().position(|x| x.length() < 0.09).unwrap();
    f64::from(solver.snapshot().unwrap().excesses[middle])
}

#[test]
fn linear_flows_on_the_lattice_are_exact() {
    for kernel in [KernelKind::WendlandC2, KernelKind::CubicSpline, KernelKind::Spiky] {
        let turn = DMat3::from_cols(DVec3::new(0.0, 1.0, -2.0), DVec3::new(-1.0, 0.0, 0.5), DVec3::new(2.0, -0.5, 0.0));
        let shear = DMat3::from_cols(DVec3::ZERO, DVec3::new(3.0, 0.0, 1.0), DVec3::ZERO);
        let squeeze = DMat3::from_diagonal(DVec3::new(1.0, -3.0, -1.0));
        for (flow, rate) in [(turn, 0.0), (shear, 0.0), (squeeze, 3.0), (turn + shear + squeeze, 3.0)] {
            let found = after_a_flow(flow, kernel) / 1e-4;
            // The lattice of the middle of the substep differs by 5e-5 of each of up to 3 / s; rounding of positions is less.
            assert!((found - rate).abs() < 3e-3, "{kernel:?}: {found} not {rate}");
        }
    }
}

/// A block that turns, and flies apart straight as nothing holds it together: what is carried in steps of `1/steps` of the time.
fn turning(steps: u32) -> f64 {
    let plan = Plan::new(&block()).unwrap();
    let velocities = plan.positions.iter().map(|x| 2.0 * Vec3::new(-x.y, x.x, 0.0)).collect();
    let mut solver = solver_of(&plan, InstructionSet::default());
    let count = plan.positions.len();
    solver.restore(&state(&plan, plan.positions.clone(), velocities, vec![0.0; count], 0.0)).unwrap();
    let duration = 0.04 / steps as f32;
    for tick in 0..u64::from(steps) {
        assert_eq!(solver.step(&StepInput { tick, duration, ..StepInput::default() }).unwrap().substeps, 1);
    }
    solver.step(&StepInput { tick: u64::from(steps), ..StepInput::default() }).unwrap();
    let middle = plan.positions.iter().position(|x| x.length() < 0.09).unwrap();
    f64::from(solver.snapshot().unwrap().excesses[middle])
}

/// `det(1 + W t)` of the turn `W` is `1 + 4 t^2`.
#[test]
fn a_turning_fluid_thins_out_to_second_order() {
    let [coarse, middle, fine] = [20, 40, 80].map(turning);
    let thinner = 1.0 / (1.0 + 4.0 * 0.04f64.powi(2)) - 1.0;
    // To a percent: the lattice is not at rest any more.
    assert!((fine / thinner - 1.0).abs() < 0.01, "{fine} not {thinner}");
    // Taken at the ends of substeps the first would be a twentieth more.
    assert!((coarse / fine - 1.0).abs() < 1e-3, "{coarse} {middle} {fine}");
}

#[test]
fn what_falls_together_keeps_its_density() {
    let mut scene = block();
    scene.gravity = Vec3::new(1.0, -9.81, 0.0);
    let mut solver = solver(&scene);
    for tick in 0..20 {
        solver.step(&StepInput { tick, duration: 0.01, ..StepInput::default() }).unwrap();
    }
    assert!(solver.snapshot().unwrap().excesses.iter().all(|&excess| excess == 0.0));
}

#[test]
fn water_at_rest_starts_with_the_pressure_of_its_depth() {
    let plan = Plan::new(&column()).unwrap();
    let mut solver = solver(&column());
    solver.step(&StepInput::default()).unwrap();
    for (pressure, x) in read(&mut solver, Field::Pressure).iter().zip(&plan.positions) {
        let depth = 0.6 - x.y;
        // Of the law at a compression of up to half a percent, and as places are those of the compressed column.
        assert!((pressure / (1000.0 * 9.81 * depth) - 1.0).abs() < 0.03, "{pressure} Pa at {depth} m");
    }
}

#[test]
fn a_run_goes_on_from_a_snapshot_and_after_a_step_that_was_made_again() {
    for redo in [false, true] {
        let mut scene = column();
        // Supersonic, as in Pirovano's jet.
        scene.volumes[0].velocity = Vec3::new(0.0, -4.76, 0.0);
        (scene.settings.sound_speed, scene.settings.allow_compressible) = (Some(1.5), true);
        scene.settings.redo_substeps = redo;
        let (mut whole, mut first, mut second) = (solver(&scene), solver(&scene), solver(&scene));
        let mut redone = 0;
        for tick in 0..6 {
            redone += whole.step(&StepInput { tick, duration: 0.01, ..StepInput::default() }).unwrap().redone;
        }
        assert_eq!(redone > 0, redo);
        for tick in 0..3 {
            first.step(&StepInput { tick, duration: 0.01, ..StepInput::default() }).unwrap();
        }
        second.restore(&Snapshot::from_bytes(&first.snapshot().unwrap().to_bytes().unwrap()).unwrap()).unwrap();
        for tick in 3..6 {
            second.step(&StepInput { tick, duration: 0.01, ..StepInput::default() }).unwrap();
        }
        assert!(whole.snapshot().unwrap() == second.snapshot().unwrap());
    }
}

/// Particles far from each other, each with a density of its own, spawned and removed: it stays with its particle, and a new one has that at rest.
#[test]
fn densities_stay_with_their_particles() {
    let mut scene = block();
    scene.settings.max_particles = Some(4000);
    let mut solver = solver(&scene);
    let places: Vec<Vec3> =
        (0..1000).map(|i| Vec3::new((i % 10) as f32, (i / 10 % 10) as f32, (i / 100) as f32)).collect();
    let excesses: Vec<f32> = (0..1000).map(|i| -1e-4 * i as f32).collect();
    let plan = solver.plan().clone();
    let flow = Mat3::from_rotation_y(0.3);
    let velocities = places.iter().map(|x| 1e-2 * (flow * *x)).collect();
    solver.restore(&state(&plan, places, velocities, excesses.clone(), 0.0)).unwrap();
    let new =
        NewParticles { positions: vec![Vec3::splat(-3.0); 1], velocities: vec![Vec3::X], lifetime: 10.0, at: None };
    let commands = vec![Command::RemoveIds { first: 100, count: 300 }, Command::Spawn(new)];
    solver.step(&StepInput { duration: 0.02, commands, ..StepInput::default() }).unwrap();
    solver.step(&StepInput { tick: 1, duration: 0.02, ..StepInput::default() }).unwrap();
    let end = solver.snapshot().unwrap();
    assert_eq!(end.ids.len(), 701);
    for (id, excess) in end.ids.iter().zip(&end.excesses) {
        assert_eq!(*excess, excesses.get(*id as usize).copied().unwrap_or(0.0), "{id}");
    }
}

#[test]
fn other_forms_hand_over_what_presses() {
    let (carried, mut summed) = (Plan::new(&column()).unwrap(), Plan::new(&column()).unwrap());
    summed.parameters.density = DensityForm::Summation;
    summed.excesses.clear();
    let mut solver = solver_of(&summed, InstructionSet::default());
    for tick in 0..5 {
        solver.step(&StepInput { tick, duration: 0.01, ..StepInput::default() }).unwrap();
    }
    let sums = read(&mut solver, Field::Density);
    assert!(sums.iter().any(|&density| density < 900.0), "the surface lacks neighbours");
    solver.reconfigure(carried).unwrap();
    let excesses = solver.snapshot().unwrap().excesses;
    for (excess, density) in excesses.iter().zip(&sums) {
        assert!((excess - (density / 1000.0 - 1.0).max(0.0)).abs() < 1e-7, "{excess} of {density}");
    }
    solver.reconfigure(summed).unwrap();
    assert_eq!(solver.snapshot().unwrap().excesses, []);
}
