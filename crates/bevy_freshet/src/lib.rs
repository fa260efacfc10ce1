//! Particle fluids for Bevy: simulated on the GPU or the CPU, coupled both ways with rapier bodies.
//!
//! Add [`FreshetPlugins`](plugins::FreshetPlugins), spawn a [`FluidDomain`](components::domain::FluidDomain), and give
//! it fluid and walls. `examples/hello_fluid.rs` is the shortest program.
//!
//! - [`components`]: what you spawn, and what you read back.
//! - [`simulation`]: from components to a plan and a stream of ticks, in the fixed schedule.
//! - [`engine`]: where ticks are executed: a worker thread, or the GPU through [`gpu`] in Bevy's render graph.
//! - [`coupling`]: rapier, walls as colliders, and bodies that float.
//! - [`rendering`]: particles as shaded spheres, or as a surface, straight from the solver's buffers.

pub mod components;
pub mod coupling;
pub mod engine;
pub mod gpu;
pub mod plugins;
pub mod rendering;
pub mod simulation;

/// What most programs need; every name begins with `Fluid` or `Freshet`.
pub mod prelude {
    pub use crate::components::body::{FluidBody, FluidBodySampling};
    pub use crate::components::boundary::{FluidBoundary, FluidBoundaryShape, FluidBoundarySide};
    pub use crate::components::boundary_mesh::FluidMesh;
    pub use crate::components::contact::{FluidContact, FluidEntered, FluidLeft};
    pub use crate::components::container::FluidContainer;
    pub use crate::components::domain::{FluidBackend, FluidDomain, FluidMode};
    pub use crate::components::emitter::FluidEmitter;
    pub use crate::components::layers::FluidLayers;
    pub use crate::components::material::Fluid;
    pub use crate::components::membership::{FluidDomainMembers, FluidInDomain};
    pub use crate::components::problem::FluidProblem;
    pub use crate::components::readback::{FluidReadback, FluidReadbackComplete};
    pub use crate::components::scene::FluidSceneCommands;
    pub use crate::components::settings::{
        FluidDensityForm, FluidEquationOfState, FluidFidelity, FluidIntegrator, FluidKernel, FluidPressureForce,
        FluidPressureGradient, FluidPressureSolver, FluidRelaxation, FluidSettings, FluidViscosityModel,
    };
    pub use crate::components::stats::{FluidPassTime, FluidStats};
    pub use crate::components::volume::{FluidShape, FluidVolume};
    pub use crate::components::wall::{FluidFriction, FluidWallMotion};
    pub use crate::components::wall_method::{FluidReflection, FluidWallMethod};
    pub use crate::coupling::FluidCouplingPlugin;
    pub use crate::plugins::FreshetPlugins;
    pub use crate::rendering::FluidRenderPlugin;
    pub use crate::rendering::appearance::{FluidAppearance, FluidColoring, FluidField, FluidStyle};
    pub use crate::rendering::gradient::FluidGradient;
    pub use crate::simulation::FluidSimulationPlugin;
    pub use crate::simulation::sets::FreshetSystems;
}
