//! What walls do to a fluid, as Bevy can reflect it.

use bevy::prelude::*;
use freshet_core::wall_method::{SpringDamper, WallMethod};

/// How the walls of a domain that stand still act on its fluid; formulas, sources and what each is for stand at [`WallMethod`]. Those that
/// [move](super::wall::FluidWallMotion) are in the sums whatever it says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Default, Clone, Debug, PartialEq)]
pub enum FluidWallMethod {
    /// In the sums of the fluid, by volume weights (Akinci et al. 2012). The others are for weakly compressible fluids, and fluid slips along them.
    #[default]
    VolumeWeights,
    /// Forces of Lennard and Jones.
    LennardJones,
    /// Forces after the kernel.
    KernelForcing,
    /// Monaghan's repulsion.
    MonaghanRepulsion,
    /// A damped spring at each face.
    SpringDamper {
        /// rad/s, 1e-3 to 1e6; none takes one by the expected speed.
        frequency: Option<f32>,
        /// 0 to 2.
        damping_ratio: f32,
    },
}

impl From<FluidWallMethod> for WallMethod {
    fn from(method: FluidWallMethod) -> Self {
        match method {
            FluidWallMethod::VolumeWeights => Self::VolumeWeights,
            FluidWallMethod::LennardJones => Self::LennardJones,
            FluidWallMethod::KernelForcing => Self::KernelForcing,
            FluidWallMethod::MonaghanRepulsion => Self::MonaghanRepulsion,
            FluidWallMethod::SpringDamper { frequency, damping_ratio } => {
                Self::SpringDamper(SpringDamper { frequency, damping_ratio })
            }
        }
    }
}

impl From<WallMethod> for FluidWallMethod {
    fn from(method: WallMethod) -> Self {
        match method {
            WallMethod::VolumeWeights => Self::VolumeWeights,
            WallMethod::LennardJones => Self::LennardJones,
            WallMethod::KernelForcing => Self::KernelForcing,
            WallMethod::MonaghanRepulsion => Self::MonaghanRepulsion,
            WallMethod::SpringDamper(SpringDamper { frequency, damping_ratio }) => {
                Self::SpringDamper { frequency, damping_ratio }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use freshet_core::scene::Settings;

    use super::*;
    use crate::components::settings::FluidSettings;

    #[test]
    fn every_method_goes_to_the_model_and_back() {
        for method in WallMethod::ALL {
            let settings = Settings { wall_method: method, ..Settings::default() };
            let mirrored = FluidSettings::from_settings(&settings, 2.0);
            assert_eq!(mirrored.to_settings().wall_method, method);
        }
    }
}
