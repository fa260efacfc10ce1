//! Stage `friction`: what walls take of velocities along them, see [`Friction`](freshet_core::scene::Friction).
//!
//! The walls push particle a with `n_a = -(1/G) rho0 sum_k V_k P_a F x_ak`, the pressure part of its acceleration, and in the sums
//! below each sample counts with its coefficient of friction: `n_s` with that of what sticks, `n_k` with that of what slides. With
//! `v = v_a + a_a dt - u` and `t` its part across `n_s`: `a_a -= t/dt` if `|t| <= |n_s| dt`, else `a_a -= |n_k| t/|t|`.
//!
//! `u` is the velocity of the walls, their mean by what they add to `n_s`.
//!
//! Walls that are [springs](freshet_core::wall_method::SpringDamper) push with these instead of a pressure.

use std::marker::PhantomData;

use freshet_core::grid::Grid;
use freshet_core::wall_method::SpringDamper;
use glam::Vec3;
use pulp::{Arch, Simd, WithSimd};

use crate::candidates::Candidates;
use crate::lanes::{ScaledRoot, difference, sum_vector};
use crate::near_walls::NearWalls;
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
    /// Walls, which are the first kind of samples.
    pub walls: &'a SortedSamples,
    /// Lists of samples after each cell's list of particles.
    pub kinds_of_samples: usize,
    /// `p / rho^2`, padded.
    pub pressure_term: &'a [f32],
    /// `-rho0 A / (G H^5)`.
    pub factor: f32,
    /// The substep, s.
    pub dt: f32,
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
    /// Accelerations, m/s2, to which that of friction is added.
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
        let [x, y, z] = &inputs.particles.position;
        let Workspace { dragging: rough, sticking: moving, sums, wall_sums, .. } = workspace;
        rough.begin(inputs.grid);
        moving.begin(inputs.grid);
        let in_radii = ScaledRoot::new(simd, 1.0 / inputs.grid.support_radius);
        let mut lists = candidates.lists();
        for cell in chunk.cells.clone() {
            let range = inputs.starts[cell] as usize..inputs.starts[cell + 1] as usize;
            if range.is_empty() {
                continue;
            }
            lists.next();
            let list = lists.next().unwrap_or_default();
            for _ in 1..inputs.kinds_of_samples {
                lists.next();
            }
            if list.is_empty() {
                continue;
            }
            let own = [&x[range.clone()], &y[range.clone()], &z[range.clone()]];
            let (sums, _) = sums.zeroed::<S>(6 * range.len()).as_chunks_mut::<6>();
            let [walls_x, walls_y, walls_z] = &inputs.walls.position;
            let [at_rest, sliding] = &inputs.walls.friction;
            rough.pack(simd, list, [walls_x, walls_y, walls_z, at_rest, sliding], own[0][0]);
            add_walls::<S, K>(simd, in_radii, own, rough, sums);
            let (surfaces, _) = wall_sums.zeroed::<S>(4 * range.len()).as_chunks_mut::<4>();
            if inputs.walls.moves() {
                let [u, v, w] = inputs.walls.velocity();
                moving.pack(simd, list, [walls_x, walls_y, walls_z, at_rest, u, v, w], own[0][0]);
                add_surfaces::<S, K>(simd, in_radii, own, moving, surfaces);
            }
            for ((i, &[sx, sy, sz, kx, ky, kz]), &[size, u, v, w]) in range.clone().zip(&*sums).zip(&*surfaces) {
                let pressure = inputs.pressure_term[i];
                // What does not press is not held.
                if pressure <= 0.0 {
                    continue;
                }
                let at = i - chunk.particles.start;
                let push = inputs.factor * pressure;
                let [most, sliding] = [[sx, sy, sz], [kx, ky, kz]].map(|sum| push * sum_vector(simd, sum));
                let before = Vec3::new(ax[at], ay[at], az[at]);
                let size = simd.reduce_sum_f32s(size);
                let surface = if size < 0.0 { sum_vector(simd, [u, v, w]) / size } else { Vec3::ZERO };
                let velocity = inputs.particles.velocity_of(i) + inputs.dt * before - surface;
                (ax[at], ay[at], az[at]) = (before - taken(velocity, most, sliding.length(), inputs.dt)).into();
            }
        }
    }
}

