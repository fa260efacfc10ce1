//! Position-based and pressure-corrected fluids, and those by a Poisson equation: iterations of the shipped shaders against sums over all pairs.

use freshet_core::prelude::*;
use freshet_gpu::{GpuOptions, GpuSolver};
use glam::DVec3;

use crate::common::{dam_break, random_vector, solver, solver_with, tick};
use crate::moved::moved;
use crate::poisson::left;

fn scene(iterations: u32) -> FluidScene {
    let mut scene = dam_break(0.1);
    scene.settings.pressure_solver = position_based(iterations);
    scene
}

fn position_based(iterations: u32) -> PressureSolver {
    PressureSolver::PositionBased(PositionBased { iterations, softness: 0.05 })
}

fn corrected(iterations: u32, gradient: PressureGradient) -> PressureSolver {
    PressureSolver::PressureCorrected(PressureCorrected { iterations, gradient })
}

/// The same as a slab that repeats itself along x, without any viscosity.
fn slab(iterations: u32) -> FluidScene {
    let mut scene = scene(iterations);
    let open = [true, true, false, true, false, false];
    let box_of = BoundaryShape::Container { half_extents: Vec3::new(0.25, 0.4, 0.25), open };
    scene.boundaries = vec![Boundary::new(box_of, Vec3::new(0.25, 0.4, 0.25))];
    scene.periodic = Periodic { x: Some((-0.2, 0.7)), y: None, z: None };
    scene.settings.artificial_viscosity = 0.0;
    scene
}

fn stirred(plan: &Plan) -> Snapshot {
    let count = plan.positions.len();
    let places = plan.positions.iter().enumerate();
    Snapshot {
        next_id: count as u32,
        gravity: plan.parameters.gravity,
        ids: (0..count as u32).collect(),
        positions: places.map(|(index, &x)| x + 0.04 * random_vector(index, 1)).collect(),
        velocities: (0..count).map(|index| 2.0 * random_vector(index, 2)).collect(),
        remaining_lives: vec![f32::INFINITY; count],
        last_substep: DT,
        ..Default::default()
    }
}

const DT: f32 = 2e-3;

/// The largest errors of ways, by positions and by velocities, over the longest way; and of pressures over the largest.
fn errors(solver: &mut GpuSolver) -> [f64; 3] {
    let plan = solver.plan().clone();
    let start = stirred(&plan);
    solver.restore(&start).unwrap();
    solver.step(&tick(0, 0.0)).unwrap();
    let after = solver.snapshot().unwrap();
    let ids = solver.read(Field::Id).unwrap().integers().unwrap();
    let mut by_id = |field| solver.read(field).unwrap().sorted_by_id(&ids).scalars().unwrap();
    let (pressure, density) = (by_id(Field::Pressure), by_id(Field::Density));
    let (places, pushes) = moved(&plan, &start.positions, DT);
    let ways: Vec<DVec3> = places.iter().zip(&start.positions).map(|(x, start)| *x - start.as_dvec3()).collect();
    let farthest = ways.iter().map(|way| way.length()).fold(0.0, f64::max);
    let dt = f64::from(DT);
    let hardest = pushes.iter().copied().fold(0.0, f64::max) / (dt * dt) * 1e6;
    assert!(farthest > 1e-3 && hardest > 1.0, "{farthest} {hardest}");
    let mut worst = [0.0f64; 3];
    for (a, way) in ways.iter().enumerate() {
        let went = plan.grid.periodic.nearest(after.positions[a] - start.positions[a]).as_dvec3();
        let change = (after.velocities[a] - start.velocities[a]).as_dvec3() * dt;
        let expected = pushes[a] / (dt * dt) * f64::from(density[a]).powi(2);
        let found = [
            went.distance(*way) / farthest,
            change.distance(*way) / farthest,
            (f64::from(pressure[a]) - expected).abs() / hardest,
        ];
        worst.iter_mut().zip(found).for_each(|(worst, found)| *worst = worst.max(found));
    }
    worst
}

