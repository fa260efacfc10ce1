//! Stage `body_drag`: fluid sticks to bodies, and drags them along (Morris, Fox & Zhu 1997, J. Comput. Phys. 136, 214).
//!
//! What a particle feels is what it feels of a [wall](super::morris1997): `(mu rho0 / rho_a^2) (1/G) |D| (u - v_a) / y`, with
//! `s = sum_k V_k F`, `D = sum_k V_k F x_ak` and `y = |D| / s - depth` over the samples of a body. `u` is the velocity that the body would
//! have where the particle is, `v + omega x (x_a - x)`: fluid that turns with a body, as a whole, is not sheared.
//!
//! The body gets the opposite, at the place of the particle, so that angular momentum is kept too. A particle sticks to one body only: of
//! several to that with the largest `s`.

use std::marker::PhantomData;

use glam::Vec3;
use pulp::{Arch, Simd, WithSimd};

use super::body_contact::{Around, Contact, Drag};
use super::body_motion::MovingBody;
use crate::candidates::Candidates;
use crate::simd_kernel::{SimdKernel, WithKernel};
use crate::workers::Chunk;
use crate::workspace::Workspace;

/// What a chunk needs.
#[derive(Clone, Copy)]
pub struct Inputs<'a> {
    /// Instruction set.
    pub arch: Arch,
    /// Particles and samples of bodies.
    pub around: Around<'a>,
    /// Densities, kg/m3.
    pub density: &'a [f32],
    /// The bodies.
    pub bodies: &'a [MovingBody],
    /// `-mu rho0 A / (G H^5)`.
    pub factor: f32,
    /// kg.
    pub particle_mass: f32,
    /// How far samples lie behind the surface, m.
    pub depth: f32,
    /// Nearest a particle is taken to be to the surface, m.
    pub nearest: f32,
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
    /// Accelerations, m/s2, to which that of the drag is added.
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

/// Force on a particle, N, over its mass, and where it is from the centre of mass.
fn drag(contact: &Contact, inputs: &Inputs, velocity: Vec3, density: f32) -> (Vec3, Vec3) {
    let distance = contact.away().length();
    let arm = contact.arm();
    let y = (distance - inputs.depth).max(inputs.nearest);
    let surface = inputs.bodies[contact.body].surface_velocity(arm);
    let rate = inputs.factor / (density * density) * contact.strength * distance / y;
    (rate * (surface - velocity), arm)
}

struct Typed<'a, K>(Task<'a>, PhantomData<K>);

impl<K: SimdKernel> WithSimd for Typed<'_, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Task { inputs, chunk, workspace, candidates, acceleration: [ax, ay, az], drags } = self.0;
        drags.clear();
        let Inputs { around, .. } = inputs;
        around.each_cell::<S, K>(
            simd,
            (chunk, candidates),
            workspace,
            |_| 1.0,
            |particles, contacts| {
                for (i, contact) in particles.zip(contacts).filter(|(_, contact)| contact.strength < 0.0) {
                    let at = i - chunk.particles.start;
                    let (drag, arm) = drag(contact, &inputs, around.particles.velocity_of(i), inputs.density[i]);
                    (ax[at], ay[at], az[at]) = (Vec3::new(ax[at], ay[at], az[at]) + drag).into();
                    drags.push(Drag { body: contact.body as u32, force: -inputs.particle_mass * drag, arm });
                }
            },
        );
    }
}
