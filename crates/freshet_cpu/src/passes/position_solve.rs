//! Stage `position_solve`: particles are moved apart where they would be too dense without pressure (`freshet_core::position_based`, `freshet_core::pressure_corrected`). An iteration is
//! [`Multiply`], for all particles, then [`Displace`]. Neighbours are those of where particles were sorted; where they have been moved to is told by their ways from there.
//!
//! Where a Poisson equation says how hard they push (`freshet_core::pressure_poisson`), [`Diagonal`] comes first, then [`Relax`] so many times, and [`Displace`] once.
//!
//! All that differs is what is summed over pairs and what is made of the sums: a [`Term`]. [`Sweep`] goes through the cells.

use std::marker::PhantomData;

use freshet_core::grid::Grid;
use freshet_core::pressure_corrected::PressureGradient;
use glam::Vec3;
use pulp::{Arch, Simd, WithSimd};

use crate::candidates::Candidates;
use crate::lanes::{ScaledRoot, difference, squared_length};
use crate::particles::Particles;
use crate::passes::projection::UNIT;
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
    /// Relative density from kernel shapes, `m A / (S H^3 rho0)`.
    pub density: f32,
    /// That of a particle alone.
    pub own_density: f32,
    /// `K` from kernel slopes, `(m A / H^5)^2 / (S G rho0)`.
    pub diagonal: f32,
    /// Least `K`.
    pub least: f32,
    /// Weights of a Poisson equation from kernel slopes, `-2 m A / (S H^5)`.
    pub poisson: f32,
    /// Ways from kernel slopes, `-m A / (G H^5)`.
    pub force: f32,
    /// `rho0 / m`, 1/m3: a sample's volume times this is how many particles it stands for.
    pub number_density: f32,
}

/// What is summed over the pairs of a particle, `N` numbers, and what they come to.
trait Term<const N: usize> {
    /// Whether samples are among the pairs.
    const SAMPLES: bool = true;

    /// Adds a pair with a particle, with the `dt^2 P` of both.
    fn add_particle<S: Simd, K: SimdKernel>(simd: S, pair: Pair<S>, push: [S::f32s; 2], sums: &mut [S::f32s; N]);

    /// Adds a pair with a sample that stands for so many particles, with the `dt^2 P` of the particle.
    fn add_sample<S: Simd, K: SimdKernel>(
        simd: S,
        pair: Pair<S>,
        share: S::f32s,
        push: S::f32s,
        sums: &mut [S::f32s; N],
    );

    /// Takes the sums of a particle, which is so far into the chunk.
    fn take(&mut self, inputs: &Inputs, particle: usize, in_chunk: usize, sums: [f32; N]);
}

/// Where a particle is from another, or from a sample.
#[derive(Clone, Copy)]
struct Pair<S: Simd> {
    /// `x_ab`, m.
    apart: [S::f32s; 3],
    /// Its length over the support radius; one for those that were no neighbours.
    q: S::f32s,
}

impl<S: Simd> Pair<S> {
    /// `f'(q)/q` of another particle: none of the particle itself, nor of one at the same place.
    #[inline(always)]
    fn slope_apart<K: SimdKernel>(self, simd: S) -> S::f32s {
        let is_apart = simd.less_than_f32s(simd.splat_f32s(1e-6), self.q);
        simd.select_f32s(is_apart, K::slope_over_q(simd, self.q), simd.splat_f32s(0.0))
    }

    /// Adds so much of `x_ab`.
    #[inline(always)]
    fn add_to(self, simd: S, strength: S::f32s, sums: &mut [S::f32s]) {
        for (sum, apart) in sums.iter_mut().zip(self.apart) {
            *sum = simd.mul_add_f32s(strength, apart, *sum);
        }
    }
}

/// A term for all particles of a chunk.
struct Sweep<'a, T, K, const N: usize> {
    inputs: Inputs<'a>,
    chunk: &'a Chunk,
    workspace: &'a mut Workspace,
    candidates: &'a Candidates,
    term: T,
    kernel: PhantomData<K>,
}

