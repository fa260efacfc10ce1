//! Kernels in SIMD lanes: the shapes `f(q)` and `f'(q)/q` of `freshet_core::kernel`, in single precision.
//!
//! Arguments are `q = r/H` already limited to 1, where every shape is exactly zero.

use freshet_core::kernel::{KernelKind, NOTCH_SHAPE, NOTCH_SLOPE};
use pulp::Simd;

use crate::lanes::divide;

/// A kernel's shape in lanes.
pub trait SimdKernel: Copy + Send + Sync + 'static {
    /// `f(q)`.
    fn shape<S: Simd>(simd: S, q: S::f32s) -> S::f32s;
    /// `f'(q)/q`; finite also at `q = 0`.
    fn slope_over_q<S: Simd>(simd: S, q: S::f32s) -> S::f32s;
}

/// Smallest divisor: keeps `f'(q)/q` finite where two particles share a spot (their distance vector is zero then).
const TINY: f32 = 1e-6;

#[inline(always)]
fn one_minus<S: Simd>(simd: S, q: S::f32s) -> S::f32s {
    simd.sub_f32s(simd.splat_f32s(1.0), q)
}

#[inline(always)]
fn scale<S: Simd>(simd: S, factor: f32, x: S::f32s) -> S::f32s {
    simd.mul_f32s(simd.splat_f32s(factor), x)
}

/// `a x + b`.
#[inline(always)]
fn line<S: Simd>(simd: S, a: f32, x: S::f32s, b: f32) -> S::f32s {
    simd.mul_add_f32s(simd.splat_f32s(a), x, simd.splat_f32s(b))
}

#[inline(always)]
fn positive<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    simd.max_f32s(x, simd.splat_f32s(0.0))
}

#[inline(always)]
fn over_q<S: Simd>(simd: S, numerator: S::f32s, q: S::f32s) -> S::f32s {
    divide(simd, numerator, simd.max_f32s(q, simd.splat_f32s(TINY)))
}

#[inline(always)]
fn square<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    simd.mul_f32s(x, x)
}

/// See [`KernelKind::WendlandC2`].
#[derive(Clone, Copy)]
pub struct WendlandC2;

impl SimdKernel for WendlandC2 {
    #[inline(always)]
    fn shape<S: Simd>(simd: S, q: S::f32s) -> S::f32s {
        let p2 = square(simd, one_minus(simd, q));
        simd.mul_f32s(square(simd, p2), line(simd, 4.0, q, 1.0))
    }

    #[inline(always)]
    fn slope_over_q<S: Simd>(simd: S, q: S::f32s) -> S::f32s {
        let p = one_minus(simd, q);
        scale(simd, -20.0, simd.mul_f32s(square(simd, p), p))
    }
}

/// See [`KernelKind::WendlandNotch`].
#[derive(Clone, Copy)]
pub struct WendlandNotch;

impl WendlandNotch {
    #[inline(always)]
    fn polynomial<S: Simd>(simd: S, coefficients: &[f64], q: S::f32s) -> S::f32s {
        let from_highest = coefficients.iter().rev().map(|&coefficient| simd.splat_f32s(coefficient as f32));
        from_highest.fold(simd.splat_f32s(0.0), |sum, coefficient| simd.mul_add_f32s(sum, q, coefficient))
    }
}

impl SimdKernel for WendlandNotch {
    #[inline(always)]
    fn shape<S: Simd>(simd: S, q: S::f32s) -> S::f32s {
        let p2 = square(simd, one_minus(simd, q));
        simd.mul_f32s(square(simd, p2), Self::polynomial(simd, &NOTCH_SHAPE, q))
    }

    #[inline(always)]
    fn slope_over_q<S: Simd>(simd: S, q: S::f32s) -> S::f32s {
        let p = one_minus(simd, q);
        simd.mul_f32s(simd.mul_f32s(square(simd, p), p), Self::polynomial(simd, &NOTCH_SLOPE, q))
    }
}

/// See [`KernelKind::CubicSpline`].
#[derive(Clone, Copy)]
pub struct CubicSpline;

