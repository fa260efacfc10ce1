//! The schedule against what the allocator says. The only test of its binary, so that nobody else allocates meanwhile.
#![allow(unsafe_code)] // An allocator cannot be counted otherwise.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicI64, Ordering::Relaxed};

use freshet_core::plan::StageKind;
use freshet_core::prelude::*;
use freshet_cpu::{CpuOptions, CpuSolver};

/// The system's, with a count of the bytes given out.
struct Counting;

static HELD: AtomicI64 = AtomicI64::new(0);

// SAFETY: every call goes to the system's allocator as it came; counting allocates nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        HELD.fetch_add(layout.size() as i64, Relaxed);
        // SAFETY: the caller keeps the contract.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size() as i64, Relaxed);
        // SAFETY: the caller keeps the contract.
        unsafe { System.dealloc(place, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

fn held() -> i64 {
    HELD.load(Relaxed)
}

/// 8,000 particles, a tank and eight bodies of 450 samples each.
fn scene() -> FluidScene {
    let mut scene = FluidScene {
        volumes: vec![Volume::block(Vec3::splat(0.5), Vec3::splat(0.5))],
        boundaries: vec![Boundary::open_box(Vec3::new(2.0, 1.5, 1.0), Vec3::new(1.0, 0.75, 0.5))],
        ..FluidScene::with_spacing(0.05)
    };
    let samples = scene.wall_layer().unwrap().sphere_surface(0.3).unwrap();
    scene.bodies = vec![Body { name: "ball".to_owned(), samples, ..Body::default() }; 8];
    scene
}

/// Steps, and compares the schedule's bytes with those that were allocated since `before`.
fn compare(solver: &mut CpuSolver, before: i64, what: &str) {
    let bodies =
        vec![BodyInput { position: Vec3::new(1.5, 0.5, 0.5), ..BodyInput::default() }; solver.plan().bodies.len()];
    for tick in 0..3 {
        let report =
            solver.step(&StepInput { tick, duration: 0.005, bodies: bodies.clone(), commands: Vec::new() }).unwrap();
        // Every pass of the schedule ran and no other.
        let mut ran: Vec<&str> = report.passes.iter().map(|pass| pass.pass.as_str()).collect();
        let mut scheduled: Vec<&str> = solver.schedule().passes.iter().map(|pass| pass.name).collect();
        ran.sort_unstable();
        scheduled.sort_unstable();
        assert_eq!(ran, scheduled, "{what}");
    }
    let stages: Vec<StageKind> = solver.plan().stages.iter().map(|stage| stage.kind).collect();
    let passes: Vec<StageKind> = solver.schedule().passes.iter().map(|pass| pass.stage).collect();
    assert_eq!(stages, passes, "{what}");
    // The solver's own plan is not in the schedule.
    let all = held() - before;
    let copy = solver.plan().clone();
    let plan = held() - before - all;
    drop(copy);
    let (allocated, scheduled) = (all - plan, solver.schedule().bytes() as i64);
    println!("{what}: {allocated} bytes allocated, {scheduled} in the schedule, {plan} in the plan");
    // A pool of one thread and the schedule's own lists are no part of it: 5 to 12 kB. The smallest thing that follows from the
    // scene, the bodies' samples before they are sorted, has 58.
    let left = allocated - scheduled;
    assert!((0..24_000).contains(&left), "{what}: {left} bytes are not in the schedule:\n{}", solver.schedule());
}

#[test]
fn bytes_of_the_schedule_are_the_bytes_allocated() {
    let plan = Plan::new(&scene()).unwrap();
    let bare = Plan::new(&FluidScene { boundaries: Vec::new(), bodies: Vec::new(), ..scene() }).unwrap();
    let options = CpuOptions { threads: Some(1), ..CpuOptions::default() };
    // What a process allocates once.
    drop(CpuSolver::new(bare.clone(), options.clone()).unwrap());
    let given = plan.clone();
    let (again, without) = (plan.clone(), bare.clone());

    let before = held();
    let mut solver = CpuSolver::new(bare.clone(), options.clone()).unwrap();
    compare(&mut solver, before, "without walls or bodies");
    drop(solver);

    let before = held();
    let mut solver = CpuSolver::new(given.clone(), options).unwrap();
    compare(&mut solver, before, "with both");
    solver.reconfigure(without.clone()).unwrap();
    compare(&mut solver, before, "without them again");
    solver.reconfigure(again.clone()).unwrap();
    compare(&mut solver, before, "and with");
    assert_eq!(plan, *solver.plan());
    drop(solver);

    let mut scene = scene();
    scene.settings.pressure_solver = PressureSolver::DivergenceFree(DivergenceFree::default());
    let given = Plan::new(&scene).unwrap();
    let options = CpuOptions { threads: Some(1), ..CpuOptions::default() };
    let before = held();
    let mut solver = CpuSolver::new(given.clone(), options).unwrap();
    compare(&mut solver, before, "of an incompressible fluid");
    assert_eq!(given, *solver.plan());
}
