//! An iteration of the stages `divergence_solve` and `density_solve`, see
//! [`DivergenceFree`](freshet_core::pressure_solver::DivergenceFree).
//!
//! Sought is what pressures change by. First come the accelerations by the change (the sum of the stage `acceleration`, with nothing
//! else in it), then this pass: how fast densities change by them, what that leaves, and the next change. The sums are those of
//! samples that stand still, as walls do; what bodies add by their motion comes from their [touches](super::body_touch).

use std::marker::PhantomData;

use freshet_core::grid::Grid;
use pulp::{Arch, Simd, WithSimd};

use super::body_motion::Motion;
use super::body_touch::Touch;
use crate::candidates::Candidates;
use crate::lanes::{ScaledRoot, difference};
use crate::packed::Packed;
use crate::particles::Particles;
use crate::samples::SortedSamples;
use crate::simd_kernel::{SimdKernel, WithKernel};
use crate::workers::Chunk;
use crate::workspace::Workspace;

/// What an iteration of a chunk needs.
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
    /// How bodies move, as the particles do.
    pub bodies: &'a [Motion],
    /// What moves the particles, padded: in the first iteration velocities, m/s, later accelerations, m/s2.
    pub motion: &'a [Vec<f32>; 3],
    /// `m A / (S H^5 rho0)`.
    pub factor: f32,
    /// `rho0 / m`, 1/m3.
    pub number_density: f32,
    /// What makes a compression of a rate: the substep, s, later its square, s2.
    pub time: f32,
    /// Of a step, what is multiplied with a compression over `K`: relaxation over the substep's square, 1/s2.
    pub relaxation: f32,
    /// Share of the last step that is taken again.
    pub momentum: f32,
}

/// An iteration of a chunk.
pub struct Task<'a> {
    /// Shared inputs.
    pub inputs: Inputs<'a>,
    /// Cells and particles.
    pub chunk: &'a Chunk,
    /// Memory of the thread.
    pub workspace: &'a mut Workspace,
    /// Their candidates, as the density pass found them.
    pub candidates: &'a Candidates,
    /// Those of them that touch bodies which move.
    pub touches: &'a [Touch],
    /// What they have been given and what they get.
    pub values: Values<'a>,
}

/// Values of a chunk's particles.
pub struct Values<'a> {
    /// `1/K`.
    pub inverse_diagonal: &'a [f32],
    /// Pressures `p / rho^2` that change; none where there are none to begin with.
    pub pressure: Option<&'a [f32]>,
    /// `R` without the change of pressures; in a first iteration it is found here.
    pub source: &'a mut [f32],
    /// Whether this is a first iteration, about velocities that no change of pressures is in yet.
    pub first: bool,
    /// Change of `p / rho^2` that this iteration is about.
    pub change: &'a [f32],
    /// Result: that of the next.
    pub next: &'a mut [f32],
    /// The change that the last step came to, before momentum; then that of this.
    pub stepped: &'a mut [f32],
    /// Result: `R` with the change that this iteration is about.
    pub left: &'a mut [f32],
}

impl WithKernel for Task<'_> {
    type Output = u64;

    fn with<K: SimdKernel>(self, _: K) -> u64 {
        self.inputs.arch.dispatch(Typed::<K>(self, PhantomData))
    }
}

struct Typed<'a, K>(Task<'a>, PhantomData<K>);

impl<K: SimdKernel> WithSimd for Typed<'_, K> {
    type Output = u64;

    /// Sum of `|R|` where it counts, limited to 1, in [units](UNIT): integers, so that order does not matter.
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> u64 {
        let Task { inputs, chunk, workspace, candidates, touches, mut values } = self.0;
        let ([x, y, z], [u, v, w]) = (&inputs.particles.position, inputs.motion);
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
            let r = || range.clone();
            let own = [&x[r()], &y[r()], &z[r()], &u[r()], &v[r()], &w[r()]];
            let sums = sums.zeroed::<S>(range.len());
            fluid.pack(simd, lists.next().unwrap_or_default(), [x, y, z, u, v, w], own[0][0]);
            add_fluid::<S, K>(simd, pairs, own, fluid, sums);
            for samples in inputs.samples {
                let list = lists.next().unwrap_or_default();
                if !list.is_empty() {
                    let [x, y, z] = &samples.position;
                    weighted.pack(simd, list, [x, y, z, &samples.volume], own[0][0]);
                    add_samples::<S, K>(simd, pairs, own, weighted, sums);
                }
            }
            let first = range.start - chunk.particles.start;
            for (rate, &sum) in values.next[first..first + range.len()].iter_mut().zip(&*sums) {
                *rate = simd.reduce_sum_f32s(sum);
            }
        }
        for touch in touches {
            let Motion { linear, angular } = inputs.bodies[touch.body as usize];
            values.next[touch.particle as usize - chunk.particles.start] -=
                linear.dot(touch.push) + angular.dot(touch.turn);
        }
        step(&inputs, &mut values)
    }
}

/// Units of sums of `R`: so many make one.
pub const UNIT: f32 = 1_073_741_824.0;

