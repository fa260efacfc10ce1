//! Which fluids touch which bodies.

use bevy::prelude::*;
use freshet_core::error::InvalidInput;

/// Layers, 0 to 31, of a [`FluidBody`](super::body::FluidBody) or of the fluid of a [`FluidDomain`](super::domain::FluidDomain): they touch
/// each other where they have one in common. Without this component they are in layer 0 alone.
///
/// A body that the fluid of its domain does not touch has no samples there: it is not planned and costs nothing, and its
/// [`FluidContact`](super::contact::FluidContact) says that it is in no fluid. Layers may change at any time; a body that comes into
/// fluid by it swells, as one does that is spawned there. What collides with it in rapier stays as it is.
///
/// ```
/// # use bevy_freshet::prelude::*;
/// let (water, ghost) = (FluidLayers::default(), FluidLayers::NONE);
/// assert!(!ghost.touches(water));
/// let fish = FluidLayers::new(&[0, 4])?;
/// assert!(fish.touches(water));
/// # Ok::<(), freshet_core::error::InvalidInput>(())
/// ```
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Hash, Reflect)]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
pub struct FluidLayers {
    /// Bit `n` is layer `n`.
    pub bits: u32,
}

impl Default for FluidLayers {
    fn default() -> Self {
        Self { bits: 1 }
    }
}

impl FluidLayers {
    /// In no layer: touches nothing.
    pub const NONE: Self = Self { bits: 0 };
    /// In all layers: touches everything that is in any.
    pub const ALL: Self = Self { bits: u32::MAX };

    /// So many layers, by their numbers.
    ///
    /// # Errors
    /// A number beyond 31.
    pub fn new(layers: &[u32]) -> Result<Self, InvalidInput> {
        let mut bits = 0;
        for (index, &layer) in layers.iter().enumerate() {
            let bit = 1u32.checked_shl(layer);
            bits |= bit.ok_or_else(|| InvalidInput::new(format_args!("FluidLayers[{index}]"), layer, "0 to 31"))?;
        }
        Ok(Self { bits })
    }

    /// Whether they have a layer in common.
    pub fn touches(self, other: Self) -> bool {
        self.bits & other.bits != 0
    }
}
