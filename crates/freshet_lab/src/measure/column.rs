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

/// How far from a wall the first layer of fluid stands, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Mean distance of the layer's centres.
    pub mean: f64,
    /// Standard deviation of the distances.
    pub spread: f64,
}

/// The gap between a wall and the layer of the `per_layer` particles nearest to it, from the distances of all, m; those beyond the
/// wall are negative. None with fewer particles.
pub fn gap(distances: &[f64], per_layer: usize) -> Option<Gap> {
    let mut nearest = distances.to_vec();
    if per_layer == 0 || nearest.len() < per_layer {
        return None;
    }
    nearest.select_nth_unstable_by(per_layer - 1, f64::total_cmp);
    let layer = &nearest[..per_layer];
    let mean_distance = mean(layer.iter().copied())?;
    let variance = mean(layer.iter().map(|distance| (distance - mean_distance).powi(2)))?;
    Some(Gap { mean: mean_distance, spread: variance.sqrt() })
}

/// Pressure against height in a fluid at rest, over bins of a given thickness above a floor at height zero.
///
/// A bin's pressure is the mean over the particles in it, and its height the mean of theirs, so that a linear profile is found as
/// it is whatever the particles' order. The bins are one support radius thick: sums over neighbours resolve nothing smaller, and
/// pressures may alternate from layer to layer without any force.
#[derive(Clone, Debug, PartialEq)]
pub struct PressureProfile {
    bin: f64,
    /// Number, sum of heights and of pressures in each bin.
    sums: Vec<[f64; 3]>,
}

impl PressureProfile {
    /// Bins of `bin` metres up to `depth`; the last is as thick as is left.
    pub fn new(depth: f64, bin: f64) -> Self {
        Self { bin, sums: vec![[0.0; 3]; (depth / bin - 1e-6).ceil().max(1.0) as usize] }
    }

    /// Adds a particle; one above the last bin counts as in it.
    pub fn add(&mut self, height: f32, pressure: f32) {
        let index = ((f64::from(height) / self.bin).max(0.0) as usize).min(self.sums.len() - 1);
        for (sum, value) in self.sums[index].iter_mut().zip([1.0, f64::from(height), f64::from(pressure)]) {
            *sum += value;
        }
    }

    /// Height in m and pressure in Pa of each bin with particles, from the floor up.
    pub fn points(&self) -> impl Iterator<Item = (f64, f64)> {
        let filled = self.sums.iter().filter(|sums| sums[0] > 0.0);
        filled.map(|&[count, height, pressure]| (height / count, pressure / count))
    }

    /// Root mean square over the bins of what differs from `reference` at a bin's height, Pa; none without particles.
    pub fn deviation(&self, reference: impl Fn(f64) -> f64) -> Option<f64> {
        mean(self.points().map(|(height, pressure)| (pressure - reference(height)).powi(2))).map(f64::sqrt)
    }
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
    fn a_linear_profile_is_found_as_it_is_and_one_that_alternates_as_its_mean() {
        let reference = |height: f64| 9810.0 * (2.0 - height);
        let (mut right, mut alternating, mut low) =
            (PressureProfile::new(2.0, 0.2), PressureProfile::new(2.0, 0.2), PressureProfile::new(2.0, 0.2));
        for (index, x) in column().into_iter().enumerate() {
            let pressure = reference(f64::from(x.y)) as f32;
            right.add(x.y, pressure);
            alternating.add(x.y, pressure + if index / 100 % 2 == 0 { 500.0 } else { -500.0 });
            low.add(x.y, 0.9 * pressure);
        }
        assert_eq!(right.points().count(), 10);
        for profile in [&right, &alternating] {
            let off = profile.deviation(reference);
            assert!(off.is_some_and(|off| off < 0.1), "{off:?}");
        }
        // A tenth of the root mean square of 0.1, 0.3, ... 1.9 m of water.
        let off = low.deviation(reference);
        assert!(off.is_some_and(|off| (off - 981.0 * 1.33_f64.sqrt()).abs() < 0.1), "{off:?}");
        assert_eq!(PressureProfile::new(1.0, 0.3).deviation(reference), None);
    }

    #[test]
    fn the_gap_is_that_of_the_nearest_layer_alone() {
        let heights: Vec<f64> = column().iter().map(|x| x.y.into()).collect();
        let found = gap(&heights, 100);
        assert!(found.is_some_and(|gap| (gap.mean - 0.05).abs() < 1e-6 && gap.spread < 1e-6), "{found:?}");
        // Half of the layer is 0.02 higher and half 0.02 lower.
        let rough = heights.iter().enumerate().map(|(i, y)| if i % 2 == 0 { y + 0.02 } else { y - 0.02 });
        let found = gap(&rough.collect::<Vec<_>>(), 100);
        assert!(
            found.is_some_and(|gap| (gap.mean - 0.05).abs() < 1e-6 && (gap.spread - 0.02).abs() < 1e-6),
            "{found:?}"
        );
        assert_eq!(gap(&heights, 2001), None);
    }

    #[test]
    fn too_few_particles_have_no_level() {
        assert_eq!(surface_level(&column()[..150], 100, 0.1), None);
        assert_eq!(floor_pressure(&column()[..50], &[0.0; 50], 100, 1000.0, 9.81), None);
    }
}