impl SimdKernel for CubicSpline {
    // 2 (1-q)^3 - 8 (1/2-q)^3, the second term only where it is positive, is both branches at once.
    #[inline(always)]
    fn shape<S: Simd>(simd: S, q: S::f32s) -> S::f32s {
        let p = one_minus(simd, q);
        let inner = positive(simd, simd.sub_f32s(simd.splat_f32s(0.5), q));
        let outer = scale(simd, 2.0, simd.mul_f32s(square(simd, p), p));
        simd.sub_f32s(outer, scale(simd, 8.0, simd.mul_f32s(square(simd, inner), inner)))
    }

    #[inline(always)]
    fn slope_over_q<S: Simd>(simd: S, q: S::f32s) -> S::f32s {
        let inside = line(simd, 18.0, q, -12.0);
        let outside = over_q(simd, scale(simd, -6.0, square(simd, one_minus(simd, q))), q);
        simd.select_f32s(simd.less_than_f32s(q, simd.splat_f32s(0.5)), inside, outside)
    }
}

/// See [`KernelKind::QuinticSpline`].
#[derive(Clone, Copy)]
pub struct QuinticSpline;

impl QuinticSpline {
    /// `max(end - 3 q, 0)`.
    #[inline(always)]
    fn bracket<S: Simd>(simd: S, q: S::f32s, end: f32) -> S::f32s {
        positive(simd, line(simd, -3.0, q, end))
    }

    #[inline(always)]
    fn fourth<S: Simd>(simd: S, q: S::f32s, end: f32) -> S::f32s {
        square(simd, square(simd, Self::bracket(simd, q, end)))
    }

    #[inline(always)]
    fn fifth<S: Simd>(simd: S, q: S::f32s, end: f32) -> S::f32s {
        simd.mul_f32s(Self::fourth(simd, q, end), Self::bracket(simd, q, end))
    }
}

impl SimdKernel for QuinticSpline {
    #[inline(always)]
    fn shape<S: Simd>(simd: S, q: S::f32s) -> S::f32s {
        let sum = simd.mul_add_f32s(simd.splat_f32s(-6.0), Self::fifth(simd, q, 2.0), Self::fifth(simd, q, 3.0));
        simd.mul_add_f32s(simd.splat_f32s(15.0), Self::fifth(simd, q, 1.0), sum)
    }

    #[inline(always)]
    fn slope_over_q<S: Simd>(simd: S, q: S::f32s) -> S::f32s {
        let s = scale(simd, 3.0, q);
        // Near the centre the three terms cancel: multiplied out, the division is exact.
        let inside =
            scale(simd, 9.0, simd.mul_add_f32s(square(simd, s), line(simd, -50.0, s, 120.0), simd.splat_f32s(-120.0)));
        let sum = simd.mul_add_f32s(
            simd.splat_f32s(30.0),
            Self::fourth(simd, q, 2.0),
            scale(simd, -5.0, Self::fourth(simd, q, 3.0)),
        );
        let outside = over_q(simd, scale(simd, 3.0, sum), q);
        simd.select_f32s(simd.less_than_f32s(s, simd.splat_f32s(1.0)), inside, outside)
    }
}

/// See [`KernelKind::Quadratic`].
#[derive(Clone, Copy)]
pub struct Quadratic;

impl SimdKernel for Quadratic {
    #[inline(always)]
    fn shape<S: Simd>(simd: S, q: S::f32s) -> S::f32s {
        square(simd, one_minus(simd, q))
    }

    #[inline(always)]
    fn slope_over_q<S: Simd>(simd: S, q: S::f32s) -> S::f32s {
        over_q(simd, scale(simd, -2.0, one_minus(simd, q)), q)
    }
}

/// See [`KernelKind::Quartic`].
#[derive(Clone, Copy)]
pub struct Quartic;

impl SimdKernel for Quartic {
    #[inline(always)]
    fn shape<S: Simd>(simd: S, q: S::f32s) -> S::f32s {
        // (1-q)^2 (4 + 8 q - 15 q^2)/6 is the published polynomial, exactly zero at q = 1.
        let inner = simd.mul_add_f32s(q, line(simd, -15.0, q, 8.0), simd.splat_f32s(4.0));
        simd.mul_f32s(square(simd, one_minus(simd, q)), scale(simd, 1.0 / 6.0, inner))
    }

