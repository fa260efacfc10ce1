//! How pressure is found, as commands offer it.

use clap::ValueEnum;
use freshet_core::density_form::DensityForm;
use freshet_core::position_based::PositionBased;
use freshet_core::pressure_corrected::PressureCorrected;
use freshet_core::pressure_force::PressureForce;
use freshet_core::pressure_poisson::PressurePoisson;
use freshet_core::pressure_solver::{DivergenceFree, PressureSolver};
use freshet_core::scene::FluidScene;
use freshet_core::viscosity::ViscosityModel;
use freshet_core::wall_method::{QuasiFluid, WallMethod};

/// Value of `--method`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, ValueEnum)]
pub enum Method {
    /// From densities, by Tait's equation of state.
    #[default]
    WeaklyCompressible,
    /// The same with Mueller's form of the pressure force.
    Mueller,
    /// The same as the default with densities that particles carry.
    Continuity,
    /// The same as the default between walls of quasi-fluid.
    QuasiFluidWalls,
    /// Particles moved apart, with the default number of iterations.
    PositionBased,
    /// Pressures corrected by what velocities compress, with the default number of iterations.
    PressureCorrected,
    /// Pressures by a Poisson equation, with its default tolerance.
    Poisson,
    /// DFSPH with its default tolerances.
    DivergenceFree,
    /// DFSPH without any viscosity but water's own, `mu` = 1e-3 Pa s.
    WaterAlone,
}

impl Method {
    /// Each way to find pressures once, with a scene's viscosity.
    pub const ALL: [Self; 2] = [Self::WeaklyCompressible, Self::DivergenceFree];

    /// Name, as in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::WeaklyCompressible => "WCSPH",
            Self::Mueller => "WCSPH, Mueller's force",
            Self::Continuity => "WCSPH, continuity",
            Self::QuasiFluidWalls => "WCSPH, quasi-fluid walls",
            Self::PositionBased => "position-based",
            Self::PressureCorrected => "pressure-corrected",
            Self::Poisson => "pressure Poisson",
            Self::DivergenceFree => "DFSPH",
            Self::WaterAlone => "DFSPH, water's viscosity alone",
        }
    }

    /// What is added to the names of files.
    pub fn suffix(self) -> &'static str {
        match self {
            Self::WeaklyCompressible => "",
            Self::Mueller => "_mueller",
            Self::Continuity => "_continuity",
            Self::QuasiFluidWalls => "_quasi_fluid_walls",
            Self::PositionBased => "_position_based",
            Self::PressureCorrected => "_pressure_corrected",
            Self::Poisson => "_poisson",
            Self::DivergenceFree => "_dfsph",
            Self::WaterAlone => "_water",
        }
    }

    /// Whether pressure follows from density.
    pub fn is_weakly_compressible(self) -> bool {
        matches!(self, Self::WeaklyCompressible | Self::Mueller | Self::Continuity | Self::QuasiFluidWalls)
    }

    /// The option that asks for it, with a space before; nothing for the default.
    pub fn option(self) -> String {
        let is_default = self == Self::default();
        let name = self.to_possible_value().filter(|_| !is_default);
        name.map_or_else(String::new, |name| format!(" --method {}", name.get_name()))
    }

    /// The scene, simulated so.
    pub fn on(self, mut scene: FluidScene) -> FluidScene {
        scene.settings.pressure_solver = match self {
            Self::WeaklyCompressible | Self::Mueller | Self::Continuity | Self::QuasiFluidWalls => {
                PressureSolver::WeaklyCompressible
            }
            Self::PositionBased => PressureSolver::PositionBased(PositionBased::default()),
            Self::PressureCorrected => PressureSolver::PressureCorrected(PressureCorrected::default()),
            Self::Poisson => PressureSolver::PressurePoisson(PressurePoisson::default()),
            Self::DivergenceFree | Self::WaterAlone => PressureSolver::DivergenceFree(DivergenceFree::default()),
        };
        if self == Self::Mueller {
            scene.settings.pressure_force = PressureForce::Mueller;
        }
        if self == Self::Continuity {
            scene.settings.density = DensityForm::Continuity;
        }
        if self == Self::QuasiFluidWalls {
            scene.settings.wall_method = WallMethod::QuasiFluid(QuasiFluid::Adapted);
        }
        if self == Self::WaterAlone {
            scene.settings.artificial_viscosity = 0.0;
            scene.settings.viscosity_model = Some(ViscosityModel::Morris1997);
            scene.material.dynamic_viscosity = 1e-3;
        }
        scene
    }
}
