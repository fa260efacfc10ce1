//! Stage `body_drag`: fluid sticks to bodies, and drags them along (Morris, Fox & Zhu 1997, J. Comput. Phys. 136, 214).
//!
//! What a particle feels is what it feels of a [wall](super::morris1997): `(mu rho0 / rho_a^2) (1/G) |D| (u - v_a) / y`, with
//! `s = sum_k V_k F`, `D = sum_k V_k F x_ak` and `y = |D| / s - depth` over the samples of a body. `u` is the velocity that the body would
//! have where the particle is, `v + omega x (x_a - x)`: fluid that turns with a body, as a whole, is not sheared.
//!
//! The body gets the opposite, at the place of the particle, so that angular momentum is kept too. A particle sticks to one body only: of
//! several to that with the largest `s`.

use std::marker::PhantomData;

use freshet_core::grid::Grid;
use glam::Vec3;
use pulp::{Arch, Simd, WithSimd};

use super::body_motion::MovingBody;
use super::body_sort::BodySamples;
use crate::candidates::Candidates;
use crate::lanes::{ScaledRoot, difference, sum_vector};
use crate::packed::Packed;
use crate::particles::Particles;
use crate::simd_kernel::{SimdKernel, WithKernel};
use crate::workers::Chunk;
use crate::workspace::Workspace;

/// What a body gets of a particle that sticks to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drag {
    /// Index of the body in the plan.
    pub body: u32,
    /// N.
    pub force: Vec3,
    /// From the body's centre of mass to the particle, m.
    pub arm: Vec3,
}

/// What a chunk needs.
#[derive(Clone, Copy)]
pub struct Inputs<'a> {
    /// Instruction set.
    pub arch: Arch,
    /// Grid of everything.
    pub grid: &'a Grid,
    /// First particle of each cell.
    pub starts: &'a [u32],
    /// Sorted particles.
    pub particles: &'a Particles,
    /// Densities, kg/m3.
    pub density: &'a [f32],
    /// Samples of all bodies, with their [arms](BodySamples::find_arms).
    pub samples: &'a BodySamples,
    /// The bodies.
    pub bodies: &'a [MovingBody],
    /// Lists of candidates before those of bodies: of the fluid, and of walls if there are any.
    pub lists_before: usize,
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

/// Sums over the samples of one body, without their factor.
#[derive(Clone, Copy, Default)]
pub struct Contact {
    body: usize,
    /// `s`, negative.
    strength: f32,
    /// `D`, pointing towards the body.
    slope: Vec3,
    /// `sum_k V_k F r_k`, where samples are from the centre of mass.
    arms: Vec3,
}

impl Contact {
    /// Force on the particle, N, over its mass, and where it is from the centre of mass.
    fn drag(&self, inputs: &Inputs, velocity: Vec3, density: f32) -> (Vec3, Vec3) {
        let away = self.slope / self.strength;
        let distance = away.length();
        let arm = self.arms / self.strength + away;
        let y = (distance - inputs.depth).max(inputs.nearest);
        let body = &inputs.bodies[self.body];
        let surface = body.linear_velocity + body.drift + (body.angular_velocity + body.turn).cross(arm);
        let rate = inputs.factor / (density * density) * self.strength * distance / y;
        (rate * (surface - velocity), arm)
    }
}

struct Typed<'a, K>(Task<'a>, PhantomData<K>);

impl<K: SimdKernel> WithSimd for Typed<'_, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Task { inputs, chunk, workspace, candidates, acceleration: [ax, ay, az], drags } = self.0;
        let [x, y, z] = &inputs.particles.position;
        let Workspace { viscous: packed, sums, contacts, .. } = workspace;
        packed.begin(inputs.grid);
        drags.clear();
        let (samples, [rx, ry, rz], owners) = (&inputs.samples.sorted, inputs.samples.arms(), inputs.samples.owners());
        let [sx, sy, sz] = &samples.position;
        let in_radii = ScaledRoot::new(simd, 1.0 / inputs.grid.support_radius);
        let mut lists = candidates.lists();
        for cell in chunk.cells.clone() {
            let range = inputs.starts[cell] as usize..inputs.starts[cell + 1] as usize;
            if range.is_empty() {
                continue;
            }
            let list = lists.nth(inputs.lists_before).unwrap_or_default();
            if list.is_empty() {
                continue;
            }
            let own = [&x[range.clone()], &y[range.clone()], &z[range.clone()]];
            packed.pack(simd, list, [sx, sy, sz, &samples.volume, rx, ry, rz, owners], own[0][0]);
            contacts.clear();
            contacts.resize(range.len(), Contact::default());
            let mut last = -1.0;
            // Owners are whole numbers; there is seldom more than one.
            while let Some(owner) = packed.values(7).iter().copied().filter(|&owner| owner > last).reduce(f32::min) {
                last = owner;
                let (sums, _) = sums.zeroed::<S>(7 * range.len()).as_chunks_mut::<7>();
                add_samples::<S, K>(simd, in_radii, own, packed, owner, sums);
                for (contact, &[s, dx, dy, dz, rx, ry, rz]) in contacts.iter_mut().zip(&*sums) {
                    let strength = simd.reduce_sum_f32s(s);
                    if strength < contact.strength {
                        let (slope, arms) = (sum_vector(simd, [dx, dy, dz]), sum_vector(simd, [rx, ry, rz]));
                        *contact = Contact { body: owner as usize, strength, slope, arms };
                    }
                }
            }
            for (i, contact) in range.clone().zip(&*contacts).filter(|(_, contact)| contact.strength < 0.0) {
                let at = i - chunk.particles.start;
                let (drag, arm) = contact.drag(&inputs, inputs.particles.velocity_of(i), inputs.density[i]);
                (ax[at], ay[at], az[at]) = (Vec3::new(ax[at], ay[at], az[at]) + drag).into();
                drags.push(Drag { body: contact.body as u32, force: -inputs.particle_mass * drag, arm });
            }
        }
    }
}

/// `sum_k V_k f'(q)/q` times one, `x_ak` and `r_k` over the samples of one body, for each of a cell's particles.
#[inline(always)]
fn add_samples<S: Simd, K: SimdKernel>(
    simd: S,
    in_radii: ScaledRoot<S>,
    own: [&[f32]; 3],
    all: &Packed<8>,
    owner: f32,
    sums: &mut [[S::f32s; 7]],
) {
    let (zero, one, owner) = (simd.splat_f32s(0.0), simd.splat_f32s(1.0), simd.splat_f32s(owner));
    let mut first = 0;
    while first < all.len() {
        let [ox, oy, oz, volume, rx, ry, rz, whose] = all.lanes::<S>(first);
        // Of another body, whose number differs by one or more, nothing.
        let apart = simd.max_f32s(simd.sub_f32s(whose, owner), simd.sub_f32s(owner, whose));
        let volume = simd.mul_f32s(volume, simd.max_f32s(simd.sub_f32s(one, apart), zero));
        for (((sum, &x), &y), &z) in sums.iter_mut().zip(own[0]).zip(own[1]).zip(own[2]) {
            let ([dx, dy, dz], squared) = difference(simd, [x, y, z], [ox, oy, oz]);
            let slope = K::slope_over_q(simd, simd.min_f32s(in_radii.of(simd, squared), one));
            let weight = simd.mul_f32s(volume, slope);
            sum[0] = simd.add_f32s(weight, sum[0]);
            for (sum, along) in sum[1..].iter_mut().zip([dx, dy, dz, rx, ry, rz]) {
                *sum = simd.mul_add_f32s(weight, along, *sum);
            }
        }
        first += S::F32_LANES;
    }
}
