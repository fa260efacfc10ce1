//! Incompressible fluids: the solves of the shaders against sums over all pairs in double precision; iterations that are decided
//! on the GPU and encoded beforehand.

use freshet_core::kernel::Kernel;
use freshet_core::prelude::*;
use freshet_core::viscosity::ViscosityModel;
use freshet_gpu::{GpuOptions, GpuSolver, NeighbourMemory, TICKS_IN_FLIGHT};
use glam::DVec3;

use crate::common::{device, random_vector, solver, solver_with, tick, tick_with};

fn incompressible(mut scene: FluidScene, solver: DivergenceFree) -> FluidScene {
    scene.settings.pressure_solver = PressureSolver::DivergenceFree(solver);
    scene
}

fn dam_break() -> FluidScene {
    incompressible(crate::common::dam_break(0.05), DivergenceFree::default())
}

/// A block between a floor and a wall that move along themselves; its viscosity is next to nothing.
fn dragged(solver: DivergenceFree) -> FluidScene {
    let mut scene = crate::common::dam_break(0.05);
    let floor = Boundary::new(BoundaryShape::Plane { half_extents: [0.5, 0.25] }, Vec3::new(0.5, 0.0, 0.25));
    let wall = Boundary {
        rotation: Quat::from_rotation_z(-std::f32::consts::FRAC_PI_2),
        ..Boundary::new(BoundaryShape::Plane { half_extents: [0.5, 0.25] }, Vec3::new(0.0, 0.5, 0.25))
    };
    scene.boundaries =
        vec![floor.with_velocity(Vec3::new(0.8, 0.0, 0.0)), wall.with_velocity(Vec3::new(0.0, 0.3, 0.1))];
    scene.material.dynamic_viscosity = 1e-6;
    scene.settings.viscosity_model = Some(ViscosityModel::Morris1997);
    incompressible(scene, solver)
}

/// Sums over all pairs, from the formulas of `freshet_core::pressure_solver` and nothing else.
struct Reference<'a> {
    plan: &'a Plan,
    kernel: Kernel,
    x: Vec<DVec3>,
    /// Position, volume. They stay where they are, also those of belts.
    walls: Vec<(DVec3, f64)>,
}

impl<'a> Reference<'a> {
    fn new(plan: &'a Plan, positions: &[Vec3]) -> Self {
        let walls = plan.boundary.positions.iter().zip(&plan.boundary.volumes);
        Self {
            plan,
            kernel: plan.parameters.kernel().unwrap(),
            x: positions.iter().map(|x| x.as_dvec3()).collect(),
            walls: walls.map(|(x, &volume)| (x.as_dvec3(), f64::from(volume))).collect(),
        }
    }

    fn gradient(&self, apart: DVec3) -> DVec3 {
        self.kernel.derivative_over_r(apart.length()) * apart
    }

    /// Relative densities.
    fn densities(&self) -> Vec<f64> {
        let p = &self.plan.parameters;
        let volume = f64::from(p.particle_mass) / f64::from(p.rest_density);
        let of = |&at: &DVec3| {
            let fluid: f64 = self.x.iter().map(|other| self.kernel.value(at.distance(*other))).sum();
            let wall: f64 = self.walls.iter().map(|(x, volume)| volume * self.kernel.value(at.distance(*x))).sum();
            (volume * fluid + wall) / f64::from(p.density_calibration)
        };
        self.x.iter().map(of).collect()
    }

    /// `D(u) / rho0`.
    fn rates(&self, u: &[DVec3]) -> Vec<f64> {
        let p = &self.plan.parameters;
        let volume = f64::from(p.particle_mass) / f64::from(p.rest_density);
        let of = |a: usize| {
            let fluid: f64 = (0..self.x.len()).map(|b| (u[a] - u[b]).dot(self.gradient(self.x[a] - self.x[b]))).sum();
            let wall: f64 = self.walls.iter().map(|(x, volume)| volume * u[a].dot(self.gradient(self.x[a] - x))).sum();
            (volume * fluid + wall) / f64::from(p.density_calibration)
        };
        (0..self.x.len()).map(of).collect()
    }

    /// Accelerations by pressures `p / rho^2`.
    fn accelerations(&self, pressures: &[f64]) -> Vec<DVec3> {
        let p = &self.plan.parameters;
        let (mass, rest) = (f64::from(p.particle_mass), f64::from(p.rest_density));
        let of = |a: usize| {
            let fluid: DVec3 =
                (0..self.x.len()).map(|b| (pressures[a] + pressures[b]) * self.gradient(self.x[a] - self.x[b])).sum();
            let wall: DVec3 =
                self.walls.iter().map(|(x, volume)| *volume * pressures[a] * self.gradient(self.x[a] - x)).sum();
            -(mass * fluid + rest * wall) / f64::from(p.gradient_calibration)
        };
        (0..self.x.len()).map(of).collect()
    }
}

