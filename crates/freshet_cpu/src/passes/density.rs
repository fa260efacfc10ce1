//! Stage `density`: `rho_a = (1/S) (m sum_b W_ab + rho0 sum_k V_k W_ak)`, and what follows from it: `P_a = p_a / rho_a^2` by an
//! equation of state, or of an incompressible fluid the diagonal of its
//! [system](freshet_core::pressure_solver::DivergenceFree). Where particles carry their densities the stage is [`continuity`](super::continuity).

use std::marker::PhantomData;

use freshet_core::equation_of_state::PressureLaw;
use freshet_core::grid::Grid;
use pulp::{Arch, Simd, WithSimd};

use crate::candidates::{Candidates, Near};
use crate::lanes::{ScaledRoot, difference, squared_length, sum_vector};
use crate::neighbours::Rows;
use crate::packed::Packed;
use crate::particles::Particles;
use crate::passes::support::inverse_width;
use crate::samples::SortedSamples;
use crate::simd_kernel::{SimdKernel, WithKernel};
use crate::tasks::Total;
use crate::workers::Chunk;
use crate::workspace::Workspace;

/// What the density of a chunk needs.
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
    /// Factor of fluid neighbours, `m A / (S H^3)`.
    pub fluid_factor: f32,
    /// Factor of samples, `rho0 A / (S H^3)`.
    pub sample_factor: f32,
    /// Widths of supports, of plans that have them, padded.
    pub width: Option<&'a [f32]>,
    /// What is asked for beside densities.
    pub second: Second,
    /// Density at rest, kg/m3.
    pub rest_density: f32,
}

/// What is asked for beside densities.
#[derive(Clone, Copy)]
pub enum Second {
    /// `p / rho^2` by an equation of state, m5/(kg s2).
    PressureTerm(PressureLaw),
    /// `1/K_a` of the system of an incompressible fluid, in the unit of `p / rho^2` times s2.
    InverseDiagonal {
        /// `(m A / H^5)^2 / (S G rho0)`.
        factor: f32,
        /// `rho0 / m`, 1/m3.
        number_density: f32,
        /// Least `K`.
        least: f32,
    },
}

/// Densities of a chunk's particles, and what follows from them.
pub struct Task<'a> {
    /// Shared inputs.
    pub inputs: Inputs<'a>,
    /// Cells and particles.
    pub chunk: &'a Chunk,
    /// Memory of the thread.
    pub workspace: &'a mut Workspace,
    /// Result: for each cell that has particles a list of particles, then one of each kind of samples.
    pub candidates: &'a mut Candidates,
    /// Result, kg/m3.
    pub density: &'a mut [f32],
    /// Result, see [`Second`].
    pub second: &'a mut [f32],
}

/// Compression of a chunk.
#[derive(Clone, Copy, Debug, Default)]
pub struct Compression {
    /// Largest `rho / rho0 - 1`.
    pub largest: f32,
    /// Sum of `max(rho / rho0 - 1, 0)` limited to 1, in units of 2^-20: integers, so that order does not matter.
    pub sum: u64,
}

impl Total for Compression {
    fn and(self, other: Self) -> Self {
        Self { largest: self.largest.max(other.largest), sum: self.sum + other.sum }
    }
}

impl WithKernel for Task<'_> {
    type Output = Compression;

    fn with<K: SimdKernel>(self, _: K) -> Compression {
        let arch = self.inputs.arch;
        match self.inputs.second {
            Second::PressureTerm(law) => match self.inputs.width {
                Some(width) => arch.dispatch(Compressible::<K, true>(self, law, width, PhantomData)),
                None => arch.dispatch(Compressible::<K, false>(self, law, &[], PhantomData)),
            },
            Second::InverseDiagonal { factor, number_density, least } => {
                arch.dispatch(Incompressible::<K>(self, [factor, number_density, least], PhantomData))
            }
        }
    }
}

