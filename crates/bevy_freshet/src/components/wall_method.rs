//! What walls do to a fluid, as Bevy can reflect it.

use bevy::prelude::*;
use freshet_core::wall_method::{Penalty, QuasiFluid, Reflection, SpringDamper, WallMethod};

/// How the walls of a domain that stand still act on its fluid; formulas, sources and what each is for stand at [`WallMethod`]. Those that
/// [move](super::wall::FluidWallMotion) are in the sums whatever it says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Default, Clone, Debug, PartialEq)]
pub enum FluidWallMethod {
    /// In the sums of the fluid, by volume weights (Akinci et al. 2012). The others are for weakly compressible fluids, and fluid slips along them but for those of
    /// quasi-fluid and images.
    #[default]
    VolumeWeights,
    /// In the sums of the fluid, by three layers of samples with densities and pressures of their own, each counted as a particle.
    QuasiFluid,
    /// The same, each counted with its mass.
    PlainQuasiFluid {
        /// Density of the walls over that of the fluid at rest, 0.1 to 10.
        relative_density: f32,
    },
    /// Mirror images of the fluid behind plane faces; walls of other shapes are refused.
    Ghosts,
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
    /// Collisions with each face after a substep.
    Penalty {
        /// Share of the speed into the wall that comes back, 0 to 1.
        bounce: f32,
        /// Share of the speed along the wall that stays, 0 to 1.
        slip: f32,
        /// Where a particle is put, and how fast it leaves.
        reflection: FluidReflection,
        /// If given, faces whose normal is within 60 degrees of this vector, in the domain's frame, are not there.
        one_way: Option<Vec3>,
    },
}

/// Where a particle is put that got into a wall, and how fast it leaves; see [`Reflection`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Default, Clone, Debug, PartialEq)]
pub enum FluidReflection {
    /// Half a spacing off the face, with all of the speed that bounces.
    #[default]
    Whole,
    /// The same, with less of it the shorter it was in the wall.
    Share,
    /// As far off as it would be if it had bounced at once, which keeps its energy.
    Mirrored,
}

impl From<FluidReflection> for Reflection {
    fn from(reflection: FluidReflection) -> Self {
        match reflection {
            FluidReflection::Whole => Self::Whole,
            FluidReflection::Share => Self::Share,
            FluidReflection::Mirrored => Self::Mirrored,
        }
    }
}

impl From<Reflection> for FluidReflection {
    fn from(reflection: Reflection) -> Self {
        match reflection {
            Reflection::Whole => Self::Whole,
            Reflection::Share => Self::Share,
            Reflection::Mirrored => Self::Mirrored,
        }
    }
}

impl From<FluidWallMethod> for WallMethod {
    fn from(method: FluidWallMethod) -> Self {
        match method {
            FluidWallMethod::VolumeWeights => Self::VolumeWeights,
            FluidWallMethod::QuasiFluid => Self::QuasiFluid(QuasiFluid::Adapted),
            FluidWallMethod::PlainQuasiFluid { relative_density } => {
                Self::QuasiFluid(QuasiFluid::Plain { relative_density })
            }
            FluidWallMethod::Ghosts => Self::Ghosts,
            FluidWallMethod::LennardJones => Self::LennardJones,
            FluidWallMethod::KernelForcing => Self::KernelForcing,
            FluidWallMethod::MonaghanRepulsion => Self::MonaghanRepulsion,
            FluidWallMethod::SpringDamper { frequency, damping_ratio } => {
                Self::SpringDamper(SpringDamper { frequency, damping_ratio })
            }
            FluidWallMethod::Penalty { bounce, slip, reflection, one_way } => {
                Self::Penalty(Penalty { bounce, slip, reflection: reflection.into(), one_way })
            }
        }
    }
}

impl From<WallMethod> for FluidWallMethod {
    fn from(method: WallMethod) -> Self {
        match method {
            WallMethod::VolumeWeights => Self::VolumeWeights,
            WallMethod::QuasiFluid(QuasiFluid::Adapted) => Self::QuasiFluid,
            WallMethod::QuasiFluid(QuasiFluid::Plain { relative_density }) => {
                Self::PlainQuasiFluid { relative_density }
            }
            WallMethod::Ghosts => Self::Ghosts,
            WallMethod::LennardJones => Self::LennardJones,
            WallMethod::KernelForcing => Self::KernelForcing,
            WallMethod::MonaghanRepulsion => Self::MonaghanRepulsion,
            WallMethod::SpringDamper(SpringDamper { frequency, damping_ratio }) => {
                Self::SpringDamper { frequency, damping_ratio }
            }
            WallMethod::Penalty(Penalty { bounce, slip, reflection, one_way }) => {
                Self::Penalty { bounce, slip, reflection: reflection.into(), one_way }
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
