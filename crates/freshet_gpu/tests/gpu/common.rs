//! One device for all tests, and small scenes.

use std::sync::OnceLock;

use freshet_core::prelude::*;
use freshet_gpu::{DeviceRequest, FluidDevice, GpuOptions, GpuSolver, open_device};

/// The device of all tests; opening one takes longer than most of them.
pub fn device() -> &'static FluidDevice {
    static DEVICE: OnceLock<FluidDevice> = OnceLock::new();
    DEVICE.get_or_init(|| open_device(DeviceRequest::default()).unwrap_or_else(|error| panic!("{error}")))
}

/// A solver on that device.
pub fn solver_with(scene: &FluidScene, options: GpuOptions) -> GpuSolver {
    let plan = Plan::new(scene).unwrap();
    GpuSolver::new(&device().device, &device().queue, plan, options).unwrap()
}

/// A solver with default options.
pub fn solver(scene: &FluidScene) -> GpuSolver {
    solver_with(scene, GpuOptions::default())
}

/// A block of water in the corner of an open box: 1000 particles at a spacing of 5 cm.
pub fn dam_break(spacing: f32) -> FluidScene {
    FluidScene {
        volumes: vec![Volume::block(Vec3::splat(0.25), Vec3::splat(0.25))],
        boundaries: vec![
            Boundary::open_box(Vec3::new(1.0, 0.75, 0.5), Vec3::new(0.5, 0.375, 0.25))
                .with_viscous_faces([false, true, true, false, false, true]),
        ],
        ..FluidScene::with_spacing(spacing)
    }
}

/// A tick without commands or bodies.
pub fn tick(number: u64, duration: f32) -> StepInput {
    StepInput { tick: number, duration, ..Default::default() }
}

/// A tick with commands.
pub fn tick_with(number: u64, duration: f32, commands: Vec<Command>) -> StepInput {
    StepInput { tick: number, duration, commands, ..Default::default() }
}

/// So short that nothing moves in single precision: for looking at the forces of a given state.
pub const INSTANT: f32 = 1e-9;

/// Puts particles where they are wanted; ids must rise.
pub fn place(solver: &mut GpuSolver, ids: &[u32], positions: &[Vec3], velocities: &[Vec3]) {
    let snapshot = Snapshot {
        next_id: ids.iter().max().map_or(0, |id| id + 1),
        gravity: solver.plan().parameters.gravity,
        ids: ids.to_vec(),
        positions: positions.to_vec(),
        velocities: velocities.to_vec(),
        remaining_lives: vec![f32::INFINITY; ids.len()],
        ..Default::default()
    };
    solver.restore(&snapshot).unwrap();
}

/// Numbers that look random, 0 to 1, the same in every run.
pub fn random(index: usize, salt: usize) -> f32 {
    let mut bits =
        (index as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ (salt as u64 + 1).wrapping_mul(0xD1B5_4A32_D192_ED03);
    bits ^= bits >> 31;
    bits = bits.wrapping_mul(0xBF58_476D_1CE4_E5B9);
    bits ^= bits >> 29;
    (bits & 0xFF_FFFF) as f32 / 16_777_216.0
}

/// A vector of such numbers, -1/2 to 1/2.
pub fn random_vector(index: usize, salt: usize) -> Vec3 {
    Vec3::new(random(index, 3 * salt), random(index, 3 * salt + 1), random(index, 3 * salt + 2)) - 0.5
}
