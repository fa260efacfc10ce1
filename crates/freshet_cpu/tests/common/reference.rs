//! The systems of an incompressible fluid as sums over all pairs in double precision, from the formulas of
//! `freshet_core::pressure_solver` and nothing else.

use freshet_core::kernel::Kernel;
use freshet_core::prelude::*;
use glam::DVec3;

/// Particles and what is around them.
pub struct Reference<'a> {
    plan: &'a Plan,
    kernel: Kernel,
    x: Vec<DVec3>,
    walls: Vec<(DVec3, f64)>,
    /// Of each body its centre of mass, and its samples.
    bodies: Vec<(DVec3, Vec<(DVec3, f64)>)>,
}

impl<'a> Reference<'a> {
    pub fn new(plan: &'a Plan, positions: &[Vec3], bodies: &[BodyInput]) -> Self {
        let walls = plan.boundary.positions.iter().zip(&plan.boundary.volumes);
        let place = |(planned, body): (&freshet_core::plan::PlannedBody, &BodyInput)| {
            let center = body.position.as_dvec3();
            let at = |sample: &Vec3| center + body.rotation.as_dquat() * sample.as_dvec3();
            let volumes = planned.volumes.iter().map(|&volume| f64::from(volume));
            (center, planned.samples.iter().map(at).zip(volumes).collect())
        };
        Self {
            plan,
            kernel: plan.parameters.kernel().unwrap(),
            x: positions.iter().map(|x| x.as_dvec3()).collect(),
            walls: walls.map(|(x, &volume)| (x.as_dvec3(), f64::from(volume))).collect(),
            bodies: plan.bodies.iter().zip(bodies).map(place).collect(),
        }
    }

    fn gradient(&self, apart: DVec3) -> DVec3 {
        self.kernel.derivative_over_r(apart.length()) * apart
    }

    /// All samples that there are.
    fn samples(&self) -> impl Iterator<Item = &(DVec3, f64)> {
        self.walls.iter().chain(self.bodies.iter().flat_map(|(_, samples)| samples))
    }

    /// Relative densities.
    pub fn densities(&self) -> Vec<f64> {
        let p = &self.plan.parameters;
        let (mass, rest) = (f64::from(p.particle_mass), f64::from(p.rest_density));
        let of = |&at: &DVec3| {
            let fluid: f64 = self.x.iter().map(|other| self.kernel.value(at.distance(*other))).sum();
            let wall: f64 = self.samples().map(|(other, volume)| volume * self.kernel.value(at.distance(*other))).sum();
            (mass * fluid / rest + wall) / f64::from(p.density_calibration)
        };
        self.x.iter().map(of).collect()
    }

    /// `D(u) / rho0` of particles that move so while walls stand and bodies move with `(v, omega)`.
    pub fn rates(&self, u: &[DVec3], bodies: &[[DVec3; 2]]) -> Vec<f64> {
        let p = &self.plan.parameters;
        let volume = f64::from(p.particle_mass) / f64::from(p.rest_density);
        let of = |a: usize| {
            let fluid: f64 = (0..self.x.len()).map(|b| (u[a] - u[b]).dot(self.gradient(self.x[a] - self.x[b]))).sum();
            let mut wall: f64 =
                self.walls.iter().map(|(x, volume)| volume * u[a].dot(self.gradient(self.x[a] - x))).sum();
            for ((center, samples), [v, omega]) in self.bodies.iter().zip(bodies) {
                for (x, volume) in samples {
                    let moving = v + omega.cross(x - center);
                    wall += volume * (u[a] - moving).dot(self.gradient(self.x[a] - x));
                }
            }
            (volume * fluid + wall) / f64::from(p.density_calibration)
        };
        (0..self.x.len()).map(of).collect()
    }

    /// Accelerations by pressures `p / rho^2`.
    pub fn accelerations(&self, pressures: &[f64]) -> Vec<DVec3> {
        let p = &self.plan.parameters;
        let (mass, rest) = (f64::from(p.particle_mass), f64::from(p.rest_density));
        let of = |a: usize| {
            let fluid: DVec3 =
                (0..self.x.len()).map(|b| (pressures[a] + pressures[b]) * self.gradient(self.x[a] - self.x[b])).sum();
            let wall: DVec3 =
                self.samples().map(|(x, volume)| *volume * pressures[a] * self.gradient(self.x[a] - x)).sum();
            -(mass * fluid + rest * wall) / f64::from(p.gradient_calibration)
        };
        (0..self.x.len()).map(of).collect()
    }

    /// Force and torque of such pressures on each body.
    #[allow(dead_code)] // Not every test has bodies.
    pub fn loads(&self, pressures: &[f64]) -> Vec<[DVec3; 2]> {
        let p = &self.plan.parameters;
        let factor = f64::from(p.particle_mass) * f64::from(p.rest_density) / f64::from(p.gradient_calibration);
        let of = |(center, samples): &(DVec3, Vec<(DVec3, f64)>)| {
            samples.iter().fold([DVec3::ZERO; 2], |[force, torque], (x, volume)| {
                let on =
                    self.x.iter().zip(pressures).map(|(a, pressure)| *pressure * self.gradient(a - x)).sum::<DVec3>();
                let on = factor * volume * on;
                [force + on, torque + (x - center).cross(on)]
            })
        };
        self.bodies.iter().map(of).collect()
    }
}

/// The plan's particles off their lattice, in motion.
pub fn disturbed(plan: &Plan) -> Snapshot {
    let mut state = 7u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 16_777_216.0 - 0.5
    };
    let count = plan.positions.len();
    let mut vector = |scale: f32| scale * Vec3::new(random(), random(), random());
    Snapshot {
        next_id: count as u32,
        gravity: plan.parameters.gravity,
        ids: (0..count as u32).collect(),
        positions: plan.positions.iter().map(|&x| x + vector(0.002)).collect(),
        velocities: plan.positions.iter().map(|&x| Vec3::new(0.4 - 3.0 * x.x, -x.y, 0.0) + vector(0.2)).collect(),
        remaining_lives: vec![f32::INFINITY; count],
        ..Snapshot::default()
    }
}
