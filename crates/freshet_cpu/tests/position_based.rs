//! Position-based and pressure-corrected fluids, and those by a Poisson equation: iterations against sums over all pairs, momentum, and what a column at rest comes to.

#[path = "common/position_based.rs"]
mod reference;

#[path = "common/poisson.rs"]
mod poisson_reference;

use freshet_core::prelude::*;
use freshet_cpu::{CpuOptions, CpuSolver, InstructionSet};
use glam::DVec3;
use reference::moved;

fn solver_of(plan: &Plan, instruction_set: InstructionSet) -> CpuSolver {
    CpuSolver::new(plan.clone(), CpuOptions { threads: Some(2), instruction_set, ..CpuOptions::default() }).unwrap()
}

fn column(iterations: u32) -> FluidScene {
    let mut scene = FluidScene {
        volumes: vec![Volume::block(Vec3::new(0.2, 0.3, 0.2), Vec3::new(0.2, 0.3, 0.2))],
        boundaries: vec![Boundary::open_box(Vec3::new(0.4, 0.8, 0.4), Vec3::new(0.2, 0.4, 0.2))],
        ..FluidScene::with_spacing(0.05)
    };
    scene.settings.pressure_solver = position_based(iterations);
    scene
}

fn position_based(iterations: u32) -> PressureSolver {
    PressureSolver::PositionBased(PositionBased { iterations, softness: 0.05 })
}

fn corrected(iterations: u32, gradient: PressureGradient) -> PressureSolver {
    PressureSolver::PressureCorrected(PressureCorrected { iterations, gradient })
}

fn poisson(tolerance: f32, max_iterations: u32) -> PressureSolver {
    PressureSolver::PressurePoisson(PressurePoisson { tolerance, max_iterations })
}

/// The same as a slab that repeats itself along x.
fn slab(iterations: u32) -> FluidScene {
    let mut scene = column(iterations);
    let open = [true, true, false, true, false, false];
    let box_of = BoundaryShape::Container { half_extents: Vec3::new(0.2, 0.4, 0.2), open };
    scene.boundaries = vec![Boundary::new(box_of, Vec3::new(0.2, 0.4, 0.2))];
    scene.periodic = Periodic { x: Some((0.0, 0.4)), y: None, z: None };
    scene
}

fn stirred(plan: &Plan, last_substep: f32) -> Snapshot {
    let mut state = 7u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 16_777_216.0 - 0.5
    };
    let count = plan.positions.len();
    let mut vector = |scale: f32| scale * Vec3::new(random(), random(), random());
    Snapshot {
        next_id: count as u32,
        gravity: plan.parameters.gravity,
        ids: (0..count as u32).collect(),
        positions: plan.positions.iter().map(|&x| plan.grid.periodic.wrap(x + vector(0.02))).collect(),
        velocities: plan.positions.iter().map(|_| vector(2.0)).collect(),
        remaining_lives: vec![f32::INFINITY; count],
        last_substep,
        ..Snapshot::default()
    }
}

