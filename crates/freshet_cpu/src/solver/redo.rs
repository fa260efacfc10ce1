//! Substeps that turn out too long are taken back and made again, see [`Parameters::redone`].

use freshet_core::plan::Parameters;

use super::{CpuSolver, Found, Tally};
use crate::particles::Particles;
use crate::passes::acceleration::Maxima;
use crate::passes::body_motion::MovingBody;
use crate::passes::sort::Dropped;
use crate::passes::step_control;

/// A state to go back to.
#[derive(Default)]
pub(super) struct Before {
    particles: Particles,
    bodies: Vec<MovingBody>,
    last_substep: f32,
    dropped: Dropped,
}

impl Before {
    /// Bytes allocated.
    pub fn bytes(&self) -> u64 {
        self.particles.bytes() + (size_of::<MovingBody>() * self.bodies.capacity()) as u64
    }

    /// Gives memory back when less than a quarter of it is in use.
    pub fn shrink(&mut self) {
        self.particles.shrink();
    }
}

impl CpuSolver {
    /// A substep of at most `remaining` seconds that is as short as the state demands that it leaves; returns its length. What was found out about
    /// that state is left in `found`, for the next substep of the tick.
    pub(super) fn substep_or_redo(&mut self, found: &mut Option<Found>, remaining: f32, tally: &mut Tally) -> f32 {
        let mut start = found.take().unwrap_or_else(|| self.find(tally));
        let mut dt = self.length(&start, remaining, tally);
        self.keep(tally);
        for redos in 0.. {
            let particles = self.particles.len;
            self.advance(&start, dt, tally);
            let end = self.find(tally);
            let shorter = Parameters::redone(dt, self.limit_of(&end));
            let Some(shorter) = shorter.filter(|_| redos < Parameters::MOST_REDOS) else {
                tally.count_substep(&start, dt, particles);
                *found = Some(end);
                break;
            };
            self.go_back(tally);
            tally.redone += 1;
            start = self.find(tally);
            dt = shorter;
        }
        dt
    }

    /// What a state allows, by the speeds that particles have and not by those that they are expected to have.
    fn limit_of(&self, found: &Found) -> f32 {
        let maxima = Maxima { speed_squared: self.particles.fastest().powi(2), ..found.maxima };
        step_control::limit(&self.plan.parameters, &maxima, (&self.plan.bodies, &self.bodies), self.gravity)
    }

    fn keep(&mut self, tally: &Tally) {
        self.before.particles.copy_from(&self.particles);
        self.before.bodies.clone_from(&self.bodies);
        self.before.last_substep = self.last_substep;
        self.before.dropped = tally.dropped;
    }

    fn go_back(&mut self, tally: &mut Tally) {
        self.particles.copy_from(&self.before.particles);
        self.bodies.clone_from(&self.before.bodies);
        self.last_substep = self.before.last_substep;
        tally.dropped = self.before.dropped;
    }
}
