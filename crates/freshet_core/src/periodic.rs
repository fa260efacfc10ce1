//! Axes along which a domain repeats itself.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::error::InvalidInput;
use crate::scene::check_position;

/// Where a domain repeats itself: what leaves through one end of a period comes back through the other, and the two ends are
/// neighbours.
///
/// Each end is within 1e6 m of the origin. A period is at least four support radii long, so that nothing meets itself twice;
/// what lies in the domain lies within it, walls included, so a wall cannot close a periodic axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Periodic {
    /// Lower and upper end along x, m; none where the domain does not repeat.
    pub x: Option<(f32, f32)>,
    /// The same along y.
    pub y: Option<(f32, f32)>,
    /// The same along z.
    pub z: Option<(f32, f32)>,
}

/// Names of the axes, as in [`Periodic`].
pub(crate) const AXES: [&str; 3] = ["x", "y", "z"];

impl Periodic {
    /// Lower and upper end along an axis, 0 to 2.
    pub fn along(&self, axis: usize) -> Option<(f32, f32)> {
        [self.x, self.y, self.z][axis]
    }

    /// Whether any axis repeats.
    pub fn any(&self) -> bool {
        (0..3).any(|axis| self.along(axis).is_some())
    }

    /// Lengths of the periods, m; zero along axes that do not repeat.
    pub fn lengths(&self) -> Vec3 {
        Vec3::from([0, 1, 2].map(|axis| self.along(axis).map_or(0.0, |(low, high)| high - low)))
    }

    /// `vector` without its components along axes that repeat.
    pub fn across(&self, vector: Vec3) -> Vec3 {
        Vec3::from([0, 1, 2].map(|axis| if self.along(axis).is_some() { 0.0 } else { vector[axis] }))
    }

    /// The image of a point within the periods: at least the lower end, below the upper one. What is not finite stays so.
    pub fn wrap(&self, mut position: Vec3) -> Vec3 {
        for axis in 0..3 {
            position[axis] = self.wrap_along(axis, position[axis]);
        }
        position
    }

    /// The image of one coordinate of a point.
    #[inline]
    pub fn wrap_along(&self, axis: usize, x: f32) -> f32 {
        let Some((low, high)) = self.along(axis) else { return x };
        if x >= low && x < high {
            return x;
        }
        let wrapped = low + (x - low).rem_euclid(high - low);
        if wrapped >= high { low } else { wrapped }
    }

    /// `x_a - x_b` to the nearest image of b.
    pub fn nearest(&self, mut difference: Vec3) -> Vec3 {
        let lengths = self.lengths();
        for axis in (0..3).filter(|&axis| lengths[axis] > 0.0) {
            difference[axis] -= lengths[axis] * (difference[axis] / lengths[axis]).round();
        }
        difference
    }

    /// The images of points that lie outside of the periods, within `reach` of their ends.
    pub fn images(&self, points: &[Vec3], reach: f32) -> Vec<Vec3> {
        self.sources_and_images(points, reach).into_iter().map(|(_, image)| image).collect()
    }

    /// The same, each with the index of the point that it is an image of.
    pub(crate) fn sources_and_images(&self, points: &[Vec3], reach: f32) -> Vec<(usize, Vec3)> {
        let mut all: Vec<(usize, Vec3)> = points.iter().copied().enumerate().collect();
        for axis in 0..3 {
            let Some((low, high)) = self.along(axis) else { continue };
            for index in 0..all.len() {
                let ((source, point), shift) = (all[index], Vec3::AXES[axis] * (high - low));
                if point[axis] < low + reach {
                    all.push((source, point + shift));
                }
                if point[axis] > high - reach {
                    all.push((source, point - shift));
                }
            }
        }
        all.split_off(points.len())
    }

    pub(crate) fn validate(&self) -> Result<(), InvalidInput> {
        for (axis, name) in AXES.into_iter().enumerate() {
            let Some((low, high)) = self.along(axis) else { continue };
            check_position(name, Vec3::new(low, high, 0.0))?;
            if low >= high {
                return Err(InvalidInput::new(name, format_args!("({low}, {high})"), "the lower end, then the upper"));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SLAB: Periodic = Periodic { x: Some((-1.0, 3.0)), y: None, z: Some((0.0, 1.0)) };

    #[test]
    fn points_are_wrapped_into_the_period() {
        assert_eq!(SLAB.wrap(Vec3::new(3.0, 9.0, -0.25)), Vec3::new(-1.0, 9.0, 0.75));
        assert_eq!(SLAB.wrap(Vec3::new(-9.5, 0.0, 1.0)), Vec3::new(2.5, 0.0, 0.0));
        let inside = Vec3::new(0.1, -7.0, 0.3);
        assert_eq!(SLAB.wrap(inside), inside);
        // A hair below the lower end rounds to the upper one, which is the lower one.
        assert_eq!(SLAB.wrap(Vec3::new(0.0, 0.0, -1e-9)).z, 0.0);
        assert!(SLAB.wrap(Vec3::splat(f32::NAN)).is_nan());
    }

    #[test]
    fn the_nearest_image_is_taken() {
        assert_eq!(SLAB.nearest(Vec3::new(3.5, 3.5, -0.75)), Vec3::new(-0.5, 3.5, 0.25));
        assert_eq!(SLAB.across(Vec3::ONE), Vec3::Y);
        assert_eq!(SLAB.lengths(), Vec3::new(4.0, 0.0, 1.0));
    }

    #[test]
    fn a_point_at_an_edge_has_three_images() {
        let images = SLAB.images(&[Vec3::new(-0.9, 0.0, 0.9), Vec3::new(1.0, 0.0, 0.5)], 0.2);
        assert_eq!(images.len(), 3);
        for (image, wanted) in images.iter().zip([[3.1, 0.0, 0.9], [-0.9, 0.0, -0.1], [3.1, 0.0, -0.1]]) {
            assert!(image.distance(Vec3::from(wanted)) < 1e-6, "{images:?}");
        }
    }
}
