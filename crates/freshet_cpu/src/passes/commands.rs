//! Commands, carried out before a tick's first substep: they add particles, and end the lives of others.

use freshet_core::misplaced::Misplaced;
use freshet_core::step::{Command, NewParticles};
use glam::Vec3;

use crate::particles::Particles;

/// What commands change.
pub struct Population<'a> {
    /// Those there are.
    pub particles: &'a mut Particles,
    /// Most there may be.
    pub max_particles: u32,
    /// The next particle's id.
    pub next_id: &'a mut u32,
    /// m/s2.
    pub gravity: &'a mut Vec3,
    /// Latest time at which particles were said to be where they were spawned, s.
    pub emitted: &'a mut Option<f64>,
    /// Whether any particle has a lifetime.
    pub mortal: &'a mut bool,
    /// Simulated time at the start of the tick, s.
    pub time: f64,
    /// Of the particles that this and later commands spawn, those inside or beside a wall or a body, by their place among all
    /// that the tick's commands spawn, in order.
    pub misplaced: &'a [Misplaced],
    /// Particles that the tick's commands were to spawn so far.
    pub asked: u32,
    /// Particles made and left out, because they are inside; because they are beside.
    pub left_out: [u32; 2],
}

impl Population<'_> {
    /// Carries out a command; returns how many particles there was no room for.
    pub fn carry_out(&mut self, command: &Command) -> u32 {
        match command {
            Command::Spawn(new) => return self.spawn(new),
            Command::RemoveIds { first, count } => {
                let range = *first..first.saturating_add(*count);
                self.retire(|particles, i| range.contains(&particles.id[i]));
            }
            Command::RemoveInBox { min, max } => self.retire(|particles, i| {
                let position = particles.position_of(i);
                position.cmpge(*min).all() && position.cmple(*max).all()
            }),
            Command::SetGravity(gravity) => *self.gravity = *gravity,
        }
        0
    }

    fn spawn(&mut self, new: &NewParticles) -> u32 {
        let room = (self.max_particles as usize).saturating_sub(self.particles.len);
        let count = new.positions.len().min(room);
        // How long ago they were where they are said to be; negative if they will be.
        let age = new.at.map_or(0.0, |at| (self.time - at) as f32);
        for (&position, &velocity) in new.positions.iter().zip(&new.velocities).take(count) {
            // Those misplaced have an id, like those a command removes, and fall out at the next sort.
            let misplaced = self.misplaced.split_first().filter(|(one, _)| one.index == self.asked);
            let life = if misplaced.is_some() { -1.0 } else { new.lifetime - age };
            self.particles.push(*self.next_id, position + velocity * age, velocity, life);
            *self.next_id = self.next_id.wrapping_add(1);
            self.asked += 1;
            if let Some((one, others)) = misplaced {
                self.misplaced = others;
                self.left_out[usize::from(!one.inside)] += 1;
            }
        }
        // Those refused are none of them.
        self.asked += (new.positions.len() - count) as u32;
        let refused = self.misplaced.partition_point(|one| one.index < self.asked);
        self.misplaced = &self.misplaced[refused..];
        *self.emitted = (*self.emitted).into_iter().chain(new.at).reduce(f64::max);
        *self.mortal |= new.lifetime.is_finite();
        (new.positions.len() - count) as u32
    }

    /// Those chosen fall out at the next sort.
    fn retire(&mut self, chosen: impl Fn(&Particles, usize) -> bool) {
        for i in 0..self.particles.len {
            if chosen(self.particles, i) {
                self.particles.life[i] = -1.0;
            }
        }
    }
}
