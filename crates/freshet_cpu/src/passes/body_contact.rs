//! Which body a particle sticks to or rubs on, with the sums over its samples that both need.

use freshet_core::grid::Grid;
use glam::Vec3;
use pulp::Simd;

use super::body_sort::BodySamples;
use crate::candidates::Candidates;
use crate::lanes::{ScaledRoot, difference, sum_vector};
use crate::packed::Packed;
use crate::particles::Particles;
use crate::simd_kernel::SimdKernel;
use crate::workers::Chunk;
use crate::workspace::Workspace;

/// What a body gets of a particle that sticks to it or rubs on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drag {
    /// Index of the body in the plan.
    pub body: u32,
    /// N.
    pub force: Vec3,
    /// From the body's centre of mass to the particle, m.
    pub arm: Vec3,
}

/// Sums over the samples of one body, without their factor.
#[derive(Clone, Copy, Default)]
pub struct Contact {
    /// Index of the body in the plan.
    pub body: usize,
    /// `sum_k V_k F`, negative; zero without any.
    pub strength: f32,
    /// `sum_k V_k F x_ak`, pointing towards the body.
    pub slope: Vec3,
    /// `sum_k V_k F r_k`, where samples are from the centre of mass.
    arms: Vec3,
}

impl Contact {
    /// From the samples to the particle, m.
    pub fn away(&self) -> Vec3 {
        self.slope / self.strength
    }

    /// From the body's centre of mass to the particle, m.
    pub fn arm(&self) -> Vec3 {
        self.arms / self.strength + self.away()
    }
}

/// Particles and the samples around them.
#[derive(Clone, Copy)]
pub struct Around<'a> {
    /// Grid of everything.
    pub grid: &'a Grid,
    /// First particle of each cell.
    pub starts: &'a [u32],
    /// Sorted particles.
    pub particles: &'a Particles,
    /// Samples of all bodies, with their [arms](BodySamples::find_arms).
    pub samples: &'a BodySamples,
    /// Lists of candidates before those of bodies: of the fluid, and of walls if there are any.
    pub lists_before: usize,
}

impl Around<'_> {
    /// Calls `look` with the particles of each cell near bodies and their contacts: of several bodies that with the largest sum of `V_k F`, times the
    /// weight of the body.
    #[inline(always)]
    pub fn each_cell<S: Simd, K: SimdKernel>(
        &self,
        simd: S,
        (chunk, candidates): (&Chunk, &Candidates),
        workspace: &mut Workspace,
        weight: impl Fn(usize) -> f32,
        mut look: impl FnMut(std::ops::Range<usize>, &[Contact]),
    ) {
        let [x, y, z] = &self.particles.position;
        let Workspace { viscous: packed, sums, contacts, .. } = workspace;
        packed.begin(self.grid);
        let (samples, [rx, ry, rz], owners) = (&self.samples.sorted, self.samples.arms(), self.samples.owners());
        let [sx, sy, sz] = &samples.position;
        let in_radii = ScaledRoot::new(simd, 1.0 / self.grid.support_radius);
        let mut lists = candidates.lists();
        for cell in chunk.cells.clone() {
            let range = self.starts[cell] as usize..self.starts[cell + 1] as usize;
            if range.is_empty() {
                continue;
            }
            let list = lists.nth(self.lists_before).unwrap_or_default();
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
                let body = owner as usize;
                for (contact, &[s, dx, dy, dz, rx, ry, rz]) in contacts.iter_mut().zip(&*sums) {
                    let strength = simd.reduce_sum_f32s(s);
                    if weight(body) * strength < weight(contact.body) * contact.strength {
                        let (slope, arms) = (sum_vector(simd, [dx, dy, dz]), sum_vector(simd, [rx, ry, rz]));
                        *contact = Contact { body, strength, slope, arms };
                    }
                }
            }
            look(range, contacts);
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
