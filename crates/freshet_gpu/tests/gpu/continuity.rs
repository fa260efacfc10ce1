//! Densities that particles carry: the rate against sums over all pairs, and that they stay with their particles.

use freshet_core::prelude::*;
use freshet_gpu::{GpuOptions, GpuSolver};
use glam::DVec3;

use crate::common::{dam_break, random, random_vector, solver, solver_with, tick, tick_with};

fn scene() -> FluidScene {
    let mut scene = dam_break(0.1);
    scene.settings.density = DensityForm::Continuity;
    scene.settings.max_particles = Some(1000);
    scene
}

/// The same as a slab that repeats itself along z, and without any viscosity.
fn slab() -> FluidScene {
    let mut scene = scene();
    let open = [true, true, false, true, false, false];
    let box_of = BoundaryShape::Container { half_extents: Vec3::new(0.25, 0.4, 0.25), open };
    scene.boundaries = vec![Boundary::new(box_of, Vec3::new(0.25, 0.4, 0.25))];
    scene.periodic = Periodic { x: Some((-0.2, 0.7)), y: None, z: None };
    scene.settings.artificial_viscosity = 0.0;
    scene
}

/// The plan's particles off their places, after a substep of a millisecond.
fn stirred(plan: &Plan) -> Snapshot {
    let of = |salt: usize, scale: f32| move |index: usize| scale * random_vector(index, salt);
    let count = plan.positions.len();
    let places = plan.positions.iter().enumerate();
    Snapshot {
        next_id: count as u32,
        gravity: plan.parameters.gravity,
        ids: (0..count as u32).collect(),
        positions: places.map(|(index, &x)| x + of(1, 0.02)(index)).collect(),
        velocities: (0..count).map(of(2, 4.0)).collect(),
        remaining_lives: vec![f32::INFINITY; count],
        excesses: (0..count).map(|index| 0.05 * random(index, 9)).collect(),
        last_substep: 1e-3,
        ..Default::default()
    }
}

/// The largest error against the formula of `freshet_core::density_form`, over the sizes of all terms together.
fn error(solver: &mut GpuSolver) -> f64 {
    let plan = solver.plan().clone();
    let start = stirred(&plan);
    solver.restore(&start).unwrap();
    solver.step(&tick(0, 0.0)).unwrap();
    let after = solver.snapshot().unwrap();
    let ids = solver.read(Field::Id).unwrap().integers().unwrap();
    let densities = solver.read(Field::Density).unwrap().sorted_by_id(&ids).scalars().unwrap();
    let p = &plan.parameters;
    let kernel = p.kernel().unwrap();
    let dt = f64::from(start.last_substep);
    let lengths = plan.grid.periodic.lengths().as_dvec3();
    let image = |apart: DVec3| {
        DVec3::from([0, 1, 2].map(|axis| match lengths[axis] {
            0.0 => apart[axis],
            length => apart[axis] - length * (apart[axis] / length).round(),
        }))
    };
    let volume = f64::from(p.particle_mass) / f64::from(p.rest_density);
    let mut worst = 0.0f64;
    for (a, &density) in densities.iter().enumerate() {
        let (x, v) = (start.positions[a].as_dvec3(), start.velocities[a].as_dvec3());
        let (mut sum, mut size) = (0.0, 0.0);
        let mut add = |weight: f64, other: DVec3, moving: DVec3| {
            let apart = image(x - other);
            if apart.length() >= f64::from(p.support_radius) {
                return;
            }
            let between = apart - 0.5 * dt * moving;
            let term = weight * kernel.derivative_over_r(between.length()) * between.dot(moving);
            (sum, size) = (sum + term, size + term.abs());
        };
        for b in (0..start.ids.len()).filter(|&b| b != a) {
            add(volume, start.positions[b].as_dvec3(), v - start.velocities[b].as_dvec3());
        }
        for (wall, &volume) in plan.boundary.positions.iter().zip(&plan.boundary.volumes) {
            add(f64::from(volume), wall.as_dvec3(), v);
        }
        let scale = dt / f64::from(p.gradient_calibration);
        let excess = f64::from(start.excesses[a]) + scale * sum;
        worst = worst.max((f64::from(after.excesses[a]) - excess).abs() / (scale * size + 1e-3));
        let density = f64::from(density);
        assert!((density - 1000.0 * (1.0 + f64::from(after.excesses[a]))).abs() < 1e-4 * 2.0, "{density}");
    }
    worst
}

const TOLERANCE: f64 = 1e-5;