impl<T: Term<N>, K: SimdKernel, const N: usize> WithSimd for Sweep<'_, T, K, N> {
    type Output = T;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> T {
        let Self { inputs, chunk, workspace, candidates, mut term, .. } = self;
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
            let (sums, _) = sums.zeroed::<S>(N * range.len()).as_chunks_mut::<N>();
            fluid.pack(simd, lists.next().unwrap_or_default(), [x, y, z, wx, wy, wz, push], x[range.start]);
            let mut first = 0;
            while first < fluid.len() {
                let [ox, oy, oz, owx, owy, owz, others] = fluid.lanes::<S>(first);
                for (sums, i) in sums.iter_mut().zip(range.clone()) {
                    let pair = pairs.of_particles(simd, at(i), [ox, oy, oz], [owx, owy, owz]);
                    T::add_particle::<S, K>(simd, pair, [simd.splat_f32s(push[i]), others], sums);
                }
                first += S::F32_LANES;
            }
            for samples in inputs.samples {
                let list = lists.next().unwrap_or_default();
                if !T::SAMPLES || list.is_empty() {
                    continue;
                }
                let [sx, sy, sz] = &samples.position;
                weighted.pack(simd, list, [sx, sy, sz, &samples.volume], x[range.start]);
                let mut first = 0;
                while first < weighted.len() {
                    let [ox, oy, oz, volume] = weighted.lanes::<S>(first);
                    let share = simd.mul_f32s(pairs.number_density, volume);
                    for (sums, i) in sums.iter_mut().zip(range.clone()) {
                        let pair = pairs.of_particles(simd, at(i), [ox, oy, oz], [simd.splat_f32s(0.0); 3]);
                        T::add_sample::<S, K>(simd, pair, share, simd.splat_f32s(push[i]), sums);
                    }
                    first += S::F32_LANES;
                }
            }
            for (sums, i) in sums.iter().zip(range) {
                let sums = sums.map(|sum| simd.reduce_sum_f32s(sum));
                term.take(&inputs, i, i - chunk.particles.start, sums);
            }
        }
        term
    }
}

/// Constants of the innermost loop, in registers.
#[derive(Clone, Copy)]
struct Pairs<S: Simd> {
    /// Distances over the support radius.
    in_radii: ScaledRoot<S>,
    squared_radius: S::f32s,
    number_density: S::f32s,
}

impl<S: Simd> Pairs<S> {
    #[inline(always)]
    fn new(simd: S, inputs: &Inputs) -> Self {
        let radius = inputs.grid.support_radius;
        Self {
            in_radii: ScaledRoot::new(simd, 1.0 / radius),
            squared_radius: simd.splat_f32s(radius * radius),
            number_density: simd.splat_f32s(inputs.number_density),
        }
    }

    /// What is between a particle and others, each from where it was and how far it has been moved from there.
    #[inline(always)]
    fn of_particles(
        self,
        simd: S,
        (own, way): ([f32; 3], [f32; 3]),
        other: [S::f32s; 3],
        other_way: [S::f32s; 3],
    ) -> Pair<S> {
        let (apart, squared) = difference(simd, own, other);
        let (ways, _) = difference(simd, way, other_way);
        let apart =
            [simd.add_f32s(apart[0], ways[0]), simd.add_f32s(apart[1], ways[1]), simd.add_f32s(apart[2], ways[2])];
        let is_near = simd.less_than_f32s(squared, self.squared_radius);
        let one = simd.splat_f32s(1.0);
        let q = simd.min_f32s(self.in_radii.of(simd, squared_length(simd, apart)), one);
        Pair { apart, q: simd.select_f32s(is_near, q, one) }
    }
}

/// A term's pass: what all of them have.
pub struct Task<'a, T> {
    /// Shared inputs.
    pub inputs: Inputs<'a>,
    /// Cells and particles.
    pub chunk: &'a Chunk,
    /// Memory of the thread.
    pub workspace: &'a mut Workspace,
    /// Their candidates, as the density pass found them.
    pub candidates: &'a Candidates,
    /// What is found.
    pub term: T,
}

