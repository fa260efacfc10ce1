//! Stage `position_solve`: particles are moved apart where they would be too dense without pressure (`freshet_core::position_based`). An iteration is [`Multiply`], for
//! all particles, then [`Displace`]. Neighbours are those of where particles were sorted; where they have been moved to is told by their ways from there.

use std::marker::PhantomData;

use freshet_core::grid::Grid;
use pulp::{Arch, Simd, WithSimd};

use crate::candidates::Candidates;
use crate::lanes::{ScaledRoot, difference, squared_length, sum_vector};
use crate::particles::Particles;
use crate::samples::SortedSamples;
use crate::simd_kernel::{SimdKernel, WithKernel};
use crate::workers::Chunk;
use crate::workspace::Workspace;

/// What an iteration needs.
#[derive(Clone, Copy)]
pub struct Inputs<'a> {
    /// Instruction set.
    pub arch: Arch,
    /// Grid of everything.
    pub grid: &'a Grid,
    /// First particle of each cell.
    pub starts: &'a [u32],
    /// Sorted particles, where they were sorted.
    pub particles: &'a Particles,
    /// How far from there they have been moved, m, padded.
    pub way: &'a [Vec<f32>; 3],
    /// `dt^2 P` of this iteration, padded.
    pub push: &'a [f32],
    /// Walls.
    pub samples: &'a [&'a SortedSamples],
    /// Relative density from kernel shapes of the fluid, `m A / (S H^3 rho0)`, and of samples, `A / (S H^3)`.
    pub density: [f32; 2],
    /// `K` from kernel slopes, `(m A / H^5)^2 / (S G rho0)`.
    pub diagonal: f32,
    /// Least `K`.
    pub least: f32,
    /// What is added to `K`.
    pub softness: f32,
    /// Share of a Jacobi step.
    pub relaxation: f32,
    /// Ways from kernel slopes of the fluid, `-m A / (G H^5)`, and of samples, `-rho0 A / (G H^5)`.
    pub force: [f32; 2],
    /// `rho0 / m`, 1/m3.
    pub number_density: f32,
}

/// Finds by how much particles push.
pub struct Multiply<'a> {
    /// Shared inputs.
    pub inputs: Inputs<'a>,
    /// Cells and particles.
    pub chunk: &'a Chunk,
    /// Memory of the thread.
    pub workspace: &'a mut Workspace,
    /// Their candidates, as the density pass found them.
    pub candidates: &'a Candidates,
    /// Result, `dt^2 P`.
    pub push: &'a mut [f32],
    /// Gets the same added.
    pub sum: &'a mut [f32],
}

/// Moves particles on by these.
pub struct Displace<'a> {
    /// Shared inputs.
    pub inputs: Inputs<'a>,
    /// Cells and particles.
    pub chunk: &'a Chunk,
    /// Memory of the thread.
    pub workspace: &'a mut Workspace,
    /// Their candidates, as the density pass found them.
    pub candidates: &'a Candidates,
    /// Result: ways after the iteration, m.
    pub way: [&'a mut [f32]; 3],
}

impl WithKernel for Multiply<'_> {
    type Output = ();

    fn with<K: SimdKernel>(self, _: K) {
        self.inputs.arch.dispatch(TypedMultiply::<K>(self, PhantomData));
    }
}

impl WithKernel for Displace<'_> {
    type Output = ();

    fn with<K: SimdKernel>(self, _: K) {
        self.inputs.arch.dispatch(TypedDisplace::<K>(self, PhantomData));
    }
}

struct TypedMultiply<'a, K>(Multiply<'a>, PhantomData<K>);

