//! How pressure is found, as commands offer it.

use clap::ValueEnum;
use freshet_core::pressure_solver::{DivergenceFree, PressureSolver};
use freshet_core::scene::FluidScene;

/// Value of `--method`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, ValueEnum)]
pub enum Method {
    /// From densities, by Tait's equation of state.
    #[default]
    WeaklyCompressible,
    /// DFSPH with its default tolerances.
    DivergenceFree,
}

impl Method {
    /// Both.
    pub const ALL: [Self; 2] = [Self::WeaklyCompressible, Self::DivergenceFree];

    /// Name, as in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::WeaklyCompressible => "WCSPH",
            Self::DivergenceFree => "DFSPH",
        }
    }

    /// What is added to the names of files.
    pub fn suffix(self) -> &'static str {
        match self {
            Self::WeaklyCompressible => "",
            Self::DivergenceFree => "_dfsph",
        }
    }

    /// The scene, simulated so.
    pub fn on(self, mut scene: FluidScene) -> FluidScene {
        scene.settings.pressure_solver = match self {
            Self::WeaklyCompressible => PressureSolver::WeaklyCompressible,
            Self::DivergenceFree => PressureSolver::DivergenceFree(DivergenceFree::default()),
        };
        scene
    }
}
