//! The model of Freshet: what is simulated, as plain data and pure functions.
//!
//! A [`FluidScene`](scene::FluidScene) says what there is; [`Plan::new`](plan::Plan::new) turns it into stages with
//! reasons; a solver ([`FluidSolver`](solver::FluidSolver), in `freshet_cpu` and `freshet_gpu`) executes the plan tick
//! by tick. Nothing here knows an engine, a thread, a GPU or a file.

pub mod configuration;
pub mod density_form;
pub mod emitter;
pub mod equation_of_state;
pub mod error;
pub mod fidelity;
pub mod field;
pub mod geometry;
pub mod grid;
pub mod integrator;
pub mod kernel;
pub mod leaks;
pub mod material;
pub mod misplaced;
pub mod near_pressure;
mod overlap;
pub mod periodic;
pub mod plan;
pub mod position_based;
pub mod pressure_corrected;
pub mod pressure_force;
pub mod pressure_poisson;
pub mod pressure_solver;
pub mod relaxation;
pub mod run;
pub mod sampling;
pub mod scene;
pub mod scene_file;
pub mod snapshot;
pub mod solid;
pub mod solver;
pub mod step;
pub mod swelling;
pub mod tensile_correction;
pub mod variable_support;
pub mod viscosity;
pub mod wall_method;
pub mod work;
pub mod xsph;

/// What most programs need.
pub mod prelude {
    pub use crate::configuration::{CONFIGURATIONS, Configuration};
    pub use crate::density_form::DensityForm;
    pub use crate::emitter::Emitter;
    pub use crate::equation_of_state::EquationOfState;
    pub use crate::error::InvalidInput;
    pub use crate::fidelity::FluidFidelity;
    pub use crate::field::{Field, FieldData};
    pub use crate::geometry::{HeightField, TriangleMesh};
    pub use crate::integrator::Integrator;
    pub use crate::kernel::KernelKind;
    pub use crate::material::Material;
    pub use crate::periodic::Periodic;
    pub use crate::plan::{Plan, SceneError, StageKind};
    pub use crate::position_based::PositionBased;
    pub use crate::pressure_corrected::{PressureCorrected, PressureGradient};
    pub use crate::pressure_force::PressureForce;
    pub use crate::pressure_poisson::PressurePoisson;
    pub use crate::pressure_solver::{DivergenceFree, PressureSolver};
    pub use crate::relaxation::Relaxation;
    pub use crate::run::SceneRun;
    pub use crate::scene::{
        Body, BodySampling, Boundary, BoundaryShape, FluidScene, FluidSide, Friction, Resolution, Settings, Shape,
        Support, Volume,
    };
    pub use crate::snapshot::Snapshot;
    pub use crate::solid::{Solid, SolidShape};
    pub use crate::solver::{FluidSolver, Schedule, SolverError};
    pub use crate::step::{BodyInput, Command, Impulse, NewParticles, StepInput, StepReport};
    pub use crate::viscosity::ViscosityModel;
    pub use crate::wall_method::{Penalty, QuasiFluid, Reflection, SpringDamper, WallMethod};
    pub use glam::{Mat3, Quat, Vec3};
}