/// Positions are rounded to 3e-8 m of some centimetres' ways.
const TOLERANCE: f64 = 1e-4;

#[test]
fn particles_are_moved_as_sums_over_all_pairs_say() {
    use PressureGradient::{Difference, Sum};
    for (kernel, method) in [
        (KernelKind::WendlandC2, position_based(1)),
        (KernelKind::WendlandC2, position_based(4)),
        (KernelKind::CubicSpline, position_based(3)),
        (KernelKind::WendlandC2, corrected(4, Sum)),
        (KernelKind::WendlandC2, corrected(1, Difference)),
        (KernelKind::CubicSpline, corrected(3, Difference)),
    ] {
        for mut scene in [scene(1), slab(1)] {
            scene.settings.kernel = kernel;
            scene.settings.pressure_solver = method;
            let found = errors(&mut solver(&scene));
            assert!(found.iter().all(|&error| error < TOLERANCE), "{kernel:?} {method:?}: {found:?}");
        }
    }
    for (method, patch) in [
        (position_based(4), ("relaxation * max(excess, 0.0)", "relaxation * 1.001 * max(excess, 0.0)")),
        (position_based(4), ("own.push * sums.samples", "1.01 * own.push * sums.samples")),
        (
            position_based(4),
            ("fields::set_motion(a, fields::place(a))", "fields::set_motion(a, fields::place(a) * 1.001)"),
        ),
        (position_based(4), ("rate = select(0.0, 1.0 /", "rate = select(0.0, 0.999 /")),
        (corrected(4, Sum), ("stiffness * excess", "stiffness * 1.001 * excess")),
        (corrected(4, Sum), ("-fields::sum_of_pushes(a)", "0.0")),
        (corrected(4, Difference), ("max(own.push - mean, 0.0)", "max(own.push - 1.01 * mean, 0.0)")),
        (corrected(4, Difference), ("(fields::push(b) - own.push)", "(fields::push(b) - 0.999 * own.push)")),
    ] {
        let scene = FluidScene { settings: Settings { pressure_solver: method, ..scene(4).settings }, ..scene(4) };
        let found = errors(&mut solver_with(&scene, GpuOptions { patch: Some(patch), ..Default::default() }));
        assert!(found.iter().any(|&error| error > TOLERANCE), "{patch:?} makes errors of {found:?} only");
    }
}

fn poisson(tolerance: f32, max_iterations: u32) -> PressureSolver {
    PressureSolver::PressurePoisson(PressurePoisson { tolerance, max_iterations })
}

/// What pressures leave of the equation over its tolerance; the largest error of ways over the longest, or of what surfaces push or others pull over the largest pressure.
fn poisson_errors(solver: &mut GpuSolver, tolerance: f32, is_halved: bool) -> [f64; 2] {
    let plan = solver.plan().clone();
    let mut start = stirred(&plan);
    if is_halved {
        // One half denser than at rest, the other thinner, but no surface.
        let squeezed = |x: &Vec3| Vec3::new(x.x, x.y * if x.x < 0.25 { 0.985 } else { 1.01 }, x.z);
        start.positions = plan.positions.iter().map(squeezed).collect();
    }
    solver.restore(&start).unwrap();
    let report = solver.step(&tick(0, 0.0)).unwrap();
    assert!(report.unsolved == 0 && report.density_iterations > 2, "{report:?}");
    assert!(report.residual > 0.0 && report.residual <= tolerance, "{report:?}");
    let after = solver.snapshot().unwrap();
    let ids = solver.read(Field::Id).unwrap().integers().unwrap();
    let mut by_id = |field| solver.read(field).unwrap().sorted_by_id(&ids).scalars().unwrap();
    let (pressure, density) = (by_id(Field::Pressure), by_id(Field::Density));
    let dt = f64::from(DT);
    let push = |(&p, &rho): (&f32, &f32)| dt * dt * f64::from(p) / f64::from(rho).powi(2);
    let pushes: Vec<f64> = pressure.iter().zip(&density).map(push).collect();
    let found = left(&plan, &start.positions, &pushes);
    let farthest = found.ways.iter().map(|way| way.length()).fold(0.0, f64::max);
    let hardest = pushes.iter().copied().fold(0.0, f64::max);
    let mut worst = 0.0f64;
    for (a, (way, &surface)) in found.ways.iter().zip(&found.surface).enumerate() {
        let change = (after.velocities[a] - start.velocities[a]).as_dvec3() * dt;
        // None at a surface, and none that pulls.
        let wrong = if surface { pushes[a] } else { (-pushes[a]).max(0.0) };
        worst = worst.max(change.distance(*way) / farthest).max(wrong / hardest);
    }
    [found.left / found.begun / f64::from(tolerance), worst]
}

