//! Stage `acceleration`: pressure, viscosity and gravity.
//!
//! `a_a = g - (1/G) [ m sum_b (P_a + P_b + Pi_ab) F x_ab + rho0 sum_k V_k (P_a + Pi_ak) F x_ak ]`; `Pi_ab` after Monaghan 1992
//! with beta = 0, for pairs that part as for pairs that approach (Monaghan 2005, section 8: a Newtonian viscosity). Walls and
//! bodies act through the density they add (Akinci et al. 2012), quasi-fluid ones by their own pressure `P_k` as well. `Pi_ak` is that of a particle at rest with the density of `a`,
//! for samples of viscous faces; elsewhere fluid slips freely. With a physical viscosity, see [`morris1997`](super::morris1997),
//! that acts at viscous faces in its stead. Other forms of the pressure force: `freshet_core::pressure_force`.

use std::marker::PhantomData;

use freshet_core::grid::Grid;
use freshet_core::pressure_force::PressureForce;
use freshet_core::tensile_correction::POSITIVE;
use glam::Vec3;
use pulp::{Arch, Simd, WithSimd};

use super::morris1997::{self, Viscosity};
use super::support::inverse_width;
use crate::candidates::Candidates;
use crate::lanes::{ScaledRoot, difference, divide, minus_quotient, sum_vector};
use crate::packed::Packed;
use crate::particles::Particles;
use crate::samples::SortedSamples;
use crate::simd_kernel::{SimdKernel, WithKernel};
use crate::tasks::Total;
use crate::workers::Chunk;
use crate::workspace::Workspace;

/// What the acceleration of a chunk needs.
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
    /// Densities, kg/m3, padded.
    pub density: &'a [f32],
    /// `p / rho^2`, padded.
    pub pressure_term: &'a [f32],
    /// How pressures become forces.
    pub force: PressureForce,
    /// Widths of supports, of plans that have them, padded.
    pub width: Option<&'a [f32]>,
    /// Factor of fluid neighbours, `-m A / (G H^5)`.
    pub fluid_factor: f32,
    /// Factor of samples, `-rho0 A / (G H^5)`.
    pub sample_factor: f32,
    /// `2 alpha c h`; zero for a plan without viscosity.
    pub viscosity: f32,
    /// Morris' viscosity, if the plan has it.
    pub physical: Option<Viscosity>,
    /// `2 k/rho0 A_near/A`: near pressure in units of the fluid's factor; zero for a plan without.
    pub near_pressure: f32,
    /// Monaghan's epsilon against clumping, and `1/f(d/H)`; of plans that have it.
    pub tensile: Option<[f32; 2]>,
    /// `0.01 h^2`, m2.
    pub softening: f32,
    /// m/s2.
    pub gravity: Vec3,
    /// Whether results are added to what is there instead of taking its place: to that of a [viscosity](super::viscosity) with a kernel of its own.
    pub adds: bool,
    /// Whether [`Maxima`] are asked for: iterations of a pressure solve need none.
    pub maxima: bool,
    /// How long, s, particles are to be moved on before their speeds are compared.
    pub ahead: f32,
}

/// Accelerations of a chunk's particles.
pub struct Task<'a> {
    /// Shared inputs.
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

/// Largest values in a chunk; speeds are those that particles have [ahead](Inputs::ahead).
#[derive(Clone, Copy, Debug, Default)]
pub struct Maxima {
    /// m2/s2.
    pub speed_squared: f32,
    /// m2/s4.
    pub acceleration_squared: f32,
    /// `p / rho^2`, m5/(kg s2).
    pub pressure_term: f32,
}

impl Total for Maxima {
    fn and(self, other: Self) -> Self {
        Self {
            speed_squared: self.speed_squared.max(other.speed_squared),
            acceleration_squared: self.acceleration_squared.max(other.acceleration_squared),
            pressure_term: self.pressure_term.max(other.pressure_term),
        }
    }
}