impl<'a, T> Task<'a, T> {
    fn dispatch<K: SimdKernel, const N: usize>(self) -> T
    where
        T: Term<N>,
    {
        let Self { inputs, chunk, workspace, candidates, term } = self;
        let sweep = Sweep { inputs, chunk, workspace, candidates, term, kernel: PhantomData::<K> };
        inputs.arch.dispatch(sweep)
    }
}

/// How hard particles push that are too dense.
#[derive(Clone, Copy)]
pub enum Rule {
    /// As far as a Jacobi step goes.
    Jacobi {
        /// Share of a step.
        relaxation: f32,
        /// What is added to `K`.
        softness: f32,
    },
    /// By so much times the relative density too large; where it is too small less again, but none below zero in all.
    Sound(f32),
}

/// Finds by how much particles push.
pub struct Multiply<'a> {
    /// By which rule.
    pub rule: Rule,
    /// Result, `dt^2 P`.
    pub push: &'a mut [f32],
    /// Gets the same added.
    pub sum: &'a mut [f32],
}

impl WithKernel for Task<'_, Multiply<'_>> {
    type Output = ();

    fn with<K: SimdKernel>(self, _: K) {
        self.dispatch::<K, 5>();
    }
}

/// `sum f(q)`, `sum f'(q)/q x_ab` and, over particles only, `sum |f'(q)/q x_ab|^2`.
impl Term<5> for Multiply<'_> {
    #[inline(always)]
    fn add_particle<S: Simd, K: SimdKernel>(simd: S, pair: Pair<S>, _: [S::f32s; 2], sums: &mut [S::f32s; 5]) {
        let slope = K::slope_over_q(simd, pair.q);
        sums[0] = simd.add_f32s(K::shape(simd, pair.q), sums[0]);
        pair.add_to(simd, slope, &mut sums[1..4]);
        let squares = simd.mul_f32s(slope, slope);
        sums[4] = simd.mul_add_f32s(squares, squared_length(simd, pair.apart), sums[4]);
    }

    #[inline(always)]
    fn add_sample<S: Simd, K: SimdKernel>(simd: S, pair: Pair<S>, share: S::f32s, _: S::f32s, sums: &mut [S::f32s; 5]) {
        sums[0] = simd.mul_add_f32s(share, K::shape(simd, pair.q), sums[0]);
        pair.add_to(simd, simd.mul_f32s(share, K::slope_over_q(simd, pair.q)), &mut sums[1..4]);
    }

    #[inline(always)]
    fn take(&mut self, inputs: &Inputs, _: usize, at: usize, [value, x, y, z, squares]: [f32; 5]) {
        let excess = inputs.density * value - 1.0;
        self.push[at] = match self.rule {
            Rule::Jacobi { relaxation, softness } => {
                let diagonal = inputs.diagonal * (Vec3::new(x, y, z).length_squared() + squares);
                relaxation * excess.max(0.0) / (diagonal.max(inputs.least) + softness)
            }
            Rule::Sound(stiffness) => (stiffness * excess).max(-self.sum[at]),
        };
        self.sum[at] += self.push[at];
    }
}

/// Moves particles on by these, equally and oppositely.
pub struct Displace<'a> {
    /// Result: ways after the iteration, m.
    pub way: [&'a mut [f32]; 3],
}

/// Moves particles on by differences of these.
pub struct DisplaceByDifference<'a> {
    /// Result: ways after the iteration, m.
    pub way: [&'a mut [f32]; 3],
}

impl WithKernel for Task<'_, Displace<'_>> {
    type Output = ();

    fn with<K: SimdKernel>(self, _: K) {
        self.dispatch::<K, 3>();
    }
}

impl WithKernel for Task<'_, DisplaceByDifference<'_>> {
    type Output = ();

