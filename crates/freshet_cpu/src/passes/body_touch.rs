//! Which particles of an incompressible fluid touch which body, and how: with this its pressures push the bodies, and the bodies'
//! motion changes its densities, without a sum over samples in every iteration.
//!
//! A body moves as a whole: sample k with `v + omega x r_k`. So what it adds to the rate of a density,
//! `-sum_k V_k (v + omega x r_k) . grad W_ak = -(v . g + omega . t)`, needs two vectors a particle and body, `g = sum_k V_k grad W_ak` and
//! `t = sum_k V_k r_k x grad W_ak`; and by these a pressure pushes and turns the body.

use freshet_core::grid::Grid;
use glam::Vec3;
use pulp::{Arch, Simd, WithSimd};

use super::body_sort::BodySamples;
use crate::candidates::Candidates;
use crate::lanes::{ScaledRoot, difference, sum_vector};
use crate::packed::Packed;
use crate::particles::Particles;
use crate::simd_kernel::{SimdKernel, WithKernel};
use crate::workers::Chunk;
use crate::workspace::Workspace;

/// A particle within reach of a body's samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// Index of the sorted particle.
    pub particle: u32,
    /// Index of the body in the plan.
    pub body: u32,
    /// `g`, as `rho0/m sum_k V_k f'(q)/q x_ak`, m.
    pub push: Vec3,
    /// `t` likewise, about the centre of mass, m2.
    pub turn: Vec3,
}

/// The touches of a chunk.
pub struct Task<'a> {
    /// Instruction set.
    pub arch: Arch,
    /// Grid of everything.
    pub grid: &'a Grid,
    /// First particle of each cell.
    pub starts: &'a [u32],
    /// Sorted particles.
    pub particles: &'a Particles,
    /// Samples of all bodies, with their [arms](BodySamples::find_arms).
    pub samples: &'a BodySamples,
    /// Whether there are walls, whose candidates come before those of bodies.
    pub walls: bool,
    /// `rho0 / m`, 1/m3.
    pub number_density: f32,
    /// Cells and particles.
    pub chunk: &'a Chunk,
    /// Memory of the thread.
    pub workspace: &'a mut Workspace,
    /// Their candidates, as the density pass found them.
    pub candidates: &'a Candidates,
    /// Result.
    pub touches: &'a mut Vec<Touch>,
}

impl WithKernel for Task<'_> {
    type Output = ();

    fn with<K: SimdKernel>(self, _: K) {
        self.arch.dispatch(Typed::<K>(self, std::marker::PhantomData));
    }
}

struct Typed<'a, K>(Task<'a>, std::marker::PhantomData<K>);

impl<K: SimdKernel> WithSimd for Typed<'_, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let task = self.0;
        let [x, y, z] = &task.particles.position;
        let Workspace { viscous: packed, sums, .. } = task.workspace;
        packed.begin(task.grid);
        task.touches.clear();
        let (samples, [rx, ry, rz], owners) = (&task.samples.sorted, task.samples.arms(), task.samples.owners());
        let [sx, sy, sz] = &samples.position;
        let in_radii = ScaledRoot::new(simd, 1.0 / task.grid.support_radius);
        let mut lists = task.candidates.lists();
        for cell in task.chunk.cells.clone() {
            let range = task.starts[cell] as usize..task.starts[cell + 1] as usize;
            if range.is_empty() {
                continue;
            }
            let list = lists.nth(1 + usize::from(task.walls)).unwrap_or_default();
            if list.is_empty() {
                continue;
            }
            let own = [&x[range.clone()], &y[range.clone()], &z[range.clone()]];
            packed.pack(simd, list, [sx, sy, sz, &samples.volume, rx, ry, rz, owners], own[0][0]);
            let mut last = -1.0;
            // Owners are whole numbers; there is seldom more than one.
            while let Some(owner) = packed.values(7).iter().copied().filter(|&owner| owner > last).reduce(f32::min) {
                last = owner;
                let (sums, _) = sums.zeroed::<S>(6 * range.len()).as_chunks_mut::<6>();
                add_samples::<S, K>(simd, in_radii, own, packed, owner, sums);
                for (particle, &[px, py, pz, tx, ty, tz]) in range.clone().zip(&*sums) {
                    let push = task.number_density * sum_vector(simd, [px, py, pz]);
                    let turn = task.number_density * sum_vector(simd, [tx, ty, tz]);
                    if push != Vec3::ZERO || turn != Vec3::ZERO {
                        task.touches.push(Touch { particle: particle as u32, body: owner as u32, push, turn });
                    }
                }
            }
        }
    }
}

/// `sum_k V_k f'(q)/q x_ak` and `sum_k V_k r_k x f'(q)/q x_ak` over the samples of one body, for each of a cell's particles.
#[inline(always)]
fn add_samples<S: Simd, K: SimdKernel>(
    simd: S,
    in_radii: ScaledRoot<S>,
    own: [&[f32]; 3],
    all: &Packed<8>,
    owner: f32,
    sums: &mut [[S::f32s; 6]],
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
            let factor = simd.mul_f32s(volume, slope);
            let [gx, gy, gz] = [dx, dy, dz].map(|along| simd.mul_f32s(factor, along));
            sum[0] = simd.add_f32s(sum[0], gx);
            sum[1] = simd.add_f32s(sum[1], gy);
            sum[2] = simd.add_f32s(sum[2], gz);
            for (axis, ([r, s], [g, h])) in
                [([ry, rz], [gy, gz]), ([rz, rx], [gz, gx]), ([rx, ry], [gx, gy])].into_iter().enumerate()
            {
                sum[3 + axis] = simd.add_f32s(sum[3 + axis], simd.sub_f32s(simd.mul_f32s(r, h), simd.mul_f32s(s, g)));
            }
        }
        first += S::F32_LANES;
    }
}