/// A block off its lattice, in motion.
fn disturbed(plan: &Plan) -> Snapshot {
    let count = plan.positions.len();
    let d = plan.parameters.spacing;
    let velocity = |(index, x): (usize, &Vec3)| Vec3::new(0.4 - 2.0 * x.x, -x.y, 0.0) + 0.2 * random_vector(index, 2);
    Snapshot {
        next_id: count as u32,
        gravity: plan.parameters.gravity,
        ids: (0..count as u32).collect(),
        positions: plan.positions.iter().enumerate().map(|(i, &x)| x + 0.03 * d * random_vector(i, 1)).collect(),
        velocities: plan.positions.iter().enumerate().map(velocity).collect(),
        remaining_lives: vec![f32::INFINITY; count],
        ..Snapshot::default()
    }
}

/// How a substep from a disturbed state differs from what it should be, each over what is allowed: velocities from those that
/// the pressures reported make of them; the divergence that is left; the density that is left of what there was too much.
fn errors(scene: &FluidScene, options: GpuOptions) -> [f64; 3] {
    let mut solver = solver_with(scene, options);
    let plan = solver.plan().clone();
    let PressureSolver::DivergenceFree(settings) = plan.parameters.pressure_solver else { panic!("compressible") };
    // Off places where it is at rest, so that no position has to be corrected by more than a substep may.
    (0..20).for_each(|at| assert_eq!(solver.step(&tick(at, 1.0 / 60.0)).unwrap().removed, 0));
    let settled = solver.snapshot().unwrap().positions;
    let mut start = disturbed(&plan);
    for ((x, at), rest) in start.positions.iter_mut().zip(&plan.positions).zip(settled) {
        *x = rest + (*x - *at);
    }
    solver.restore(&start).unwrap();
    let dt = 1e-3;
    let report = solver.step(&tick(0, dt)).unwrap();
    assert_eq!((report.substeps, report.removed), (1, 0));
    assert!(report.divergence_iterations > 10, "{}", report.divergence_iterations);

    let reference = Reference::new(&plan, &start.positions);
    let end = solver.snapshot().unwrap();
    let pressures: Vec<f64> = end.pressures.iter().map(|&p| f64::from(p)).collect();
    assert!(pressures.iter().all(|&pressure| pressure >= 0.0));
    let velocities: Vec<DVec3> = end.velocities.iter().map(|v| v.as_dvec3()).collect();
    let mut worst: f64 = if report.unsolved > 0 { f64::INFINITY } else { 0.0 };
    for (i, acceleration) in reference.accelerations(&pressures).iter().enumerate() {
        let expected = start.velocities[i].as_dvec3() + f64::from(dt) * (scene.gravity.as_dvec3() + *acceleration);
        let allowed = 1e-4 * f64::from(dt) * acceleration.length().max(10.0) + 1e-6;
        worst = worst.max(velocities[i].distance(expected) / allowed);
    }
    let fastest = start.velocities.iter().map(|v| v.length()).fold(0.0, f32::max);
    let way = (fastest * dt / plan.parameters.longest_way()).min(1.0);
    let share = DivergenceFree::share(way);
    let most = plan.parameters.most_by_velocity(dt);
    let densities = reference.densities();
    let (mut wrong, mut too_much) = (0.0, 0.0);
    for ((density, rate), pressure) in densities.iter().zip(reference.rates(&velocities)).zip(&pressures) {
        let left = f64::from(DivergenceFree::source((density - 1.0) as f32, share, most)) + f64::from(dt) * rate;
        wrong += if *pressure > 0.0 { left.abs() } else { left.max(0.0) };
        too_much += (density - 1.0).max(0.0);
    }
    let after = Reference::new(&plan, &end.positions).densities();
    let after: f64 = after.iter().map(|density| (density - 1.0).max(0.0)).sum();
    assert!(too_much > 5e-4 * densities.len() as f64, "{too_much}");
    [worst, wrong / densities.len() as f64 / (1.5 * f64::from(settings.divergence * way)), after / (0.2 * too_much)]
}

