//! How high the fluid stands at a wall at x = 0.

use glam::Vec3;

/// Thickness of the strip at the wall whose particles count, in spacings: two supports of the kernel.
pub const STRIP_IN_SPACINGS: f32 = 4.0;

/// Height of the fluid above a floor at y = 0, in a strip four spacings thick at the wall x = 0, m: the volume of the
/// strip's particles over its floor. `depth_in_spacings` is the strip's extent along z.
///
/// A wall is a line of symmetry, the surface meets it level: over the strip it is as high as at the wall, up to second order.
/// By volume, a film one particle thick counts as what it is, and a surface of disordered particles is not taken for as high
/// as its crests. The strip is thick enough that the layers of particles beside the wall, which lie nearer to each other
/// than a spacing, do not show; its outer edge is a slope from three to five spacings, so that no whole layer leaves it at once.
pub fn wall_height(positions: &[Vec3], depth_in_spacings: usize, spacing: f32) -> f64 {
    let share = |position: &Vec3| f64::from(((STRIP_IN_SPACINGS + 1.0 - position.x / spacing) / 2.0).clamp(0.0, 1.0));
    let inside: f64 = positions.iter().map(share).sum();
    inside * f64::from(spacing) / (f64::from(STRIP_IN_SPACINGS) * depth_in_spacings as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    const DEPTH: usize = 10;

    /// A block ten spacings of 0.1 deep.
    fn block(across: usize, layers: usize) -> Vec<Vec3> {
        let at = |index: usize| (index as f32 + 0.5) * 0.1;
        let particle = |i: usize| Vec3::new(at(i / DEPTH % across), at(i / (DEPTH * across)), at(i % DEPTH));
        (0..across * layers * DEPTH).map(particle).collect()
    }

    fn assert_height(positions: &[Vec3], expected: f64) {
        let found = wall_height(positions, DEPTH, 0.1);
        assert!((found - expected).abs() < 1e-6, "{found}, not {expected}");
    }

    #[test]
    fn height_of_a_block_is_its_own() {
        for layers in [1, 2, 12] {
            assert_height(&block(12, layers), layers as f64 * 0.1);
        }
    }

    #[test]
    fn what_stands_farther_from_the_wall_does_not_count() {
        let mut positions = block(12, 5);
        positions.extend(block(12, 9).into_iter().filter(|position| position.x > 0.5));
        assert_height(&positions, 0.5);
        assert_height(&[], 0.0);
    }

    #[test]
    fn the_outer_edge_is_a_slope_from_three_to_five_spacings() {
        for (x, share) in [(0.29, 1.0), (0.35, 0.75), (0.4, 0.5), (0.45, 0.25), (0.51, 0.0)] {
            assert_height(&[Vec3::new(x, 0.0, 0.0)], share * 0.1 / (4.0 * DEPTH as f64));
        }
    }

    #[test]
    fn a_film_on_the_wall_counts_by_its_volume() {
        // One particle thick, four spacings high: a quarter of the strip's thickness.
        let mut positions = block(12, 5);
        positions.extend(block(1, 9).into_iter().filter(|position| position.y > 0.5));
        assert_height(&positions, 0.5 + 0.4 / 4.0);
    }
}