#[test]
fn particles_are_moved_as_sums_over_all_pairs_say() {
    use PressureGradient::{Difference, Sum};
    let tried = [
        (KernelKind::WendlandC2, position_based(1), InstructionSet::Widest),
        (KernelKind::WendlandC2, position_based(4), InstructionSet::Widest),
        (KernelKind::CubicSpline, position_based(3), InstructionSet::Scalar),
        (KernelKind::WendlandC2, corrected(1, Difference), InstructionSet::Widest),
        (KernelKind::WendlandC2, corrected(4, Sum), InstructionSet::Widest),
        (KernelKind::WendlandC2, corrected(4, Difference), InstructionSet::Widest),
        (KernelKind::CubicSpline, corrected(3, Difference), InstructionSet::Scalar),
    ];
    // The second is so slow a sound that no iteration limits it.
    for ((kernel, method, instruction_set), sound_speed) in
        tried.into_iter().flat_map(|one| [None, Some(11.0)].map(|sound| (one, sound)))
    {
        for mut scene in [column(1), slab(1)] {
            scene.settings.kernel = kernel;
            scene.settings.pressure_solver = method;
            scene.settings.sound_speed = sound_speed;
            scene.settings.allow_compressible = true;
            let plan = Plan::new(&scene).unwrap();
            let (start, dt) = (stirred(&plan, 2e-3), 2e-3);
            let mut solver = solver_of(&plan, instruction_set);
            solver.restore(&start).unwrap();
            solver.step(&StepInput::default()).unwrap();
            let after = solver.snapshot().unwrap();
            let ids = solver.read(Field::Id).unwrap().integers().unwrap();
            let by_id =
                |solver: &mut CpuSolver, field| solver.read(field).unwrap().sorted_by_id(&ids).scalars().unwrap();
            let (pressure, density) = (by_id(&mut solver, Field::Pressure), by_id(&mut solver, Field::Density));
            let (places, pushes) = moved(&plan, &start.positions, start.last_substep);
            let ways: Vec<DVec3> =
                places.iter().zip(&start.positions).map(|(x, start)| *x - start.as_dvec3()).collect();
            let farthest = ways.iter().map(|way| way.length()).fold(0.0, f64::max);
            let hardest = pushes.iter().copied().fold(0.0, f64::max);
            assert!(farthest > 1e-3, "{farthest}");
            for (a, way) in ways.iter().enumerate() {
                // Rounding of positions of up to a metre, and of sums of some thirty terms.
                let change = (after.velocities[a] - start.velocities[a]).as_dvec3();
                let allowed = 1.2e-7 + 2e-5 * farthest;
                assert!(
                    (change * dt).distance(*way) < allowed,
                    "{kernel:?} {method:?}, {a}: {} not {way}",
                    change * dt
                );
                let found = plan.grid.periodic.nearest(after.positions[a] - start.positions[a]).as_dvec3();
                assert!(found.distance(*way) < allowed, "{kernel:?} {method:?}, {a}: {found} not {way}");
                let expected = pushes[a] / (dt * dt) * f64::from(density[a]).powi(2);
                let scale = hardest / (dt * dt) * 1e6;
                assert!(
                    (f64::from(pressure[a]) - expected).abs() < 1e-4 * scale,
                    "{a}: {} Pa not {expected}",
                    pressure[a]
                );
            }
        }
    }
}

/// Of a fluid between walls, one that repeats itself, and drops thrown apart.
#[test]
fn pressures_solve_the_poisson_equation_and_move_particles_by_their_sums() {
    for (kernel, tolerance, instruction_set) in [
        (KernelKind::WendlandC2, 1e-3, InstructionSet::Widest),
        (KernelKind::WendlandC2, 0.1, InstructionSet::Widest),
        (KernelKind::CubicSpline, 1e-3, InstructionSet::Scalar),
    ] {
        for mut scene in [column(1), slab(1)] {
            scene.settings.kernel = kernel;
            scene.settings.pressure_solver = poisson(tolerance, 1000);
            let plan = Plan::new(&scene).unwrap();
            let (start, dt) = (stirred(&plan, 2e-3), 2e-3);
            let mut solver = solver_of(&plan, instruction_set);
            solver.restore(&start).unwrap();
            let report = solver.step(&StepInput::default()).unwrap();
            assert!(report.unsolved == 0 && report.density_iterations > 2, "{report:?}");
            assert!(report.residual > 0.0 && report.residual <= tolerance, "{}", report.residual);
            let after = solver.snapshot().unwrap();
            let ids = solver.read(Field::Id).unwrap().integers().unwrap();
            let mut by_id = |field| solver.read(field).unwrap().sorted_by_id(&ids).scalars().unwrap();
            let (pressure, density) = (by_id(Field::Pressure), by_id(Field::Density));
            let pushes: Vec<f64> = pressure
                .iter()
                .zip(&density)
                .map(|(&p, &rho)| dt * dt * f64::from(p) / f64::from(rho).powi(2))
                .collect();
            let found = poisson_reference::left(&plan, &start.positions, &pushes);
            // One more step than what was reported.
            let left = found.left / found.begun;
            assert!(left < 1.1 * f64::from(tolerance) && left > 0.02 * f64::from(tolerance), "{kernel:?} {left}");
            let pushed = pushes.iter().filter(|&&push| push > 0.0).count();
            assert!(pushes.iter().all(|&push| push >= 0.0) && pushed > pushes.len() / 4, "{pushed}");
            let farthest = found.ways.iter().map(|way| way.length()).fold(0.0, f64::max);
            for (a, (way, surface)) in found.ways.iter().zip(&found.surface).enumerate() {
                assert!(!surface || pushes[a] == 0.0, "{a}");
                let change = (after.velocities[a] - start.velocities[a]).as_dvec3();
                assert!((change * dt).distance(*way) < 1.2e-7 + 2e-5 * farthest, "{a}: {} not {way}", change * dt);
            }
        }
    }
}

