//! Friction of walls.

use serde::{Deserialize, Serialize};

use crate::error::{InvalidInput, check_range};

/// Coulomb's friction between a wall and the fluid that it carries, beside any viscosity (Krog 2010, section 7.1.1.4, with what his
/// eq. 7.2 lacks: the normal force).
///
/// Velocities are those relative to the wall's surface, which may move: as a [belt](super::Boundary::velocity), or with a
/// [body](super::Body::friction) that the fluid does not move. The wall's pressure pushes a particle with the acceleration `n` in a substep. Whatever part of its velocity along the wall an
/// acceleration of up to `at_rest |n|` takes away in the substep, it takes away whole, and the particle sticks; of one that is faster,
/// `sliding |n|` slows it down. So friction never turns a velocity round, and where the fluid does not press there is none. Only
/// particles within the support of a wall's samples feel it: in fluid at rest the first layer. A particle near several bodies feels the friction of
/// that which could hold it the most; of walls it feels the sum, with the mean of their velocities.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Friction {
    /// Coefficient of what sticks, from that of what slides to 10.
    pub at_rest: f32,
    /// Coefficient of what slides, 0 to 10.
    pub sliding: f32,
}

impl Friction {
    /// Both coefficients the same.
    pub fn coulomb(coefficient: f32) -> Self {
        Self { at_rest: coefficient, sliding: coefficient }
    }

    /// Whether there is any.
    pub fn is_some(&self) -> bool {
        self.at_rest > 0.0
    }

    /// Checks both coefficients.
    ///
    /// # Errors
    /// The one that is out of range.
    pub fn validate(&self) -> Result<(), InvalidInput> {
        check_range("sliding", self.sliding, 0.0, 10.0, "")?;
        check_range("at_rest", self.at_rest, self.sliding, 10.0, "")
    }
}
