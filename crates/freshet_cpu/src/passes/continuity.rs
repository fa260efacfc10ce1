//! Stage `density` of plans whose particles carry their densities (`freshet_core::density_form`), as `e = rho/rho0 - 1`:
//! `e_a' = max(e_a + dt/(G rho0) [m sum_b v_ab . grad W_ab + rho0 sum_k V_k v_a . grad W_ak], least)`, with the gradients in the middle of the last substep's way, at
//! `x_ab - v_ab dt/2`, and `P_a = p_a / rho_a^2` from that.

use std::marker::PhantomData;

use freshet_core::density_form::DensityForm;
use freshet_core::equation_of_state::PressureLaw;
use freshet_core::grid::Grid;
use pulp::{Arch, Simd, WithSimd};

use super::density::{Compression, compression, pressure_terms};
use crate::candidates::{Candidates, Near};
use crate::lanes::{ScaledRoot, difference, squared_length};
use crate::neighbours::Rows;
use crate::packed::Packed;
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
    /// Where the sorted particles are.
    pub position: &'a [Vec<f32>; 3],
    /// What they moved with, m/s.
    pub velocity: &'a [Vec<f32>; 3],
    /// Walls.
    pub samples: &'a [&'a SortedSamples],
    /// Factor of fluid neighbours, `m A / (G H^5 rho0)`.
    pub fluid_factor: f32,
    /// Factor of samples, `A / (G H^5)`.
    pub sample_factor: f32,
    /// Length of the last substep, s.
    pub elapsed: f32,
    /// Density at rest, kg/m3.
    pub rest_density: f32,
    /// Pressure from density.
    pub law: PressureLaw,
}

/// Densities of a chunk's particles.
pub struct Task<'a> {
    /// Shared inputs.
    pub inputs: Inputs<'a>,
    /// Cells and particles.
    pub chunk: &'a Chunk,
    /// Memory of the thread.
    pub workspace: &'a mut Workspace,
    /// Result: for each cell that has particles a list of particles, then one of samples.
    pub candidates: &'a mut Candidates,
    /// What they carry, no unit: of one substep before, then of now.
    pub excess: &'a mut [f32],
    /// Result, kg/m3.
    pub density: &'a mut [f32],
    /// Result, m5/(kg s2).
    pub pressure_term: &'a mut [f32],
}

impl WithKernel for Task<'_> {
    type Output = Compression;

    fn with<K: SimdKernel>(self, _: K) -> Compression {
        self.inputs.arch.dispatch(Typed::<K>(self, PhantomData))
    }
}

struct Typed<'a, K>(Task<'a>, PhantomData<K>);

impl<K: SimdKernel> WithSimd for Typed<'_, K> {
    type Output = Compression;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Compression {
        let Task { inputs, chunk, workspace, candidates, excess, density, pressure_term } = self.0;
        let ([x, y, z], [u, v, w]) = (inputs.position, inputs.velocity);
        let Workspace { moving: fluid, calm: weighted, sums, .. } = workspace;
        fluid.begin(inputs.grid);
        weighted.begin(inputs.grid);
        let pairs = Pairs::new(simd, &inputs);
        candidates.begin(inputs.grid);
        for cell in chunk.cells.clone() {
            let range = inputs.starts[cell] as usize..inputs.starts[cell + 1] as usize;
            if range.is_empty() {
                continue;
            }
            let near = Near::around([x, y, z], range.clone(), inputs.grid.cell_size);
            let r = || range.clone();
            let own = [&x[r()], &y[r()], &z[r()], &u[r()], &v[r()], &w[r()]];
            let sums = sums.zeroed::<S>(range.len());
            let rows = Rows::around(inputs.grid, inputs.starts, cell);
            let list = candidates.add(simd, &rows, &near, [x, y, z]);
            fluid.pack(simd, list, [x, y, z, u, v, w], own[0][0]);
            add_fluid::<S, K>(simd, pairs, own, fluid, sums);
            for samples in inputs.samples {
                let rows = Rows::around(inputs.grid, &samples.starts, cell);
                let [x, y, z] = &samples.position;
                let list = candidates.add(simd, &rows, &near, [x, y, z]);
                if !list.is_empty() {
                    weighted.pack(simd, list, [x, y, z, &samples.volume], own[0][0]);
                    add_samples::<S, K>(simd, pairs, own, weighted, sums);
                }
            }
            let first = range.start - chunk.particles.start;
            for (excess, &sum) in excess[first..first + range.len()].iter_mut().zip(&*sums) {
                *excess = (*excess + inputs.elapsed * simd.reduce_sum_f32s(sum)).max(DensityForm::LEAST_EXCESS);
            }
        }
        for (density, excess) in density.iter_mut().zip(&*excess) {
            *density = inputs.rest_density * (1.0 + excess);
        }
        pressure_terms(inputs.rest_density, inputs.law, density, pressure_term);
        compression(inputs.rest_density, density)
    }
}

