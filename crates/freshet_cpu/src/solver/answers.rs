//! How bodies answer to the pressures of a solve, see [`DivergenceFree`].

use freshet_core::plan::Parameters;
use freshet_core::pressure_solver::DivergenceFree;
use glam::{DVec3, Vec3};

use super::stages::slope_scale;
use crate::passes::body_motion::{Motion, MovingBody};
use crate::passes::body_touch::Touch;
use crate::workers::Chunk;

/// Force (N) and torque (N m) of the fluid on a body.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Load {
    pub force: Vec3,
    pub torque: Vec3,
}

impl std::ops::Add for Load {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { force: self.force + other.force, torque: self.torque + other.torque }
    }
}

/// Who touches whom, and what comes of it. Empty without bodies.
#[derive(Default)]
pub(super) struct Answers {
    /// Of each chunk.
    pub found: Vec<Vec<Touch>>,
    /// Of all chunks, in their order.
    touches: Vec<Touch>,
    /// Of each body: velocities, then accelerations by the change of pressures.
    motions: Vec<Motion>,
    /// Sums of forces and torques over what is multiplied with pressures.
    sums: Vec<[DVec3; 2]>,
    /// Of each body, by the last change of pressures.
    loads: Vec<Load>,
    /// Inverse diagonals of those that touch, without the bodies' part, in the order of touches.
    plain: Vec<f32>,
    /// `m^2 A / (G H^5)`: force is this times pressures times pushes.
    factor: f32,
}

impl Answers {
    /// Takes what was found in `count` chunks.
    pub fn take_found(&mut self, count: usize, parameters: &Parameters) {
        let gradient = parameters.particle_mass * slope_scale(parameters);
        self.factor = parameters.particle_mass * gradient / parameters.gradient_calibration;
        self.touches.clear();
        self.found[..count].iter().for_each(|found| self.touches.extend(found));
        // A cell's are found body by body: a particle between two bodies would stand apart from itself.
        self.touches.sort_unstable_by_key(|touch| (touch.particle, touch.body));
    }

    /// Bytes allocated.
    pub fn bytes(&self) -> u64 {
        let Self { found, touches, motions, sums, loads, plain, factor: _ } = self;
        let all = touches.capacity() + found.iter().map(Vec::capacity).sum::<usize>();
        let bytes = size_of::<Touch>() * all
            + size_of::<Vec<Touch>>() * found.capacity()
            + size_of::<Motion>() * motions.capacity()
            + size_of::<[DVec3; 2]>() * sums.capacity()
            + size_of::<Load>() * loads.capacity()
            + 4 * plain.capacity();
        bytes as u64
    }

    /// The touches of a chunk's particles.
    pub fn touches_of(&self, chunk: &Chunk) -> &[Touch] {
        // Chunks and touches are in the order of cells.
        let up_to = |end: usize| self.touches.partition_point(|touch| (touch.particle as usize) < end);
        &self.touches[up_to(chunk.particles.start)..up_to(chunk.particles.end)]
    }

    /// How the bodies move.
    pub fn motions(&self) -> &[Motion] {
        &self.motions
    }

    /// What `pressures`, `p / rho^2` of each particle, do to `count` bodies. One after the other and in double precision, whatever the
    /// number of threads.
    pub fn load_by(&mut self, pressures: &[f32], count: usize) -> &[Load] {
        self.sums.clear();
        self.sums.resize(count, [DVec3::ZERO; 2]);
        for touch in &self.touches {
            let pressure = pressures[touch.particle as usize];
            if pressure != 0.0 {
                let [force, torque] = &mut self.sums[touch.body as usize];
                *force += (touch.push * pressure).as_dvec3();
                *torque += (touch.turn * pressure).as_dvec3();
            }
        }
        let factor = f64::from(self.factor);
        let load = |&[force, torque]: &[DVec3; 2]| Load {
            force: (factor * force).as_vec3(),
            torque: (factor * torque).as_vec3(),
        };
        self.loads.clear();
        self.loads.extend(self.sums.iter().map(load));
        &self.loads
    }

    /// Begins with the velocities that bodies would have after `dt` seconds under these loads.
    pub fn begin(&mut self, bodies: &[MovingBody], loads: &[Load], dt: f32) {
        let ahead = |(body, load): (&MovingBody, &Load)| body.ahead(load.force, load.torque, dt);
        self.motions.clear();
        self.motions.extend(bodies.iter().zip(loads).map(ahead));
    }

    /// Goes on with the accelerations of bodies by a change of pressures, which [are kept](Self::loads) too.
    pub fn answer(&mut self, bodies: &[MovingBody], change: &[f32]) {
        if bodies.is_empty() {
            return;
        }
        self.load_by(change, bodies.len());
        let answer = |(body, load): (&MovingBody, &Load)| body.answer(load.force, load.torque);
        self.motions.clear();
        self.motions.extend(bodies.iter().zip(&self.loads).map(answer));
    }