#[test]
fn pressures_solve_the_poisson_equation_and_move_particles_by_their_sums() {
    let of = |mut scene: FluidScene, tolerance| {
        scene.settings.pressure_solver = poisson(tolerance, 1000);
        scene
    };
    let is_right = |[left, ways]: [f64; 2]| (0.02..1.1).contains(&left) && ways < TOLERANCE;
    for (scene, tolerance, is_halved) in
        [(scene(1), 2e-3, false), (slab(1), 2e-3, false), (scene(1), 0.1, false), (scene(1), 2e-3, true)]
    {
        let found = poisson_errors(&mut solver(&of(scene, tolerance)), tolerance, is_halved);
        assert!(is_right(found), "to {tolerance}, {is_halved}: {found:?}");
    }
    for (patch, is_halved) in [
        (("poisson_scale * sums_of(own_of(a), a)", "poisson_scale * 1.02 * sums_of(own_of(a), a)"), false),
        (("max(own - fields::parameters.poisson_scale", "max(0.9 * own - fields::parameters.poisson_scale"), false),
        (("select(all, 0.0, fields", "select(all, all, fields"), false),
        (("let stepped = max(free, 0.0)", "let stepped = free"), true),
    ] {
        let mut solver = solver_with(&of(scene(1), 2e-3), GpuOptions { patch: Some(patch), ..Default::default() });
        let found = poisson_errors(&mut solver, 2e-3, is_halved);
        assert!(!is_right(found), "{patch:?} makes errors of {found:?} only");
    }
}

#[test]
fn a_poisson_equation_that_is_not_solved_is_reported() {
    let mut scene = scene(1);
    scene.settings.pressure_solver = poisson(1e-4, 5);
    let mut solver = solver(&scene);
    solver.restore(&stirred(solver.plan())).unwrap();
    let report = solver.step(&tick(0, 0.0)).unwrap();
    assert!(report.unsolved == 1 && report.density_iterations == 5 && report.residual > 1e-4, "{report:?}");
    let report = solver.step(&tick(1, 0.0)).unwrap();
    assert!(report.unsolved == 0 && report.density_iterations == 0, "nothing has moved: {report:?}");
}

#[test]
fn a_run_goes_on_from_a_snapshot_as_if_it_had_not_ended() {
    let scene = scene(3);
    let [mut whole, mut first, mut second] = [(); 3].map(|()| solver(&scene));
    for number in 0..6 {
        whole.step(&tick(number, 0.02)).unwrap();
    }
    for number in 0..3 {
        first.step(&tick(number, 0.02)).unwrap();
    }
    second.restore(&first.snapshot().unwrap()).unwrap();
    for number in 3..6 {
        second.step(&tick(number, 0.02)).unwrap();
    }
    assert!(whole.snapshot().unwrap() == second.snapshot().unwrap());
}

#[test]
fn iterations_cost_time_and_no_memory() {
    let [few, many] = [1, 50].map(|iterations| solver(&scene(iterations)));
    assert_eq!(few.schedule().bytes(), many.schedule().bytes());
    assert_eq!(few.schedule().bytes(), few.allocated_bytes());
    let other = solver(&dam_break(0.1));
    assert!(other.shader("displace").is_none());
    assert!(other.schedule().buffers.iter().all(|buffer| buffer.name != "places"));
}