/// `m A/(G H^5 rho0) sum_b f'(q)/q x_ab . v_ab` over the fluid, for each of a cell's particles.
#[inline(always)]
fn add_fluid<S: Simd, K: SimdKernel>(
    simd: S,
    pairs: Pairs<S>,
    own: [&[f32]; 6],
    all: &Packed<6>,
    sums: &mut [S::f32s],
) {
    let [x, y, z, u, v, w] = own;
    let mut first = 0;
    while first < all.len() {
        let [ox, oy, oz, ou, ov, ow] = all.lanes::<S>(first);
        let motions = u.iter().zip(v).zip(w);
        for ((((sum, &x), &y), &z), ((&u, &v), &w)) in sums.iter_mut().zip(x).zip(y).zip(z).zip(motions) {
            let apart = difference(simd, [x, y, z], [ox, oy, oz]);
            let (motion, _) = difference(simd, [u, v, w], [ou, ov, ow]);
            *sum = simd.mul_add_f32s(pairs.fluid_factor, pairs.parting::<K>(simd, apart, motion), *sum);
        }
        first += S::F32_LANES;
    }
}

/// `A/(G H^5) sum_k V_k f'(q)/q x_ak . v_a` over walls, which stand still, for each of a cell's particles.
#[inline(always)]
fn add_samples<S: Simd, K: SimdKernel>(
    simd: S,
    pairs: Pairs<S>,
    own: [&[f32]; 6],
    all: &Packed<4>,
    sums: &mut [S::f32s],
) {
    let [x, y, z, u, v, w] = own;
    let mut first = 0;
    while first < all.len() {
        let [ox, oy, oz, volume] = all.lanes::<S>(first);
        let weight = simd.mul_f32s(pairs.sample_factor, volume);
        let motions = u.iter().zip(v).zip(w);
        for ((((sum, &x), &y), &z), ((&u, &v), &w)) in sums.iter_mut().zip(x).zip(y).zip(z).zip(motions) {
            let apart = difference(simd, [x, y, z], [ox, oy, oz]);
            let motion = [simd.splat_f32s(u), simd.splat_f32s(v), simd.splat_f32s(w)];
            *sum = simd.mul_add_f32s(weight, pairs.parting::<K>(simd, apart, motion), *sum);
        }
        first += S::F32_LANES;
    }
}

/// Constants of the innermost loop, in registers.
#[derive(Clone, Copy)]
struct Pairs<S: Simd> {
    /// Distances over the support radius.
    in_radii: ScaledRoot<S>,
    squared_radius: S::f32s,
    fluid_factor: S::f32s,
    sample_factor: S::f32s,
    /// Minus half of the time that has passed.
    back: S::f32s,
}

impl<S: Simd> Pairs<S> {
    #[inline(always)]
    fn new(simd: S, inputs: &Inputs) -> Self {
        Self {
            in_radii: ScaledRoot::new(simd, 1.0 / inputs.grid.support_radius),
            squared_radius: simd.splat_f32s(inputs.grid.support_radius * inputs.grid.support_radius),
            fluid_factor: simd.splat_f32s(inputs.fluid_factor),
            sample_factor: simd.splat_f32s(inputs.sample_factor),
            back: simd.splat_f32s(-0.5 * inputs.elapsed),
        }
    }

    /// `f'(q)/q x . v` half a substep ago, of a difference of places and one of velocities; zero for who is no neighbour now.
    #[inline(always)]
    fn parting<K: SimdKernel>(
        self,
        simd: S,
        (apart, squared): ([S::f32s; 3], S::f32s),
        motion: [S::f32s; 3],
    ) -> S::f32s {
        let x = simd.mul_add_f32s(self.back, motion[0], apart[0]);
        let y = simd.mul_add_f32s(self.back, motion[1], apart[1]);
        let z = simd.mul_add_f32s(self.back, motion[2], apart[2]);
        let parting = simd.mul_f32s(x, motion[0]);
        let parting = simd.mul_add_f32s(y, motion[1], parting);
        let parting = simd.mul_add_f32s(z, motion[2], parting);
        let one = simd.splat_f32s(1.0);
        let q = simd.min_f32s(self.in_radii.of(simd, squared_length(simd, [x, y, z])), one);
        let q = simd.select_f32s(simd.less_than_f32s(squared, self.squared_radius), q, one);
        simd.mul_f32s(K::slope_over_q(simd, q), parting)
    }
}