    #[inline(always)]
    fn slope_over_q<S: Simd>(simd: S, q: S::f32s) -> S::f32s {
        simd.mul_f32s(one_minus(simd, q), line(simd, 10.0, q, -9.0))
    }
}

/// See [`KernelKind::Poly6`].
#[derive(Clone, Copy)]
pub struct Poly6;

impl SimdKernel for Poly6 {
    #[inline(always)]
    fn shape<S: Simd>(simd: S, q: S::f32s) -> S::f32s {
        let p = simd.mul_f32s(one_minus(simd, q), line(simd, 1.0, q, 1.0));
        simd.mul_f32s(square(simd, p), p)
    }

    #[inline(always)]
    fn slope_over_q<S: Simd>(simd: S, q: S::f32s) -> S::f32s {
        scale(simd, -6.0, square(simd, simd.mul_f32s(one_minus(simd, q), line(simd, 1.0, q, 1.0))))
    }
}

/// See [`KernelKind::Spiky`].
#[derive(Clone, Copy)]
pub struct Spiky;

impl SimdKernel for Spiky {
    #[inline(always)]
    fn shape<S: Simd>(simd: S, q: S::f32s) -> S::f32s {
        let p = one_minus(simd, q);
        simd.mul_f32s(square(simd, p), p)
    }

    #[inline(always)]
    fn slope_over_q<S: Simd>(simd: S, q: S::f32s) -> S::f32s {
        over_q(simd, scale(simd, -3.0, square(simd, one_minus(simd, q))), q)
    }
}

/// What stands for the slope in viscous forces of [`KernelKind::Viscosity`]: half its Laplacian with the other sign.
#[derive(Clone, Copy)]
pub struct Viscosity;

impl SimdKernel for Viscosity {
    #[inline(always)]
    fn shape<S: Simd>(simd: S, q: S::f32s) -> S::f32s {
        let rest = line(simd, -0.5, q, 1.0);
        let rest = simd.mul_add_f32s(square(simd, q), rest, simd.splat_f32s(-1.0));
        let near = divide(simd, simd.splat_f32s(0.5), simd.max_f32s(q, simd.splat_f32s(TINY)));
        simd.add_f32s(rest, near)
    }

    #[inline(always)]
    fn slope_over_q<S: Simd>(simd: S, q: S::f32s) -> S::f32s {
        scale(simd, -3.0, one_minus(simd, q))
    }
}

/// See [`KernelKind::Gaussian`].
#[derive(Clone, Copy)]
pub struct Gaussian;

impl Gaussian {
    /// `exp(-9 q^2)` as the eighth power of a Taylor polynomial of `exp(-9 q^2 / 8)`, to 4e-7 of one.
    #[inline(always)]
    fn exponential<S: Simd>(simd: S, q: S::f32s) -> S::f32s {
        let x = scale(simd, -9.0 / 8.0, square(simd, q));
        let mut sum = simd.splat_f32s(1.0 / 362_880.0);
        for factor in [40_320.0, 5_040.0, 720.0, 120.0, 24.0, 6.0, 2.0, 1.0, 1.0] {
            sum = simd.mul_add_f32s(sum, x, simd.splat_f32s(1.0 / factor));
        }
        square(simd, square(simd, square(simd, sum)))
    }
}

impl SimdKernel for Gaussian {
    #[inline(always)]
    fn shape<S: Simd>(simd: S, q: S::f32s) -> S::f32s {
        positive(simd, simd.sub_f32s(Self::exponential(simd, q), simd.splat_f32s(1.234_098e-4)))
    }

    #[inline(always)]
    fn slope_over_q<S: Simd>(simd: S, q: S::f32s) -> S::f32s {
        let slope = scale(simd, -18.0, Self::exponential(simd, q));
        // The cut Gaussian's slope jumps to zero at the support.
        simd.select_f32s(simd.less_than_f32s(q, simd.splat_f32s(1.0)), slope, simd.splat_f32s(0.0))
    }
}

