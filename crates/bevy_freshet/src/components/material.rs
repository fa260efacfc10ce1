//! What a fluid is made of.

use bevy::prelude::*;
use freshet_core::material::Material;

/// What a fluid is made of; stands beside a [`FluidVolume`](super::volume::FluidVolume) or
/// [`FluidEmitter`](super::emitter::FluidEmitter). All fluid of one domain is of one kind.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component, Clone, Debug, PartialEq)]
pub struct Fluid {
    /// Shown in panels and reports; not empty.
    pub name: String,
    /// Density without pressure, kg/m3, 0.001 to 50,000.
    pub rest_density: f32,
    /// Dynamic viscosity, Pa s, 0 to 1e6. It acts as the [viscosity model](super::settings::FluidSettings::viscosity_model) says, and
    /// not at all without one.
    pub dynamic_viscosity: f32,
}

impl Fluid {
    /// Water: 1000 kg/m3.
    pub fn water() -> Self {
        Material::water().into()
    }

    /// Olive oil: 914 kg/m3.
    pub fn oil() -> Self {
        Material::oil().into()
    }

    /// The same as the model knows it.
    pub(crate) fn to_material(&self) -> Material {
        let Self { name, rest_density, dynamic_viscosity } = self.clone();
        Material { name, rest_density, dynamic_viscosity }
    }
}

impl Default for Fluid {
    fn default() -> Self {
        Self::water()
    }
}

impl From<Material> for Fluid {
    fn from(material: Material) -> Self {
        let Material { name, rest_density, dynamic_viscosity } = material;
        Self { name, rest_density, dynamic_viscosity }
    }
}
