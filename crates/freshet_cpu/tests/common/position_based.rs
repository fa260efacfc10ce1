//! Position-based and pressure-corrected fluids by sums over all pairs in double precision, from the formulas of `freshet_core::position_based` and `freshet_core::pressure_corrected` and nothing else.

use freshet_core::prelude::*;
use freshet_core::pressure_solver::{largest_eigenvalue, lattice_diagonal};
use glam::DVec3;

/// Where particles are after the iterations of a substep of `dt` seconds, and `dt^2` times their pressures over the squares of their densities.
pub fn moved(plan: &Plan, start: &[Vec3], dt: f32) -> (Vec<DVec3>, Vec<f64>) {
    let p = &plan.parameters;
    let (iterations, gradient) = match p.pressure_solver {
        PressureSolver::PositionBased(solver) => (solver.iterations, PressureGradient::Sum),
        PressureSolver::PressureCorrected(solver) => (solver.iterations, solver.gradient),
        other => panic!("{other:?}"),
    };
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
    for _ in 0..iterations {
        let slope = |apart: DVec3| kernel.derivative_over_r(apart.length()) * apart;
        let (x, before) = (&mut x, &mut pushes);
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
            let excess = sum / s - 1.0;
            match p.pressure_solver {
                PressureSolver::PositionBased(solver) => {
                    omega * excess.max(0.0) / (diagonal.max(least) + f64::from(solver.softness) * lattice)
                }
                _ => {
                    // Sound goes so far that the strongest wave of the lattice changes by 1.2 of itself, or as far as it is fast.
                    let longest = (1.2 / (largest_eigenvalue(&kernel, p.spacing) * lattice / rest)).sqrt();
                    let way = (f64::from(p.sound_speed) * f64::from(dt)).min(longest);
                    (way * way / rest * excess).max(-before[a])
                }
            }
        };
        let found: Vec<f64> = (0..x.len()).map(push).collect();
        let way = |a: usize| {
            let others = (0..x.len()).filter(|&b| near(a, b));
            let sign = if gradient == PressureGradient::Sum { 1.0 } else { -1.0 };
            let fluid: DVec3 = others.map(|b| (sign * found[a] + found[b]) * slope(image(x[a] - x[b]))).sum();
            let around = walls.iter().filter(|wall| beside(a, wall));
            let wall: DVec3 = around.map(|&(wall, volume)| volume * slope(image(x[a] - wall))).sum();
            let at_wall = match gradient {
                PressureGradient::Sum => found[a],
                // The pressure of the wall is as much above the particle's own as that is above the mean around it, and never below.
                PressureGradient::Difference => {
                    let weight = |b: usize| mass / (rest * s) * kernel.value(image(x[a] - x[b]).length());
                    let others = || (0..x.len()).filter(|&b| b != a && near(a, b));
                    let around = others().map(weight).sum::<f64>();
                    let whole = 1.0 - mass / (rest * s) * kernel.value(0.0);
                    let mean = others().map(|b| weight(b) * found[b]).sum::<f64>() / around.max(0.25 * whole);
                    (found[a] - mean).max(0.0)
                }
            };
            -(mass * fluid + rest * at_wall * wall) / g
        };
        let ways: Vec<DVec3> = (0..x.len()).map(way).collect();
        x.iter_mut().zip(ways).for_each(|(x, way)| *x += way);
        before.iter_mut().zip(found).for_each(|(sum, push)| *sum += push);
    }
    (x, pushes)
}