/// What is done with a kernel chosen at run time.
pub trait WithKernel {
    /// Result.
    type Output;
    /// Does it.
    fn with<K: SimdKernel>(self, kernel: K) -> Self::Output;
}

/// Calls `task` with the kernel's type.
pub fn dispatch<T: WithKernel>(kind: KernelKind, task: T) -> T::Output {
    match kind {
        KernelKind::Gaussian => task.with(Gaussian),
        KernelKind::CubicSpline => task.with(CubicSpline),
        KernelKind::QuinticSpline => task.with(QuinticSpline),
        KernelKind::Quadratic => task.with(Quadratic),
        KernelKind::Quartic => task.with(Quartic),
        KernelKind::WendlandNotch => task.with(WendlandNotch),
        KernelKind::Poly6 => task.with(Poly6),
        KernelKind::Spiky => task.with(Spiky),
        // The planner refuses the viscosity kernel here: it has no usable value.
        KernelKind::WendlandC2 | KernelKind::Viscosity => task.with(WendlandC2),
    }
}

/// The same for a task of viscous forces, which are what the viscosity kernel is for.
pub fn dispatch_viscous<T: WithKernel>(kind: KernelKind, task: T) -> T::Output {
    match kind {
        KernelKind::Viscosity => task.with(Viscosity),
        other => dispatch(other, task),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use freshet_core::kernel::Kernel;

    struct Compare(KernelKind);

    impl WithKernel for Compare {
        type Output = ();
        fn with<K: SimdKernel>(self, _: K) {
            let arch = pulp::Arch::new();
            let exact = Kernel::new(self.0, 1.0).unwrap();
            let norm = self.0.normalisation();
            let (peak, steepest) = (exact.value(0.0).abs(), exact.derivative(0.3).abs());
            for step in 0..=1000 {
                let q = step as f32 / 1000.0;
                let [value, slope] = arch.dispatch(Lane::<K>(q, std::marker::PhantomData));
                let (value, slope) = (f64::from(value) * norm, f64::from(slope * q) * norm);
                let r = f64::from(q);
                assert!((value - exact.value(r)).abs() < 2e-6 * peak, "{:?} f({q}) = {value}", self.0);
                let expected = if q == 0.0 { 0.0 } else { exact.derivative(r) };
                assert!((slope - expected).abs() < 1e-5 * steepest, "{:?} f'({q}) = {slope}, not {expected}", self.0);
            }
        }
    }

    struct Lane<K>(f32, std::marker::PhantomData<K>);

    impl<K: SimdKernel> pulp::WithSimd for Lane<K> {
        type Output = [f32; 2];
        fn with_simd<S: Simd>(self, simd: S) -> [f32; 2] {
            let q = simd.splat_f32s(self.0);
            let lanes = S::F32_LANES as f32;
            [K::shape(simd, q), K::slope_over_q(simd, q)].map(|value| simd.reduce_sum_f32s(value) / lanes)
        }
    }

    #[test]
    fn lanes_agree_with_the_reference() {
        for kind in KernelKind::WITH_GRADIENT {
            dispatch(kind, Compare(kind));
        }
    }

    #[test]
    fn viscous_lanes_agree_with_the_reference() {
        let (kind, arch) = (KernelKind::Viscosity, pulp::Arch::new());
        let exact = Kernel::new(kind, 1.0).unwrap();
        let norm = kind.normalisation();
        for step in 1..=1000 {
            let q = step as f32 / 1000.0;
            let [value, slope] = arch.dispatch(Lane::<Viscosity>(q, std::marker::PhantomData));
            let (expected, r) = (exact.viscous_over_r(f64::from(q)) / norm, f64::from(q));
            assert!((f64::from(slope) - expected).abs() < 1e-6, "{q}: {slope}, not {expected}");
            let expected = exact.value(r) / norm;
            assert!((f64::from(value) - expected).abs() < 1e-6 * expected.max(1.0), "{q}: {value}, not {expected}");
        }
    }
}
