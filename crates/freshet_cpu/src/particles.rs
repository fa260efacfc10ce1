//! The state, as a structure of arrays.

use freshet_core::integrator::Integrator;
use freshet_core::periodic::Periodic;
use glam::Vec3;

use crate::lanes::PADDING;

/// Particles; every real array has [`PADDING`] spare values at its end.
#[derive(Clone, Debug, Default)]
pub struct Particles {
    /// Number of particles.
    pub len: usize,
    /// Ids.
    pub id: Vec<u32>,
    /// Positions, m.
    pub position: [Vec<f32>; 3],
    /// Velocities, m/s.
    pub velocity: [Vec<f32>; 3],
    /// Remaining lifetimes, s.
    pub life: Vec<f32>,
    /// `p / rho^2` of the last substep, m5/(kg s2), if the next one [starts from it](Particles::keep_pressures); empty otherwise.
    pub pressure: Vec<f32>,
    /// `rho/rho0 - 1`, no unit, if particles [carry](freshet_core::density_form) it; empty otherwise.
    pub excess: Vec<f32>,
    /// What the integrator [keeps](Integrator::words) of particles, an array for each number; empty for others.
    pub history: [Vec<f32>; Integrator::MOST_WORDS],
}

impl Particles {
    /// Makes room for `len` particles; new ones are zero.
    pub fn resize(&mut self, len: usize) {
        self.len = len;
        self.id.resize(len, 0);
        for values in self.reals_mut() {
            values.resize(len + PADDING, 0.0);
        }
    }

    /// Makes pressures part of the state, zero at first, or not.
    pub fn keep_pressures(&mut self, keep: bool) {
        if keep != self.keeps_pressures() {
            self.pressure = vec![0.0; if keep { self.len + PADDING } else { 0 }];
        }
    }

    /// Whether pressures are part of the state.
    pub fn keeps_pressures(&self) -> bool {
        !self.pressure.is_empty()
    }

    /// Makes densities part of the state, those at rest at first, or not.
    pub fn carry_densities(&mut self, carry: bool) {
        if carry == self.excess.is_empty() {
            self.excess = vec![0.0; if carry { self.len + PADDING } else { 0 }];
        }
    }

    /// Makes what an integrator keeps part of the state, as that of particles that are new.
    pub fn begin_histories(&mut self, integrator: Integrator) {
        let words = integrator.words();
        for (word, values) in self.history.iter_mut().enumerate() {
            *values = vec![0.0; if word < words { self.len + PADDING } else { 0 }];
        }
    }

    /// Makes room for what `other` keeps.
    pub fn keep_histories_of(&mut self, other: &Self) {
        for (values, others) in self.history.iter_mut().zip(&other.history) {
            if values.is_empty() != others.is_empty() {
                *values = vec![0.0; if others.is_empty() { 0 } else { self.len + PADDING }];
            }
        }
    }