/// Steps by the rates in `values.next`: a loop without branches, which the compiler makes lanes of.
#[inline(always)]
fn step(inputs: &Inputs, values: &mut Values) -> u64 {
    let len = values.next.len();
    let (inverse, change, next) = (&values.inverse_diagonal[..len], &values.change[..len], &mut values.next[..len]);
    let (source, stepped) = (&mut values.source[..len], &mut values.stepped[..len]);
    let left = &mut values.left[..len];
    let scale = inputs.factor * inputs.time;
    for i in 0..len {
        left[i] = source[i] + scale * next[i];
    }
    if values.first {
        source.copy_from_slice(left);
    }
    let mut sum = 0;
    match values.pressure {
        Some(pressure) => {
            let pressure = &pressure[..len];
            for i in 0..len {
                let one = Step::of(inputs, [change[i], left[i], inverse[i], stepped[i]], -pressure[i]);
                (next[i], stepped[i]) = (one.next, one.stepped);
                sum += u64::from(one.wrong);
            }
        }
        None => {
            for i in 0..len {
                let one = Step::of(inputs, [change[i], left[i], inverse[i], stepped[i]], 0.0);
                (next[i], stepped[i]) = (one.next, one.stepped);
                sum += u64::from(one.wrong);
            }
        }
    }
    sum
}

/// A step of one particle. No closure: what is called in a loop of lanes has to be inlined.
struct Step {
    next: f32,
    stepped: f32,
    /// `|R|` where it counts, in [units](UNIT).
    wrong: u32,
}

impl Step {
    /// From a change that left so much of the compression, to one of at least `least`.
    #[inline(always)]
    fn of(inputs: &Inputs, [change, left, inverse_diagonal, before]: [f32; 4], least: f32) -> Self {
        let free = change + inputs.relaxation * left * inverse_diagonal;
        let stepped = free.max(least);
        let next = (stepped + inputs.momentum * (stepped - before)).max(least);
        // Where there is no pressure left to take away, a fluid that parts is as it should be.
        let wrong = if free < least { 0.0 } else { left.abs() };
        Self { next, stepped, wrong: (wrong.min(1.0) * UNIT) as u32 }
    }
}

/// `sum_b f'(q)/q x_ab . (u_a - u_b)` over the fluid, for each of a cell's particles.
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
            let (apart, squared) = difference(simd, [x, y, z], [ox, oy, oz]);
            let parting = parting(simd, [u, v, w], [ou, ov, ow], apart);
            *sum = simd.mul_add_f32s(pairs.slope::<K>(simd, squared), parting, *sum);
        }
        first += S::F32_LANES;
    }
}

/// `rho0/m sum_k V_k f'(q)/q x_ak . u_a` over walls or bodies that stand still, for each of a cell's particles.
#[inline(always)]
fn add_samples<S: Simd, K: SimdKernel>(
    simd: S,
    pairs: Pairs<S>,
    own: [&[f32]; 6],
    all: &Packed<4>,
    sums: &mut [S::f32s],
) {
    let [x, y, z, u, v, w] = own;
    let zero = simd.splat_f32s(0.0);
    let mut first = 0;
    while first < all.len() {
        let [ox, oy, oz, volume] = all.lanes::<S>(first);
        let weight = simd.mul_f32s(pairs.number_density, volume);
        let motions = u.iter().zip(v).zip(w);
        for ((((sum, &x), &y), &z), ((&u, &v), &w)) in sums.iter_mut().zip(x).zip(y).zip(z).zip(motions) {
            let (apart, squared) = difference(simd, [x, y, z], [ox, oy, oz]);
            let parting = parting(simd, [u, v, w], [zero; 3], apart);
            let slope = simd.mul_f32s(weight, pairs.slope::<K>(simd, squared));
            *sum = simd.mul_add_f32s(slope, parting, *sum);
        }
        first += S::F32_LANES;
    }
}

/// `x_ab . (u_a - u_b)`.
#[inline(always)]
fn parting<S: Simd>(simd: S, own: [f32; 3], other: [S::f32s; 3], apart: [S::f32s; 3]) -> S::f32s {
    let du = simd.sub_f32s(simd.splat_f32s(own[0]), other[0]);
    let dv = simd.sub_f32s(simd.splat_f32s(own[1]), other[1]);
    let dw = simd.sub_f32s(simd.splat_f32s(own[2]), other[2]);
    simd.mul_add_f32s(dw, apart[2], simd.mul_add_f32s(dv, apart[1], simd.mul_f32s(du, apart[0])))
}

/// Constants of the innermost loop, in registers.
#[derive(Clone, Copy)]
struct Pairs<S: Simd> {
    /// Distances over the support radius.
    in_radii: ScaledRoot<S>,
    number_density: S::f32s,
}

impl<S: Simd> Pairs<S> {
    #[inline(always)]
    fn new(simd: S, inputs: &Inputs) -> Self {
        Self {
            in_radii: ScaledRoot::new(simd, 1.0 / inputs.grid.support_radius),
            number_density: simd.splat_f32s(inputs.number_density),
        }
    }

    /// `f'(q)/q`, zero beyond the support.
    #[inline(always)]
    fn slope<K: SimdKernel>(self, simd: S, squared: S::f32s) -> S::f32s {
        K::slope_over_q(simd, simd.min_f32s(self.in_radii.of(simd, squared), simd.splat_f32s(1.0)))
    }
}
