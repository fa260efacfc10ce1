//! The stages of a substep, and why a scene needs them.

use serde::{Deserialize, Serialize};

use super::sampling::PlannedBody;
use crate::density_form::DensityForm;
use crate::position_based::PositionBased;
use crate::pressure_corrected::{PressureCorrected, PressureGradient};
use crate::pressure_force::PressureForce;
use crate::pressure_poisson::PressurePoisson;
use crate::pressure_solver::PressureSolver;
use crate::scene::FluidScene;
use crate::viscosity::ViscosityModel;
use crate::wall_method::WallMethod;

/// What a substep consists of; a solver may make several passes of a stage or fuse stages.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum StageKind {
    /// Sorts particles by cell, and by id within a cell; those retired or removed fall out.
    Sort,
    /// Moves the bodies' samples to where the bodies are and sorts them by cell.
    BodySort,
    /// How wide the support of each particle is.
    Support,
    /// Density sum and pressure.
    Density,
    /// Moves particles apart where they would be too dense without pressure, and their velocities with them.
    PositionSolve,
    /// Density and pressure of the bodies' samples.
    BodyDensity,
    /// Density and pressure of the walls' samples; what images of the fluid in the walls add to its densities.
    WallDensity,
    /// Acceleration by pressure, viscosity and gravity.
    Acceleration,
    /// What walls push by forces of their own.
    WallForce,
    /// How fluid sticks to bodies and drags them along.
    BodyDrag,
    /// Force and torque of the fluid on each body.
    BodyLoad,
    /// Chooses the substep.
    StepControl,
    /// Finds the pressures with which velocities do not compress the fluid.
    DivergenceSolve,
    /// What walls with friction take of velocities along them.
    Friction,
    /// What bodies with friction take of velocities along them.
    BodyFriction,
    /// How much faster or slower than with their own velocity particles move, for the mean velocity around them.
    Xsph,
    /// Moves particles apart where the fluid is compressed.
    DensitySolve,
    /// Moves the bodies by the fluid's force over the substep.
    BodyMotion,
    /// Moves the particles.
    Integrate,
    /// Puts particles back that got into walls.
    WallCollision,
}

impl StageKind {
    /// Name, as in file names of both solvers.
    pub fn name(self) -> &'static str {
        match self {
            StageKind::Sort => "sort",
            StageKind::BodySort => "body_sort",
            StageKind::Support => "support",
            StageKind::Density => "density",
            StageKind::PositionSolve => "position_solve",
            StageKind::BodyDensity => "body_density",
            StageKind::WallDensity => "wall_density",
            StageKind::Acceleration => "acceleration",
            StageKind::WallForce => "wall_force",
            StageKind::BodyDrag => "body_drag",
            StageKind::BodyLoad => "body_load",
            StageKind::StepControl => "step_control",
            StageKind::DivergenceSolve => "divergence_solve",
            StageKind::Friction => "friction",
            StageKind::BodyFriction => "body_friction",
            StageKind::Xsph => "xsph",
            StageKind::DensitySolve => "density_solve",
            StageKind::BodyMotion => "body_motion",
            StageKind::Integrate => "integrate",
            StageKind::WallCollision => "wall_collision",
        }
    }
}

/// A stage, and why the scene needs it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stage {
    /// Which.
    pub kind: StageKind,
    /// Why it is there.
    pub reason: String,
}