/// With every kind of wall, and proof that a wrong constant in any of the passes would be noticed.
#[test]
fn a_substep_solves_what_it_says() {
    let exact = DivergenceFree { compression: 1e-5, divergence: 1e-5, max_iterations: 2000 };
    for kernel in [KernelKind::WendlandC2, KernelKind::CubicSpline] {
        for (mut scene, neighbours) in [
            (incompressible(crate::common::dam_break(0.05), exact), NeighbourMemory::Textures),
            (dragged(exact), NeighbourMemory::Buffers),
        ] {
            scene.settings.kernel = kernel;
            scene.settings.artificial_viscosity = 0.0;
            let found = errors(&scene, GpuOptions { neighbours, ..GpuOptions::default() });
            assert!(found.iter().all(|&error| error < 1.0), "{kernel:?}, {neighbours:?}: {found:?}");
        }
    }
    let mut scene = dragged(exact);
    scene.settings.artificial_viscosity = 0.0;
    for (from, to) in [
        ("(*sums).samples += dot(along, own.velocity)", "(*sums).samples += 0.99 * dot(along, own.velocity)"),
        ("(own.change + fields::change(b)) *", "(own.change + 1.01 * fields::change(b)) *"),
        ("let left = fields::source(a) + dt * dt * rate", "let left = fields::source(a) + 1.01 * dt * dt * rate"),
        ("pressure += fields::taken(a)", "pressure += fields::change(a)"),
        ("fields::control.share * clamp(excess", "1.5 * fields::control.share * clamp(excess"),
        ("fields::motion(a) * fields::control.correction", "0.7 * fields::motion(a) * fields::control.correction"),
    ] {
        let found = errors(&scene, GpuOptions { patch: Some((from, to)), ..GpuOptions::default() });
        assert!(found.iter().any(|&error| error > 1.0), "{from} -> {to} went unnoticed: {found:?}");
    }
}

fn run(solver: &mut GpuSolver, ticks: std::ops::Range<u64>) -> Vec<StepReport> {
    ticks.map(|number| solver.step(&tick(number, 1.0 / 60.0)).unwrap()).collect()
}

/// Fluid that falls onto a floor and needs more iterations when it arrives there than the tick before: as many as have been
/// encoded before any are known in one solver, as many as the tick before needed in the other.
#[test]
fn bits_depend_neither_on_how_many_iterations_were_encoded_nor_on_memory_and_groups() {
    let mut scene = dam_break();
    scene.volumes[0].center.y += 0.1;
    let mut whole = solver(&scene);
    let reports = run(&mut whole, 0..20);
    let most = |report: &StepReport| report.divergence_iterations / report.substeps;
    let more = reports.windows(2).filter(|pair| most(&pair[1]) > 2 * most(&pair[0]) + 4).count();
    assert!(more > 0 && reports.iter().all(|report| report.unsolved == 0), "{reports:?}");
    let end = whole.snapshot().unwrap();
    assert!(end.pressures.iter().any(|&pressure| pressure > 1e-3) && end.last_substep > 0.0);

    let mut again = solver(&scene);
    for number in 0..20 {
        let state = again.snapshot().unwrap();
        again.restore(&state).unwrap();
        run(&mut again, number..number + 1);
    }
    assert!(again.snapshot().unwrap() == end, "from a snapshot each tick");
    for (workgroup_size, neighbours) in [(32, NeighbourMemory::Buffers), (256, NeighbourMemory::Textures)] {
        let mut other = solver_with(&scene, GpuOptions { workgroup_size, neighbours, ..GpuOptions::default() });
        run(&mut other, 0..20);
        assert!(other.snapshot().unwrap() == end, "{workgroup_size}, {neighbours:?}");
    }
}

/// In the pipelined mode a tick ends with the iterations it has: what that leaves is said, and ticks after its report have more
/// iterations and make up for the time.
/// Reports are waited for after each tick, or after every third, so that nothing depends on the device's pace.
#[test]
fn a_tick_that_nobody_waits_for_ends_its_solves_and_says_so() {
    for in_flight in [1, TICKS_IN_FLIGHT] {
        let settings = DivergenceFree { compression: 1e-6, divergence: 1e-6, max_iterations: 300 };
        let mut solver = solver(&incompressible(crate::common::dam_break(0.05), settings));
        let state = disturbed(solver.plan());
        solver.restore(&state).unwrap();
        let device = device();
        let mut reports = Vec::new();
        for number in 0..24 {
            solver.prepare(&device.queue, &tick(number, 1.0 / 60.0)).unwrap();
            let mut encoder = device.device.create_command_encoder(&Default::default());
            solver.encode(&mut encoder).unwrap();
            device.queue.submit([encoder.finish()]);
            let batch_ends = (number + 1) % in_flight as u64 == 0;
            while batch_ends && solver.ticks_in_flight() > 0 {
                reports.extend(solver.collect(&device.device).unwrap());
            }
        }
        assert_eq!(reports.len(), 24);
        assert!(reports.iter().all(|report| (report.particles, report.removed) == (1000, 0)), "{reports:?}");
        assert!(reports[0].unsolved > 0 && reports[0].substeps > 0, "{:?}", reports[0]);
        // Later a tick needs more iterations than those before it here and there, as the splash does what it does.
        let late = reports[3 * in_flight..].iter().filter(|report| report.unsolved > 0).count();
        assert!(late < 6, "{in_flight}: {reports:?}");
        // A tick that is waited for makes up for all that is left.
        reports.push(solver.step(&tick(24, 1.0 / 60.0)).unwrap());
        let simulated: f64 = reports.iter().map(|report| report.simulated).sum();
        assert!((simulated - 25.0 / 60.0).abs() < 1e-5, "{in_flight}: {simulated}");
        let speeds = solver.read(Field::Speed).unwrap().scalars().unwrap();
        assert!(speeds.iter().all(|&speed| speed < 5.0), "{speeds:?}");
    }
}

