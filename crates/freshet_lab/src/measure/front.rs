//! Where the front of a flow along +x is.

use glam::Vec3;

use super::statistics::percentile;

/// Share of the particles that lie behind the front, %.
///
/// The very first particle is no front: single particles are thrown ahead of the tongue, and how far is chance. Peers are
/// measured by the same share.
pub const FRONT_PERCENTILE: f64 = 99.5;

/// The front: the 99.5th percentile of the particle centres' `x`, plus half a spacing, as a particle stands for the fluid
/// half a spacing around its centre. In the positions' frame, m; none without particles.
///
/// At the start of a column `n` particles wide this is the column's face exactly for `n <= 200`, as more than 0.5 % of the
/// particles are in its last layer.
pub fn front(positions: &[Vec3], spacing: f32) -> Option<f64> {
    let mut x: Vec<f32> = positions.iter().map(|position| position.x).collect();
    percentile(&mut x, FRONT_PERCENTILE).map(|x| x + f64::from(spacing) / 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lattice(n: usize, spacing: f32) -> Vec<Vec3> {
        let at = |index: usize| (index as f32 + 0.5) * spacing;
        (0..n * n * n).map(|i| Vec3::new(at(i % n), at(i / n % n), at(i / (n * n)))).collect()
    }

    #[test]
    fn front_of_a_block_is_its_face() {
        let found = front(&lattice(12, 0.1), 0.1);
        assert!(found.is_some_and(|x| (x - 1.2).abs() < 1e-6), "{found:?}");
    }

    #[test]
    fn front_ignores_the_few_ahead_of_it_and_only_those() {
        let mut positions = lattice(12, 0.1);
        for position in positions.iter_mut().take(8) {
            position.x = 5.0;
        }
        let with_strays = front(&positions, 0.1);
        assert!(with_strays.is_some_and(|x| (x - 1.2).abs() < 1e-6), "8 of 1728 are 0.46 %: {with_strays:?}");
        for position in positions.iter_mut().take(20) {
            position.x = 5.0;
        }
        let with_tongue = front(&positions, 0.1);
        assert!(with_tongue.is_some_and(|x| (x - 5.05).abs() < 1e-6), "20 of 1728 are 1.2 %: {with_tongue:?}");
    }

    #[test]
    fn nothing_has_no_front() {
        assert_eq!(front(&[], 0.1), None);
    }
}
