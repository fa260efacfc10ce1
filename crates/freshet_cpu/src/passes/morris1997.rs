//! Part of stage `acceleration`: Morris' viscosity (Morris, Fox & Zhu 1997, J. Comput. Phys. 136, 214), and how fluid sticks
//! to walls.
//!
//! Fluid (eq. 22): `(1/G') m sum_b 2 mu / (rho_a rho_b) F r^2/(r^2 + 0.01 h^2) v_ab`, with G' the viscous calibration.
//!
//! Walls: `(mu rho0 / rho_a^2) (1/G) |D| (v_a - u) / y`, from the sums `s = sum_k V_k F`, `D = sum_k V_k F x_ak` and
//! `u = sum_k V_k F v_k / s` over samples of viscous faces. Of a plane of samples `|D| / |s|` is the distance, so
//! `y = |D| / |s| - depth` is that of the face. It is what fluid behind the face would do whose velocity goes on in a straight
//! line (Morris' eqs. 23-24): a wall's `D` is twice that of the fluid it replaces (`freshet_core::sampling::wall_layer`), hence
//! mu and not 2 mu. `y` is at least a quarter of a spacing, as particles of a rough flow come closer than those of a lattice.

use glam::Vec3;
use pulp::Simd;

use super::acceleration::{Own, Pairs};
use crate::lanes::{difference, divide};
use crate::packed::Packed;
use crate::simd_kernel::SimdKernel;

/// Numbers of the model.
#[derive(Clone, Copy)]
pub struct Viscosity {
    /// `2 mu G / G'`, Pa s, as pair forces are divided by G.
    pub of_pairs: f32,
    /// `mu`, Pa s.
    pub of_walls: f32,
    /// How far samples lie behind the face, m.
    pub depth: f32,
    /// A quarter of a spacing, m.
    pub nearest: f32,
}

/// Adds what a particle and lanes of others exchange; `slope` is `f'(q)/q`.
#[inline(always)]
pub fn add_pair<S: Simd>(
    simd: S,
    pairs: Pairs<S>,
    [squared, slope]: [S::f32s; 2],
    densities: [S::f32s; 2],
    velocity: [S::f32s; 3],
    sum: &mut [S::f32s; 3],
) {
    let divisor = simd.mul_f32s(simd.add_f32s(squared, pairs.softening), simd.mul_f32s(densities[0], densities[1]));
    let factor = divide(simd, simd.mul_f32s(pairs.physical, squared), divisor);
    let factor = simd.mul_f32s(factor, slope);
    sum[0] = simd.negate_mul_add_f32s(factor, velocity[0], sum[0]);
    sum[1] = simd.negate_mul_add_f32s(factor, velocity[1], sum[1]);
    sum[2] = simd.negate_mul_add_f32s(factor, velocity[2], sum[2]);
}

/// Lanes of `(rho0/G) (s, D, s u)`, without their sign, for each of a cell's particles.
pub type WallSums<S> = [<S as Simd>::f32s; 7];

/// Adds samples: position, weight of viscous faces, velocity.
#[inline(always)]
pub fn add_walls<S: Simd, K: SimdKernel>(
    simd: S,
    pairs: Pairs<S>,
    own: Own,
    all: &Packed<7>,
    sums: &mut [WallSums<S>],
) {
    let mut first = 0;
    while first < all.len() {
        let [x, y, z, volume, u, v, w] = all.lanes::<S>(first);
        let weight = simd.mul_f32s(pairs.sample_factor, volume);
        for (sum, position, _) in own.with(sums) {
            let ([dx, dy, dz], squared) = difference(simd, position, [x, y, z]);
            let weight = simd.mul_f32s(weight, pairs.slope::<K>(simd, squared));
            sum[0] = simd.add_f32s(weight, sum[0]);
            sum[1] = simd.mul_add_f32s(weight, dx, sum[1]);
            sum[2] = simd.mul_add_f32s(weight, dy, sum[2]);
            sum[3] = simd.mul_add_f32s(weight, dz, sum[3]);
            sum[4] = simd.mul_add_f32s(weight, u, sum[4]);
            sum[5] = simd.mul_add_f32s(weight, v, sum[5]);
            sum[6] = simd.mul_add_f32s(weight, w, sum[6]);
        }
        first += S::F32_LANES;
    }
}

/// Acceleration by the walls, m/s2, of a particle with these sums.
#[inline(always)]
pub fn wall_drag<S: Simd>(simd: S, sums: &WallSums<S>, viscosity: Viscosity, velocity: Vec3, density: f32) -> Vec3 {
    let strength = simd.reduce_sum_f32s(sums[0]);
    if strength <= 0.0 {
        return Vec3::ZERO;
    }
    let slope =
        Vec3::new(simd.reduce_sum_f32s(sums[1]), simd.reduce_sum_f32s(sums[2]), simd.reduce_sum_f32s(sums[3])).length();
    let wall = Vec3::new(simd.reduce_sum_f32s(sums[4]), simd.reduce_sum_f32s(sums[5]), simd.reduce_sum_f32s(sums[6]));
    let distance = (slope / strength - viscosity.depth).max(viscosity.nearest);
    viscosity.of_walls / (density * density) * slope / distance * (wall / strength - velocity)
}