impl WithKernel for Task<'_> {
    type Output = Maxima;

    fn with<K: SimdKernel>(self, _: K) -> Maxima {
        let arch = self.inputs.arch;
        if let Some(width) = self.inputs.width {
            // Code for everything; what of it a plan has is asked for every pair.
            return arch.dispatch(Typed::<K, true, true, true>(self, width, PhantomData));
        }
        // Mueller's form needs the densities that viscosity needs.
        let pairs = self.inputs.viscosity > 0.0 || self.inputs.force == PressureForce::Mueller;
        match (pairs, self.inputs.physical.is_some()) {
            (_, true) => arch.dispatch(Typed::<K, false, true, false>(self, &[], PhantomData)),
            (true, false) => arch.dispatch(Typed::<K, true, false, false>(self, &[], PhantomData)),
            (false, false) => arch.dispatch(Typed::<K, false, false, false>(self, &[], PhantomData)),
        }
    }
}

struct Typed<'a, K, const ARTIFICIAL: bool, const PHYSICAL: bool, const WIDTHS: bool>(
    Task<'a>,
    &'a [f32],
    PhantomData<K>,
);

impl<K: SimdKernel, const ARTIFICIAL: bool, const PHYSICAL: bool, const WIDTHS: bool> WithSimd
    for Typed<'_, K, ARTIFICIAL, PHYSICAL, WIDTHS>
{
    type Output = Maxima;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Maxima {
        let Task { inputs, chunk, workspace, candidates, acceleration: [ax, ay, az] } = self.0;
        let ([x, y, z], [vx, vy, vz]) = (&inputs.particles.position, &inputs.particles.velocity);
        let Workspace { calm, moving, dragging, sticking, viscous, wide, sums, wall_sums, .. } = workspace;
        calm.begin(inputs.grid);
        moving.begin(inputs.grid);
        dragging.begin(inputs.grid);
        sticking.begin(inputs.grid);
        viscous.begin(inputs.grid);
        wide.begin(inputs.grid);
        let pairs = Pairs::new(simd, &inputs);
        let (is_artificial, is_physical) =
            (ARTIFICIAL && inputs.viscosity > 0.0, PHYSICAL && inputs.physical.is_some());
        // At viscous faces the physical viscosity acts in the artificial one's stead.
        let drags = is_artificial && !is_physical && !inputs.adds;
        let mut maxima = Maxima::default();
        let mut lists = candidates.lists();
        for cell in chunk.cells.clone() {
            let range = inputs.starts[cell] as usize..inputs.starts[cell + 1] as usize;
            if range.is_empty() {
                continue;
            }
            let own = Own::new(&inputs, &range);
            let at = own.position[0][0];
            let (sums, _) = sums.zeroed::<S>(3 * range.len()).as_chunks_mut::<3>();
            let list = lists.next().unwrap_or_default();
            if WIDTHS {
                let width = self.1;
                let sources = [x, y, z, inputs.pressure_term, vx, vy, vz, inputs.density, width];
                wide.pack(simd, list, sources, at);
                let width = &width[range.clone()];
                add_wide_fluid::<S, K>(simd, pairs, own, width, wide, [is_artificial, is_physical], sums);
            } else if ARTIFICIAL || PHYSICAL {
                let sources = [x, y, z, inputs.pressure_term, vx, vy, vz, inputs.density];
                viscous.pack(simd, list, sources, at);
                // Beside a physical viscosity the artificial one is a question once a pair instead of code of its own.
                let is_artificial = ARTIFICIAL || inputs.viscosity > 0.0;
                add_viscous_fluid::<S, K, PHYSICAL>(simd, pairs, own, viscous, is_artificial, sums);
            } else {
                calm.pack(simd, list, [x, y, z, inputs.pressure_term], at);
                add_fluid::<S, K>(simd, pairs, own, calm, sums);
            }
            if (ARTIFICIAL || PHYSICAL) && inputs.force == PressureForce::Mueller {
                add_mueller::<S, K>(simd, pairs, own, viscous, sums);
            }
            if let Some(tensile) = inputs.tensile {
                match ARTIFICIAL || PHYSICAL {
                    true => add_tensile::<S, K, 8>(simd, pairs, own, viscous, tensile, sums),
                    false => add_tensile::<S, K, 4>(simd, pairs, own, calm, tensile, sums),
                }
            }
            if inputs.near_pressure > 0.0 {
                match ARTIFICIAL || PHYSICAL {
                    true if WIDTHS => add_near_pressure::<S, 9>(simd, pairs, own, wide, inputs.near_pressure, sums),
                    true => add_near_pressure::<S, 8>(simd, pairs, own, viscous, inputs.near_pressure, sums),
                    false => add_near_pressure::<S, 4>(simd, pairs, own, calm, inputs.near_pressure, sums),
                }
            }
            let stuck = if is_physical { 7 * range.len() } else { 0 };
            let (wall_sums, _) = wall_sums.zeroed::<S>(stuck).as_chunks_mut::<7>();
            for samples in inputs.samples {
                let list = lists.next().unwrap_or_default();
                if list.is_empty() {
                    continue;
                }
                let [x, y, z] = &samples.position;
                if is_physical && samples.drags() {
                    let [u, v, w] = samples.velocity();
                    sticking.pack(simd, list, [x, y, z, &samples.viscous_volume, u, v, w], at);
                    morris1997::add_walls::<S, K>(simd, pairs, own, sticking, wall_sums);
                }
                if drags && samples.drags() {
                    let [volume, weight, term] = [&*samples.volume, &*samples.viscous_volume, &*samples.pressure_term];
                    let [u, v, w] = samples.velocity();
                    match (samples.moves(), term.is_empty()) {
                        (false, true) => {
                            dragging.pack(simd, list, [x, y, z, volume, weight], at);
                            add_viscous_samples::<S, K, 5>(simd, pairs, own, dragging, sums);
                        }
                        (false, false) => {
                            moving.pack(simd, list, [x, y, z, volume, weight, term], at);
                            add_viscous_samples::<S, K, 6>(simd, pairs, own, moving, sums);
                        }
                        (true, true) => {
                            viscous.pack(simd, list, [x, y, z, volume, weight, u, v, w], at);
                            add_viscous_samples::<S, K, 8>(simd, pairs, own, viscous, sums);
                        }
                        (true, false) => {
                            wide.pack(simd, list, [x, y, z, volume, weight, u, v, w, term], at);
                            add_viscous_samples::<S, K, 9>(simd, pairs, own, wide, sums);
                        }
                    }
                } else if !samples.pressure_term.is_empty() {
                    dragging.pack(simd, list, [x, y, z, &samples.volume, &samples.pressure_term], at);
                    add_quasi_fluid::<S, K>(simd, pairs, own, dragging, sums);
                } else {
                    calm.pack(simd, list, [x, y, z, &samples.volume], at);
                    add_samples::<S, K>(simd, pairs, own, calm, sums);
                }
            }
            for (i, &sum) in range.clone().zip(&*sums) {
                let mut value = inputs.gravity + inputs.fluid_factor * sum_vector(simd, sum);
                if PHYSICAL && let Some(viscosity) = inputs.physical {
                    let (walls, velocity) = (&wall_sums[i - range.start], inputs.particles.velocity_of(i));
                    value += morris1997::wall_drag(simd, walls, viscosity, velocity, inputs.density[i]);
                }
                let at = i - chunk.particles.start;
                if inputs.adds {
                    value += Vec3::new(ax[at], ay[at], az[at]);
                }
                (ax[at], ay[at], az[at]) = value.into();
                if inputs.maxima {
                    let speed = inputs.particles.velocity_of(i) + inputs.ahead * value;
                    maxima.acceleration_squared = maxima.acceleration_squared.max(value.length_squared());
                    maxima.speed_squared = maxima.speed_squared.max(speed.length_squared());
                    maxima.pressure_term = maxima.pressure_term.max(inputs.pressure_term[i]);
                }
            }
        }
        maxima
    }
}

