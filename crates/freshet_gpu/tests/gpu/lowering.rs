//! What the plan does not need is not there: not in the schedule, not in memory, not in the compiled shaders.

use freshet_core::plan::StageKind;
use freshet_core::prelude::*;
use freshet_gpu::{DeviceRequest, GpuOptions, GpuSolver, NeighbourMemory, open_device};

use crate::common::{dam_break, device, solver, solver_with};

fn with_body() -> FluidScene {
    let samples = vec![Vec3::ZERO, Vec3::X * 0.04, Vec3::Y * 0.04];
    FluidScene { bodies: vec![Body { name: "ball".to_owned(), samples, ..Body::default() }], ..dam_break(0.05) }
}

fn names(solver: &GpuSolver) -> (Vec<&'static str>, Vec<&'static str>) {
    let schedule = solver.schedule();
    (
        schedule.passes.iter().map(|pass| pass.name).collect(),
        schedule.buffers.iter().map(|buffer| buffer.name).collect(),
    )
}

/// The schedule against what was counted where buffers are made, and against sums over plan and capacity.
fn check_bytes(solver: &GpuSolver, neighbours: NeighbourMemory) {
    let (schedule, plan) = (solver.schedule(), solver.plan());
    assert_eq!(schedule.bytes(), solver.allocated_bytes(), "{schedule}");
    let (walls, samples) = (plan.boundary.positions.len() as u64, plan.body_samples() as u64);
    // The shaders cut each cell of the plan in two along x.
    let section = 2 * u64::from(plan.grid.cells()) + 1;
    let (with_walls, with_bodies) = (u64::from(walls > 0), u64::from(samples > 0));
    // State 32, sorted position and velocity 16 each, in textures of rows of 512; acceleration 16, density and pressure term
    // 8, life and slot 4 each.
    let capacity = u64::from(schedule.capacity);
    let texels = |count: u64| if neighbours == NeighbourMemory::Textures { count.next_multiple_of(512) } else { count };
    let per_particle = texels(capacity) * 2 * 16 + capacity * (32 + 16 + 8 + 2 * 4);
    // Counts of particles and bodies; starts of particles, walls and bodies, and the totals of blocks of 1024 cells.
    let cells = 4 * (section * (2 + with_walls + 2 * with_bodies) + section.div_ceil(1024));
    let growing: u64 = schedule.buffers.iter().filter(|buffer| buffer.per_particle).map(|buffer| buffer.bytes).sum();
    assert_eq!(growing, per_particle + cells, "{schedule}");
    let bytes =
        |name: &str| schedule.buffers.iter().find(|buffer| buffer.name == name).map_or(0, |buffer| buffer.bytes);
    assert_eq!(bytes("samples"), 16 * texels(walls + samples));
    // A ring of eight reports: what control and bodies hold.
    assert_eq!(bytes("report_staging"), 8 * (bytes("control") + bytes("bodies")));
}

#[test]
fn bytes_of_the_schedule_are_the_bytes_allocated() {
    let memories = [NeighbourMemory::Textures, NeighbourMemory::Buffers];
    for (scene, neighbours) in [dam_break(0.05), with_body()].into_iter().zip(memories) {
        let mut solver = solver_with(&scene, GpuOptions { neighbours, ..Default::default() });
        check_bytes(&solver, neighbours);
        let per_particle = solver.schedule().bytes_per_particle();
        assert!(per_particle <= 120.0, "{}", solver.schedule());
        // Also after growing.
        let plan = Plan { max_particles: 5000, ..solver.plan().clone() };
        solver.reconfigure(plan).unwrap();
        let spawn = Command::Spawn(NewParticles {
            positions: (0..2000u16)
                .map(|i| 0.05 * Vec3::from([i % 10, 20 + i / 100, i / 10 % 10].map(f32::from)))
                .collect(),
            velocities: vec![Vec3::ZERO; 2000],
            lifetime: f32::INFINITY,
            at: None,
        });
        let bodies = vec![BodyInput::default(); scene.bodies.len()];
        let before = solver.schedule().bytes();
        let input = StepInput { duration: 0.0, commands: vec![spawn], bodies, ..Default::default() };
        assert_eq!(solver.step(&input).unwrap().particles, 3000);
        assert!(solver.schedule().bytes() > before);
        check_bytes(&solver, neighbours);
        // And shrinking, which takes a few ticks; and with staging of downloads and commands, which come and go.
        for number in 1..6 {
            let commands = vec![Command::RemoveIds { first: 100, count: u32::MAX }];
            let bodies = vec![BodyInput::default(); scene.bodies.len()];
            solver.step(&StepInput { commands, bodies, ..crate::common::tick(number, 0.0) }).unwrap();
            solver.snapshot().unwrap();
            check_bytes(&solver, neighbours);
        }
        assert!(solver.schedule().capacity < 3000, "{}", solver.schedule());
    }
}