impl<K: SimdKernel> WithSimd for TypedMultiply<'_, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Multiply { inputs, chunk, workspace, candidates, push, sum } = self.0;
        let ([x, y, z], [wx, wy, wz]) = (&inputs.particles.position, inputs.way);
        let Workspace { moving: fluid, calm: weighted, sums, .. } = workspace;
        fluid.begin(inputs.grid);
        weighted.begin(inputs.grid);
        let pairs = Pairs::new(simd, &inputs);
        let mut lists = candidates.lists();
        for cell in chunk.cells.clone() {
            let range = inputs.starts[cell] as usize..inputs.starts[cell + 1] as usize;
            if range.is_empty() {
                continue;
            }
            let at = |i: usize| ([x[i], y[i], z[i]], [wx[i], wy[i], wz[i]]);
            let (sums, _) = sums.zeroed::<S>(5 * range.len()).as_chunks_mut::<5>();
            fluid.pack(simd, lists.next().unwrap_or_default(), [x, y, z, wx, wy, wz], x[range.start]);
            let mut first = 0;
            while first < fluid.len() {
                let lanes = fluid.lanes::<S>(first);
                for (sum, i) in sums.iter_mut().zip(range.clone()) {
                    let (apart, q) =
                        pairs.of_particles(simd, at(i), [lanes[0], lanes[1], lanes[2]], [lanes[3], lanes[4], lanes[5]]);
                    let slope = K::slope_over_q(simd, q);
                    sum[0] = simd.mul_add_f32s(pairs.density[0], K::shape(simd, q), sum[0]);
                    for axis in 0..3 {
                        sum[1 + axis] = simd.mul_add_f32s(slope, apart[axis], sum[1 + axis]);
                    }
                    let squares = simd.mul_f32s(slope, slope);
                    sum[4] = simd.mul_add_f32s(squares, squared_length(simd, apart), sum[4]);
                }
                first += S::F32_LANES;
            }
            for samples in inputs.samples {
                let list = lists.next().unwrap_or_default();
                if list.is_empty() {
                    continue;
                }
                let [sx, sy, sz] = &samples.position;
                weighted.pack(simd, list, [sx, sy, sz, &samples.volume], x[range.start]);
                let mut first = 0;
                while first < weighted.len() {
                    let [ox, oy, oz, volume] = weighted.lanes::<S>(first);
                    let weight = simd.mul_f32s(pairs.density[1], volume);
                    let share = simd.mul_f32s(pairs.number_density, volume);
                    for (sum, i) in sums.iter_mut().zip(range.clone()) {
                        let (apart, q) = pairs.of_sample(simd, at(i), [ox, oy, oz]);
                        let slope = simd.mul_f32s(share, K::slope_over_q(simd, q));
                        sum[0] = simd.mul_add_f32s(weight, K::shape(simd, q), sum[0]);
                        for axis in 0..3 {
                            sum[1 + axis] = simd.mul_add_f32s(slope, apart[axis], sum[1 + axis]);
                        }
                    }
                    first += S::F32_LANES;
                }
            }
            let base = range.start - chunk.particles.start;
            let results = push[base..base + range.len()].iter_mut().zip(&mut sum[base..]);
            for ((push, sum), &[value, x, y, z, squares]) in results.zip(&*sums) {
                let excess = (simd.reduce_sum_f32s(value) - 1.0).max(0.0);
                let gradient = sum_vector(simd, [x, y, z]).length_squared();
                let diagonal = (inputs.diagonal * (gradient + simd.reduce_sum_f32s(squares))).max(inputs.least);
                *push = inputs.relaxation * excess / (diagonal + inputs.softness);
                *sum += *push;
            }
        }
    }
}

struct TypedDisplace<'a, K>(Displace<'a>, PhantomData<K>);

