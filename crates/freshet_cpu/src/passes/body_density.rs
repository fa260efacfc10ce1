//! Stages `body_density` and `wall_density`: densities and pressures of the quasi-fluid samples of bodies, see `freshet_core::sampling::quasi_fluid`, and of
//! [walls](freshet_core::wall_method::QuasiFluid).
//!
//! `rho_k = own_k rho0 + (m/S) sum_a W_ak` and `P_k = p(rho_k) / rho_k^2`; zero for samples of a single layer. Of walls `s` times as dense as the fluid at rest
//! `rho_k/s = own_k rho0 + (m/(s S)) sum_a W_ak` and `P_k = p(rho_k/s) / rho_k^2`.

use std::ops::Range;

use freshet_core::equation_of_state::PressureLaw;
use freshet_core::grid::Grid;
use glam::Vec3;
use pulp::{Arch, Simd, WithSimd};

use crate::candidates::Near;
use crate::lanes::{ScaledRoot, squared_length};
use crate::neighbours::Rows;
use crate::packed::Packed;
use crate::particles::Particles;
use crate::samples::SortedSamples;
use crate::simd_kernel::{SimdKernel, WithKernel};
use crate::workspace::Workspace;

/// What samples need.
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
    /// Sorted samples of all bodies, or of all walls.
    pub samples: &'a SortedSamples,
    /// `own_k` in the order of the sources; negative for samples of a single layer.
    pub own: &'a [f32],
    /// `m A / (s S H^3)`.
    pub factor: f32,
    /// `1/s^2`.
    pub term_factor: f32,
    /// Density at rest, kg/m3.
    pub rest_density: f32,
    /// Pressure from density.
    pub law: PressureLaw,
}

/// Pressures of samples.
pub struct Task<'a> {
    /// Shared inputs.
    pub inputs: Inputs<'a>,
    /// Slots of the samples to do.
    pub slots: Range<usize>,
    /// Memory of the thread.
    pub workspace: &'a mut Workspace,
    /// Result: `p / rho^2` of each, m5/(kg s2).
    pub pressure_terms: &'a mut [f32],
}

impl WithKernel for Task<'_> {
    type Output = ();

    fn with<K: SimdKernel>(self, _: K) {
        self.inputs.arch.dispatch(Typed::<K>(self, std::marker::PhantomData));
    }
}

struct Typed<'a, K>(Task<'a>, std::marker::PhantomData<K>);

impl<K: SimdKernel> WithSimd for Typed<'_, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Task { inputs, slots, workspace, pressure_terms } = self.0;
        let [x, y, z] = &inputs.particles.position;
        let Workspace { candidates, places: fluid, .. } = workspace;
        fluid.begin(inputs.grid);
        let mut packed_cell = None;
        for (slot, term) in slots.zip(pressure_terms) {
            let own = inputs.own[inputs.samples.source[slot] as usize];
            if own < 0.0 {
                *term = 0.0;
                continue;
            }
            let at = inputs.samples.position_of(slot);
            let cell = inputs.grid.index(inputs.grid.coordinates(at)) as usize;
            if packed_cell != Some(cell) {
                let rows = Rows::around(inputs.grid, inputs.starts, cell);
                let [sx, sy, sz] = &inputs.samples.position;
                let sharing = inputs.samples.starts[cell] as usize..inputs.samples.starts[cell + 1] as usize;
                let near = Near::around([sx, sy, sz], sharing, inputs.grid.support_radius);
                candidates.begin(inputs.grid);
                let list = candidates.add(simd, &rows, &near, [x, y, z]);
                fluid.pack(simd, list, [x, y, z], at.x);
                packed_cell = Some(cell);
            }
            let sum = sum_around::<S, K>(simd, fluid, at, 1.0 / inputs.grid.support_radius);
            // Those of a body that has not begun to swell weigh nothing.
            let density = (own * inputs.rest_density + inputs.factor * sum).max(1e-3 * inputs.rest_density);
            let pressure = inputs.law.pressure(f64::from(inputs.rest_density), f64::from(density));
            *term = inputs.term_factor * pressure as f32 / (density * density);
        }
    }
}

/// `sum_a f(q)`.
#[inline(always)]
fn sum_around<S: Simd, K: SimdKernel>(simd: S, candidates: &Packed<3>, at: Vec3, inverse_radius: f32) -> f32 {
    let (in_radii, one) = (ScaledRoot::new(simd, inverse_radius), simd.splat_f32s(1.0));
    let mut sum = simd.splat_f32s(0.0);
    let mut first = 0;
    while first < candidates.len() {
        let [x, y, z] = candidates.lanes::<S>(first);
        let dx = simd.sub_f32s(x, simd.splat_f32s(at.x));
        let dy = simd.sub_f32s(y, simd.splat_f32s(at.y));
        let dz = simd.sub_f32s(z, simd.splat_f32s(at.z));
        let q = simd.min_f32s(in_radii.of(simd, squared_length(simd, [dx, dy, dz])), one);
        sum = simd.add_f32s(K::shape(simd, q), sum);
        first += S::F32_LANES;
    }
    simd.reduce_sum_f32s(sum)
}