    fn with<K: SimdKernel>(self, _: K) {
        self.dispatch::<K, 8>();
    }
}

/// Adds to the ways before.
#[inline(always)]
fn move_on(way: &mut [&mut [f32]; 3], inputs: &Inputs, particle: usize, at: usize, moved: Vec3) {
    for ((way, before), moved) in way.iter_mut().zip(inputs.way).zip(moved.to_array()) {
        way[at] = before[particle] + moved;
    }
}

/// `sum (P_a + P_b) f'(q)/q x_ab`, with none of samples.
impl Term<3> for Displace<'_> {
    #[inline(always)]
    fn add_particle<S: Simd, K: SimdKernel>(simd: S, pair: Pair<S>, push: [S::f32s; 2], sums: &mut [S::f32s; 3]) {
        let pushes = simd.add_f32s(push[0], push[1]);
        pair.add_to(simd, simd.mul_f32s(pushes, K::slope_over_q(simd, pair.q)), sums);
    }

    #[inline(always)]
    fn add_sample<S: Simd, K: SimdKernel>(
        simd: S,
        pair: Pair<S>,
        share: S::f32s,
        push: S::f32s,
        sums: &mut [S::f32s; 3],
    ) {
        let slope = simd.mul_f32s(share, K::slope_over_q(simd, pair.q));
        pair.add_to(simd, simd.mul_f32s(push, slope), sums);
    }

    #[inline(always)]
    fn take(&mut self, inputs: &Inputs, particle: usize, at: usize, sums: [f32; 3]) {
        move_on(&mut self.way, inputs, particle, at, inputs.force * Vec3::from(sums));
    }
}

/// `sum_b (P_b - P_a) f'(q)/q x_ab`, `sum_k f'(q)/q x_ak`, `sum_b f(q) P_b` and `sum_b f(q)`.
impl Term<8> for DisplaceByDifference<'_> {
    #[inline(always)]
    fn add_particle<S: Simd, K: SimdKernel>(simd: S, pair: Pair<S>, push: [S::f32s; 2], sums: &mut [S::f32s; 8]) {
        let more = simd.sub_f32s(push[1], push[0]);
        pair.add_to(simd, simd.mul_f32s(more, K::slope_over_q(simd, pair.q)), &mut sums[..3]);
        let shape = K::shape(simd, pair.q);
        sums[6] = simd.mul_add_f32s(shape, push[1], sums[6]);
        sums[7] = simd.add_f32s(shape, sums[7]);
    }

    #[inline(always)]
    fn add_sample<S: Simd, K: SimdKernel>(simd: S, pair: Pair<S>, share: S::f32s, _: S::f32s, sums: &mut [S::f32s; 8]) {
        pair.add_to(simd, simd.mul_f32s(share, K::slope_over_q(simd, pair.q)), &mut sums[3..6]);
    }

    #[inline(always)]
    fn take(&mut self, inputs: &Inputs, particle: usize, at: usize, sums: [f32; 8]) {
        let [x, y, z, wall_x, wall_y, wall_z, pushes, shapes] = sums;
        let push = inputs.push[particle];
        // Without the particle itself.
        let [pushes, around] =
            [inputs.density * pushes - inputs.own_density * push, inputs.density * shapes - inputs.own_density];
        let more = PressureGradient::in_walls(push, pushes, around, inputs.own_density) - push;
        let moved = Vec3::new(x, y, z) + more * Vec3::new(wall_x, wall_y, wall_z);
        move_on(&mut self.way, inputs, particle, at, inputs.force * moved);
    }
}

/// Finds the diagonal of a Poisson equation.
pub struct Diagonal<'a> {
    /// Densities, kg/m3, padded.
    pub density: &'a [f32],
    /// Density of a free surface, kg/m3.
    pub surface: f32,
    /// Result; zero at surfaces.
    pub diagonal: &'a mut [f32],
}

impl WithKernel for Task<'_, Diagonal<'_>> {
    type Output = ();