/// Only what the scene needs, in order.
pub(super) fn stages(scene: &FluidScene, walls: bool, bodies: &[PlannedBody]) -> Vec<Stage> {
    let mut stages = Vec::new();
    let mut add = |kind, reason: &str| stages.push(Stage { kind, reason: reason.to_owned() });
    add(StageKind::Sort, "particles have neighbours, which are searched in cells of the support radius");
    if !bodies.is_empty() {
        add(StageKind::BodySort, "the scene has bodies, which move");
    }
    if scene.settings.widest_support > 1.0 {
        let widest = scene.settings.widest_support;
        add(
            StageKind::Support,
            &format!(
                "settings.widest_support is {widest}: where the fluid is thin supports are wider, up to so many times"
            ),
        );
    }
    let incompressible = match scene.settings.pressure_solver {
        PressureSolver::DivergenceFree(solver) => Some(solver),
        _ => None,
    };
    let by_positions = match scene.settings.pressure_solver {
        PressureSolver::PositionBased(PositionBased { iterations, .. }) => {
            Some(format!("the fluid is moved apart {iterations} times, and velocities with it (position-based)"))
        }
        PressureSolver::PressureCorrected(PressureCorrected { iterations, gradient }) => Some(format!(
            "pressures and velocities are corrected {iterations} times, by {} of pressures (pressure-corrected)",
            match gradient {
                PressureGradient::Sum => "sums",
                PressureGradient::Difference => "differences",
            }
        )),
        PressureSolver::PressurePoisson(PressurePoisson { tolerance, max_iterations }) => Some(format!(
            "pressures undo what is too dense (Poisson equation), to {tolerance} of it; at most {max_iterations} iterations"
        )),
        PressureSolver::WeaklyCompressible | PressureSolver::DivergenceFree(_) => None,
    };
    let method = scene.settings.wall_method;
    let others = match (walls && method.is_in_sums(), bodies.is_empty()) {
        (false, true) => "fluid only",
        (true, true) => "fluid and walls",
        (false, false) => "fluid and bodies",
        (true, false) => "fluid, walls and bodies",
    };
    let density = match (incompressible, scene.settings.density) {
        _ if by_positions.is_some() => "densities where particles would be without pressure",
        (None, DensityForm::Summation) => "pressure follows from density (weakly compressible)",
        (None, DensityForm::Adapted) => {
            "pressure follows from number density, which is density with particles of one mass"
        }
        (None, DensityForm::Continuity) => "pressure follows from density, which particles carry and the flow changes",
        (None, DensityForm::AdaptedContinuity) => {
            "pressure follows from number density, which particles carry and the flow changes"
        }
        (Some(_), _) => "densities, and what each pressure changes of them",
    };
    add(StageKind::Density, &format!("{density}; {others}"));
    if let Some(what) = &by_positions {
        add(StageKind::PositionSolve, what);
    }
    if bodies.iter().any(|body| !body.own_densities.is_empty()) {
        add(StageKind::BodyDensity, "bodies are sampled by quasi-fluid, which has densities and pressures of its own");
    }
    if walls && matches!(method, WallMethod::QuasiFluid(_)) {
        let name = method.name();
        let what = format!("settings.wall_method is {name}: walls have densities and pressures of their own");
        add(StageKind::WallDensity, &what);
    }
    if walls && method == WallMethod::Ghosts {
        let name = method.name();
        add(
            StageKind::WallDensity,
            &format!("settings.wall_method is {name}: images of the fluid stand in its densities"),
        );
    }
    let pressure = match (incompressible, scene.settings.pressure_force) {
        _ if by_positions.is_some() => "no pressure",
        (Some(_), _) => "pressure of the last substep",
        (None, PressureForce::Monaghan) => "pressure",
        (None, PressureForce::Mueller) => "pressure by Mueller's form",
    };
    let rest = match (scene.settings.artificial_viscosity > 0.0, scene.physical_viscosity()) {
        (true, None) => ", artificial viscosity and gravity",
        (false, None) => " and gravity; settings.artificial_viscosity is 0",
        (true, Some(_)) => ", artificial viscosity, the material's viscosity and gravity",
        (false, Some(_)) => ", the material's viscosity and gravity",
    };
    let settings = &scene.settings;
    let of_terms = [("pressure", settings.pressure_kernel), ("viscosity", settings.viscosity_kernel)];
    let of_terms: String = of_terms
        .into_iter()
        .filter_map(|(term, kernel)| kernel.map(|kernel| format!("; settings.{term}_kernel is {}", kernel.name())))
        .collect();
    add(StageKind::Acceleration, &format!("{pressure}{rest}{of_terms}"));
    if walls && method.is_force() {
        let name = method.name();
        add(
            StageKind::WallForce,
            &format!("settings.wall_method is {name}: walls push by it alone, and fluid slips along them"),
        );
    }
    if walls && method == WallMethod::Ghosts {
        let name = method.name();
        add(
            StageKind::WallForce,
            &format!("settings.wall_method is {name}: images of the fluid push and drag as it does"),
        );
    }
    if let Some(model) = scene.physical_viscosity().filter(|_| !bodies.is_empty()) {
        add(StageKind::BodyDrag, &format!("fluid sticks to bodies by the material's viscosity ({})", model.name()));
    }
    if !bodies.is_empty() {
        add(StageKind::BodyLoad, "the scene has bodies, which the fluid pushes");
    }
    add(
        StageKind::StepControl,
        match incompressible {
            None if by_positions.is_some() => "substeps adapt to the fastest particle",
            None => "substeps adapt to the fastest particle and the largest acceleration",
            Some(_) => "substeps adapt to the fastest particle and the largest pressure",
        },
    );
    if let Some(solver) = incompressible {
        let most = solver.max_iterations;
        let answer = if bodies.is_empty() { "" } else { ", in which bodies answer" };
        let divergence = format!(
            "velocities compress nothing, to {} a substep on average; at most {most} iterations{answer}",
            solver.divergence
        );
        add(StageKind::DivergenceSolve, &divergence);
    }
    if scene.boundaries.iter().any(|boundary| boundary.friction.is_some()) {
        add(StageKind::Friction, "boundaries have friction, which holds or slows what they carry");
    }
    if scene.bodies.iter().any(|body| body.friction.is_some()) {
        add(StageKind::BodyFriction, "bodies have friction, which holds or slows what they carry, or drags it along");
    }
    if scene.settings.xsph > 0.0 {
        let share = scene.settings.xsph;
        add(
            StageKind::Xsph,
            &format!("settings.xsph is {share}: particles move with a share of the velocity around them"),
        );
    }
    if let Some(solver) = incompressible {
        let most = solver.max_iterations;
        let density = format!(
            "positions are corrected to a mean compression of {}; at most {most} iterations",
            solver.compression
        );
        add(StageKind::DensitySolve, &density);
    }
    if !bodies.is_empty() {
        add(StageKind::BodyMotion, "bodies answer within the tick");
    }
    let integrator = scene.settings.integrator;
    let repeats = if scene.periodic.any() { "; the domain repeats itself" } else { "" };
    let what = integrator.in_solvers().unwrap_or_default();
    add(StageKind::Integrate, &format!("{}: {what}{repeats}", integrator.name()));
    if walls && method.collides() {
        let name = method.name();
        let what = match method {
            WallMethod::Ghosts => "walls put back what has no pressure against its own image",
            _ => "walls put back what got into them, and do nothing else",
        };
        add(StageKind::WallCollision, &format!("settings.wall_method is {name}: {what}"));
    }
    stages
}

impl FluidScene {
    /// The model by which the material's viscosity acts, if it has both.
    pub(super) fn physical_viscosity(&self) -> Option<ViscosityModel> {
        self.settings.viscosity_model.filter(|_| self.material.dynamic_viscosity > 0.0)
    }
}
