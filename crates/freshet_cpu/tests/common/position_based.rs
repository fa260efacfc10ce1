//! Position-based fluids by sums over all pairs in double precision, from the formulas of `freshet_core::position_based` and nothing else.

use freshet_core::prelude::*;
use freshet_core::pressure_solver::{largest_eigenvalue, lattice_diagonal};
use glam::DVec3;

/// Where particles are after the iterations of a substep, and `dt^2` times their pressures over the squares of their densities.
pub fn moved(plan: &Plan, start: &[Vec3]) -> (Vec<DVec3>, Vec<f64>) {
    let p = &plan.parameters;
    let PressureSolver::PositionBased(solver) = p.pressure_solver else { panic!("{:?}", p.pressure_solver) };
    let kernel = p.kernel().unwrap();
    let (mass, rest) = (f64::from(p.particle_mass), f64::from(p.rest_density));
    let (s, g) = (kernel.lattice_sum(p.spacing), kernel.lattice_gradient_sum(p.spacing));
    let lattice = rest / (s * g) * lattice_diagonal(&kernel, p.spacing);
    let omega = f64::from(PositionBased::RELAXATION) / largest_eigenvalue(&kernel, p.spacing);
    let lengths = plan.grid.periodic.lengths().as_dvec3();
    let image = |apart: DVec3| {
        DVec3::from([0, 1, 2].map(|axis| match lengths[axis] {
            0.0 => apart[axis],
            length => apart[axis] - length * (apart[axis] / length).round(),
        }))
    };
    let walls: Vec<(DVec3, f64)> = plan
        .boundary
        .positions
        .iter()
        .zip(&plan.boundary.volumes)
        .map(|(x, &volume)| (x.as_dvec3(), f64::from(volume)))
        .collect();
    // Neighbours are those of the start.
    let radius = f64::from(p.support_radius);
    let near = |a: usize, b: usize| image(start[a].as_dvec3() - start[b].as_dvec3()).length() < radius;
    let beside = |a: usize, wall: &(DVec3, f64)| image(start[a].as_dvec3() - wall.0).length() < radius;
    let mut x: Vec<DVec3> = start.iter().map(|x| x.as_dvec3()).collect();
    let mut pushes = vec![0.0; x.len()];
    for _ in 0..solver.iterations {
        let slope = |apart: DVec3| kernel.derivative_over_r(apart.length()) * apart;
        let push = |a: usize| {
            let others = || (0..x.len()).filter(|&b| near(a, b)).map(|b| image(x[a] - x[b]));
            let around =
                || walls.iter().filter(|wall| beside(a, wall)).map(|&(wall, volume)| (image(x[a] - wall), volume));
            let value = |apart: DVec3| kernel.value(apart.length());
            let sum: f64 = mass / rest * others().map(value).sum::<f64>()
                + around().map(|(apart, volume)| volume * value(apart)).sum::<f64>();
            let gradient: DVec3 = others().map(slope).sum::<DVec3>()
                + rest / mass * around().map(|(apart, volume)| volume * slope(apart)).sum::<DVec3>();
            let squares: f64 = others().map(|apart| slope(apart).length_squared()).sum();
            let diagonal = mass * mass / (s * g * rest) * (gradient.length_squared() + squares);
            let least = f64::from(DivergenceFree::LEAST_DIAGONAL) * lattice;
            omega * (sum / s - 1.0).max(0.0) / (diagonal.max(least) + f64::from(solver.softness) * lattice)
        };
        let found: Vec<f64> = (0..x.len()).map(push).collect();
        let way = |a: usize| {
            let others = (0..x.len()).filter(|&b| near(a, b));
            let fluid: DVec3 = others.map(|b| (found[a] + found[b]) * slope(image(x[a] - x[b]))).sum();
            let around = walls.iter().filter(|wall| beside(a, wall));
            let wall: DVec3 = around.map(|&(wall, volume)| volume * found[a] * slope(image(x[a] - wall))).sum();
            -(mass * fluid + rest * wall) / g
        };
        let ways: Vec<DVec3> = (0..x.len()).map(way).collect();
        x.iter_mut().zip(ways).for_each(|(x, way)| *x += way);
        pushes.iter_mut().zip(found).for_each(|(sum, push)| *sum += push);
    }
    (x, pushes)
}