/// What iterations leave is said, and that they were too few.
#[test]
fn a_poisson_equation_that_is_not_solved_is_reported() {
    let mut scene = column(1);
    scene.settings.pressure_solver = poisson(1e-4, 5);
    let plan = Plan::new(&scene).unwrap();
    let mut solver = solver_of(&plan, InstructionSet::default());
    solver.restore(&stirred(&plan, 2e-3)).unwrap();
    let report = solver.step(&StepInput::default()).unwrap();
    assert!(report.unsolved == 1 && report.density_iterations == 5 && report.residual > 1e-4, "{report:?}");
}

#[test]
fn water_by_a_poisson_equation_stands() {
    for (tolerance, d) in [(0.02, 120.0), (0.02, 480.0), (0.002, 120.0)] {
        let [pressure, height] = at_rest(poisson(tolerance, 300), 1.0 / d);
        println!("POISSON {tolerance} {d}: {pressure} {height}");
        assert!((pressure - 1.0).abs() < 0.1 && (height - 1.0).abs() < 0.03, "{tolerance} {d}: {pressure} {height}");
    }
}

#[test]
fn fluid_alone_keeps_its_momentum() {
    for method in [position_based(5), corrected(5, PressureGradient::Sum), poisson(0.01, 60)] {
        keeps_momentum(method);
    }
}

fn keeps_momentum(method: PressureSolver) {
    let mut scene = column(5);
    scene.settings.pressure_solver = method;
    scene.boundaries.clear();
    scene.gravity = Vec3::ZERO;
    scene.settings.expected_speed = Some(2.0);
    let plan = Plan::new(&scene).unwrap();
    let start = stirred(&plan, 2e-3);
    let mut solver = solver_of(&plan, InstructionSet::default());
    solver.restore(&start).unwrap();
    solver.step(&StepInput::default()).unwrap();
    let end = solver.snapshot().unwrap();
    let changes: Vec<DVec3> = end.velocities.iter().zip(&start.velocities).map(|(v, u)| (*v - *u).as_dvec3()).collect();
    let (sum, sizes) = (changes.iter().sum::<DVec3>(), changes.iter().map(|change| change.length()).sum::<f64>());
    // Differences of positions have 6e-8 m of rounding each, over 2 ms; they add up at random.
    assert!(sizes > 10.0 && sum.length() < 1e-6 * sizes + 3e-5 * (changes.len() as f64).sqrt(), "{sum} of {sizes}");
}