    fn with<K: SimdKernel>(self, _: K) {
        self.dispatch::<K, 4>();
    }
}

/// `sum_b f'(q)/q` and `sum f'(q)/q x_ab`.
impl Term<4> for Diagonal<'_> {
    #[inline(always)]
    fn add_particle<S: Simd, K: SimdKernel>(simd: S, pair: Pair<S>, _: [S::f32s; 2], sums: &mut [S::f32s; 4]) {
        let slope = pair.slope_apart::<K>(simd);
        sums[0] = simd.add_f32s(slope, sums[0]);
        pair.add_to(simd, slope, &mut sums[1..]);
    }

    #[inline(always)]
    fn add_sample<S: Simd, K: SimdKernel>(simd: S, pair: Pair<S>, share: S::f32s, _: S::f32s, sums: &mut [S::f32s; 4]) {
        pair.add_to(simd, simd.mul_f32s(share, K::slope_over_q(simd, pair.q)), &mut sums[1..]);
    }

    #[inline(always)]
    fn take(&mut self, inputs: &Inputs, particle: usize, at: usize, [slopes, x, y, z]: [f32; 4]) {
        let own = inputs.diagonal * Vec3::new(x, y, z).length_squared();
        let all = (inputs.poisson * slopes + own).max(inputs.least);
        self.diagonal[at] = if self.density[particle] < self.surface { 0.0 } else { all };
    }
}

/// A step towards the solution of a Poisson equation.
pub struct Relax<'a> {
    /// Densities, kg/m3, padded.
    pub density: &'a [f32],
    /// One over the density at rest, m3/kg.
    pub inverse_rest_density: f32,
    /// See [`Diagonal`], padded.
    pub diagonal: &'a [f32],
    /// Share of a Jacobi step.
    pub relaxation: f32,
    /// Share of the last step that is taken again.
    pub momentum: f32,
    /// What the last step came to, before momentum; then that of this.
    pub stepped: &'a mut [f32],
    /// Result.
    pub next: &'a mut [f32],
    /// Result: sum of what was left before the step, where it counts, limited to 1, in [units](UNIT): integers, so that order does not matter.
    pub left: u64,
}

impl WithKernel for Task<'_, Relax<'_>> {
    type Output = u64;

    fn with<K: SimdKernel>(self, _: K) -> u64 {
        self.dispatch::<K, 1>().left
    }
}

/// `sum_b f'(q)/q P_b`.
impl Term<1> for Relax<'_> {
    const SAMPLES: bool = false;

    #[inline(always)]
    fn add_particle<S: Simd, K: SimdKernel>(simd: S, pair: Pair<S>, push: [S::f32s; 2], sums: &mut [S::f32s; 1]) {
        sums[0] = simd.mul_add_f32s(pair.slope_apart::<K>(simd), push[1], sums[0]);
    }

    #[inline(always)]
    fn add_sample<S: Simd, K: SimdKernel>(_: S, _: Pair<S>, _: S::f32s, _: S::f32s, _: &mut [S::f32s; 1]) {}

    #[inline(always)]
    fn take(&mut self, inputs: &Inputs, particle: usize, at: usize, [slopes]: [f32; 1]) {
        let (push, diagonal) = (inputs.push[particle], self.diagonal[particle]);
        if diagonal == 0.0 {
            (self.stepped[at], self.next[at]) = (0.0, 0.0);
            return;
        }
        let excess = self.density[particle] * self.inverse_rest_density - 1.0;
        let left = excess - diagonal * push + inputs.poisson * slopes;
        let free = push + self.relaxation * left / diagonal;
        let stepped = free.max(0.0);
        self.next[at] = (stepped + self.momentum * (stepped - self.stepped[at])).max(0.0);
        self.stepped[at] = stepped;
        // Where there is no pressure left to take away, a fluid that parts is as it should be.
        let wrong = if free < 0.0 { 0.0 } else { left.abs().min(1.0) };
        self.left += u64::from((wrong * UNIT) as u32);
    }
}
