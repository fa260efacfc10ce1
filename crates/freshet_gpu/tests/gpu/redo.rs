//! Substeps that turn out too long are made again: see `crates/freshet_cpu/tests/redo.rs`, and `crates/freshet_lab/tests/backends.rs` for the same numbers.

use freshet_core::prelude::*;
use freshet_gpu::GpuOptions;

use crate::common::{dam_break, solver, solver_with};

#[path = "../../../freshet_cpu/tests/common/redo.rs"]
mod scenes;
use scenes::{SPACING, SPEED, block_on_a_body, collision, supersonic};

/// Substeps made again in twelve ticks, and the state after them; `anew`: each tick starts from a snapshot, so that the solver does not know how many substeps
/// to encode.
fn run(scene: &FluidScene, duration: f32, options: GpuOptions, anew: bool) -> (u32, Snapshot) {
    let mut solver = solver_with(scene, options);
    let mut redone = 0;
    for tick in 0..12 {
        if anew {
            let state = solver.snapshot().unwrap();
            solver.restore(&state).unwrap();
        }
        let report = solver.step(&StepInput { tick, duration, ..StepInput::default() }).unwrap();
        assert_eq!((report.removed, report.time_scale), (0, 1.0), "{report:?}");
        redone += report.redone;
    }
    (redone, solver.snapshot().unwrap())
}

#[test]
fn bits_do_not_depend_on_the_workgroup_size_nor_on_how_many_substeps_were_encoded() {
    for (scene, duration) in [(collision(true), 0.8 * SPACING / SPEED), (supersonic(true), 8e-3)] {
        let reference = run(&scene, duration, GpuOptions::default(), false);
        assert!(reference.0 > 0, "none is made again");
        let sized = |workgroup_size| GpuOptions { workgroup_size, ..GpuOptions::default() };
        for size in [32, 256] {
            assert!(run(&scene, duration, sized(size), false) == reference, "workgroup size {size} gives other bits");
        }
        assert!(run(&scene, duration, GpuOptions::default(), true) == reference, "as many as are encoded");
    }
}

/// What a body got in a substep that was taken back is taken back, too.
#[test]
fn bodies_go_back_as_well() {
    let (scene, mut body) = block_on_a_body();
    let mut solver = solver(&scene);
    let mass = solver.plan().parameters.particle_mass;
    let (mut redone, mut momenta) = (0, Vec::new());
    for tick in 0..12 {
        let input = StepInput { tick, duration: 4e-3, bodies: vec![body], ..StepInput::default() };
        let report = solver.step(&input).unwrap();
        redone += report.redone;
        body.linear_velocity += report.bodies[0].linear * body.inverse_mass;
        body.position += body.linear_velocity * 4e-3;
        let fluid = solver.snapshot().unwrap().velocities.iter().sum::<Vec3>() * mass;
        momenta.push(fluid + body.linear_velocity / body.inverse_mass);
    }
    let (start, end) = (momenta[0], momenta[11]);
    assert!(redone > 0 && body.linear_velocity.x > 0.5, "{redone}, {body:?}");
    assert!(start.distance(end) < 1e-3 * start.length(), "{start} {end}");
}

#[test]
fn only_plans_that_ask_for_it_keep_states() {
    let has = |scene: &FluidScene| {
        let solver = solver(scene);
        let schedule = solver.schedule();
        let passes = ["keep_state", "restore_state"].map(|name| schedule.passes.iter().any(|pass| pass.name == name));
        let buffer = schedule.buffers.iter().any(|buffer| buffer.name == "befores");
        (passes, buffer, solver.shader("step_control").unwrap().contains("take_back"))
    };
    let mut scene = dam_break(0.05);
    assert_eq!(has(&scene), ([false; 2], false, false));
    scene.settings.redo_substeps = true;
    assert_eq!(has(&scene), ([true; 2], true, true));
}
