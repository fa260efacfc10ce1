//! Stage `xsph`: what particles move with beside their own velocity, see [`freshet_core::xsph`].
//!
//! `e_a = epsilon (m/S) sum_b 2 (v_b - v_a) / (rho_a + rho_b) W_ab` over the fluid, of the velocities that particles leave the
//! substep with.

use std::marker::PhantomData;

use freshet_core::grid::Grid;
use pulp::{Arch, Simd, WithSimd};

use crate::candidates::Candidates;
use crate::lanes::{ScaledRoot, difference, divide, sum_vector};
use crate::packed::Packed;
use crate::particles::Particles;
use crate::simd_kernel::{SimdKernel, WithKernel};
use crate::workers::Chunk;
use crate::workspace::Workspace;

/// What a chunk needs.
#[derive(Clone, Copy)]
pub struct Inputs<'a> {
    /// Instruction set.
    pub arch: Arch,
    /// Grid of everything.
    pub grid: &'a Grid,
    /// First particle of each cell.
    pub starts: &'a [u32],
    /// Sorted particles, with the velocities they leave the substep with.
    pub particles: &'a Particles,
    /// Densities, kg/m3, padded.
    pub density: &'a [f32],
    /// Lists of samples after each cell's list of particles.
    pub kinds_of_samples: usize,
    /// `2 epsilon m A / (S H^3)`.
    pub factor: f32,
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
    /// Result, m/s.
    pub drift: [&'a mut [f32]; 3],
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
        let Task { inputs, chunk, workspace, candidates, drift: [ex, ey, ez] } = self.0;
        let ([x, y, z], [u, v, w]) = (&inputs.particles.position, &inputs.particles.velocity);
        let Workspace { sticking: fluid, sums, .. } = workspace;
        fluid.begin(inputs.grid);
        let in_radii = ScaledRoot::new(simd, 1.0 / inputs.grid.support_radius);
        let mut lists = candidates.lists();
        for cell in chunk.cells.clone() {
            let range = inputs.starts[cell] as usize..inputs.starts[cell + 1] as usize;
            if range.is_empty() {
                continue;
            }
            let r = || range.clone();
            let own = [&x[r()], &y[r()], &z[r()], &u[r()], &v[r()], &w[r()], &inputs.density[r()]];
            let (sums, _) = sums.zeroed::<S>(3 * range.len()).as_chunks_mut::<3>();
            let list = lists.next().unwrap_or_default();
            for _ in 0..inputs.kinds_of_samples {
                lists.next();
            }
            fluid.pack(simd, list, [x, y, z, u, v, w, inputs.density], own[0][0]);
            add_fluid::<S, K>(simd, in_radii, own, fluid, sums);
            for (i, &sum) in (range.start - chunk.particles.start..).zip(&*sums) {
                (ex[i], ey[i], ez[i]) = (inputs.factor * sum_vector(simd, sum)).into();
            }
        }
    }
}

/// `sum_b f(q) (v_b - v_a) / (rho_a + rho_b)`, for each of a cell's particles.
#[inline(always)]
fn add_fluid<S: Simd, K: SimdKernel>(
    simd: S,
    in_radii: ScaledRoot<S>,
    own: [&[f32]; 7],
    all: &Packed<7>,
    sums: &mut [[S::f32s; 3]],
) {
    let [x, y, z, u, v, w, density] = own;
    let one = simd.splat_f32s(1.0);
    let mut first = 0;
    while first < all.len() {
        let [ox, oy, oz, ou, ov, ow, other_density] = all.lanes::<S>(first);
        let motions = u.iter().zip(v).zip(w).zip(density);
        for ((((sum, &x), &y), &z), (((&u, &v), &w), &density)) in sums.iter_mut().zip(x).zip(y).zip(z).zip(motions) {
            let (_, squared) = difference(simd, [x, y, z], [ox, oy, oz]);
            let shape = K::shape(simd, simd.min_f32s(in_radii.of(simd, squared), one));
            let factor = divide(simd, shape, simd.add_f32s(simd.splat_f32s(density), other_density));
            sum[0] = simd.mul_add_f32s(factor, simd.sub_f32s(ou, simd.splat_f32s(u)), sum[0]);
            sum[1] = simd.mul_add_f32s(factor, simd.sub_f32s(ov, simd.splat_f32s(v)), sum[1]);
            sum[2] = simd.mul_add_f32s(factor, simd.sub_f32s(ow, simd.splat_f32s(w)), sum[2]);
        }
        first += S::F32_LANES;
    }
}
