//! Measures of a fluid at rest in a container with vertical walls and a level floor.

use glam::Vec3;

use super::statistics::mean;

/// Height of the free surface above the origin, m: the mean height of the highest two layers of particles, plus one
/// spacing, as the middle of two layers is one spacing below their upper face.
///
/// A layer is `per_layer` particles, the container's area over the spacing squared. Two layers instead of one particle
/// or one layer, because a disordered surface has particles that stand out by half a spacing; the mean does not follow
/// them. None with fewer particles than that.
pub fn surface_level(positions: &[Vec3], per_layer: usize, spacing: f32) -> Option<f64> {
    let layers = 2;
    let highest = extreme_heights(positions, layers * per_layer, |a, b| b.total_cmp(&a))?;
    Some(highest + layers as f64 / 2.0 * f64::from(spacing))
}

/// Height of the surface from the height of the centre of mass: a column of even density is twice as high as that.
pub fn level_from_centre_of_mass(positions: &[Vec3]) -> Option<f64> {
    mean(positions.iter().map(|position| 2.0 * f64::from(position.y)))
}

/// Pressure on a floor at height zero, Pa: the mean pressure of the lowest `per_layer` particles, plus what the fluid
/// between them and the floor weighs.
pub fn floor_pressure(
    positions: &[Vec3],
    pressures: &[f32],
    per_layer: usize,
    rest_density: f32,
    gravity: f32,
) -> Option<f64> {
    let mut order: Vec<usize> = (0..positions.len().min(pressures.len())).collect();
    if per_layer == 0 || order.len() < per_layer {
        return None;
    }
    order.select_nth_unstable_by(per_layer - 1, |&a, &b| positions[a].y.total_cmp(&positions[b].y));
    let layer = &order[..per_layer];
    let pressure = mean(layer.iter().map(|&i| f64::from(pressures[i])))?;
    let height = mean(layer.iter().map(|&i| f64::from(positions[i].y)))?;
    Some(pressure + f64::from(rest_density) * f64::from(gravity) * height)
}

/// Mean of the first `count` heights in an order.
fn extreme_heights(positions: &[Vec3], count: usize, order: impl Fn(f32, f32) -> std::cmp::Ordering) -> Option<f64> {
    let mut heights: Vec<f32> = positions.iter().map(|position| position.y).collect();
    if count == 0 || heights.len() < count {
        return None;
    }
    heights.select_nth_unstable_by(count - 1, |&a, &b| order(a, b));
    mean(heights[..count].iter().map(|&height| f64::from(height)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 10 x 20 x 10 particles, 0.1 apart, on a floor at zero.
    fn column() -> Vec<Vec3> {
        let at = |index: usize| (index as f32 + 0.5) * 0.1;
        (0..2000).map(|i| Vec3::new(at(i % 10), at(i / 100), at(i / 10 % 10))).collect()
    }

    #[test]
    fn surface_of_a_lattice_is_its_upper_face() {
        let level = surface_level(&column(), 100, 0.1);
        assert!(level.is_some_and(|level| (level - 2.0).abs() < 1e-5), "{level:?}");
        let level = level_from_centre_of_mass(&column());
        assert!(level.is_some_and(|level| (level - 2.0).abs() < 1e-5), "{level:?}");
    }

    #[test]
    fn surface_hardly_follows_a_rough_top_but_follows_a_missing_layer() {
        let mut rough = column();
        for (index, position) in rough.iter_mut().enumerate().skip(1800) {
            position.y += if index % 2 == 0 { 0.04 } else { -0.04 };
        }
        let level = surface_level(&rough, 100, 0.1);
        assert!(level.is_some_and(|level| (level - 2.0).abs() < 1e-3), "{level:?}");
        let level = surface_level(&column()[..1900], 100, 0.1);
        assert!(level.is_some_and(|level| (level - 1.9).abs() < 1e-5), "{level:?}");
    }

    #[test]
    fn floor_pressure_of_a_hydrostatic_column_is_its_weight_over_its_area() {
        let positions = column();
        let pressures: Vec<f32> = positions.iter().map(|position| 1000.0 * 9.81 * (2.0 - position.y)).collect();
        let pressure = floor_pressure(&positions, &pressures, 100, 1000.0, 9.81);
        assert!(pressure.is_some_and(|pressure| (pressure - 19_620.0).abs() < 0.1), "{pressure:?}");
    }

    #[test]
    fn too_few_particles_have_no_level() {
        assert_eq!(surface_level(&column()[..150], 100, 0.1), None);
        assert_eq!(floor_pressure(&column()[..50], &[0.0; 50], 100, 1000.0, 9.81), None);
    }
}