#[test]
fn densities_change_as_sums_over_all_pairs_say() {
    for kernel in [KernelKind::WendlandC2, KernelKind::CubicSpline] {
        for mut scene in [scene(), slab()] {
            scene.settings.kernel = kernel;
            let found = error(&mut solver(&scene));
            assert!(found < TOLERANCE, "{kernel:?}: {found:e} off");
        }
    }
    for patch in [
        ("dt * rate_of(a, 0.5 * dt)", "dt * rate_of(a, 0.45 * dt)"),
        ("wall.weight * parting(x, velocity,", "wall.weight * parting(x, 1.01 * velocity,"),
        ("set_sorted_history(first + rank, word,", "set_sorted_history(first, word,"),
    ] {
        let options = GpuOptions { patch: Some(patch), ..Default::default() };
        let found = error(&mut solver_with(&scene(), options));
        assert!(found > TOLERANCE, "{patch:?} makes an error of {found:e} only");
    }
}

/// A substep from the carried state gives the forces that the CPU's formula has: by the pressure of what is carried.
#[test]
fn pressures_are_those_of_what_is_carried() {
    for scene in [scene(), slab()] {
        let mut solver = solver(&scene);
        let plan = solver.plan().clone();
        solver.restore(&stirred(&plan)).unwrap();
        solver.step(&tick(0, 0.0)).unwrap();
        let read = |solver: &mut GpuSolver, field| solver.read(field).unwrap().scalars().unwrap();
        let (densities, pressures) = (read(&mut solver, Field::Density), read(&mut solver, Field::Pressure));
        assert!(pressures.iter().any(|&pressure| pressure > 0.0));
        for (density, pressure) in densities.iter().zip(&pressures) {
            let law = plan.parameters.pressure_law.pressure(1000.0, f64::from(*density)) as f32;
            let stiffness = 1000.0 * plan.parameters.sound_speed.powi(2);
            assert!((law - pressure).abs() < 1e-5 * (law + stiffness), "{pressure} Pa not {law} at {density}");
        }
    }
}

#[test]
fn a_run_goes_on_from_a_snapshot_as_if_it_had_not_ended() {
    let (mut whole, mut first, mut second) = (solver(&scene()), solver(&scene()), solver(&scene()));
    let commands = vec![
        Command::RemoveIds { first: 20, count: 30 },
        Command::Spawn(NewParticles {
            positions: vec![Vec3::new(0.75, 0.55, 0.25)],
            velocities: vec![Vec3::ZERO],
            lifetime: f32::INFINITY,
            at: None,
        }),
    ];
    for number in 0..6 {
        whole.step(&tick_with(number, 0.02, if number == 1 { commands.clone() } else { Vec::new() })).unwrap();
    }
    for number in 0..3 {
        first.step(&tick_with(number, 0.02, if number == 1 { commands.clone() } else { Vec::new() })).unwrap();
    }
    second.restore(&first.snapshot().unwrap()).unwrap();
    for number in 3..6 {
        second.step(&tick(number, 0.02)).unwrap();
    }
    let end = whole.snapshot().unwrap();
    assert!(end == second.snapshot().unwrap());
    let new = end.ids.iter().position(|&id| id == 125).unwrap();
    assert_eq!(end.excesses[new], 0.0, "a particle that flies alone has the density at rest");
    assert!(end.excesses.iter().any(|&excess| excess > 1e-4));
}

#[test]
fn other_forms_hand_over_what_presses() {
    let (carried, mut summed) = (Plan::new(&scene()).unwrap(), scene());
    summed.settings.density = DensityForm::Summation;
    let mut solver = solver(&summed);
    for number in 0..3 {
        solver.step(&tick(number, 0.02)).unwrap();
    }
    let ids = solver.read(Field::Id).unwrap().integers().unwrap();
    let sums = solver.read(Field::Density).unwrap().sorted_by_id(&ids).scalars().unwrap();
    solver.reconfigure(carried).unwrap();
    for (excess, density) in solver.snapshot().unwrap().excesses.iter().zip(&sums) {
        assert!((excess - (density / 1000.0 - 1.0).max(0.0)).abs() < 1e-7, "{excess} of {density}");
    }
    solver.reconfigure(Plan::new(&summed).unwrap()).unwrap();
    assert_eq!(solver.snapshot().unwrap().excesses, []);
}

/// What is carried has memory in plans that ask for it, and no trace in others.
#[test]
fn only_plans_that_carry_densities_pay_for_it() {
    let bytes = |scene: &FluidScene| {
        let solver = solver(scene);
        let schedule = solver.schedule();
        let bytes = schedule.buffers.iter().find(|buffer| buffer.name == "histories").map_or(0, |buffer| buffer.bytes);
        (bytes, u64::from(schedule.capacity))
    };
    let (carried, capacity) = bytes(&scene());
    assert_eq!(carried, 8 * capacity);
    let summed = dam_break(0.1);
    assert_eq!(bytes(&summed).0, 0);
    assert!(solver(&summed).shader("continuity").is_none());
    for pass in ["sort_reorder", "integrate", "density"] {
        let code = solver(&summed).shader(pass).unwrap();
        assert!(!code.contains("histories"), "{pass}");
    }
}