    /// What is kept of one particle.
    pub fn history_of(&self, index: usize) -> impl Iterator<Item = f32> + '_ {
        self.history.iter().filter_map(move |values| values.get(index).copied())
    }

    /// Takes what is kept of all particles, one after the other; without it they are new.
    pub fn take_histories(&mut self, histories: &[f32]) {
        let words = self.history.iter().filter(|values| !values.is_empty()).count();
        for (index, particle) in histories.chunks_exact(words.max(1)).enumerate() {
            for (values, &value) in self.history.iter_mut().zip(particle) {
                values[index] = value;
            }
        }
    }

    /// Becomes what `other` is, in the memory that is there.
    pub fn copy_from(&mut self, other: &Self) {
        self.len = other.len;
        self.id.clone_from(&other.id);
        self.life.clone_from(&other.life);
        self.pressure.clone_from(&other.pressure);
        self.excess.clone_from(&other.excess);
        for (values, others) in self.history.iter_mut().zip(&other.history) {
            values.clone_from(others);
        }
        for (values, others) in self.position.iter_mut().zip(&other.position) {
            values.clone_from(others);
        }
        for (values, others) in self.velocity.iter_mut().zip(&other.velocity) {
            values.clone_from(others);
        }
    }

    /// The largest speed, m/s.
    pub fn fastest(&self) -> f32 {
        let [u, v, w] = &self.velocity;
        let squares = u.iter().zip(v).zip(w).take(self.len).map(|((u, v), w)| u * u + v * v + w * w);
        squares.fold(0.0, f32::max).sqrt()
    }

    /// Adds a particle.
    pub fn push(&mut self, id: u32, position: Vec3, velocity: Vec3, life: f32) {
        let index = self.len;
        self.resize(index + 1);
        self.id[index] = id;
        self.life[index] = life;
        // Where there was padding there may be what is left of a particle that fell out.
        for value in self
            .history
            .iter_mut()
            .chain([&mut self.pressure, &mut self.excess])
            .filter_map(|values| values.get_mut(index))
        {
            *value = 0.0;
        }
        for axis in 0..3 {
            self.position[axis][index] = position[axis];
            self.velocity[axis][index] = velocity[axis];
        }
    }

    /// Brings particles back into the periods of a domain that repeats itself.
    pub fn wrap(&mut self, periodic: &Periodic) {
        for axis in 0..3 {
            if periodic.along(axis).is_some() {
                for value in &mut self.position[axis][..self.len] {
                    *value = periodic.wrap_along(axis, *value);
                }
            }
        }
    }

    /// Gives memory back when less than a quarter of it is in use.
    pub fn shrink(&mut self) {
        if self.id.capacity() > 4 * self.len.max(1024) {
            let room = 2 * self.len;
            self.id.shrink_to(room);
            for values in self.reals_mut() {
                values.shrink_to(room + PADDING);
            }
        }
    }

    /// Bytes allocated.
    pub fn bytes(&self) -> u64 {
        let reals: usize = self.reals().map(Vec::capacity).sum();
        4 * (reals + self.id.capacity()) as u64
    }

    /// Position of one particle, m.
    pub fn position_of(&self, index: usize) -> Vec3 {
        Vec3::new(self.position[0][index], self.position[1][index], self.position[2][index])
    }

    /// Velocity of one particle, m/s.
    pub fn velocity_of(&self, index: usize) -> Vec3 {
        Vec3::new(self.velocity[0][index], self.velocity[1][index], self.velocity[2][index])
    }

    fn reals(&self) -> impl Iterator<Item = &Vec<f32>> {
        self.position
            .iter()
            .chain(&self.velocity)
            .chain([&self.life, &self.pressure, &self.excess])
            .chain(&self.history)
    }

    fn reals_mut(&mut self) -> impl Iterator<Item = &mut Vec<f32>> {
        let optional = self.history.iter_mut().chain([&mut self.pressure, &mut self.excess]);
        let kept = optional.filter(|values| !values.is_empty());
        self.position.iter_mut().chain(&mut self.velocity).chain([&mut self.life]).chain(kept)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_new_particle_has_no_pressure_of_one_that_is_gone() {
        let mut particles = Particles::default();
        particles.keep_pressures(true);
        for id in 0..20 {
            particles.push(id, Vec3::ZERO, Vec3::ZERO, f32::INFINITY);
        }
        particles.pressure.fill(7.0);
        particles.resize(5);
        particles.push(20, Vec3::ZERO, Vec3::ZERO, f32::INFINITY);
        assert_eq!(particles.pressure[4..6], [7.0, 0.0]);
    }

    #[test]
    fn a_new_particle_has_no_past() {
        let mut particles = Particles::default();
        particles.begin_histories(Integrator::Leapfrog);
        for id in 0..20 {
            particles.push(id, Vec3::ZERO, Vec3::ZERO, f32::INFINITY);
        }
        particles.history[0].fill(7.0);
        particles.resize(5);
        particles.push(20, Vec3::ZERO, Vec3::ZERO, f32::INFINITY);
        assert_eq!(particles.history[0][4..6], [7.0, 0.0]);
        assert!(particles.history[1..].iter().all(Vec::is_empty), "leapfrog keeps one number");
    }
}
