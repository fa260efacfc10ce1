//! Materials: what a fluid is made of, and presets with their sources.

use serde::{Deserialize, Serialize};

use crate::error::{InvalidInput, check_range};

/// What a fluid is made of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Shown in panels and charts; not empty.
    pub name: String,
    /// Density without pressure, in kg/m3, 0.001 to 50000. It sets the mass of a particle.
    pub rest_density: f32,
    /// Dynamic viscosity in Pa s, 0 to 1e6.
    ///
    /// Read by the viscosity models: until one is chosen
    /// ([`Settings::viscosity_model`](crate::scene::Settings::viscosity_model)), this number changes nothing, and honey flows
    /// as water.
    pub dynamic_viscosity: f32,
}

impl Material {
    /// The names that [`Material::preset`] knows.
    pub const PRESETS: [&'static str; 7] = ["water", "oil", "honey", "mud", "lava", "mercury", "glycerin"];

    /// Water at about 20 C: 1000 kg/m3, 1.0e-3 Pa s.
    ///
    /// Measured: 998.2 kg/m3 and 1.0016 mPa s at 20 C (IAPWS 2008). Rounded so that a litre weighs a kilogram.
    pub fn water() -> Self {
        Self::new("water", 1000.0, 1.0e-3)
    }

    /// Olive oil at 20 C: 914 kg/m3, 0.084 Pa s (CRC Handbook of Chemistry and Physics, viscosity of liquids).
    pub fn oil() -> Self {
        Self::new("oil", 914.0, 0.084)
    }

    /// Liquid honey at 20 to 25 C: 1420 kg/m3, 10 Pa s.
    ///
    /// Juszczak & Fortuna 2006 (J. Food Eng. 75, 43) measured 1.8 to 250 Pa s between 40 and 10 C at 15 to 18 % water:
    /// Newtonian, and very dependent on both.
    pub fn honey() -> Self {
        Self::new("honey", 1420.0, 10.0)
    }

    /// Mud with a solids share of 0.36: 1600 kg/m3, 10 Pa s.
    ///
    /// The density is that of water with grains of 2650 kg/m3. The viscosity is the plastic one of a natural mudflow matrix
    /// (O'Brien & Julien 1988, J. Hydraul. Eng. 114, 877), which changes a thousandfold between shares of 0.1 and 0.4. Real
    /// mud has a yield stress too, which a constant viscosity lacks.
    pub fn mud() -> Self {
        Self::new("mud", 1600.0, 10.0)
    }

    /// Basaltic lava as it erupts, at 1050 to 1200 C: 2730 kg/m3, 300 Pa s.
    ///
    /// Macdonald 1963 (GSA Bulletin 74, 1071), Hawaii: 2000 to 4000 poise, specific gravity 2.73 below the level at which gas
    /// bubbles form.
    pub fn lava() -> Self {
        Self::new("lava", 2730.0, 300.0)
    }

    /// Mercury at 25 C: 13534 kg/m3, 1.526e-3 Pa s (CRC Handbook of Chemistry and Physics).
    pub fn mercury() -> Self {
        Self::new("mercury", 13_534.0, 1.526e-3)
    }

    /// Glycerin, pure, at 20 C: 1261 kg/m3, 1.41 Pa s (Segur & Oberstar 1951, Ind. Eng. Chem. 43, 2117).
    pub fn glycerin() -> Self {
        Self::new("glycerin", 1261.0, 1.41)
    }

    /// The preset of that name; the names are [`Material::PRESETS`], in lower case.
    ///
    /// # Errors
    /// If there is none; the error lists those there are.
    pub fn preset(name: &str) -> Result<Self, InvalidInput> {
        Self::presets()
            .into_iter()
            .find(|material| material.name == name)
            .ok_or_else(|| InvalidInput::new("material", name, format_args!("one of {}", Self::PRESETS.join(", "))))
    }

    /// Every preset, in the order of [`Material::PRESETS`].
    pub fn presets() -> Vec<Self> {
        vec![Self::water(), Self::oil(), Self::honey(), Self::mud(), Self::lava(), Self::mercury(), Self::glycerin()]
    }

    /// Checks every field against the range in its documentation.
    ///
    /// # Errors
    /// Names the first field out of range.
    pub fn validate(&self) -> Result<(), InvalidInput> {
        if self.name.trim().is_empty() {
            return Err(InvalidInput::new("name", "(empty)", "a name"));
        }
        check_range("rest_density", self.rest_density, 0.001, 50_000.0, "kg/m3")?;
        check_range("dynamic_viscosity", self.dynamic_viscosity, 0.0, 1.0e6, "Pa s")
    }

    fn new(name: &str, rest_density: f32, dynamic_viscosity: f32) -> Self {
        Self { name: name.to_owned(), rest_density, dynamic_viscosity }
    }
}
