//! Stage `body_load`: the opposite of what the particles felt from each sample, summed over a body.
//!
//! Sample k feels `+ (1/G) m rho0 V_k sum_a (P_a + P_k) F x_ak`, `P_k` being zero for samples of a single layer.

use std::ops::Range;

use freshet_core::grid::Grid;
use glam::Vec3;
use pulp::{Arch, Simd, WithSimd};

use crate::candidates::Near;
use crate::lanes::{ScaledRoot, squared_length, sum_vector};
use crate::neighbours::Rows;
use crate::packed::Packed;
use crate::particles::Particles;
use crate::samples::SortedSamples;
use crate::simd_kernel::{SimdKernel, WithKernel};
use crate::workspace::Workspace;

/// Forces on samples.
pub struct Task<'a> {
    /// Instruction set.
    pub arch: Arch,
    /// Grid of everything.
    pub grid: &'a Grid,
    /// First particle of each cell.
    pub starts: &'a [u32],
    /// Sorted particles.
    pub particles: &'a Particles,
    /// `p / rho^2`, padded.
    pub pressure_term: &'a [f32],
    /// Sorted samples of all bodies.
    pub samples: &'a SortedSamples,
    /// Slots of the samples to do.
    pub slots: Range<usize>,
    /// Memory of the thread.
    pub workspace: &'a mut Workspace,
    /// Result: the force on each, N.
    pub forces: &'a mut [Vec3],
    /// `m rho0 A / (G H^5)`.
    pub factor: f32,
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
        let Workspace { candidates, calm: fluid, .. } = task.workspace;
        fluid.begin(task.grid);
        let mut packed_cell = None;
        for (slot, force) in task.slots.zip(task.forces) {
            let at = task.samples.position_of(slot);
            let cell = task.grid.index(task.grid.coordinates(at)) as usize;
            if packed_cell != Some(cell) {
                let rows = Rows::around(task.grid, task.starts, cell);
                let [sx, sy, sz] = &task.samples.position;
                let sharing = task.samples.starts[cell] as usize..task.samples.starts[cell + 1] as usize;
                let near = Near::around([sx, sy, sz], sharing, task.grid.support_radius);
                candidates.begin(task.grid);
                let list = candidates.add(simd, &rows, &near, [x, y, z]);
                fluid.pack(simd, list, [x, y, z, task.pressure_term], at.x);
                packed_cell = Some(cell);
            }
            let own = task.samples.pressure_term.get(slot).copied().unwrap_or(0.0);
            let sum = sum_around::<S, K>(simd, fluid, at, own, 1.0 / task.grid.support_radius);
            *force = task.factor * task.samples.volume[slot] * sum;
        }
    }
}

/// `sum_a (P_a + P_k) f'(q)/q x_ak`.
#[inline(always)]
fn sum_around<S: Simd, K: SimdKernel>(
    simd: S,
    candidates: &Packed<4>,
    at: Vec3,
    own: f32,
    inverse_radius: f32,
) -> Vec3 {
    let own = simd.splat_f32s(own);
    let (in_radii, one) = (ScaledRoot::new(simd, inverse_radius), simd.splat_f32s(1.0));
    let mut sum = [simd.splat_f32s(0.0); 3];
    let mut first = 0;
    while first < candidates.len() {
        let [x, y, z, term] = candidates.lanes::<S>(first);
        let dx = simd.sub_f32s(x, simd.splat_f32s(at.x));
        let dy = simd.sub_f32s(y, simd.splat_f32s(at.y));
        let dz = simd.sub_f32s(z, simd.splat_f32s(at.z));
        let q = simd.min_f32s(in_radii.of(simd, squared_length(simd, [dx, dy, dz])), one);
        let factor = simd.mul_f32s(simd.add_f32s(term, own), K::slope_over_q(simd, q));
        sum[0] = simd.mul_add_f32s(factor, dx, sum[0]);
        sum[1] = simd.mul_add_f32s(factor, dy, sum[1]);
        sum[2] = simd.mul_add_f32s(factor, dz, sum[2]);
        first += S::F32_LANES;
    }
    sum_vector(simd, sum)
}
