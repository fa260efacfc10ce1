//! Collisions with the faces of walls, after particles have moved (Pirovano 2011, section 3.5.1).

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::Plane;
use crate::error::{InvalidInput, check_finite, check_range};

/// What happens to a particle that is nearer to a face than half a spacing, by `s`, after a substep: it is put back, and what of its velocity goes
/// into the wall comes back times [`bounce`](Self::bounce), what goes along times [`slip`](Self::slip). Where it stands is changed without any
/// force, and so are the sums of its neighbours: that is what the method is rough by. Nothing happens in no time.
///
/// The face is that of the [springs](super::SpringDamper). In an edge faces act one after the other, the nearest first.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Penalty {
    /// Share of the speed into the wall that comes back, 0 to 1.
    pub bounce: f32,
    /// Share of the speed along the wall that stays, 0 (no slip) to 1 (free slip).
    pub slip: f32,
    /// Where it is put, and how fast it leaves.
    pub reflection: Reflection,
    /// Direction control: what moves along this vector is stopped, and faces that could only stop what moves against it are not there: those whose normal is within 60
    /// degrees of it. For water in a closed box whose ceiling is not there for what rises: the direction of gravity. Upright walls and the floor hold as without. Any length but zero.
    pub one_way: Option<Vec3>,
}

/// Where a particle is put that got into a wall, and how fast it leaves. `dt` is the substep, `v_N` its velocity across the face.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Reflection {
    /// Half a spacing off the face, with all of the speed that bounces: the rest of its way is lost.
    #[default]
    Whole,
    /// The same, with the share `s/(|v_N| dt)` of that speed, which is the part of the substep that it spent in the wall (Kelager 2006; P divides by
    /// `|v|`, which is that of a particle that comes straight): it never gains, and loses two thirds of its energy on average.
    Share,
    /// It goes that share of the substep back with the speed that bounces: to `bounce s` before where the others put it. This is what conserves energy.
    Mirrored,
}

impl Penalty {
    /// Nothing bounces, all slips.
    pub const DEFAULT: Self = Self { bounce: 0.0, slip: 1.0, reflection: Reflection::Whole, one_way: None };
    /// All bounces, by the share that the source has for energy.
    pub const SHARE: Self = Self { bounce: 1.0, reflection: Reflection::Share, ..Self::DEFAULT };
    /// All bounces, and energy is kept.
    pub const MIRRORED: Self = Self { bounce: 1.0, reflection: Reflection::Mirrored, ..Self::DEFAULT };

    /// Place and velocity of a particle after a substep of `dt` seconds that ended so close to some faces, half a spacing being `contact` metres.
    pub fn collide(&self, position: &mut Vec3, velocity: &mut Vec3, planes: &[Plane], contact: f32, dt: f32) {
        if dt <= 0.0 {
            return;
        }
        let (start, way) = (*position, self.way());
        for plane in planes {
            let normal = plane.normal;
            let depth = contact - plane.distance - (*position - start).dot(normal);
            if depth <= 0.0 || way.dot(normal) > 1.0 {
                continue;
            }
            let across = velocity.dot(normal);
            let mut back = depth;
            if across < 0.0 {
                let along = *velocity - across * normal;
                let mut leaving = -self.bounce * across;
                match self.reflection {
                    Reflection::Whole => {}
                    Reflection::Share => leaving *= depth / (-across * dt).max(depth),
                    Reflection::Mirrored => back *= 1.0 + self.bounce,
                }
                *velocity = self.slip * along + leaving * normal;
            }
            *position += back * normal;
        }
    }

    /// The [direction](Self::one_way), so long that its product with the normal of a face that is not there is above one; zero without.
    pub fn way(&self) -> Vec3 {
        /// Cosine of 60 degrees.
        const OPEN: f64 = 0.5;
        self.one_way.map_or(Vec3::ZERO, |way| (way.as_dvec3().normalize() / OPEN).as_vec3())
    }

    pub(super) fn validate(&self) -> Result<(), InvalidInput> {
        check_range("bounce", self.bounce, 0.0, 1.0, "")?;
        check_range("slip", self.slip, 0.0, 1.0, "")?;
        if let Some(way) = self.one_way {
            check_finite("one_way", way)?;
            if way == Vec3::ZERO {
                return Err(InvalidInput::new("one_way", way, "a vector longer than zero, or none"));
            }
        }
        Ok(())
    }
}

impl Default for Penalty {
    fn default() -> Self {
        Self::DEFAULT
    }
}