/// Mean pressure of the lowest layer over that of its depth, and depth of the column over that at the start, after two seconds.
fn at_rest(method: PressureSolver, duration: f32) -> [f64; 2] {
    let mut scene = column(1);
    scene.settings.pressure_solver = method;
    scene.settings.artificial_viscosity = 0.1;
    let mut solver = solver_of(&Plan::new(&scene).unwrap(), InstructionSet::default());
    let (mut pressure, mut heights, mut count) = (0.0, 0.0, 0.0);
    let ticks = (2.0 / duration) as u64;
    for tick in 0..ticks {
        solver.step(&StepInput { tick, duration, ..StepInput::default() }).unwrap();
        if tick >= ticks * 3 / 4 {
            let positions = solver.read(Field::Position).unwrap().vectors().unwrap();
            let pressures = solver.read(Field::Pressure).unwrap().scalars().unwrap();
            heights += positions.iter().map(|x| f64::from(x.y)).sum::<f64>() / positions.len() as f64;
            let mut order: Vec<usize> = (0..positions.len()).collect();
            order.sort_by(|&a, &b| positions[a].y.total_cmp(&positions[b].y));
            pressure += order[..64].iter().map(|&a| f64::from(pressures[a])).sum::<f64>() / 64.0;
            count += 1.0;
        }
    }
    // The lowest layer is half a spacing off the floor.
    [pressure / count / (1000.0 * 9.81 * 0.575), heights / count / 0.3]
}

/// Pressure is that of the weight whatever the iterations; how far the column sinks in for it is theirs, and the step's.
#[test]
fn a_column_has_the_pressure_of_its_depth_and_is_as_soft_as_its_iterations() {
    for of in [position_based, |iterations| corrected(iterations, PressureGradient::Sum)] {
        let [few, many, short] =
            [at_rest(of(2), 1.0 / 120.0), at_rest(of(20), 1.0 / 120.0), at_rest(of(2), 1.0 / 480.0)];
        for [pressure, _] in [few, many, short] {
            assert!((pressure - 1.0).abs() < 0.1, "{few:?} {many:?} {short:?}");
        }
        let sunk = |[_, height]: [f64; 2]| 1.0 - height;
        assert!(
            sunk(few) > 0.02 && sunk(many) < 0.3 * sunk(few) && sunk(short) < 0.3 * sunk(few),
            "{few:?} {many:?} {short:?}"
        );
    }
}

/// The difference keeps no momentum: it holds a column, a little too high and with too much pressure at the floor.
#[test]
fn differences_of_pressures_hold_a_column_badly() {
    for duration in [1.0 / 120.0, 1.0 / 480.0] {
        let [pressure, height] = at_rest(corrected(4, PressureGradient::Difference), duration);
        assert!((1.1..1.45).contains(&pressure) && (1.01..1.1).contains(&height), "{pressure} {height}");
    }
}

#[test]
fn a_run_goes_on_from_a_snapshot_as_if_it_had_not_ended() {
    let plan = Plan::new(&column(3)).unwrap();
    let [mut whole, mut first, mut second] = [(); 3].map(|()| solver_of(&plan, InstructionSet::default()));
    for tick in 0..6 {
        whole.step(&StepInput { tick, duration: 0.01, ..StepInput::default() }).unwrap();
    }
    for tick in 0..3 {
        first.step(&StepInput { tick, duration: 0.01, ..StepInput::default() }).unwrap();
    }
    second.restore(&first.snapshot().unwrap()).unwrap();
    for tick in 3..6 {
        second.step(&StepInput { tick, duration: 0.01, ..StepInput::default() }).unwrap();
    }
    assert!(whole.snapshot().unwrap() == second.snapshot().unwrap());
}

