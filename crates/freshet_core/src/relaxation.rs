//! Particles settle before the start (Pirovano 2011, section 4.1.6): a lattice that a curved wall cuts leaves gaps and crowds, which
//! otherwise show in the first tenths of a second as noise.
//!
//! The fluid moves by itself, with walls as they are, no velocities to begin with and an artificial viscosity of 1, until its fastest
//! particle was slower than asked for three times in a row, or for as long as allowed. No time passes: the simulation begins at 0 s with
//! the velocities that the scene gives. Source: "no gravity force is added and the viscosity coefficient is greatly increased. The real
//! simulation begins when the maximum velocity of any particle in the fluid is less than a given threshold for at least three
//! simulation steps."

use serde::{Deserialize, Serialize};

use crate::error::{InvalidInput, check_range};
use crate::integrator::Integrator;
use crate::plan::{Plan, StageKind};
use crate::snapshot::Snapshot;
use crate::solver::{FluidSolver, SolverError};
use crate::step::StepInput;
use glam::Vec3;

/// When particles have settled.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Relaxation {
    /// They have when the fastest is slower than this share of the expected speed, 1e-6 to 1.
    pub calm: f32,
    /// Most substeps, 1 to 1,000,000; then the start is as they are, and the plan's notes say so.
    pub max_substeps: u32,
    /// Whether they settle under gravity. Without, as in the source, what lies on a wall falls on it later, and a
    /// [hydrostatic](crate::scene::Volume::hydrostatic) start is undone.
    pub under_gravity: bool,
}

impl Default for Relaxation {
    fn default() -> Self {
        Self { calm: 1e-3, max_substeps: 5000, under_gravity: false }
    }
}

/// Artificial viscosity, the most that settings allow.
const VISCOSITY: f32 = 1.0;

/// Substeps between two looks at the fastest particle.
const STRIDE: u32 = 4;

impl Relaxation {
    pub(crate) fn validate(&self) -> Result<(), InvalidInput> {
        check_range("calm", self.calm, 1e-6, 1.0, "times the expected speed")?;
        if !(1..=1_000_000).contains(&self.max_substeps) {
            return Err(InvalidInput::new("max_substeps", self.max_substeps, "1 to 1000000"));
        }
        Ok(())
    }

    /// The plan by which particles settle.
    fn plan(&self, plan: &Plan) -> Plan {
        let mut settling = Plan { relaxation: None, budget_milliseconds: None, ..plan.clone() };
        settling.stages.retain(|stage| !matches!(stage.kind, StageKind::Friction | StageKind::Xsph));
        settling.parameters.xsph = 0.0;
        settling.parameters.artificial_viscosity = VISCOSITY;
        settling.parameters.redo_substeps = false;
        settling.parameters.integrator = Integrator::default();
        settling.parameters.max_substeps = STRIDE;
        settling
    }
}

/// Lets the particles of a solver that has just started settle, if its plan asks for it; for backends. What came of it is among the
/// notes of the solver's plan then.
///
/// # Errors
/// Those of the solver.
pub fn relax(solver: &mut impl FluidSolver) -> Result<(), SolverError> {
    let Some(relaxation) = solver.plan().relaxation else { return Ok(()) };
    let mut plan = solver.plan().clone();
    let start = solver.snapshot()?;
    if start.ids.is_empty() {
        return Ok(());
    }
    solver.reconfigure(relaxation.plan(&plan))?;
    let still = Snapshot { velocities: vec![Vec3::ZERO; start.ids.len()], ..start.clone() };
    let gravity = if relaxation.under_gravity { start.gravity } else { Vec3::ZERO };
    solver.restore(&Snapshot { gravity, ..still })?;
    let asked = relaxation.calm * plan.parameters.expected_speed;
    let (mut substeps, mut time, mut calm, mut fastest) = (0, 0.0, 0, f32::INFINITY);
    for tick in 0.. {
        if calm == 3 || substeps >= relaxation.max_substeps {
            break;
        }
        let report = solver.step(&StepInput { tick, duration: StepInput::MAX_DURATION, ..StepInput::default() })?;
        substeps += report.substeps.max(1);
        time += report.simulated;
        fastest = report.max_speed;
        calm = if fastest < asked { calm + 1 } else { 0 };
    }
    let end = solver.snapshot()?;
    let reached = if calm == 3 { "below" } else { "not below" };
    plan.notes.push(format!(
        "relaxation: particles settled in {substeps} substeps, {time:.3} s of their own; the fastest ended with {fastest:.2e} m/s, \
         {reached} {asked:.2e}"
    ));
    solver.reconfigure(plan)?;
    solver.restore(&begin(&start, end, relaxation.under_gravity))
}

/// The start with particles where they ended; those that left the bounds are gone.
fn begin(start: &Snapshot, end: Snapshot, under_gravity: bool) -> Snapshot {
    let place = |id: &u32| start.ids.binary_search(id).ok();
    let of_start = |values: &[f32]| end.ids.iter().filter_map(|id| values.get(place(id)?).copied()).collect();
    Snapshot {
        velocities: end.ids.iter().filter_map(|id| Some(start.velocities[place(id)?])).collect(),
        remaining_lives: of_start(&start.remaining_lives),
        pressures: if under_gravity { end.pressures } else { of_start(&start.pressures) },
        positions: end.positions,
        ids: end.ids,
        ..start.clone()
    }
}