#[test]
fn a_plan_without_bodies_walls_or_viscosity_has_no_trace_of_them() {
    let everything = solver(&with_body());
    let (passes, buffers) = names(&everything);
    for name in ["body_sort_count", "body_load", "body_sum", "body_motion"] {
        assert!(passes.contains(&name), "{passes:?}");
    }
    assert!(buffers.contains(&"bodies") && buffers.contains(&"samples"));
    let text = everything.shader("acceleration").unwrap();
    assert!(text.contains("sorted_velocities") && text.contains("samples"));

    let mut plain = dam_break(0.05);
    plain.boundaries.clear();
    plain.settings.artificial_viscosity = 0.0;
    let bare = solver(&plain);
    let (passes, buffers) = names(&bare);
    assert!(passes.iter().chain(&buffers).all(|name| !name.contains("bod") && !name.contains("sample")), "{bare:?}");
    let text = bare.shader("acceleration").unwrap();
    for trace in ["sorted_velocities", "samples", "viscosity_scale *", "body"] {
        let code = text.split("fn ").skip(1).collect::<String>();
        assert!(!code.contains(trace), "{trace} in the acceleration of a plan that has none");
    }
    assert!(bare.schedule().bytes() < solver(&dam_break(0.05)).schedule().bytes());
}

#[test]
fn every_stage_of_the_plan_has_a_pass_and_no_other() {
    let solver = solver(&with_body());
    let stages: Vec<StageKind> = solver.plan().stages.iter().map(|stage| stage.kind).collect();
    let mut scheduled: Vec<StageKind> = solver.schedule().passes.iter().map(|pass| pass.stage).collect();
    scheduled.dedup();
    assert_eq!(stages, scheduled);
}

#[test]
fn limits_and_options_out_of_reach_are_named() {
    let error = GpuSolver::new(
        &device().device,
        &device().queue,
        Plan::new(&dam_break(0.05)).unwrap(),
        GpuOptions { workgroup_size: 48, ..Default::default() },
    )
    .unwrap_err();
    assert!(error.to_string().contains("workgroup_size: 48"), "{error}");

    let patch = Some(("what no shader says", ""));
    let plan = Plan::new(&dam_break(0.05)).unwrap();
    let options = GpuOptions { patch, ..Default::default() };
    let error = GpuSolver::new(&device().device, &device().queue, plan, options).unwrap_err();
    assert!(error.to_string().contains("what no shader says"), "{error}");

    // 32 bytes a particle in a binding of 128 MiB: 4 Mi particles.
    let mut plan = Plan::new(&dam_break(0.05)).unwrap();
    plan.max_particles = 5 << 20;
    plan.positions = vec![Vec3::ZERO; 5 << 20];
    plan.velocities = vec![Vec3::ZERO; 5 << 20];
    let error = GpuSolver::new(&device().device, &device().queue, plan, GpuOptions::default()).unwrap_err();
    let SolverError::WeakAdapter { limit, offered, needed, .. } = error else { panic!("{error}") };
    assert_eq!((limit.as_str(), offered, needed), ("max_storage_buffer_binding_size", 128 << 20, 160 << 20));
}

#[test]
fn time_stamps_are_summed_by_pass_where_the_device_has_them() {
    let opened = open_device(DeviceRequest { time_stamps: true, ..Default::default() }).unwrap();
    let plan = Plan::new(&dam_break(0.05)).unwrap();
    let options = GpuOptions { time_stamps: true, ..Default::default() };
    let mut solver = GpuSolver::new(&opened.device, &opened.queue, plan, options).unwrap();
    let report = solver.step(&crate::common::tick(0, 1.0 / 60.0)).unwrap();
    if opened.device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
        let passes: Vec<&str> = report.passes.iter().map(|pass| pass.pass.as_str()).collect();
        assert_eq!(passes, solver.schedule().passes.iter().map(|pass| pass.name).collect::<Vec<_>>());
        assert!(report.passes.iter().all(|pass| pass.milliseconds >= 0.0));
        assert!(report.passes.iter().map(|pass| pass.milliseconds).sum::<f32>() > 0.0);
    } else {
        assert!(report.passes.is_empty());
    }
    // Measuring changes nothing else.
    let mut plain = solver_with(&dam_break(0.05), GpuOptions::default());
    plain.step(&crate::common::tick(0, 1.0 / 60.0)).unwrap();
    assert!(solver.snapshot().unwrap() == plain.snapshot().unwrap());
    assert_eq!(solver.schedule().bytes(), solver.allocated_bytes());
}
