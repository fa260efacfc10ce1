//! How a fluid looks.

use bevy::prelude::*;
use freshet_core::field::Field;

use super::gradient::FluidGradient;

/// How the particles of a domain are drawn; stands on the domain.
///
/// To hide a fluid, use Bevy's `Visibility` on the domain.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
pub struct FluidAppearance {
    /// Radius of a particle's sphere over the spacing, 0.05 to 2. At 0.62 spheres of a rested fluid overlap enough to
    /// close the surface. Outside, the nearest allowed value is used.
    pub radius: f32,
    /// What the colours mean.
    pub coloring: FluidColoring,
    /// What is made of the spheres.
    pub style: FluidStyle,
    /// Whether what is drawn lies between ticks, as far as the fixed step has got. Off draws the last tick as it is.
    pub interpolate: bool,
}

impl Default for FluidAppearance {
    fn default() -> Self {
        Self { radius: 0.62, coloring: FluidColoring::default(), style: FluidStyle::default(), interpolate: true }
    }
}

/// What is made of the spheres of a fluid's particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Default, Clone, Debug, PartialEq)]
pub enum FluidStyle {
    /// Each is drawn, opaque: every particle can be seen.
    #[default]
    Spheres,
    /// A surface around all of them, through which the scene is seen, refracted and tinted, and in which the sky is mirrored. Opaque
    /// meshes are seen through it; what is blended, such as glass, is drawn over it. Takes seven passes over the screen.
    Surface {
        /// Thickness that lets a third of the light through, m, 0.001 to 1000; white foam lets less through.
        clarity: f32,
        /// How far bumps are smoothed over the radius of a sphere, 0 to 20.
        smoothing: f32,
    },
}

impl FluidStyle {
    /// A surface of water that is clear for half a metre.
    pub fn water() -> Self {
        Self::Surface { clarity: 0.5, smoothing: 3.0 }
    }
}

/// Colours particles by a field.
#[derive(Clone, Debug, PartialEq, Reflect)]
#[reflect(Default, Clone, Debug, PartialEq)]
pub struct FluidColoring {
    /// Which. Of vectors it is the length; of the position, the height; of ids, a random colour for each.
    pub field: FluidField,
    /// Which colours.
    pub gradient: FluidGradient,
    /// The values of the first and the last colour, in the field's unit; none derives them from the scene.
    pub range: Option<(f32, f32)>,
}

impl Default for FluidColoring {
    fn default() -> Self {
        Self { field: FluidField::Speed, gradient: FluidGradient::Water, range: None }
    }
}

/// A registered field of the particles; units and meaning stand at [`Field`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Default, Clone, Debug, PartialEq)]
pub enum FluidField {
    /// Stable number.
    Id,
    /// Position, m.
    Position,
    /// Velocity, m/s.
    Velocity,
    /// Density, kg/m3.
    Density,
    /// Pressure, Pa.
    Pressure,
    /// Acceleration, m/s2.
    Acceleration,
    /// Magnitude of the velocity, m/s.
    #[default]
    Speed,
    /// Time until the particle is retired, s.
    RemainingLife,
}

impl From<FluidField> for Field {
    fn from(field: FluidField) -> Self {
        match field {
            FluidField::Id => Self::Id,
            FluidField::Position => Self::Position,
            FluidField::Velocity => Self::Velocity,
            FluidField::Density => Self::Density,
            FluidField::Pressure => Self::Pressure,
            FluidField::Acceleration => Self::Acceleration,
            FluidField::Speed => Self::Speed,
            FluidField::RemainingLife => Self::RemainingLife,
        }
    }
}

impl From<Field> for FluidField {
    fn from(field: Field) -> Self {
        match field {
            Field::Id => Self::Id,
            Field::Position => Self::Position,
            Field::Velocity => Self::Velocity,
            Field::Density => Self::Density,
            Field::Pressure => Self::Pressure,
            Field::Acceleration => Self::Acceleration,
            Field::Speed => Self::Speed,
            Field::RemainingLife => Self::RemainingLife,
        }
    }
}
