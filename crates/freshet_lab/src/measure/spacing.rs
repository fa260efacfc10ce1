//! How far particles are from each other.

use std::collections::HashMap;

use glam::{IVec3, Vec3};

/// Distances of pairs up to `reach`, m, each pair once.
pub fn pair_distances(positions: &[Vec3], reach: f32) -> Vec<f32> {
    let mut distances = Vec::new();
    visit_pairs(positions, reach, |_, _, distance| distances.push(distance));
    distances
}

/// The distance of each particle to its nearest neighbour, m; infinite where there is none within `reach`.
pub fn nearest_distances(positions: &[Vec3], reach: f32) -> Vec<f32> {
    let mut nearest = vec![f32::INFINITY; positions.len()];
    visit_pairs(positions, reach, |a, b, distance| {
        nearest[a] = nearest[a].min(distance);
        nearest[b] = nearest[b].min(distance);
    });
    nearest
}

/// Calls for each pair up to `reach` apart, once, with its indices and its distance, m.
pub fn visit_pairs(positions: &[Vec3], reach: f32, mut visit: impl FnMut(usize, usize, f32)) {
    let cell_of = |position: Vec3| (position / reach).floor().as_ivec3();
    let mut cells: HashMap<IVec3, Vec<usize>> = HashMap::new();
    for (b, &position) in positions.iter().enumerate() {
        let cell = cell_of(position);
        for offset in (0..27).map(|n| IVec3::new(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1)) {
            for &a in cells.get(&(cell + offset)).into_iter().flatten() {
                let distance = positions[a].distance(position);
                if distance <= reach {
                    visit(a, b, distance);
                }
            }
        }
        cells.entry(cell).or_default().push(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lattice_has_its_own_distances() {
        let points: Vec<Vec3> =
            (0..125).map(|n| Vec3::new((n % 5) as f32, (n / 5 % 5) as f32, (n / 25) as f32) - 2.0).collect();
        let distances = pair_distances(&points, 1.1);
        assert_eq!(distances.len(), 3 * 4 * 25);
        assert!(distances.iter().chain(&nearest_distances(&points, 1.1)).all(|&distance| distance == 1.0));
        assert_eq!(nearest_distances(&[Vec3::ZERO, Vec3::X * 9.0], 1.0), [f32::INFINITY; 2]);
    }
}