/// The same of walls that are springs of a frequency in rad/s.
pub fn of_springs(
    near: NearWalls<'_>,
    (spring, frequency): (SpringDamper, f32),
    particles: &Particles,
    (chunk, workspace): (&Chunk, &mut Workspace),
    [ax, ay, az]: [&mut [f32]; 3],
    dt: f32,
) {
    for i in chunk.particles.clone() {
        let Some(around) = near.around(particles.position_of(i)) else { continue };
        let (planes, count) = near.planes(&around, &mut workspace.near_walls);
        let velocity = particles.velocity_of(i);
        let mut pushes = [Vec3::ZERO; 2];
        for plane in &planes[..count] {
            let nearer = 0.5 * near.plan.parameters.spacing - plane.distance;
            let push = spring.push(frequency, nearer, velocity.dot(plane.normal));
            let coefficients = near.plan.boundary.frictions[near.source(plane.sample)];
            pushes = [0, 1].map(|kind| pushes[kind] + coefficients[kind] * push * plane.normal);
        }
        let at = i - chunk.particles.start;
        let before = Vec3::new(ax[at], ay[at], az[at]);
        let [most, sliding] = pushes;
        (ax[at], ay[at], az[at]) = (before - taken(velocity + dt * before, most, sliding.length(), dt)).into();
    }
}

/// What friction takes of an acceleration, m/s2, with a velocity relative to the wall and `most` what it can hold, along the wall's normal.
pub(super) fn taken(velocity: Vec3, most: Vec3, sliding: f32, dt: f32) -> Vec3 {
    let Some(normal) = most.try_normalize() else { return Vec3::ZERO };
    let along = velocity - normal * velocity.dot(normal);
    let speed = along.length();
    if speed > most.length() * dt {
        sliding / speed * along
    } else if dt > 0.0 {
        along / dt
    } else {
        Vec3::ZERO
    }
}

/// `sum_k V_k f'(q)/q x_ak`, times either coefficient, over walls, for each of a cell's particles.
#[inline(always)]
fn add_walls<S: Simd, K: SimdKernel>(
    simd: S,
    in_radii: ScaledRoot<S>,
    own: [&[f32]; 3],
    all: &Packed<5>,
    sums: &mut [[S::f32s; 6]],
) {
    let one = simd.splat_f32s(1.0);
    let mut first = 0;
    while first < all.len() {
        let [ox, oy, oz, at_rest, sliding] = all.lanes::<S>(first);
        for (((sum, &x), &y), &z) in sums.iter_mut().zip(own[0]).zip(own[1]).zip(own[2]) {
            let (apart, squared) = difference(simd, [x, y, z], [ox, oy, oz]);
            let slope = K::slope_over_q(simd, simd.min_f32s(in_radii.of(simd, squared), one));
            let weights = [simd.mul_f32s(at_rest, slope), simd.mul_f32s(sliding, slope)];
            for (i, sum) in sum.iter_mut().enumerate() {
                *sum = simd.mul_add_f32s(weights[i / 3], apart[i % 3], *sum);
            }
        }
        first += S::F32_LANES;
    }
}

/// `sum_k V_k f'(q)/q` times the coefficient of what sticks, and that times the velocities of walls, for each of a cell's particles.
#[inline(always)]
fn add_surfaces<S: Simd, K: SimdKernel>(
    simd: S,
    in_radii: ScaledRoot<S>,
    own: [&[f32]; 3],
    all: &Packed<7>,
    sums: &mut [[S::f32s; 4]],
) {
    let one = simd.splat_f32s(1.0);
    let mut first = 0;
    while first < all.len() {
        let [ox, oy, oz, at_rest, u, v, w] = all.lanes::<S>(first);
        for (((sum, &x), &y), &z) in sums.iter_mut().zip(own[0]).zip(own[1]).zip(own[2]) {
            let (_, squared) = difference(simd, [x, y, z], [ox, oy, oz]);
            let slope = K::slope_over_q(simd, simd.min_f32s(in_radii.of(simd, squared), one));
            let weight = simd.mul_f32s(at_rest, slope);
            sum[0] = simd.add_f32s(weight, sum[0]);
            for (sum, along) in sum[1..].iter_mut().zip([u, v, w]) {
                *sum = simd.mul_add_f32s(weight, along, *sum);
            }
        }
        first += S::F32_LANES;
    }
}