struct Compressible<'a, K, const WIDTHS: bool>(Task<'a>, PressureLaw, &'a [f32], PhantomData<K>);

impl<K: SimdKernel, const WIDTHS: bool> WithSimd for Compressible<'_, K, WIDTHS> {
    type Output = Compression;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Compression {
        let Task { inputs, chunk, workspace, candidates, density, second } = self.0;
        let [x, y, z] = &inputs.particles.position;
        let Workspace { places: fluid, calm: weighted, sums, .. } = workspace;
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
            let own = [&x[range.clone()], &y[range.clone()], &z[range.clone()]];
            let sums = sums.zeroed::<S>(range.len());
            let rows = Rows::around(inputs.grid, inputs.starts, cell);
            let list = candidates.add(simd, &rows, &near, [x, y, z]);
            if WIDTHS {
                let width = self.2;
                weighted.pack(simd, list, [x, y, z, width], own[0][0]);
                add_wide_fluid::<S, K>(simd, pairs, own, &width[range.clone()], weighted, sums);
            } else {
                fluid.pack(simd, list, [x, y, z], own[0][0]);
                add_fluid::<S, K>(simd, pairs, own, fluid, sums);
            }
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
            for (density, &sum) in density[first..first + range.len()].iter_mut().zip(&*sums) {
                *density = simd.reduce_sum_f32s(sum);
            }
        }
        pressure_terms(inputs.rest_density, self.1, density, second);
        compression(inputs.rest_density, density)
    }
}

struct Incompressible<'a, K>(Task<'a>, [f32; 3], PhantomData<K>);

impl<K: SimdKernel> WithSimd for Incompressible<'_, K> {
    type Output = Compression;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Compression {
        let Task { inputs, chunk, workspace, candidates, density, second } = self.0;
        let [factor, number_density, least] = self.1;
        let [x, y, z] = &inputs.particles.position;
        let Workspace { places: fluid, calm: weighted, sums, .. } = workspace;
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
            let own = [&x[range.clone()], &y[range.clone()], &z[range.clone()]];
            let (sums, _) = sums.zeroed::<S>(5 * range.len()).as_chunks_mut::<5>();
            let rows = Rows::around(inputs.grid, inputs.starts, cell);
            let list = candidates.add(simd, &rows, &near, [x, y, z]);
            fluid.pack(simd, list, [x, y, z], own[0][0]);
            add_fluid_gradients::<S, K>(simd, pairs, own, fluid, sums);
            for samples in inputs.samples {
                let rows = Rows::around(inputs.grid, &samples.starts, cell);
                let [x, y, z] = &samples.position;
                let list = candidates.add(simd, &rows, &near, [x, y, z]);
                if !list.is_empty() {
                    weighted.pack(simd, list, [x, y, z, &samples.volume], own[0][0]);
                    add_sample_gradients::<S, K>(simd, pairs, own, weighted, number_density, sums);
                }
            }
            let first = range.start - chunk.particles.start;
            let results = density[first..first + range.len()].iter_mut().zip(&mut second[first..]);
            for ((density, inverse), &[value, x, y, z, squares]) in results.zip(&*sums) {
                *density = simd.reduce_sum_f32s(value);
                let own = sum_vector(simd, [x, y, z]).length_squared();
                *inverse = (factor * (own + simd.reduce_sum_f32s(squares))).max(least).recip();
            }
        }
        compression(inputs.rest_density, density)
    }
}

