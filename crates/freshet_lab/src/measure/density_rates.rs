//! How fast velocities change densities: the sum `D` of [`DivergenceFree`], over all pairs in double precision, apart from any solver's.

use freshet_core::error::InvalidInput;
use freshet_core::plan::Plan;
use freshet_core::pressure_solver::DivergenceFree;
use glam::{DVec3, Vec3};

use super::spacing::visit_pairs;

/// The sum for a set of positions, of a plan without bodies.
#[derive(Clone, Debug)]
pub struct DensityRates {
    /// Densities over that at rest.
    densities: Vec<f64>,
    /// Two particles and `m / (S rho0) grad W`, 1/m, of the first.
    pairs: Vec<(usize, usize, DVec3)>,
    /// Of each particle, `1/S sum_k V_k grad W` over walls, 1/m.
    walls: Vec<DVec3>,
    /// What velocities correct in a second at most, of a relative density.
    most_by_velocity: f32,
}

impl DensityRates {
    /// Finds who is near whom. Walls of domains that repeat themselves are not looked for.
    ///
    /// # Errors
    /// If the plan's kernel is not valid.
    pub fn new(plan: &Plan, positions: &[Vec3]) -> Result<Self, InvalidInput> {
        let (parameters, kernel) = (&plan.parameters, plan.parameters.kernel()?);
        let scale = 1.0 / f64::from(parameters.density_calibration);
        let volume = f64::from(parameters.particle_mass / parameters.rest_density);
        let count = positions.len();
        let mut rates = Self {
            densities: vec![volume * scale * kernel.value(0.0); count],
            pairs: Vec::new(),
            walls: vec![DVec3::ZERO; count],
            most_by_velocity: parameters.most_by_velocity(1.0),
        };
        let all: Vec<Vec3> = positions.iter().chain(&plan.boundary.positions).copied().collect();
        visit_pairs(&all, parameters.support_radius, |a, b, _| {
            let (a, b) = (a.min(b), a.max(b));
            if a >= count {
                return;
            }
            let apart = all[a].as_dvec3() - all[b].as_dvec3();
            let distance = apart.length();
            let (value, gradient) = (kernel.value(distance), kernel.derivative_over_r(distance) * apart);
            match plan.boundary.volumes.get(b.wrapping_sub(count)) {
                Some(&weight) => {
                    rates.densities[a] += f64::from(weight) * scale * value;
                    rates.walls[a] += f64::from(weight) * scale * gradient;
                }
                None => {
                    rates.densities[a] += volume * scale * value;
                    rates.densities[b] += volume * scale * value;
                    rates.pairs.push((a, b, volume * scale * gradient));
                }
            }
        });
        Ok(rates)
    }

    /// `D(v) / rho0` of each particle, 1/s, with walls that stand still; velocities in m/s.
    pub fn of(&self, velocities: &[Vec3]) -> Vec<f64> {
        let own = |(wall, velocity): (&DVec3, &Vec3)| wall.dot(velocity.as_dvec3());
        let mut rates: Vec<f64> = self.walls.iter().zip(velocities).map(own).collect();
        for &(a, b, gradient) in &self.pairs {
            let rate = gradient.dot(velocities[a].as_dvec3() - velocities[b].as_dvec3());
            rates[a] += rate;
            rates[b] += rate;
        }
        rates
    }

    /// What a divergence solve has left to do after a substep of `dt` seconds: mean over the particles of `|R|` where there is
    /// pressure, of `max(R, 0)` elsewhere; see [`DivergenceFree`]. `velocities` are those at its end, `pressures` of any unit, and `way` is
    /// that of the fastest particle over the longest allowed.
    pub fn left(&self, velocities: &[Vec3], pressures: &[f32], dt: f64, way: f32) -> f64 {
        let share = DivergenceFree::share(way);
        let most = self.most_by_velocity * dt as f32;
        let rates = self.of(velocities);
        let wrong = |((density, rate), pressure): ((&f64, &f64), &f32)| {
            let left = f64::from(DivergenceFree::source((density - 1.0) as f32, share, most)) + dt * rate;
            if *pressure > 0.0 { left.abs() } else { left.max(0.0) }
        };
        let sum: f64 = self.densities.iter().zip(&rates).zip(pressures).map(wrong).sum();
        sum / self.densities.len().max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use freshet_core::plan::SceneError;

    use super::*;
    use crate::scenes::column::walled;

    /// By moving all particles a little and summing densities again.
    #[test]
    fn rates_are_those_of_the_densities() -> Result<(), SceneError> {
        let plan = Plan::new(&walled(0.3, 0.3, 0.05))?;
        let swirl = |x: &Vec3| Vec3::new((9.0 * x.y).sin(), 0.3 - x.z, (7.0 * x.x).cos());
        let velocities: Vec<Vec3> = plan.positions.iter().map(swirl).collect();
        let step = 1e-3;
        let moved =
            |way: f32| -> Vec<Vec3> { plan.positions.iter().zip(&velocities).map(|(x, v)| *x + way * *v).collect() };
        let rates = DensityRates::new(&plan, &plan.positions)?.of(&velocities);
        let [before, after] = [-step, step].map(|way| DensityRates::new(&plan, &moved(way)));
        let (before, after) = (before?.densities, after?.densities);
        let largest = rates.iter().fold(0.0f64, |largest, rate| largest.max(rate.abs()));
        assert!(largest > 1.0, "{largest}");
        for ((rate, before), after) in rates.iter().zip(before).zip(after) {
            let expected = (after - before) / f64::from(2.0 * step);
            assert!((rate - expected).abs() < 2e-3 * largest, "{rate} not {expected}");
        }
        Ok(())
    }

    #[test]
    fn what_falls_apart_without_pressure_is_not_wrong() -> Result<(), SceneError> {
        let plan = Plan::new(&walled(0.3, 0.3, 0.05))?;
        let apart: Vec<Vec3> = plan.positions.iter().map(|x| Vec3::Y * x.y).collect();
        let rates = DensityRates::new(&plan, &plan.positions)?;
        let free = vec![0.0; apart.len()];
        let pressed = vec![1.0; apart.len()];
        // The lattice is as dense as at rest to a thousandth.
        assert!(rates.left(&apart, &free, 0.1, 0.0) < 0.01 * rates.left(&apart, &pressed, 0.1, 0.0));
        assert!(rates.left(&apart, &pressed, 0.1, 0.0) > 0.05);
        Ok(())
    }
}
