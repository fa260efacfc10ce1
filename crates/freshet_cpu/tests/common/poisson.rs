//! A Poisson equation for the pressure by sums over all pairs in double precision, from the formulas of `freshet_core::pressure_poisson` and nothing else.

use freshet_core::prelude::*;
use glam::DVec3;

/// What pressures leave of the equation.
pub struct Left {
    /// Mean of what there is to do.
    pub begun: f64,
    /// Mean of what is left, where it counts.
    pub left: f64,
    /// Particles at a free surface.
    pub surface: Vec<bool>,
    /// Where particles go by these pressures, m.
    pub ways: Vec<DVec3>,
}

/// For particles that are at `x` without pressure, and `dt^2` times their pressures over the squares of their densities.
pub fn left(plan: &Plan, x: &[Vec3], pushes: &[f64]) -> Left {
    let p = &plan.parameters;
    let kernel = p.kernel().unwrap();
    let (mass, rest) = (f64::from(p.particle_mass), f64::from(p.rest_density));
    let (s, g) = (kernel.lattice_sum(p.spacing), kernel.lattice_gradient_sum(p.spacing));
    let apart = |a: usize, b: Vec3| plan.grid.periodic.nearest(x[a] - b).as_dvec3();
    let walls = || plan.boundary.positions.iter().zip(&plan.boundary.volumes);
    let mut found = Left { begun: 0.0, left: 0.0, surface: Vec::new(), ways: Vec::new() };
    for a in 0..x.len() {
        let around: Vec<(usize, DVec3)> = (0..x.len())
            .map(|b| (b, apart(a, x[b])))
            .filter(|(_, x)| x.length() < f64::from(p.support_radius))
            .collect();
        let beside: Vec<(f64, DVec3)> = walls()
            .map(|(&wall, &volume)| (f64::from(volume), apart(a, wall)))
            .filter(|(_, x)| x.length() < f64::from(p.support_radius))
            .collect();
        let slope = |x: DVec3| kernel.derivative_over_r(x.length());
        let density: f64 = (mass * around.iter().map(|(_, x)| kernel.value(x.length())).sum::<f64>()
            + rest * beside.iter().map(|(volume, x)| volume * kernel.value(x.length())).sum::<f64>())
            / s;
        let others = || around.iter().filter(|(b, _)| *b != a);
        let wall: DVec3 = beside.iter().map(|&(volume, x)| volume * slope(x) * x).sum();
        let gradient = others().map(|&(_, x)| slope(x) * x).sum::<DVec3>() + rest / mass * wall;
        let pair: DVec3 = others().map(|&(b, x)| (pushes[a] + pushes[b]) * slope(x) * x).sum();
        found.ways.push(-(mass * pair + rest * pushes[a] * wall) / g);
        found.surface.push(density < 0.97 * rest);
        if density < 0.97 * rest {
            continue;
        }
        let own = mass * mass / (s * g * rest) * gradient.length_squared();
        let weights: f64 = others().map(|&(_, x)| -2.0 * mass / s * slope(x)).sum();
        let flow: f64 = others().map(|&(b, x)| -2.0 * mass / s * slope(x) * (pushes[a] - pushes[b])).sum();
        let excess = density / rest - 1.0;
        let least = (f64::from(p.least_diagonal) - own - weights).max(0.0);
        let left = excess - flow - (own + least) * pushes[a];
        found.begun += excess.max(0.0) / x.len() as f64;
        if pushes[a] > 0.0 || left > 0.0 {
            found.left += left.abs() / x.len() as f64;
        }
    }
    found
}
