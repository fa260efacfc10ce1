//! Substeps of the steady state allocate nothing. The only test of its binary, so that nobody else allocates meanwhile.
#![allow(unsafe_code)] // An allocator cannot be counted otherwise.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use freshet_core::prelude::*;
use freshet_cpu::{CpuOptions, CpuSolver};

/// The system's, with a count of its calls.
struct Counting;

static ALLOCATIONS: AtomicU64 = AtomicU64::new(0);

// SAFETY: every call goes to the system's allocator as it came; counting allocates nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Relaxed);
        // SAFETY: the caller keeps the contract.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract.
        unsafe { System.dealloc(place, layout) }
    }

    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Relaxed);
        // SAFETY: the caller keeps the contract.
        unsafe { System.realloc(place, layout, size) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// Allocations of one tick, and its substeps.
fn tick(solver: &mut CpuSolver, tick: u64, duration: f32) -> (u64, u32) {
    let body = BodyInput { position: Vec3::new(0.5, 0.5, 0.25), ..BodyInput::default() };
    let input = StepInput { tick, duration, bodies: vec![body; solver.plan().bodies.len()], commands: Vec::new() };
    let before = ALLOCATIONS.load(Relaxed);
    let report = solver.step(&input).unwrap();
    (ALLOCATIONS.load(Relaxed) - before, report.substeps)
}

/// What a substep more allocates, after the arrays have grown to what the fluid needs.
fn compare(scene: &FluidScene, threads: usize, what: &str) {
    let plan = Plan::new(scene).unwrap();
    // So many that all threads share the passes.
    assert!(plan.positions.len() > 1000 * threads, "{}", plan.positions.len());
    let mut solver = CpuSolver::new(plan, CpuOptions { threads: Some(threads), ..CpuOptions::default() }).unwrap();
    for at in 0..5 {
        tick(&mut solver, at, 0.01);
    }
    // A tick has its report and a few lists of its own; the least of several, as a thread may be new to the pool's own lists.
    let least = |solver: &mut CpuSolver, first: u64, duration: f32| {
        (first..first + 3).map(|at| tick(solver, at, duration)).min().unwrap()
    };
    let short = least(&mut solver, 5, 0.002);
    let long = least(&mut solver, 8, 0.01);
    println!("{what}, {threads} threads: {short:?} and {long:?} allocations and substeps");
    assert!(long.1 > short.1 + 3, "{what}: {short:?} and {long:?} allocations and substeps of two ticks");
    // What a substep allocates comes once for each of them; the pool's own queue takes a block for some fifty jobs that no thread
    // picks up at once, on a busy machine now and then one in a tick.
    let (more, substeps) = (long.0.saturating_sub(short.0), u64::from(long.1 - short.1));
    assert!(8 * more < substeps, "{what}, {threads} threads: {more} allocations in {substeps} substeps more");
}

#[test]
fn substeps_allocate_nothing() {
    let tank = FluidScene {
        volumes: vec![Volume::block(Vec3::new(0.5, 0.25, 0.25), Vec3::new(0.5, 0.25, 0.25))],
        boundaries: vec![Boundary::open_box(Vec3::new(1.0, 1.0, 0.5), Vec3::new(0.5, 0.5, 0.25))],
        ..FluidScene::with_spacing(1.0 / 32.0)
    };
    let samples = tank.wall_layer().unwrap().sphere_surface(0.1).unwrap();
    let body = Body { name: "ball".to_owned(), samples, ..Body::default() };
    let mut incompressible = tank.clone();
    incompressible.settings.pressure_solver = PressureSolver::DivergenceFree(DivergenceFree::default());
    // So viscous that a tick has several substeps.
    incompressible.settings.viscous_factor = 0.01;
    incompressible.settings.artificial_viscosity = 0.3;
    let with_body = FluidScene { bodies: vec![body.clone()], ..tank.clone() };
    compare(&incompressible, 2, "a tank of incompressible fluid");
    incompressible.bodies.push(body);
    compare(&incompressible, 2, "a tank of incompressible fluid and a ball");
    for threads in [1, 2, 3] {
        compare(&tank, threads, "a tank");
        compare(&with_body, threads, "a tank and a ball");
    }
}
