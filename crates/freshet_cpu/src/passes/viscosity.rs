//! Part of stage `acceleration`: a [physical viscosity](super::morris1997) with a kernel of its own (P §4.2.3), before all else of the stage.
//!
//! In a sweep of its own: each kernel of viscosity with each of pressure in one would be code of its own. Pairs have the `F` of
//! `freshet_core::kernel::Kernel::viscous_over_r`, and walls are weighted by `freshet_core::sampling::wall_layer::WallLayer::viscous_share`.

use std::marker::PhantomData;

use glam::Vec3;
use pulp::{Simd, WithSimd};

use super::acceleration::{Inputs, Own, Pairs};
use super::morris1997;
use crate::candidates::Candidates;
use crate::lanes::{difference, sum_vector};
use crate::packed::Packed;
use crate::simd_kernel::{SimdKernel, WithKernel};
use crate::workers::Chunk;
use crate::workspace::Workspace;

/// A chunk's particles.
pub struct Task<'a> {
    /// Those of the stage, with a physical viscosity.
    pub inputs: Inputs<'a>,
    /// Cells and particles.
    pub chunk: &'a Chunk,
    /// Memory of the thread.
    pub workspace: &'a mut Workspace,
    /// Their candidates, as the density pass found them.
    pub candidates: &'a Candidates,
    /// Result, m/s2.
    pub acceleration: [&'a mut [f32]; 3],
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
        let Task { inputs, chunk, workspace, candidates, acceleration: [ax, ay, az] } = self.0;
        let ([x, y, z], [u, v, w]) = (&inputs.particles.position, &inputs.particles.velocity);
        let Workspace { sticking, sums, wall_sums, .. } = workspace;
        sticking.begin(inputs.grid);
        let pairs = Pairs::new(simd, &inputs);
        let mut lists = candidates.lists();
        for cell in chunk.cells.clone() {
            let range = inputs.starts[cell] as usize..inputs.starts[cell + 1] as usize;
            if range.is_empty() {
                continue;
            }
            let own = Own::new(&inputs, &range);
            let at = x[range.start];
            let (sums, _) = sums.zeroed::<S>(3 * range.len()).as_chunks_mut::<3>();
            let list = lists.next().unwrap_or_default();
            sticking.pack(simd, list, [x, y, z, u, v, w, inputs.density], at);
            add_fluid::<S, K>(simd, pairs, own, sticking, sums);
            let (wall_sums, _) = wall_sums.zeroed::<S>(7 * range.len()).as_chunks_mut::<7>();
            for samples in inputs.samples {
                let list = lists.next().unwrap_or_default();
                if list.is_empty() || !samples.drags() {
                    continue;
                }
                let ([x, y, z], [u, v, w]) = (&samples.position, samples.velocity());
                sticking.pack(simd, list, [x, y, z, &samples.viscous_volume, u, v, w], at);
                morris1997::add_walls::<S, K>(simd, pairs, own, sticking, wall_sums);
            }
            for ((i, &sum), walls) in range.zip(&*sums).zip(&*wall_sums) {
                let velocity = inputs.particles.velocity_of(i);
                let of_walls = inputs.physical.map_or(Vec3::ZERO, |viscosity| {
                    morris1997::wall_drag(simd, walls, viscosity, velocity, inputs.density[i])
                });
                let i = i - chunk.particles.start;
                (ax[i], ay[i], az[i]) = (inputs.fluid_factor * sum_vector(simd, sum) + of_walls).into();
            }
        }
    }
}

/// What particles of a cell exchange with others: position, velocity, density.
#[inline(always)]
fn add_fluid<S: Simd, K: SimdKernel>(simd: S, pairs: Pairs<S>, own: Own, all: &Packed<7>, sums: &mut [[S::f32s; 3]]) {
    let [vx, vy, vz] = own.velocity;
    let mut first = 0;
    while first < all.len() {
        let [x, y, z, u, v, w, density] = all.lanes::<S>(first);
        let motions = vx.iter().zip(vy).zip(vz).zip(own.density);
        for ((sum, position, _), (((&own_u, &own_v), &own_w), &own_density)) in own.with(sums).zip(motions) {
            let (_, squared) = difference(simd, position, [x, y, z]);
            let du = simd.sub_f32s(simd.splat_f32s(own_u), u);
            let dv = simd.sub_f32s(simd.splat_f32s(own_v), v);
            let dw = simd.sub_f32s(simd.splat_f32s(own_w), w);
            let slope = pairs.slope::<K>(simd, squared);
            let densities = [simd.splat_f32s(own_density), density];
            morris1997::add_pair(simd, pairs, [squared, slope], densities, [du, dv, dw], sum);
        }
        first += S::F32_LANES;
    }
}
