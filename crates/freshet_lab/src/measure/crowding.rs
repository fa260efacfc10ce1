//! How far particles are crowded together, from positions alone: the same measure for every solver.

use glam::{IVec3, Vec3};

use super::statistics::percentile;

/// Crowding of a moment, in percent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Crowding {
    /// Mean over particles of `max(rho / rho0 - 1, 0)`.
    pub mean: f64,
    /// Its 99th percentile.
    pub percentile_99: f64,
    /// Its maximum.
    pub maximum: f64,
    /// Share of the volume that is gone: crowded particles stand for `rho0 / rho` of theirs, escaped ones for none.
    pub lost_volume: f64,
}

/// A box whose outside is thought to be full of fluid at rest, in a lattice of the particles' spacing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tank {
    /// Inner size, m, a whole number of spacings along each axis; the lower corner is the origin.
    pub size: Vec3,
    /// Spacing, m.
    pub spacing: f32,
}

/// Cubic spline of support `2 d`, in units of its value at the centre.
fn kernel(squared_distance: f32, support: f32) -> f64 {
    let q = f64::from(squared_distance.sqrt() / support);
    if q < 0.5 { 1.0 - 6.0 * q * q * (1.0 - q) } else { 2.0 * (1.0 - q).max(0.0).powi(3) }
}

impl Tank {
    /// Densities from a cubic-spline sum of support `2 d` over particles and the lattice outside, over that of the full
    /// lattice. Particles farther outside than a spacing, or not finite, have none.
    pub fn densities(&self, positions: &[Vec3]) -> Vec<Option<f64>> {
        let (d, support) = (self.spacing, 2.0 * self.spacing);
        // Cells of the support, two more than the tank has on each side.
        let cells = (self.size / support).ceil().as_ivec3() + 4;
        let cell_of = |x: Vec3| (x / support).floor().as_ivec3() + 2;
        let index = |cell: IVec3| ((cell.z * cells.y + cell.y) * cells.x + cell.x) as usize;
        let mut contents: Vec<Vec<Vec3>> = vec![Vec::new(); cells.element_product() as usize];
        let escaped = |x: &Vec3| !x.is_finite() || x.cmplt(Vec3::splat(-d)).any() || x.cmpgt(self.size + d).any();
        let layers = (self.size / d).round().as_ivec3();
        for k in -2..layers.z + 2 {
            for j in -2..layers.y + 2 {
                for i in -2..layers.x + 2 {
                    let site = IVec3::new(i, j, k);
                    if site.cmplt(IVec3::ZERO).any() || site.cmpge(layers).any() {
                        let x = (site.as_vec3() + 0.5) * d;
                        contents[index(cell_of(x))].push(x);
                    }
                }
            }
        }
        for &x in positions.iter().filter(|x| !escaped(x)) {
            contents[index(cell_of(x))].push(x);
        }
        let full: f64 = lattice_sum(d, support);
        let density = |x: &Vec3| {
            if escaped(x) {
                return None;
            }
            let center = cell_of(*x);
            let mut sum = 0.0;
            for z in -1..=1 {
                for y in -1..=1 {
                    for x_step in -1..=1 {
                        let cell = center + IVec3::new(x_step, y, z);
                        if cell.cmplt(IVec3::ZERO).any() || cell.cmpge(cells).any() {
                            continue;
                        }
                        sum +=
                            contents[index(cell)].iter().map(|y| kernel(x.distance_squared(*y), support)).sum::<f64>();
                    }
                }
            }
            Some(sum / full)
        };
        positions.iter().map(density).collect()
    }

    /// Crowding of particles; zero without any.
    pub fn crowding(&self, positions: &[Vec3]) -> Crowding {
        let densities = self.densities(positions);
        let count = densities.len().max(1) as f64;
        let mut excess: Vec<f32> = densities.iter().flatten().map(|density| (density - 1.0).max(0.0) as f32).collect();
        let kept: f64 = densities.iter().flatten().map(|density| 1.0 / density.max(1.0)).sum();
        let sum: f64 = excess.iter().map(|&excess| f64::from(excess)).sum();
        Crowding {
            mean: 100.0 * sum / count,
            maximum: 100.0 * f64::from(excess.iter().copied().fold(0.0, f32::max)),
            percentile_99: 100.0 * percentile(&mut excess, 99.0).unwrap_or(0.0),
            lost_volume: if densities.is_empty() { 0.0 } else { 100.0 * (1.0 - kept / count) },
        }
    }
}

fn lattice_sum(d: f32, support: f32) -> f64 {
    let range = || (-2..=2).map(|index| index as f32 * d);
    range()
        .flat_map(|x| range().flat_map(move |y| range().map(move |z| x * x + y * y + z * z)))
        .map(|squared| kernel(squared, support))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TANK: Tank = Tank { size: Vec3::new(1.0, 0.8, 0.6), spacing: 0.1 };

    fn block(layers: IVec3, spacing: f32) -> Vec<Vec3> {
        let count = layers.element_product();
        let site = |i: i32| IVec3::new(i % layers.x, i / layers.x % layers.y, i / (layers.x * layers.y));
        (0..count).map(|i| (site(i).as_vec3() + 0.5) * spacing).collect()
    }

    #[test]
    fn a_full_tank_at_rest_is_not_crowded_anywhere() {
        let found = TANK.crowding(&block(IVec3::new(10, 8, 6), 0.1));
        assert!(found.maximum < 1e-3 && found.lost_volume < 1e-3, "{found:?}");
    }

    #[test]
    fn a_surface_is_no_crowd_and_a_denser_lattice_is() {
        assert!(TANK.crowding(&block(IVec3::new(10, 4, 6), 0.1)).maximum < 1e-3);
        // Two percent closer along each axis, away from the walls: six percent denser.
        let inner: Vec<Vec3> = block(IVec3::new(8, 6, 4), 0.098).into_iter().map(|x| x + 0.12).collect();
        let densities = TANK.densities(&inner);
        let center = inner.iter().position(|x| x.distance(Vec3::new(0.561, 0.463, 0.365)) < 0.01).unwrap();
        let density = densities[center].unwrap();
        assert!((density - 0.98_f64.powi(-3)).abs() < 0.01, "{density}");
    }

    #[test]
    fn a_particle_that_is_gone_is_lost_volume() {
        let mut positions = block(IVec3::new(10, 8, 6), 0.1);
        positions[0].x = -5.0;
        positions[1].y = f32::NAN;
        let found = TANK.crowding(&positions);
        assert!((found.lost_volume - 200.0 / 480.0).abs() < 1e-3, "{found:?}");
        assert_eq!(TANK.crowding(&[]), Crowding::default());
    }
}
