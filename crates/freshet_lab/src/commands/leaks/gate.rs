//! Surfaces that no particle may go through, and whether one did.

use glam::Vec3;

/// A surface in the frame of what it belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Gate {
    /// A rectangle in the plane of the local x and z axes.
    Rectangle {
        /// Half its edge lengths, m.
        half_extents: [f32; 2],
    },
    /// Side and bottom of a cylinder about the local y axis.
    Cup {
        /// m.
        radius: f32,
        /// Where the bottom is along y, m.
        bottom: f32,
        /// Where the side ends along y, m.
        rim: f32,
    },
    /// A sphere below a height.
    Bowl {
        /// m.
        radius: f32,
        /// Where it ends along y, m.
        rim: f32,
    },
}

impl Gate {
    /// Whether a straight way goes through it.
    pub fn is_crossed(self, from: Vec3, to: Vec3) -> bool {
        match self {
            Self::Rectangle { half_extents: [x, z] } => {
                plane_crossing(from, to, 0.0).is_some_and(|at| at.x.abs() <= x && at.z.abs() <= z)
            }
            Self::Cup { radius, bottom, rim } => {
                let flat = Vec3::new(1.0, 0.0, 1.0);
                let through_side = round_crossings(from * flat, to * flat, radius)
                    .any(|t| (bottom..=rim).contains(&from.lerp(to, t).y));
                let through_bottom = plane_crossing(from, to, bottom).is_some_and(|at| at.x.hypot(at.z) <= radius);
                through_side || through_bottom
            }
            Self::Bowl { radius, rim } => round_crossings(from, to, radius).any(|t| from.lerp(to, t).y <= rim),
        }
    }
}

/// Where a way meets the plane at a height, if its ends are on different sides.
fn plane_crossing(from: Vec3, to: Vec3, height: f32) -> Option<Vec3> {
    let (before, after) = (from.y - height, to.y - height);
    ((before > 0.0) != (after > 0.0)).then(|| from.lerp(to, before / (before - after)))
}

/// The shares of a way at which its distance from the origin is `radius`.
fn round_crossings(from: Vec3, to: Vec3, radius: f32) -> impl Iterator<Item = f32> {
    // |from + t way|^2 = radius^2
    let way = to - from;
    let (a, b, c) = (way.length_squared(), from.dot(way), from.length_squared() - radius * radius);
    let root = (b * b - a * c).max(0.0).sqrt();
    let meets = a > 0.0 && b * b > a * c;
    [(-b - root) / a, (-b + root) / a].into_iter().filter(move |t| meets && (0.0..1.0).contains(t))
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn at(x: f32, y: f32, z: f32) -> Vec3 {
        Vec3::new(x, y, z)
    }

    #[test]
    fn ways_through_a_rectangle_are_told_from_those_beside_it() {
        let gate = Gate::Rectangle { half_extents: [1.0, 0.5] };
        assert!(gate.is_crossed(at(0.9, 0.1, 0.4), at(0.9, -0.1, 0.4)));
        assert!(gate.is_crossed(at(0.0, -1.0, 0.0), at(0.5, 0.1, 0.0)));
        assert!(!gate.is_crossed(at(0.9, 0.1, 0.6), at(0.9, -0.1, 0.6)), "beside it");
        assert!(!gate.is_crossed(at(0.0, 0.2, 0.0), at(0.5, 0.1, 0.0)), "before it");
    }

    #[test]
    fn a_cup_is_left_over_its_rim_only() {
        let gate = Gate::Cup { radius: 1.0, bottom: -1.0, rim: 1.0 };
        assert!(gate.is_crossed(at(0.9, 0.0, 0.0), at(1.1, 0.0, 0.0)), "through the side");
        assert!(gate.is_crossed(at(-1.5, 0.0, 0.1), at(1.5, 0.0, 0.1)), "in and out in one way");
        assert!(gate.is_crossed(at(0.3, -0.9, 0.3), at(0.3, -1.1, 0.3)), "through the bottom");
        assert!(!gate.is_crossed(at(0.9, 1.2, 0.0), at(1.1, 1.1, 0.0)), "over the rim");
        assert!(!gate.is_crossed(at(0.0, 1.5, 0.0), at(0.0, 0.5, 0.0)), "in from above");
        assert!(!gate.is_crossed(at(1.2, -0.5, 0.0), at(1.2, -1.5, 0.0)), "down beside it");
        assert!(!gate.is_crossed(at(0.2, 0.0, 0.0), at(0.2, 0.0, 0.0)), "not at all");
    }

    #[test]
    fn a_bowl_is_left_over_its_rim_only() {
        let gate = Gate::Bowl { radius: 1.0, rim: 0.0 };
        assert!(gate.is_crossed(at(0.0, -0.9, 0.0), at(0.1, -1.1, 0.0)));
        assert!(!gate.is_crossed(at(0.9, 0.3, 0.0), at(1.1, 0.3, 0.0)));
        assert!(!gate.is_crossed(at(0.0, 0.5, 0.0), at(0.1, -0.5, 0.0)));
    }
}