#[test]
fn memory_and_passes_are_those_of_the_plan() {
    let mut incompressible = solver(&dam_break());
    let schedule = incompressible.schedule();
    assert!(schedule.bytes_per_particle() < 220.0, "{schedule}");
    assert_eq!(schedule.bytes(), incompressible.allocated_bytes(), "{schedule}");
    let passes: Vec<_> = schedule.passes.iter().map(|pass| pass.name).collect();
    for name in ["divergence_first", "divergence_iterations", "density_begin", "density_iterations"] {
        assert!(passes.contains(&name), "{passes:?}");
    }
    assert!(!incompressible.shader("density").unwrap().contains("stiffness)"), "no equation of state");
    let plain = solver(&crate::common::dam_break(0.05));
    let text = plain.schedule().to_string();
    assert!(!text.contains("solve") && !text.contains("motions"), "{text}");
    assert!(!plain.shader("step_control").unwrap().contains("begin_solves"));

    // From one to the other and back, while it runs.
    run(&mut incompressible, 0..3);
    for (scene, ticks) in [(crate::common::dam_break(0.05), 3..6), (dam_break(), 6..9)] {
        incompressible.reconfigure(Plan::new(&scene).unwrap()).unwrap();
        assert!(run(&mut incompressible, ticks).iter().all(|report| report.removed == 0));
    }
}

/// Those that are gone leave no pressures to those that come, also in buffers that grow.
#[test]
fn spawned_particles_come_without_pressure() {
    let mut scene = dam_break();
    scene.settings.max_particles = Some(5_000);
    let new = NewParticles {
        positions: (0..2000u16)
            .map(|i| Vec3::new(f32::from(i % 10), 20.0 + f32::from(i / 100), f32::from(i / 10 % 10)) * 0.05)
            .collect(),
        velocities: vec![Vec3::ZERO; 2000],
        lifetime: f32::INFINITY,
        at: None,
    };
    let remove = Command::RemoveInBox { min: Vec3::splat(-1.0), max: Vec3::new(2.0, 2.0, 0.25) };
    let mut whole = solver(&scene);
    run(&mut whole, 0..5);
    assert!(whole.step(&tick_with(5, 0.01, vec![remove])).unwrap().retired > 5);
    let mut restored = solver(&scene);
    restored.restore(&whole.snapshot().unwrap()).unwrap();
    let ends = [&mut whole, &mut restored].map(|solver| {
        let report = solver.step(&tick_with(6, 0.01, vec![Command::Spawn(new.clone())])).unwrap();
        assert_eq!((report.refused, report.removed), (0, 0));
        run(solver, 7..9);
        solver.snapshot().unwrap()
    });
    assert!(ends[0] == ends[1]);
    assert!(ends[0].ids.len() > 2000);
}

/// Nothing, one particle, two at one place, and ticks of next to no time.
#[test]
fn odd_scenes_end_with_finite_numbers() {
    let particle = Volume::block(Vec3::splat(0.025), Vec3::ZERO);
    for volumes in [Vec::new(), vec![particle]] {
        let scene = FluidScene { volumes, ..FluidScene::with_spacing(0.05) };
        let mut scene = incompressible(scene, DivergenceFree::default());
        scene.settings.max_particles = Some(10);
        let mut solver = solver(&scene);
        let twin = NewParticles {
            positions: vec![Vec3::splat(0.3); 2],
            velocities: vec![Vec3::ZERO; 2],
            lifetime: f32::INFINITY,
            at: None,
        };
        for (number, duration) in [1e-3, 0.0, 1e-30, 1e-12, 1e-3, 1e-3].into_iter().enumerate() {
            let commands = if number == 2 { vec![Command::Spawn(twin.clone())] } else { Vec::new() };
            let report = solver.step(&tick_with(number as u64, duration, commands)).unwrap();
            assert_eq!((report.removed, report.unsolved), (0, 0), "{report:?}");
        }
        let speeds = solver.read(Field::Speed).unwrap().scalars().unwrap();
        assert!(speeds.iter().all(|&speed| speed < 1.0), "{speeds:?}");
    }
}
