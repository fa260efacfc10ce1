//! Density and acceleration in double precision, by brute force, with the kernel of `freshet_core`: what METHODS says,
//! not what the shaders do.

use freshet_core::kernel::Kernel;
use freshet_core::plan::PlannedBoundary;
use freshet_core::prelude::*;
use glam::DVec3;

/// Of one particle.
#[derive(Clone, Copy, Debug)]
pub struct Expected {
    pub density: f64,
    pub pressure: f64,
    pub acceleration: DVec3,
    /// Sum of the sizes of all terms of the acceleration: what rounding errors are relative to.
    pub magnitude: f64,
}

/// Samples of boundaries as they are: position, volume weight, and whether the fluid's viscosity acts.
pub type Samples = Vec<(Vec3, f32, bool)>;

/// The walls of a plan.
pub fn walls(plan: &Plan) -> Samples {
    let PlannedBoundary { positions, volumes, viscous, .. } = &plan.boundary;
    positions.iter().zip(volumes).zip(viscous).map(|((&at, &volume), &viscous)| (at, volume, viscous)).collect()
}

/// All particles.
pub fn expected(plan: &Plan, positions: &[Vec3], velocities: &[Vec3], samples: &Samples) -> Vec<Expected> {
    let p = &plan.parameters;
    let kernel: Kernel = p.kernel().unwrap();
    let of_pressure = p.pressure_kernel().unwrap();
    let (mass, rest) = (f64::from(p.particle_mass), f64::from(p.rest_density));
    let period = plan.grid.periodic.lengths().as_dvec3();
    let difference = |a: Vec3, b: Vec3| {
        let mut x = a.as_dvec3() - b.as_dvec3();
        for axis in (0..3).filter(|&axis| period[axis] > 0.0) {
            x[axis] -= period[axis] * (x[axis] / period[axis]).round();
        }
        x
    };
    let distance = |a: Vec3, b: Vec3| difference(a, b).length();
    let of_width = |width: f64| Kernel::new(p.kernel, (f64::from(p.support_radius) * width) as f32).unwrap();
    let density_with = |a: Vec3, kernel_of: &dyn Fn(usize) -> Kernel| {
        let fluid: f64 = positions.iter().enumerate().map(|(i, &b)| kernel_of(i).value(distance(a, b))).sum();
        let walls: f64 = samples.iter().map(|&(b, volume, _)| f64::from(volume) * kernel.value(distance(a, b))).sum();
        (mass * fluid + rest * walls) / f64::from(p.density_calibration)
    };
    // From the formulas of freshet_core::variable_support.
    let widest = f64::from(p.widest_support);
    let put_right = |a, width| (rest / density_with(a, &|_| of_width(width))).cbrt().clamp(1.0, widest);
    let widths: Vec<f64> = match widest > 1.0 {
        true => positions.iter().map(|&a| (0..4).fold(1.0, |width, _| put_right(a, width))).collect(),
        false => vec![1.0; positions.len()],
    };
    let of_pair = |a: usize, b: usize| of_width(0.5 * (widths[a] + widths[b]));
    let states: Vec<(f64, f64)> = (0..positions.len())
        .map(|a| {
            let density = density_with(positions[a], &|b| of_pair(a, b));
            (density, p.pressure_law.pressure(rest, density))
        })
        .collect();
    let (alpha, sound) = (f64::from(p.artificial_viscosity), f64::from(p.sound_speed));
    let h = f64::from(p.smoothing_length);
    let calibration = f64::from(p.gradient_calibration);
    let pi = |x: DVec3, v: DVec3, mean_density: f64| {
        let mu = h * v.dot(x) / (x.length_squared() + 0.01 * h * h);
        -alpha * sound * mu / mean_density
    };
    let viscosity = f64::from(p.dynamic_viscosity);
    let of_viscosity = |r: f64| match p.viscosity_kernel {
        // Half of Mueller's Laplacian (2003, eq. 22).
        KernelKind::Viscosity => {
            let radius = f64::from(p.support_radius);
            -22.5 / (std::f64::consts::PI * radius.powi(6)) * (radius - r).max(0.0)
        }
        _ => p.viscosity_kernel().unwrap().derivative_over_r(r),
    };
    let of_walls = match p.has_own_viscosity_kernel() {
        true => f64::from(p.viscous_calibration / p.viscous_share),
        false => calibration,
    };
    // Morris, Fox & Zhu 1997, eq. 22.
    let morris = |x: DVec3, v: DVec3, densities: f64, slope: f64| {
        let regular = x.length_squared() / (x.length_squared() + 0.01 * h * h);
        2.0 * viscosity / densities * slope * regular * v
    };
    (0..positions.len())
        .map(|a| {
            let (density, pressure) = states[a];
            let term = pressure / (density * density);
            let (mut sum, mut magnitude) = (DVec3::ZERO, p.gravity.as_dvec3().length());
            let (mut resisted, mut repelled, mut friction) = (DVec3::ZERO, DVec3::ZERO, 0.0);
            let mut add = |factor: f64, x: DVec3, slope: f64| {
                let part = -factor * slope * x / calibration;
                sum += part;
                magnitude += part.length();
            };
            for b in (0..positions.len()).filter(|&b| b != a) {
                let x = difference(positions[a], positions[b]);
                let v = velocities[a].as_dvec3() - velocities[b].as_dvec3();
                let (other_density, other_pressure) = states[b];
                let viscous = pi(x, v, 0.5 * (density + other_density));
                let slope = match p.pressure_kernel == p.kernel {
                    true => of_pair(a, b).derivative_over_r(x.length()),
                    false => of_pressure.derivative_over_r(x.length()),
                };
                let push = match p.pressure_force {
                    PressureForce::Monaghan => term + other_pressure / (other_density * other_density),
                    PressureForce::Mueller => (pressure + other_pressure) / (density * other_density),
                };
                // Monaghan 2000.
                let (own_term, other_term) = (term, other_pressure / (other_density * other_density));
                let tension = -f64::from(p.tensile_correction) * (own_term.min(0.0) + other_term.min(0.0));
                let both = own_term > 0.0 && other_term > 0.0;
                let repels = if both { 0.01 * (own_term + other_term) } else { tension };
                let ratio = of_pressure.value(x.length()) / of_pressure.value(f64::from(p.spacing));
                let repels = if p.tensile_correction > 0.0 { repels * ratio.powi(4) } else { 0.0 };
                add(mass * (push + viscous + repels), x, slope);
                // Clavet et al. 2005 and Pirovano 2011: W = 105/(4 pi H^7) (H - r)^4.
                let (r, radius) = (x.length(), f64::from(p.support_radius));
                let left = (radius - r).max(0.0);
                let steep = -105.0 / (std::f64::consts::PI * radius.powi(7)) * left.powi(3) / r;
                let part = -mass * 2.0 * f64::from(p.near_pressure) / rest * steep * x / calibration;
                repelled += part;
                friction += part.length();
                if viscosity > 0.0 {
                    let slope = if p.has_own_viscosity_kernel() { of_viscosity(r) } else { slope };
                    let part = mass * morris(x, v, density * other_density, slope) / f64::from(p.viscous_calibration);
                    resisted += part;
                    friction += part.length();
                }
            }
            // Of viscous faces: how many there are around, where, and how they move.
            let (mut strength, mut slope, mut moved) = (0.0, DVec3::ZERO, DVec3::ZERO);
            for (k, &(b, volume, viscous)) in samples.iter().enumerate() {
                let x = difference(positions[a], b);
                let dragged = viscous && viscosity == 0.0;
                let drag = if dragged { pi(x, velocities[a].as_dvec3(), density) } else { 0.0 };
                add(rest * f64::from(volume) * (term + drag), x, of_pressure.derivative_over_r(x.length()));
                if viscous {
                    let weight = -f64::from(volume) * of_viscosity(x.length());
                    strength += weight;
                    slope += weight * x;
                    moved += weight * plan.boundary.velocities.get(k).map_or(DVec3::ZERO, |v| v.as_dvec3());
                }
            }
            if viscosity > 0.0 && strength > 0.0 {
                let depth = f64::from(p.boundary_depth);
                let from_face = (slope.length() / strength - depth).max(0.25 * f64::from(p.spacing));
                let rate = viscosity * rest / (density * density * of_walls) * slope.length() / from_face;
                let part = rate * (moved / strength - velocities[a].as_dvec3());
                resisted += part;
                friction += part.length();
            }
            let acceleration = p.gravity.as_dvec3() + sum + resisted + repelled;
            Expected { density, pressure, acceleration, magnitude: magnitude + friction }
        })
        .collect()
}
