//! Stage `body_friction`: what bodies that the fluid does not move take of velocities along them, see [`Friction`](freshet_core::scene::Friction).
//!
//! As that of [walls](super::friction), with `D = sum_k V_k F x_ak` over the samples of a body, its own coefficients and the velocity that it has at the
//! end of the substep where the particle is, `v + omega x (x_a - x)`. The body gets the opposite, at the place of the particle. Of several bodies a particle rubs on
//! that which could hold it the most.

use std::marker::PhantomData;

use freshet_core::plan::PlannedBody;
use pulp::{Arch, Simd, WithSimd};

use super::body_contact::{Around, Drag};
use super::body_motion::MovingBody;
use super::friction::taken;
use crate::candidates::Candidates;
use crate::simd_kernel::{SimdKernel, WithKernel};
use crate::workers::Chunk;
use crate::workspace::Workspace;
use glam::Vec3;

/// What a chunk needs.
#[derive(Clone, Copy)]
pub struct Inputs<'a> {
    /// Instruction set.
    pub arch: Arch,
    /// Particles and samples of bodies.
    pub around: Around<'a>,
    /// The bodies as planned.
    pub planned: &'a [PlannedBody],
    /// The bodies.
    pub bodies: &'a [MovingBody],
    /// `p / rho^2`, padded.
    pub pressure_term: &'a [f32],
    /// `-rho0 A / (G H^5)`.
    pub factor: f32,
    /// kg.
    pub particle_mass: f32,
    /// The substep, s.
    pub dt: f32,
}

/// A chunk's particles.
pub struct Task<'a> {
    /// Shared inputs.
    pub inputs: Inputs<'a>,
    /// Cells and particles.
    pub chunk: &'a Chunk,
    /// Memory of the thread.
    pub workspace: &'a mut Workspace,
    /// Their candidates, as the density pass found them.
    pub candidates: &'a Candidates,
    /// Accelerations, m/s2, to which that of friction is added.
    pub acceleration: [&'a mut [f32]; 3],
    /// Result, in the order of the particles.
    pub drags: &'a mut Vec<Drag>,
}

impl WithKernel for Task<'_> {
    type Output = ();

    fn with<K: SimdKernel>(self, _: K) {
        self.inputs.arch.dispatch(Typed::<K>(self, PhantomData));
    }
}

struct Typed<'a, K>(Task<'a>, PhantomData<K>);

impl<K: SimdKernel> WithSimd for Typed<'_, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Task { inputs, chunk, workspace, candidates, acceleration: [ax, ay, az], drags } = self.0;
        let Inputs { around, planned, dt, .. } = inputs;
        drags.clear();
        let at_rest = |body: usize| planned[body].friction.at_rest;
        around.each_cell::<S, K>(simd, (chunk, candidates), workspace, at_rest, |particles, contacts| {
            for (i, contact) in particles.zip(contacts).filter(|(_, contact)| contact.strength < 0.0) {
                let pressure = inputs.pressure_term[i];
                // What does not press is not held.
                if pressure <= 0.0 {
                    continue;
                }
                let friction = planned[contact.body].friction;
                let at = i - chunk.particles.start;
                let before = Vec3::new(ax[at], ay[at], az[at]);
                let arm = contact.arm();
                let ahead = inputs.bodies[contact.body].ahead(Vec3::ZERO, Vec3::ZERO, dt);
                let surface = ahead.linear + ahead.angular.cross(arm);
                let velocity = around.particles.velocity_of(i) + dt * before - surface;
                let push = inputs.factor * pressure * contact.slope;
                let taken = taken(velocity, friction.at_rest * push, friction.sliding * push.length(), dt);
                (ax[at], ay[at], az[at]) = (before - taken).into();
                drags.push(Drag { body: contact.body as u32, force: inputs.particle_mass * taken, arm });
            }
        });
    }
}