    /// Loads by the last change of pressures.
    pub fn loads(&self) -> &[Load] {
        &self.loads
    }

    /// The largest speed of a body that touches the fluid, m/s.
    pub fn speed(&self, bodies: &[MovingBody]) -> f32 {
        self.touches.iter().map(|touch| bodies[touch.body as usize].speed()).fold(0.0, f32::max)
    }

    /// The particles that touch a body that swells, once each.
    pub fn pushed_out<'a>(&'a self, bodies: &'a [MovingBody]) -> impl Iterator<Item = usize> + 'a {
        let swells = |touch: &&Touch| bodies[touch.body as usize].swollen < 1.0;
        let mut last = None;
        let particles = self.touches.iter().filter(swells).map(|touch| touch.particle as usize);
        particles.filter(move |&particle| last.replace(particle) != Some(particle))
    }

    /// The mean of `|R|` where it counts over those that touch a body which answers or swells; the largest of the bodies.
    pub fn left(&mut self, bodies: &[MovingBody], left: &[f32], change: &[f32], pressure: &[f32]) -> f32 {
        self.sums.clear();
        self.sums.resize(bodies.len(), [DVec3::ZERO; 2]);
        for touch in &self.touches {
            let (at, body) = (touch.particle as usize, touch.body as usize);
            let is_free = change[at] <= -pressure[at] && left[at] < 0.0;
            if bodies[body].inverse_mass > 0.0 || bodies[body].swollen < 1.0 {
                let wrong = if is_free { 0.0 } else { left[at].abs().min(1.0) };
                self.sums[body][0] += DVec3::new(wrong.into(), 1.0, 0.0);
            }
        }
        let mean = |[sums, _]: &[DVec3; 2]| (sums.x / sums.y.max(1.0)) as f32;
        self.sums.iter().map(mean).fold(0.0, f32::max)
    }

    /// Adds to the diagonal what keeps iterations stable when bodies answer: see [`DivergenceFree`].
    pub fn stiffen(&mut self, bodies: &[MovingBody], inverse_diagonal: &mut [f32], parameters: &Parameters) {
        if bodies.is_empty() {
            return;
        }
        let size = |touch: &Touch| {
            let body = &bodies[touch.body as usize];
            let turned = touch.turn.dot(body.inverse_inertia * touch.turn);
            (body.inverse_mass * touch.push.length_squared() + turned).max(0.0).sqrt()
        };
        self.sums.clear();
        self.sums.resize(bodies.len(), [DVec3::ZERO; 2]);
        for touch in &self.touches {
            self.sums[touch.body as usize][0].x += f64::from(size(touch));
        }
        let gradient = parameters.particle_mass * slope_scale(parameters);
        let calibrations = parameters.density_calibration * parameters.gradient_calibration;
        let factor = gradient * gradient / (calibrations * parameters.rest_density) * parameters.particle_mass;
        let over_eigenvalue = parameters.relaxation / DivergenceFree::RELAXATION;
        self.plain.clear();
        for touch in &self.touches {
            let inverse = &mut inverse_diagonal[touch.particle as usize];
            let row = factor * size(touch) * self.sums[touch.body as usize][0].x as f32;
            self.plain.push(*inverse);
            *inverse = (inverse.recip() + over_eigenvalue * row).recip();
        }
    }

    /// Takes that away again.
    pub fn soften(&self, inverse_diagonal: &mut [f32]) {
        // The first of a particle that touches several bodies comes last.
        for (touch, &plain) in self.touches.iter().zip(&self.plain).rev() {
            inverse_diagonal[touch.particle as usize] = plain;
        }
    }
}

#[cfg(test)]
mod tests {
    use freshet_core::prelude::*;

    use super::*;

    #[test]
    fn a_particle_between_two_bodies_that_swell_is_pushed_out_once() -> Result<(), SceneError> {
        let plan = Plan::new(&FluidScene {
            volumes: vec![Volume::block(Vec3::splat(0.1), Vec3::ZERO)],
            ..FluidScene::with_spacing(0.05)
        })?;
        let touch = |particle, body| Touch { particle, body, push: Vec3::X, turn: Vec3::ZERO };
        let found = vec![vec![touch(3, 0), touch(4, 0), touch(3, 1), touch(4, 1)], vec![touch(7, 1)]];
        let mut answers = Answers { found, ..Answers::default() };
        answers.take_found(2, &plan.parameters);
        let bodies = [MovingBody { swollen: 0.5, ..MovingBody::default() }; 2];
        assert_eq!(answers.pushed_out(&bodies).collect::<Vec<_>>(), [3, 4, 7]);
        let whole = bodies.map(|body| MovingBody { swollen: 1.0, ..body });
        assert_eq!(answers.pushed_out(&whole).count(), 0);
        Ok(())
    }
}