/// As [`add_fluid`], with `sum_b f'(q)/q x_ab` and `sum_b |f'(q)/q x_ab|^2`.
#[inline(always)]
fn add_fluid_gradients<S: Simd, K: SimdKernel>(
    simd: S,
    pairs: Pairs<S>,
    own: [&[f32]; 3],
    all: &Packed<3>,
    sums: &mut [[S::f32s; 5]],
) {
    let mut first = 0;
    while first < all.len() {
        let other = all.lanes::<S>(first);
        for (((sum, &x), &y), &z) in sums.iter_mut().zip(own[0]).zip(own[1]).zip(own[2]) {
            let ([dx, dy, dz], squared) = difference(simd, [x, y, z], other);
            let q = simd.min_f32s(pairs.in_radii.of(simd, squared), simd.splat_f32s(1.0));
            let slope = K::slope_over_q(simd, q);
            sum[0] = simd.mul_add_f32s(pairs.fluid_factor, K::shape(simd, q), sum[0]);
            sum[1] = simd.mul_add_f32s(slope, dx, sum[1]);
            sum[2] = simd.mul_add_f32s(slope, dy, sum[2]);
            sum[3] = simd.mul_add_f32s(slope, dz, sum[3]);
            sum[4] = simd.mul_add_f32s(simd.mul_f32s(slope, slope), squared, sum[4]);
        }
        first += S::F32_LANES;
    }
}

/// As [`add_samples`], with `rho0/m sum_k V_k f'(q)/q x_ak`.
#[inline(always)]
fn add_sample_gradients<S: Simd, K: SimdKernel>(
    simd: S,
    pairs: Pairs<S>,
    own: [&[f32]; 3],
    all: &Packed<4>,
    number_density: f32,
    sums: &mut [[S::f32s; 5]],
) {
    let mut first = 0;
    while first < all.len() {
        let [ox, oy, oz, volume] = all.lanes::<S>(first);
        let weight = simd.mul_f32s(pairs.sample_factor, volume);
        let share = simd.mul_f32s(simd.splat_f32s(number_density), volume);
        for (((sum, &x), &y), &z) in sums.iter_mut().zip(own[0]).zip(own[1]).zip(own[2]) {
            let ([dx, dy, dz], squared) = difference(simd, [x, y, z], [ox, oy, oz]);
            let q = simd.min_f32s(pairs.in_radii.of(simd, squared), simd.splat_f32s(1.0));
            let slope = simd.mul_f32s(share, K::slope_over_q(simd, q));
            sum[0] = simd.mul_add_f32s(weight, K::shape(simd, q), sum[0]);
            sum[1] = simd.mul_add_f32s(slope, dx, sum[1]);
            sum[2] = simd.mul_add_f32s(slope, dy, sum[2]);
            sum[3] = simd.mul_add_f32s(slope, dz, sum[3]);
        }
        first += S::F32_LANES;
    }
}

/// `m A/(S H^3) sum_b f(q_ab)` over the fluid, for each of a cell's particles.
#[inline(always)]
fn add_fluid<S: Simd, K: SimdKernel>(
    simd: S,
    pairs: Pairs<S>,
    own: [&[f32]; 3],
    all: &Packed<3>,
    sums: &mut [S::f32s],
) {
    let mut first = 0;
    while first < all.len() {
        let other = all.lanes::<S>(first);
        for (((sum, &x), &y), &z) in sums.iter_mut().zip(own[0]).zip(own[1]).zip(own[2]) {
            let q = pairs.relative_distance(simd, [x, y, z], other);
            *sum = simd.mul_add_f32s(pairs.fluid_factor, K::shape(simd, q), *sum);
        }
        first += S::F32_LANES;
    }
}

/// `m A/(S H^3) sum_b f(q_ab / w_ab) / w_ab^3` over the fluid, for each of a cell's particles.
#[inline(always)]
fn add_wide_fluid<S: Simd, K: SimdKernel>(
    simd: S,
    pairs: Pairs<S>,
    own: [&[f32]; 3],
    width: &[f32],
    all: &Packed<4>,
    sums: &mut [S::f32s],
) {
    let mut first = 0;
    while first < all.len() {
        let [ox, oy, oz, other_width] = all.lanes::<S>(first);
        for ((((sum, &x), &y), &z), &width) in sums.iter_mut().zip(own[0]).zip(own[1]).zip(own[2]).zip(width) {
            let inverse = inverse_width(simd, width, other_width);
            let (_, squared) = difference(simd, [x, y, z], [ox, oy, oz]);
            let q = simd.mul_f32s(pairs.in_radii.of(simd, squared), inverse);
            let cube = simd.mul_f32s(simd.mul_f32s(inverse, inverse), inverse);
            let shape = K::shape(simd, simd.min_f32s(q, simd.splat_f32s(1.0)));
            *sum = simd.mul_add_f32s(simd.mul_f32s(pairs.fluid_factor, cube), shape, *sum);
        }
        first += S::F32_LANES;
    }
}