/// A cell's particles.
#[derive(Clone, Copy)]
pub struct Own<'a> {
    position: [&'a [f32]; 3],
    pub(super) velocity: [&'a [f32]; 3],
    pub(super) density: &'a [f32],
    pressure_term: &'a [f32],
}

impl<'a> Own<'a> {
    #[inline(always)]
    pub(super) fn new(inputs: &Inputs<'a>, range: &std::ops::Range<usize>) -> Self {
        let ([x, y, z], [u, v, w]) = (&inputs.particles.position, &inputs.particles.velocity);
        Self {
            position: [&x[range.clone()], &y[range.clone()], &z[range.clone()]],
            velocity: [&u[range.clone()], &v[range.clone()], &w[range.clone()]],
            density: &inputs.density[range.clone()],
            pressure_term: &inputs.pressure_term[range.clone()],
        }
    }

    /// Positions and pressure terms, each beside the sum it belongs to.
    #[inline(always)]
    pub fn with<'b, T>(self, sums: &'b mut [T]) -> impl Iterator<Item = (&'b mut T, [f32; 3], f32)>
    where
        'a: 'b,
    {
        let [x, y, z] = self.position;
        sums.iter_mut()
            .zip(x)
            .zip(y)
            .zip(z)
            .zip(self.pressure_term)
            .map(|((((sum, &x), &y), &z), &term)| (sum, [x, y, z], term))
    }
}

/// `sum_b (P_a + P_b + Pi_ab) f'(q)/q x_ab` over the fluid, for each of a cell's particles, and Morris' viscosity.
#[inline(always)]
fn add_viscous_fluid<S: Simd, K: SimdKernel, const PHYSICAL: bool>(
    simd: S,
    pairs: Pairs<S>,
    own: Own,
    all: &Packed<8>,
    is_artificial: bool,
    sums: &mut [[S::f32s; 3]],
) {
    let [vx, vy, vz] = own.velocity;
    let mut first = 0;
    while first < all.len() {
        let [x, y, z, term, u, v, w, density] = all.lanes::<S>(first);
        let motions = vx.iter().zip(vy).zip(vz).zip(own.density);
        for ((sum, position, own_term), (((&own_u, &own_v), &own_w), &own_density)) in own.with(sums).zip(motions) {
            let ([dx, dy, dz], squared) = difference(simd, position, [x, y, z]);
            let du = simd.sub_f32s(simd.splat_f32s(own_u), u);
            let dv = simd.sub_f32s(simd.splat_f32s(own_v), v);
            let dw = simd.sub_f32s(simd.splat_f32s(own_w), w);
            let own_density = simd.splat_f32s(own_density);
            let mut strength = simd.add_f32s(simd.splat_f32s(own_term), term);
            if is_artificial {
                let approach = simd.mul_add_f32s(dw, dz, simd.mul_add_f32s(dv, dy, simd.mul_f32s(du, dx)));
                let numerator = simd.mul_f32s(pairs.viscosity, approach);
                let densities = simd.add_f32s(own_density, density);
                let divisor = simd.mul_f32s(simd.add_f32s(squared, pairs.softening), densities);
                strength = minus_quotient(simd, strength, numerator, divisor);
            }
            let slope = pairs.slope::<K>(simd, squared);
            if PHYSICAL {
                morris1997::add_pair(simd, pairs, [squared, slope], [own_density, density], [du, dv, dw], sum);
            }
            add(simd, sum, simd.mul_f32s(strength, slope), [dx, dy, dz]);
        }
        first += S::F32_LANES;
    }
}

/// The same without viscosity.
#[inline(always)]
fn add_fluid<S: Simd, K: SimdKernel>(simd: S, pairs: Pairs<S>, own: Own, all: &Packed<4>, sums: &mut [[S::f32s; 3]]) {
    let mut first = 0;
    while first < all.len() {
        let [x, y, z, term] = all.lanes::<S>(first);
        for (sum, position, own_term) in own.with(sums) {
            let (difference, squared) = difference(simd, position, [x, y, z]);
            let pressure = simd.add_f32s(simd.splat_f32s(own_term), term);
            let slope = pairs.slope::<K>(simd, squared);
            add(simd, sum, simd.mul_f32s(pressure, slope), difference);
        }
        first += S::F32_LANES;
    }
}

/// The same with supports of different widths, and each viscosity if it is asked for. Code for both: few plans have it.
#[inline(always)]
fn add_wide_fluid<S: Simd, K: SimdKernel>(
    simd: S,
    pairs: Pairs<S>,
    own: Own,
    width: &[f32],
    all: &Packed<9>,
    [is_artificial, is_physical]: [bool; 2],
    sums: &mut [[S::f32s; 3]],
) {
    let [vx, vy, vz] = own.velocity;
    let one = simd.splat_f32s(1.0);
    let mut first = 0;
    while first < all.len() {
        let [x, y, z, term, u, v, w, density, other_width] = all.lanes::<S>(first);
        let motions = vx.iter().zip(vy).zip(vz).zip(own.density).zip(width);
        for ((sum, position, own_term), ((((&own_u, &own_v), &own_w), &own_density), &width)) in
            own.with(sums).zip(motions)
        {
            let ([dx, dy, dz], squared) = difference(simd, position, [x, y, z]);
            let du = simd.sub_f32s(simd.splat_f32s(own_u), u);
            let dv = simd.sub_f32s(simd.splat_f32s(own_v), v);
            let dw = simd.sub_f32s(simd.splat_f32s(own_w), w);
            let own_density = simd.splat_f32s(own_density);
            let mut strength = simd.add_f32s(simd.splat_f32s(own_term), term);
            if is_artificial {
                let approach = simd.mul_add_f32s(dw, dz, simd.mul_add_f32s(dv, dy, simd.mul_f32s(du, dx)));
                let numerator = simd.mul_f32s(pairs.viscosity, approach);
                let densities = simd.add_f32s(own_density, density);
                let divisor = simd.mul_f32s(simd.add_f32s(squared, pairs.softening), densities);
                strength = minus_quotient(simd, strength, numerator, divisor);
            }
            let inverse = inverse_width(simd, width, other_width);
            let square = simd.mul_f32s(inverse, inverse);
            let fifth = simd.mul_f32s(simd.mul_f32s(square, square), inverse);
            let q = simd.min_f32s(simd.mul_f32s(pairs.in_radii.of(simd, squared), inverse), one);
            let slope = simd.mul_f32s(K::slope_over_q(simd, q), fifth);
            if is_physical {
                morris1997::add_pair(simd, pairs, [squared, slope], [own_density, density], [du, dv, dw], sum);
            }
            add(simd, sum, simd.mul_f32s(strength, slope), [dx, dy, dz]);
        }
        first += S::F32_LANES;
    }
}

/// What makes Mueller's form of Monaghan's: `sum_b (rho_a - rho_b) (P_a rho_a - P_b rho_b) / (rho_a rho_b) f'(q)/q x_ab` over the fluid. A loop of its own:
/// few plans have it.
#[inline(always)]
fn add_mueller<S: Simd, K: SimdKernel>(simd: S, pairs: Pairs<S>, own: Own, all: &Packed<8>, sums: &mut [[S::f32s; 3]]) {
    let mut first = 0;
    while first < all.len() {
        let [x, y, z, term, _, _, _, density] = all.lanes::<S>(first);
        let over_density = simd.mul_f32s(term, density);
        for ((sum, position, own_term), &own_density) in own.with(sums).zip(own.density) {
            let (difference, squared) = difference(simd, position, [x, y, z]);
            let denser = simd.sub_f32s(simd.splat_f32s(own_density), density);
            let harder = simd.sub_f32s(simd.splat_f32s(own_term * own_density), over_density);
            let densities = simd.mul_f32s(simd.splat_f32s(own_density), density);
            let strength = divide(simd, simd.mul_f32s(denser, harder), densities);
            add(simd, sum, simd.mul_f32s(strength, pairs.slope::<K>(simd, squared)), difference);
        }
        first += S::F32_LANES;
    }
}

/// Monaghan's repulsion under tension, see `freshet_core::tensile_correction`: `sum_b R f^4 f'(q)/q x_ab` over the fluid. A loop of its own: few plans have it.
#[inline(always)]
fn add_tensile<S: Simd, K: SimdKernel, const N: usize>(
    simd: S,
    pairs: Pairs<S>,
    own: Own,
    all: &Packed<N>,
    [epsilon, inverse_shape]: [f32; 2],
    sums: &mut [[S::f32s; 3]],
) {
    let (zero, one) = (simd.splat_f32s(0.0), simd.splat_f32s(1.0));
    let (epsilon, inverse_shape) = (simd.splat_f32s(epsilon), simd.splat_f32s(inverse_shape));
    let positive = simd.splat_f32s(POSITIVE);
    let mut first = 0;
    while first < all.len() {
        let lanes = all.lanes::<S>(first);
        for (sum, position, own_term) in own.with(sums) {
            let (difference, squared) = difference(simd, position, [lanes[0], lanes[1], lanes[2]]);
            let own_term = simd.splat_f32s(own_term);
            let pulls = simd.add_f32s(simd.min_f32s(own_term, zero), simd.min_f32s(lanes[3], zero));
            let pulls = simd.mul_f32s(simd.sub_f32s(zero, epsilon), pulls);
            let presses = simd.mul_f32s(positive, simd.add_f32s(own_term, lanes[3]));
            let both = simd.less_than_f32s(zero, simd.min_f32s(own_term, lanes[3]));
            let q = simd.min_f32s(pairs.in_radii.of(simd, squared), one);
            let ratio = simd.mul_f32s(K::shape(simd, q), inverse_shape);
            let square = simd.mul_f32s(ratio, ratio);
            let strength = simd.mul_f32s(simd.select_f32s(both, presses, pulls), simd.mul_f32s(square, square));
            add(simd, sum, simd.mul_f32s(strength, K::slope_over_q(simd, q)), difference);
        }
        first += S::F32_LANES;
    }
}

/// Double density relaxation, see `freshet_core::near_pressure`, over the fluid. A loop of its own: few plans have it.
#[inline(always)]
fn add_near_pressure<S: Simd, const N: usize>(
    simd: S,
    pairs: Pairs<S>,
    own: Own,
    all: &Packed<N>,
    near_pressure: f32,
    sums: &mut [[S::f32s; 3]],
) {
    let (one, least) = (simd.splat_f32s(1.0), simd.splat_f32s(1e-6));
    let scale = simd.splat_f32s(-4.0 * near_pressure);
    let mut first = 0;
    while first < all.len() {
        let lanes = all.lanes::<S>(first);
        for (sum, position, _) in own.with(sums) {
            let (difference, squared) = difference(simd, position, [lanes[0], lanes[1], lanes[2]]);
            let q = simd.max_f32s(simd.min_f32s(pairs.in_radii.of(simd, squared), one), least);
            let left = simd.sub_f32s(one, q);
            let cube = simd.mul_f32s(simd.mul_f32s(left, left), left);
            add(simd, sum, divide(simd, simd.mul_f32s(scale, cube), q), difference);
        }
        first += S::F32_LANES;
    }
}

/// `rho0/m P_a sum_k V_k f'(q)/q x_ak` over walls or bodies, for each of a cell's particles.
#[inline(always)]
fn add_samples<S: Simd, K: SimdKernel>(simd: S, pairs: Pairs<S>, own: Own, all: &Packed<4>, sums: &mut [[S::f32s; 3]]) {
    let mut first = 0;
    while first < all.len() {
        let [x, y, z, volume] = all.lanes::<S>(first);
        let weight = simd.mul_f32s(pairs.relative_factor, volume);
        for (sum, position, own_term) in own.with(sums) {
            let (difference, squared) = difference(simd, position, [x, y, z]);
            let pressure = simd.mul_f32s(weight, simd.splat_f32s(own_term));
            add(simd, sum, simd.mul_f32s(pressure, pairs.slope::<K>(simd, squared)), difference);
        }
        first += S::F32_LANES;
    }
}

/// `rho0/m sum_k V_k (P_a + P_k) f'(q)/q x_ak` over quasi-fluid samples, for each of a cell's particles.
#[inline(always)]
fn add_quasi_fluid<S: Simd, K: SimdKernel>(
    simd: S,
    pairs: Pairs<S>,
    own: Own,
    all: &Packed<5>,
    sums: &mut [[S::f32s; 3]],
) {
    let mut first = 0;
    while first < all.len() {
        let [x, y, z, volume, term] = all.lanes::<S>(first);
        let weight = simd.mul_f32s(pairs.relative_factor, volume);
        for (sum, position, own_term) in own.with(sums) {
            let (difference, squared) = difference(simd, position, [x, y, z]);
            let pressure = simd.mul_f32s(weight, simd.add_f32s(simd.splat_f32s(own_term), term));
            add(simd, sum, simd.mul_f32s(pressure, pairs.slope::<K>(simd, squared)), difference);
        }
        first += S::F32_LANES;
    }
}

/// `rho0/m sum_k V_k (P_a + P_k + Pi_ak) f'(q)/q x_ak` over walls, for each of a cell's particles. Quantities six to eight are the velocities of walls that
/// move, where there are eight or more; the last of six or nine is `P_k` of quasi-fluid.
#[inline(always)]
fn add_viscous_samples<S: Simd, K: SimdKernel, const N: usize>(
    simd: S,
    pairs: Pairs<S>,
    own: Own,
    all: &Packed<N>,
    sums: &mut [[S::f32s; 3]],
) {
    let [vx, vy, vz] = own.velocity;
    let mut first = 0;
    while first < all.len() {
        let lanes = all.lanes::<S>(first);
        let [x, y, z, volume, viscous_volume] = [0, 1, 2, 3, 4].map(|quantity| lanes[quantity]);
        let weight = simd.mul_f32s(pairs.relative_factor, volume);
        let viscous_weight = simd.mul_f32s(simd.mul_f32s(pairs.relative_factor, viscous_volume), pairs.viscosity);
        let relative = |value: f32, axis: usize| match lanes.get(5 + axis) {
            Some(&surface) if N >= 8 => simd.sub_f32s(simd.splat_f32s(value), surface),
            _ => simd.splat_f32s(value),
        };
        let motions = vx.iter().zip(vy).zip(vz).zip(own.density);
        for ((sum, position, own_term), (((&u, &v), &w), &own_density)) in own.with(sums).zip(motions) {
            let ([dx, dy, dz], squared) = difference(simd, position, [x, y, z]);
            let approach = simd.mul_f32s(relative(u, 0), dx);
            let approach = simd.mul_add_f32s(relative(v, 1), dy, approach);
            let approach = simd.mul_add_f32s(relative(w, 2), dz, approach);
            let divisor = simd.mul_f32s(simd.add_f32s(squared, pairs.softening), simd.splat_f32s(2.0 * own_density));
            let own_term = simd.splat_f32s(own_term);
            let term = if N == 6 || N == 9 { simd.add_f32s(own_term, lanes[N - 1]) } else { own_term };
            let pressure = simd.mul_f32s(weight, term);
            let strength = minus_quotient(simd, pressure, simd.mul_f32s(viscous_weight, approach), divisor);
            add(simd, sum, simd.mul_f32s(strength, pairs.slope::<K>(simd, squared)), [dx, dy, dz]);
        }
        first += S::F32_LANES;
    }
}

/// Constants of the innermost loop, in registers: read through a reference they would be read again for every pair.
#[derive(Clone, Copy)]
pub struct Pairs<S: Simd> {
    /// Distances over the support radius.
    in_radii: ScaledRoot<S>,
    /// See [`Inputs::sample_factor`].
    pub sample_factor: S::f32s,
    /// The same in units of the fluid's factor, by which sums are multiplied at the end.
    relative_factor: S::f32s,
    viscosity: S::f32s,
    /// See [`Viscosity::of_pairs`].
    pub physical: S::f32s,
    /// See [`Inputs::softening`].
    pub softening: S::f32s,
}

impl<S: Simd> Pairs<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, inputs: &Inputs) -> Self {
        Self {
            in_radii: ScaledRoot::new(simd, 1.0 / inputs.grid.support_radius),
            sample_factor: simd.splat_f32s(inputs.sample_factor),
            relative_factor: simd.splat_f32s(inputs.sample_factor / inputs.fluid_factor),
            viscosity: simd.splat_f32s(inputs.viscosity),
            physical: simd.splat_f32s(inputs.physical.map_or(0.0, |viscosity| viscosity.of_pairs)),
            softening: simd.splat_f32s(inputs.softening),
        }
    }

    /// `f'(q)/q`, zero beyond the support.
    #[inline(always)]
    pub fn slope<K: SimdKernel>(self, simd: S, squared: S::f32s) -> S::f32s {
        K::slope_over_q(simd, simd.min_f32s(self.in_radii.of(simd, squared), simd.splat_f32s(1.0)))
    }
}

#[inline(always)]
fn add<S: Simd>(simd: S, sum: &mut [S::f32s; 3], factor: S::f32s, difference: [S::f32s; 3]) {
    sum[0] = simd.mul_add_f32s(factor, difference[0], sum[0]);
    sum[1] = simd.mul_add_f32s(factor, difference[1], sum[1]);
    sum[2] = simd.mul_add_f32s(factor, difference[2], sum[2]);
}
