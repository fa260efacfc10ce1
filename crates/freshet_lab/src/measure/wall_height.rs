//! How high the fluid stands at a wall at x = 0.

use glam::Vec3;

/// Thickness of the strip at the wall whose particles count, in spacings: two layers of particles that stand in order.
pub const STRIP_IN_SPACINGS: f32 = 2.0;

/// Height of the fluid above a floor at y = 0, in a strip two spacings thick at the wall x = 0, m: the height up to which
/// there is still fluid over half of the strip's floor.
///
/// A full layer of the strip is [`STRIP_IN_SPACINGS`] times `depth_in_spacings` particles. The height is that of the centre
/// of the particle that has half a layer at or above it, plus half a spacing, as a particle stands for the fluid half a
/// spacing around its centre. It is so the median of the highest layer: exact for a block, between the troughs and the
/// crests of a rough surface, and blind for droplets and for a film on the wall of fewer particles than half a layer. With
/// fewer particles than that in the strip there is no column: zero.
pub fn wall_height(positions: &[Vec3], depth_in_spacings: usize, spacing: f32) -> f64 {
    let half_layer = (STRIP_IN_SPACINGS as usize * depth_in_spacings / 2).max(1);
    let strip = positions.iter().filter(|position| position.x < STRIP_IN_SPACINGS * spacing);
    let mut heights: Vec<f32> = strip.map(|position| position.y).collect();
    if heights.len() < half_layer {
        return 0.0;
    }
    let (_, &mut height, _) = heights.select_nth_unstable_by(half_layer - 1, |a, b| b.total_cmp(a));
    f64::from(height) + f64::from(spacing) / 2.0
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
        let mut positions = block(12, 4);
        positions.extend(block(12, 9).into_iter().filter(|position| position.x > 0.2));
        assert_height(&positions, 0.4);
    }

    #[test]
    fn droplets_do_not_count_until_they_cover_half_of_the_strip() {
        let mut positions = block(12, 4);
        positions.extend([Vec3::new(0.05, 3.0, 0.5); 9]);
        assert_height(&positions, 0.4);
        positions.push(Vec3::new(0.05, 3.0, 0.5));
        assert_height(&positions, 3.05);
    }

    #[test]
    fn half_a_layer_is_the_least_there_can_be() {
        assert_height(&[Vec3::new(0.05, 0.05, 0.5); 10], 0.1);
        assert_height(&[Vec3::new(0.05, 0.05, 0.5); 9], 0.0);
        assert_height(&[], 0.0);
    }
}
