//! Loads, stores and arithmetic in SIMD lanes.

use glam::Vec3;
use pulp::Simd;

/// Arrays that are read in lanes end with this many spare values, so that the last chunk of a range may overrun.
pub const PADDING: usize = 16;

/// The lanes that begin at `first`.
#[inline(always)]
pub fn load<S: Simd>(values: &[f32], first: usize) -> S::f32s {
    S::as_simd_f32s(&values[first..first + S::F32_LANES]).0[0]
}

/// Writes lanes from `first` on.
#[inline(always)]
pub fn store<S: Simd>(values: &mut [f32], first: usize, lanes: S::f32s) {
    S::as_mut_simd_f32s(&mut values[first..first + S::F32_LANES]).0[0] = lanes;
}

/// The sums over lanes of three components.
#[inline(always)]
pub fn sum_vector<S: Simd>(simd: S, [x, y, z]: [S::f32s; 3]) -> Vec3 {
    Vec3::new(simd.reduce_sum_f32s(x), simd.reduce_sum_f32s(y), simd.reduce_sum_f32s(z))
}

/// The square of a vector's length, and of one of length zero the smallest number that roots and quotients take.
#[inline(always)]
pub fn squared_length<S: Simd>(simd: S, [x, y, z]: [S::f32s; 3]) -> S::f32s {
    let tiny = simd.splat_f32s(1e-30);
    simd.mul_add_f32s(z, z, simd.mul_add_f32s(y, y, simd.mul_add_f32s(x, x, tiny)))
}

/// `x_ab` and its square, between a particle and lanes of others.
#[inline(always)]
pub fn difference<S: Simd>(simd: S, own: [f32; 3], other: [S::f32s; 3]) -> ([S::f32s; 3], S::f32s) {
    let dx = simd.sub_f32s(simd.splat_f32s(own[0]), other[0]);
    let dy = simd.sub_f32s(simd.splat_f32s(own[1]), other[1]);
    let dz = simd.sub_f32s(simd.splat_f32s(own[2]), other[2]);
    ([dx, dy, dz], squared_length(simd, [dx, dy, dz]))
}

/// A factor times the square root of positive values, to single precision.
///
/// With AVX-512 the reciprocal estimate and one Newton step, which takes in the factor: the exact instruction takes twelve
/// cycles and would be the longest part of a pair. Estimates differ between makers of processors in the last bit.
#[derive(Clone, Copy)]
pub struct ScaledRoot<S: Simd> {
    factor: S::f32s,
    steps: [S::f32s; 2],
}

impl<S: Simd> ScaledRoot<S> {
    /// With a factor.
    #[inline(always)]
    pub fn new(simd: S, factor: f32) -> Self {
        Self { factor: simd.splat_f32s(factor), steps: [simd.splat_f32s(-0.5 * factor), simd.splat_f32s(1.5 * factor)] }
    }

    /// Of some values.
    #[inline(always)]
    pub fn of(self, simd: S, x: S::f32s) -> S::f32s {
        #[cfg(target_arch = "x86_64")]
        if let Some(avx512) = avx512(simd) {
            let y: S::f32s = bytemuck::cast(avx512.avx512f._mm512_rsqrt14_ps(bytemuck::cast(x)));
            // f sqrt(x) = x y (3 - x y^2) f / 2
            let root = simd.mul_f32s(x, y);
            let step = simd.mul_add_f32s(simd.mul_f32s(root, y), self.steps[0], self.steps[1]);
            return simd.mul_f32s(root, step);
        }
        simd.mul_f32s(simd.sqrt_f32s(x), self.factor)
    }
}

/// `from` minus a quotient, that to single precision by an estimate and one Newton step with AVX-512; see [`ScaledRoot`].
#[inline(always)]
pub fn minus_quotient<S: Simd>(simd: S, from: S::f32s, numerator: S::f32s, divisor: S::f32s) -> S::f32s {
    #[cfg(target_arch = "x86_64")]
    if let Some(avx512) = avx512(simd) {
        let y: S::f32s = bytemuck::cast(avx512.avx512f._mm512_rcp14_ps(bytemuck::cast(divisor)));
        let step = simd.negate_mul_add_f32s(divisor, y, simd.splat_f32s(2.0));
        return simd.negate_mul_add_f32s(simd.mul_f32s(numerator, y), step, from);
    }
    simd.sub_f32s(from, simd.div_f32s(numerator, divisor))
}

/// A quotient, as in [`minus_quotient`].
#[inline(always)]
pub fn divide<S: Simd>(simd: S, numerator: S::f32s, divisor: S::f32s) -> S::f32s {
    #[cfg(target_arch = "x86_64")]
    if let Some(avx512) = avx512(simd) {
        let y: S::f32s = bytemuck::cast(avx512.avx512f._mm512_rcp14_ps(bytemuck::cast(divisor)));
        let step = simd.negate_mul_add_f32s(divisor, y, simd.splat_f32s(2.0));
        return simd.mul_f32s(simd.mul_f32s(numerator, y), step);
    }
    simd.div_f32s(numerator, divisor)
}

/// The AVX-512 instructions if `simd` is them; decided by the compiler.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub fn avx512<S: Simd>(simd: S) -> Option<pulp::x86::V4> {
    (&simd as &dyn std::any::Any).downcast_ref::<pulp::x86::V4>().copied()
}

/// Sums in lanes, one or more for each particle of a cell, on whole cache lines: a store across two costs twice.
#[derive(Default)]
pub struct Sums {
    values: Vec<f32>,
}

impl Sums {
    /// Bytes allocated.
    pub fn bytes(&self) -> u64 {
        4 * self.values.capacity() as u64
    }

    /// `count` lanes of zeros.
    #[inline(always)]
    pub fn zeroed<S: Simd>(&mut self, count: usize) -> &mut [S::f32s] {
        const LINE: usize = 64;
        self.values.clear();
        self.values.resize(count * S::F32_LANES + LINE / 4, 0.0);
        let first = (LINE - self.values.as_ptr() as usize % LINE) / 4;
        S::as_mut_simd_f32s(&mut self.values[first..first + count * S::F32_LANES]).0
    }
}
