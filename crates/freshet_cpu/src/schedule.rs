//! Lowering: which passes the plan's stages become on the CPU, and what memory they hold.

use freshet_core::kernel::KernelKind;
use freshet_core::plan::{Plan, StageKind};
use freshet_core::pressure_solver::PressureSolver;
use freshet_core::solver::{Schedule, ScheduledBuffer, ScheduledPass, SolverError};

/// The passes of a plan, without buffers (their sizes follow the particles).
///
/// # Errors
/// If a method of the plan does not exist on the CPU.
pub fn lower(plan: &Plan) -> Result<Vec<ScheduledPass>, SolverError> {
    if [plan.parameters.kernel, plan.parameters.pressure_kernel].contains(&KernelKind::Viscosity) {
        return Err(SolverError::Unsupported {
            backend: "cpu",
            what: "the viscosity kernel for density and pressure".to_owned(),
            reason: "it has a Laplacian only; choose another kernel".to_owned(),
        });
    }
    Ok(plan.stages.iter().map(|stage| pass(plan, stage.kind)).collect())
}

fn pass(plan: &Plan, stage: StageKind) -> ScheduledPass {
    let viscous = plan.parameters.artificial_viscosity > 0.0 || plan.parameters.dynamic_viscosity > 0.0;
    let width = if plan.has(StageKind::Support) { 4 } else { 0 };
    // What the integrator keeps, read and written.
    let kept = 2 * 4 * plan.parameters.integrator.words() as u32;
    // What is carried beside it, likewise.
    let carried = if plan.parameters.density.is_carried() { 2 * 4 } else { 0 };
    let bytes_per_particle = match stage {
        // Key and order written and read, 32 bytes read and written.
        StageKind::Sort => 4 * 4 + 2 * 32 + kept + carried,
        // Position read, density and pressure term or diagonal written.
        // Carried, besides: velocity read, excess read and written.
        StageKind::Density => 12 + 8 + width + if plan.parameters.density.is_carried() { 12 + 8 } else { 0 },
        // Of one iteration of a Poisson equation: position, way, push, density, diagonal and last step read, push and step written.
        StageKind::PositionSolve if matches!(plan.parameters.pressure_solver, PressureSolver::PressurePoisson(_)) => {
            12 + 12 + 16 + 8
        }
        // Of one iteration: position read, density and diagonal written; position and push read, position written; and the sum of pushes.
        StageKind::PositionSolve => 12 + 8 + 16 + 12 + 8,
        // Position read, width written.
        StageKind::Support => 12 + 4,
        // Position and pressure term read, with viscosity also velocity and density; acceleration written.
        StageKind::Acceleration => 12 + 4 + if viscous || width > 0 { 16 } else { 0 } + width + 12,
        // Of one iteration: position and change of pressure read, acceleration written; position and acceleration read, four
        // values of the iteration read, four written.
        StageKind::DivergenceSolve | StageKind::DensitySolve => 16 + 12 + 24 + 16 + 16,
        // Those beside bodies or walls only.
        StageKind::BodyDensity | StageKind::WallDensity | StageKind::BodyDrag | StageKind::BodyFriction => 0,
        // Position and pressure term read near the bodies.
        StageKind::BodyLoad => 16,
        // Position, velocity and acceleration read, position and velocity written.
        StageKind::Integrate => 36 + 24 + kept,
        // Velocity and acceleration read, velocity written; position, velocity and density read, what moves it written.
        StageKind::Xsph => 36 + 28 + 12 + kept / 2,
        // Those beside walls only.
        StageKind::WallForce | StageKind::WallCollision | StageKind::Friction => 0,
        StageKind::BodySort | StageKind::StepControl | StageKind::BodyMotion => 0,
    };
    ScheduledPass { stage, name: stage.name(), bytes_per_particle }
}

/// A buffer of the schedule.
pub fn buffer(name: &'static str, bytes: u64, per_particle: bool) -> ScheduledBuffer {
    ScheduledBuffer { name, bytes, per_particle }
}

/// The whole schedule.
pub fn schedule(passes: Vec<ScheduledPass>, buffers: Vec<ScheduledBuffer>, capacity: u32) -> Schedule {
    Schedule { backend: "cpu", passes, buffers, capacity }
}