/// Plans of the same column for every method that keeps something else of a substep.
fn methods() -> [(&'static str, Plan); 6] {
    let of = |change: fn(&mut Settings)| {
        let mut scene = column(3);
        change(&mut scene.settings);
        Plan::new(&scene).unwrap()
    };
    [
        ("summed", of(|settings| settings.pressure_solver = PressureSolver::WeaklyCompressible)),
        (
            "carried",
            of(|settings| {
                settings.pressure_solver = PressureSolver::WeaklyCompressible;
                settings.density = DensityForm::Continuity;
            }),
        ),
        (
            "incompressible",
            of(|settings| settings.pressure_solver = PressureSolver::DivergenceFree(DivergenceFree::default())),
        ),
        ("position-based", of(|_| ())),
        ("pressure-corrected", of(|settings| settings.pressure_solver = corrected(3, PressureGradient::Sum))),
        ("poisson", of(|settings| settings.pressure_solver = poisson(0.02, 60))),
    ]
}

/// What one method did in its last substep is nothing that another goes on from: a tick of no length changes no velocity and no place.
#[test]
fn no_method_goes_on_from_the_substep_of_another() {
    // They leave the same, and go on from each other.
    let moving_apart = ["position-based", "pressure-corrected", "poisson"];
    for (before, plan) in &methods() {
        let mut solver = solver_of(plan, InstructionSet::default());
        for tick in 0..3 {
            solver.step(&StepInput { tick, duration: 0.01, ..StepInput::default() }).unwrap();
        }
        let left = solver.snapshot().unwrap();
        assert_eq!(left.last_substep > 0.0, *before != "summed", "{before}");
        for (after, next) in &methods() {
            let mut changed = solver_of(plan, InstructionSet::default());
            changed.restore(&left).unwrap();
            assert_eq!(changed.snapshot().unwrap().last_substep, left.last_substep);
            changed.reconfigure(next.clone()).unwrap();
            let mut restored = solver_of(next, InstructionSet::default());
            restored.restore(&left).unwrap();
            for (how, solver) in [("reconfigured", &mut changed), ("restored", &mut restored)] {
                let state = solver.snapshot().unwrap();
                let same = before == after || [before, after].iter().all(|name| moving_apart.contains(*name));
                let kept = if same { left.last_substep } else { 0.0 };
                assert_eq!(state.last_substep, kept, "{before} to {after}, {how}");
                solver.step(&StepInput { tick: 3, ..StepInput::default() }).unwrap();
                let end = solver.snapshot().unwrap();
                if !same {
                    assert!(
                        end.velocities == left.velocities && end.positions == left.positions,
                        "{before} to {after}, {how}"
                    );
                }
            }
            // Nor does it come back after another.
            changed.reconfigure(plan.clone()).unwrap();
            let same = before == after || [before, after].iter().all(|name| moving_apart.contains(*name));
            assert!(same || changed.snapshot().unwrap().last_substep == 0.0, "{before} to {after} and back");
        }
    }
}

/// Between substeps particles are where they would be without pressure, and their velocities those of the way there: at rest, a substep's fall.
#[test]
fn a_fluid_at_rest_has_the_velocity_of_a_substeps_fall() {
    let mut scene = column(20);
    scene.settings.artificial_viscosity = 0.1;
    let mut solver = solver_of(&Plan::new(&scene).unwrap(), InstructionSet::default());
    let duration = 1.0 / 120.0;
    let mut before = Vec::new();
    let mut way = 0.0;
    for tick in 0..240 {
        let report = solver.step(&StepInput { tick, duration, ..StepInput::default() }).unwrap();
        assert_eq!(report.substeps, 1);
        let places = solver.snapshot().unwrap().positions;
        way = places.iter().zip(&before).map(|(x, was): (&Vec3, &Vec3)| x.distance(*was)).sum::<f32>()
            / places.len() as f32;
        before = places;
    }
    let velocities = solver.snapshot().unwrap().velocities;
    let mean = velocities.iter().sum::<Vec3>() / velocities.len() as f32;
    let fall = 9.81 * duration;
    assert!((mean.y / -fall - 1.0).abs() < 0.1, "{mean} m/s, not {fall} down");
    assert!(way < 0.1 * fall * duration, "they go {way} m");
}
