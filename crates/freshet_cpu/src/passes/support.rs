//! Stage `support`: how wide the support of each particle is, see [`freshet_core::variable_support`].
//!
//! `w_a = (rho0 / rho_a)^(1/3)` within limits, `rho_a = (1/S) (m sum_b W(r_ab, w_a H) + rho0 sum_k V_k W(r_ak, H))`, from 1 on.

use std::marker::PhantomData;

use freshet_core::grid::Grid;
use freshet_core::variable_support::EVALUATIONS;
use pulp::{Arch, Simd, WithSimd};

use crate::candidates::Near;
use crate::lanes::{ScaledRoot, difference};
use crate::neighbours::Rows;
use crate::packed::Packed;
use crate::particles::Particles;
use crate::samples::SortedSamples;
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
    /// Sorted particles.
    pub particles: &'a Particles,
    /// Walls and bodies.
    pub samples: &'a [&'a SortedSamples],
    /// Factor of fluid neighbours, `m A / (S H^3 rho0)`.
    pub fluid_factor: f32,
    /// Factor of samples, `A / (S H^3)`.
    pub sample_factor: f32,
    /// Most that a width can be.
    pub widest: f32,
}

/// A chunk's particles.
pub struct Task<'a> {
    /// Shared inputs.
    pub inputs: Inputs<'a>,
    /// Cells and particles.
    pub chunk: &'a Chunk,
    /// Memory of the thread.
    pub workspace: &'a mut Workspace,
    /// Result, over `H`.
    pub width: &'a mut [f32],
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
        let Task { inputs, chunk, workspace, width } = self.0;
        let [x, y, z] = &inputs.particles.position;
        let Workspace { places: fluid, calm: weighted, sums, wall_sums, candidates, .. } = workspace;
        fluid.begin(inputs.grid);
        weighted.begin(inputs.grid);
        let in_radii = ScaledRoot::new(simd, 1.0 / inputs.grid.support_radius);
        for cell in chunk.cells.clone() {
            let range = inputs.starts[cell] as usize..inputs.starts[cell + 1] as usize;
            if range.is_empty() {
                continue;
            }
            candidates.begin(inputs.grid);
            let near = Near::around([x, y, z], range.clone(), inputs.grid.cell_size);
            let own = [&x[range.clone()], &y[range.clone()], &z[range.clone()]];
            let rows = Rows::around(inputs.grid, inputs.starts, cell);
            fluid.pack(simd, candidates.add(simd, &rows, &near, [x, y, z]), [x, y, z], own[0][0]);
            let walls = wall_sums.zeroed::<S>(range.len());
            for samples in inputs.samples {
                let rows = Rows::around(inputs.grid, &samples.starts, cell);
                let [x, y, z] = &samples.position;
                let list = candidates.add(simd, &rows, &near, [x, y, z]);
                if !list.is_empty() {
                    weighted.pack(simd, list, [x, y, z, &samples.volume], own[0][0]);
                    add_samples::<S, K>(simd, in_radii, own, weighted, walls);
                }
            }
            let first = range.start - chunk.particles.start;
            let width = &mut width[first..first + range.len()];
            width.fill(1.0);
            for _ in 0..EVALUATIONS {
                let sums = sums.zeroed::<S>(range.len());
                add_fluid::<S, K>(simd, in_radii, own, width, fluid, sums);
                for ((width, &sum), &walls) in width.iter_mut().zip(&*sums).zip(&*walls) {
                    let fluid = inputs.fluid_factor * simd.reduce_sum_f32s(sum) / (*width * *width * *width);
                    let density = fluid + inputs.sample_factor * simd.reduce_sum_f32s(walls);
                    *width = density.recip().cbrt().clamp(1.0, inputs.widest);
                }
            }
        }
    }
}

/// `sum_b f(r_ab / (w_a H))` over the fluid, for each of a cell's particles.
#[inline(always)]
fn add_fluid<S: Simd, K: SimdKernel>(
    simd: S,
    in_radii: ScaledRoot<S>,
    own: [&[f32]; 3],
    width: &[f32],
    all: &Packed<3>,
    sums: &mut [S::f32s],
) {
    let one = simd.splat_f32s(1.0);
    let mut first = 0;
    while first < all.len() {
        let other = all.lanes::<S>(first);
        for ((((sum, &x), &y), &z), &width) in sums.iter_mut().zip(own[0]).zip(own[1]).zip(own[2]).zip(width) {
            let (_, squared) = difference(simd, [x, y, z], other);
            let q = simd.mul_f32s(in_radii.of(simd, squared), simd.splat_f32s(width.recip()));
            *sum = simd.add_f32s(K::shape(simd, simd.min_f32s(q, one)), *sum);
        }
        first += S::F32_LANES;
    }
}

/// `sum_k V_k f(r_ak / H)` over walls or bodies, for each of a cell's particles.
#[inline(always)]
fn add_samples<S: Simd, K: SimdKernel>(
    simd: S,
    in_radii: ScaledRoot<S>,
    own: [&[f32]; 3],
    all: &Packed<4>,
    sums: &mut [S::f32s],
) {
    let one = simd.splat_f32s(1.0);
    let mut first = 0;
    while first < all.len() {
        let [ox, oy, oz, volume] = all.lanes::<S>(first);
        for (((sum, &x), &y), &z) in sums.iter_mut().zip(own[0]).zip(own[1]).zip(own[2]) {
            let (_, squared) = difference(simd, [x, y, z], [ox, oy, oz]);
            let q = simd.min_f32s(in_radii.of(simd, squared), one);
            *sum = simd.mul_add_f32s(volume, K::shape(simd, q), *sum);
        }
        first += S::F32_LANES;
    }
}

/// Lanes of one over the width of pairs, the mean of both.
#[inline(always)]
pub fn inverse_width<S: Simd>(simd: S, own: f32, other: S::f32s) -> S::f32s {
    crate::lanes::divide(simd, simd.splat_f32s(2.0), simd.add_f32s(simd.splat_f32s(own), other))
}