/// `rho0 A/(S H^3) sum_k V_k f(q_ak)` over walls or bodies, for each of a cell's particles.
#[inline(always)]
fn add_samples<S: Simd, K: SimdKernel>(
    simd: S,
    pairs: Pairs<S>,
    own: [&[f32]; 3],
    all: &Packed<4>,
    sums: &mut [S::f32s],
) {
    let mut first = 0;
    while first < all.len() {
        let [ox, oy, oz, volume] = all.lanes::<S>(first);
        let weight = simd.mul_f32s(pairs.sample_factor, volume);
        for (((sum, &x), &y), &z) in sums.iter_mut().zip(own[0]).zip(own[1]).zip(own[2]) {
            let q = pairs.relative_distance(simd, [x, y, z], [ox, oy, oz]);
            *sum = simd.mul_add_f32s(weight, K::shape(simd, q), *sum);
        }
        first += S::F32_LANES;
    }
}

/// Constants of the innermost loop, in registers: read through a reference they would be read again for every pair.
#[derive(Clone, Copy)]
struct Pairs<S: Simd> {
    /// Distances over the support radius.
    in_radii: ScaledRoot<S>,
    fluid_factor: S::f32s,
    sample_factor: S::f32s,
}

impl<S: Simd> Pairs<S> {
    #[inline(always)]
    fn new(simd: S, inputs: &Inputs) -> Self {
        Self {
            in_radii: ScaledRoot::new(simd, 1.0 / inputs.grid.support_radius),
            fluid_factor: simd.splat_f32s(inputs.fluid_factor),
            sample_factor: simd.splat_f32s(inputs.sample_factor),
        }
    }

    /// `min(r/H, 1)` between a particle and lanes of others.
    #[inline(always)]
    fn relative_distance(self, simd: S, own: [f32; 3], other: [S::f32s; 3]) -> S::f32s {
        let dx = simd.sub_f32s(simd.splat_f32s(own[0]), other[0]);
        let dy = simd.sub_f32s(simd.splat_f32s(own[1]), other[1]);
        let dz = simd.sub_f32s(simd.splat_f32s(own[2]), other[2]);
        let squared = squared_length(simd, [dx, dy, dz]);
        simd.min_f32s(self.in_radii.of(simd, squared), simd.splat_f32s(1.0))
    }
}

/// Pressure terms from densities: a loop without branches, which the compiler makes lanes of.
#[inline(always)]
pub(super) fn pressure_terms(rest_density: f32, law: PressureLaw, density: &[f32], pressure_term: &mut [f32]) {
    let rest_density = f64::from(rest_density);
    for (&density, term) in density.iter().zip(pressure_term) {
        *term = law.pressure(rest_density, f64::from(density)) as f32 / (density * density);
    }
}

/// Compression from densities, likewise.
#[inline(always)]
pub(super) fn compression(rest_density: f32, density: &[f32]) -> Compression {
    // Bits of numbers that are not negative are in the order of the numbers.
    let (mut largest, mut sum) = (0u32, 0u64);
    for density in density {
        let excess = (density / rest_density - 1.0).max(0.0);
        largest = largest.max(excess.to_bits());
        sum += u64::from((excess.min(1.0) * 1_048_576.0) as u32);
    }
    Compression { largest: f32::from_bits(largest), sum }
}