impl<K: SimdKernel> WithSimd for TypedDisplace<'_, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Displace { inputs, chunk, workspace, candidates, way } = self.0;
        let ([x, y, z], [wx, wy, wz], push) = (&inputs.particles.position, inputs.way, inputs.push);
        let Workspace { sticking: fluid, calm: weighted, sums, .. } = workspace;
        fluid.begin(inputs.grid);
        weighted.begin(inputs.grid);
        let pairs = Pairs::new(simd, &inputs);
        let mut lists = candidates.lists();
        for cell in chunk.cells.clone() {
            let range = inputs.starts[cell] as usize..inputs.starts[cell + 1] as usize;
            if range.is_empty() {
                continue;
            }
            let at = |i: usize| ([x[i], y[i], z[i]], [wx[i], wy[i], wz[i]]);
            let (sums, _) = sums.zeroed::<S>(3 * range.len()).as_chunks_mut::<3>();
            fluid.pack(simd, lists.next().unwrap_or_default(), [x, y, z, wx, wy, wz, push], x[range.start]);
            let mut first = 0;
            while first < fluid.len() {
                let lanes = fluid.lanes::<S>(first);
                for (sum, i) in sums.iter_mut().zip(range.clone()) {
                    let (apart, q) =
                        pairs.of_particles(simd, at(i), [lanes[0], lanes[1], lanes[2]], [lanes[3], lanes[4], lanes[5]]);
                    let pushes = simd.add_f32s(simd.splat_f32s(push[i]), lanes[6]);
                    let strength = simd.mul_f32s(simd.mul_f32s(pairs.force[0], pushes), K::slope_over_q(simd, q));
                    for axis in 0..3 {
                        sum[axis] = simd.mul_add_f32s(strength, apart[axis], sum[axis]);
                    }
                }
                first += S::F32_LANES;
            }
            for samples in inputs.samples {
                let list = lists.next().unwrap_or_default();
                if list.is_empty() {
                    continue;
                }
                let [sx, sy, sz] = &samples.position;
                weighted.pack(simd, list, [sx, sy, sz, &samples.volume], x[range.start]);
                let mut first = 0;
                while first < weighted.len() {
                    let [ox, oy, oz, volume] = weighted.lanes::<S>(first);
                    let weight = simd.mul_f32s(pairs.force[1], volume);
                    for (sum, i) in sums.iter_mut().zip(range.clone()) {
                        let (apart, q) = pairs.of_sample(simd, at(i), [ox, oy, oz]);
                        let strength = simd.mul_f32s(weight, simd.splat_f32s(push[i]));
                        let strength = simd.mul_f32s(strength, K::slope_over_q(simd, q));
                        for axis in 0..3 {
                            sum[axis] = simd.mul_add_f32s(strength, apart[axis], sum[axis]);
                        }
                    }
                    first += S::F32_LANES;
                }
            }
            let base = range.start - chunk.particles.start;
            for (n, (i, &sum)) in range.clone().zip(&*sums).enumerate() {
                let moved = sum_vector(simd, sum);
                for axis in 0..3 {
                    way[axis][base + n] = inputs.way[axis][i] + moved[axis];
                }
            }
        }
    }
}

/// Constants of the innermost loop, in registers.
#[derive(Clone, Copy)]
struct Pairs<S: Simd> {
    /// Distances over the support radius.
    in_radii: ScaledRoot<S>,
    squared_radius: S::f32s,
    density: [S::f32s; 2],
    force: [S::f32s; 2],
    number_density: S::f32s,
}

impl<S: Simd> Pairs<S> {
    #[inline(always)]
    fn new(simd: S, inputs: &Inputs) -> Self {
        let radius = inputs.grid.support_radius;
        Self {
            in_radii: ScaledRoot::new(simd, 1.0 / radius),
            squared_radius: simd.splat_f32s(radius * radius),
            density: [simd.splat_f32s(inputs.density[0]), simd.splat_f32s(inputs.density[1])],
            force: [simd.splat_f32s(inputs.force[0]), simd.splat_f32s(inputs.force[1])],
            number_density: simd.splat_f32s(inputs.number_density),
        }
    }

    /// What is between a particle and others, each from where it was and how far it has been moved from there; and the distance over the support radius, one for
    /// those that were no neighbours.
    #[inline(always)]
    fn of_particles(
        self,
        simd: S,
        (own, way): ([f32; 3], [f32; 3]),
        other: [S::f32s; 3],
        other_way: [S::f32s; 3],
    ) -> ([S::f32s; 3], S::f32s) {
        let (apart, squared) = difference(simd, own, other);
        let (ways, _) = difference(simd, way, other_way);
        let now =
            [simd.add_f32s(apart[0], ways[0]), simd.add_f32s(apart[1], ways[1]), simd.add_f32s(apart[2], ways[2])];
        let is_near = simd.less_than_f32s(squared, self.squared_radius);
        let one = simd.splat_f32s(1.0);
        let q = simd.min_f32s(self.in_radii.of(simd, squared_length(simd, now)), one);
        (now, simd.select_f32s(is_near, q, one))
    }

    /// The same of samples, which stay where they are.
    #[inline(always)]
    fn of_sample(self, simd: S, (own, way): ([f32; 3], [f32; 3]), other: [S::f32s; 3]) -> ([S::f32s; 3], S::f32s) {
        let zero = simd.splat_f32s(0.0);
        self.of_particles(simd, (own, way), other, [zero; 3])
    }
}
