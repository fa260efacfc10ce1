//! Smoothing kernels in three dimensions, all on one support radius, and what a cubic lattice makes of them.
//!
//! Every kernel is exactly zero at and beyond its support radius `H`. A kernel which the literature gives on a support of
//! `2 h` or `3 h` is rescaled to `H`, so that kernels can be exchanged without moving the set of neighbours. Below,
//! `q = r / H`, and `W = A / H^3 f(q)` with `A` such that `4 pi A` times the integral of `q^2 f(q)` over 0..1 is one.
//!
//! Arithmetic is in `f64`: this module is the reference that the single-precision CPU and GPU passes are held to.

use std::f64::consts::PI;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::error::{InvalidInput, check_range};

/// Smallest support radius a kernel accepts, in metres.
pub const MIN_SUPPORT_RADIUS: f32 = 1.0e-5;
/// Largest support radius a kernel accepts, in metres.
pub const MAX_SUPPORT_RADIUS: f32 = 1.0e5;

/// Lattice sums treat a lattice finer than this share of `H` as if it were this fine: they are 1 to 1e-5 by then.
const FINEST_LATTICE: f64 = 1.0 / 64.0;

/// erf(3), in the normalisation of the cut Gaussian.
const ERF_3: f64 = 0.999_977_909_503_001_4;

/// The smoothing kernels.
///
/// The source and formula stand at each variant; `q = r / H`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum KernelKind {
    /// Gaussian (Gingold & Monaghan 1977), cut at the support and shifted so that it ends at zero:
    /// `W = 4.8632 / H^3 (exp(-9 q^2) - exp(-9))`.
    ///
    /// The width is `H / 3`. K 4.27 cuts it at `2 h` and keeps the constant of the infinite one: that integrates to 0.954
    /// and jumps. The gradient of this one still jumps at `H`, by 0.09 % of its largest value.
    Gaussian,
    /// Cubic B-spline (Monaghan & Lattanzio 1985; P 2.43 with its misprints mended; E §1):
    /// `W = 8 / (pi H^3) (1 - 6 q^2 + 6 q^3)` for `q < 1/2`, `8 / (pi H^3) 2 (1 - q)^3` beyond.
    CubicSpline,
    /// Quintic B-spline (Morris, Fox & Zhu 1997; K 4.29 with the constant mended), `s = 3 q`:
    /// `W = 27 / (120 pi H^3) ((3 - s)^5 - 6 (2 - s)^5 + 15 (1 - s)^5)`, each bracket only where it is positive.
    QuinticSpline,
    /// Quadratic (Johnson, Stryk & Beissel 1996; K 4.30 with the constant mended): `W = 15 / (2 pi H^3) (1 - q)^2`.
    ///
    /// Made for compression: its gradient grows towards the centre and has no limit there, as the spiky kernel's.
    Quadratic,
    /// Quartic (Liu, Liu & Lam 2003; K §4.3.1.6, the "quadric" of E):
    /// `W = 315 / (26 pi H^3) (2/3 - 9/2 q^2 + 19/3 q^3 - 5/2 q^4)`.
    ///
    /// `dW/dr` is proportional to `-q (1 - q) (9 - 10 q)`: in the outermost tenth of the support the gradient has the
    /// other sign, and W is below zero there, by up to 0.25 % of W(0).
    Quartic,
    /// Wendland C2 (Wendland 1995; K 4.31 with the formula mended; Dehnen & Aly 2012 for its use in SPH):
    /// `W = 21 / (2 pi H^3) (1 - q)^4 (4 q + 1)`. No pairing of particles, hence the default.
    #[default]
    WendlandC2,
    /// Wendland C6 without the wavelength of a lattice: `(1 + H^2 lap/k^2)^2` of it, with `k^2 = 188.5`, times the same constant,
    /// `W = 1365 / (64 pi H^3) (1 - q)^4 P(q)`, positive and falling throughout. Meant for `H = 2.3 d`, 51 neighbours.
    ///
    /// Every kernel of compact support sees whether particles sit in rows: sums over them differ from lattice to lattice, and particles under pressure go where
    /// sums are least and hold on to it, as a soft solid ([`Kernel::lattice_shear`]). How much follows from its Fourier transform at the
    /// reciprocal lattice. This one is zero there, with its slope, at `kH = 13.73`, which is 0.95 of the shortest reciprocal vector of the cubic lattice
    /// at `H = 2.3 d`, and positive else, so that particles do not pair: sums over the simple, body-centred and face-centred cubic lattices agree to 0.01 %
    /// (Wendland C2 at 2.3 d: 0.4 %, at 2 d: 0.6 %), and all their shear moduli are below 0.02 of the pressure (0.07; 0.18).
    /// Derived here; Wendland 1995 for what it is made from, Dehnen & Aly 2012 for the use of the transform.
    WendlandNotch,
    /// Poly6 (Mueller, Charypar & Gross 2003, eq. 20): `W = 315 / (64 pi H^3) (1 - q^2)^3`.
    ///
    /// Its gradient vanishes at the centre: for densities, not for pressure.
    Poly6,
    /// Spiky (Desbrun & Gascuel 1996; Mueller et al. 2003, eq. 21; P 2.45 with the sign mended): `W = 15 / (pi H^3) (1 - q)^3`.
    ///
    /// Its gradient is largest next to the centre and has no limit there; at `r = 0` it is taken as zero.
    Spiky,
    /// Viscosity kernel (Mueller et al. 2003, eq. 22; P 2.46 with the sign mended), meant for its Laplacian only:
    /// `W = 15 / (2 pi H^3) (-q^3/2 + q^2 + 1/(2 q) - 1)`, with the Laplacian `45 / (pi H^5) (1 - q)`, nowhere negative.
    ///
    /// W is infinite at `r = 0`; the Laplacian integrates to `15 / H^2` over the ball without its centre, not to 0.
    Viscosity,
}

impl KernelKind {
    /// Every kernel, in the order of declaration.
    pub const ALL: [KernelKind; 10] = [
        KernelKind::Gaussian,
        KernelKind::CubicSpline,
        KernelKind::QuinticSpline,
        KernelKind::Quadratic,
        KernelKind::Quartic,
        KernelKind::WendlandC2,
        KernelKind::WendlandNotch,
        KernelKind::Poly6,
        KernelKind::Spiky,
        KernelKind::Viscosity,
    ];

    /// The kernels whose value and gradient may be used: all but [`KernelKind::Viscosity`].
    pub const WITH_GRADIENT: [KernelKind; 9] = [
        KernelKind::Gaussian,
        KernelKind::CubicSpline,
        KernelKind::QuinticSpline,
        KernelKind::Quadratic,
        KernelKind::Quartic,
        KernelKind::WendlandC2,
        KernelKind::WendlandNotch,
        KernelKind::Poly6,
        KernelKind::Spiky,
    ];

    /// The name in `snake_case`, as charts and file names use it.
    pub fn name(self) -> &'static str {
        match self {
            KernelKind::Gaussian => "gaussian",
            KernelKind::CubicSpline => "cubic_spline",
            KernelKind::QuinticSpline => "quintic_spline",
            KernelKind::Quadratic => "quadratic",
            KernelKind::Quartic => "quartic",
            KernelKind::WendlandC2 => "wendland_c2",
            KernelKind::WendlandNotch => "wendland_notch",
            KernelKind::Poly6 => "poly6",
            KernelKind::Spiky => "spiky",
            KernelKind::Viscosity => "viscosity",
        }
    }

    /// The constant `A` of `W = A / H^3 f(q)`.
    pub fn normalisation(self) -> f64 {
        match self {
            // 4 pi times the integral of q^2 (exp(-9 q^2) - exp(-9)): by parts, with the integral of exp(-9 q^2) = sqrt(pi)/6 erf(3).
            KernelKind::Gaussian => {
                let edge = (-9.0_f64).exp();
                let squares = (PI.sqrt() / 6.0 * ERF_3 - edge) / 18.0;
                1.0 / (4.0 * PI * (squares - edge / 3.0))
            }
            KernelKind::CubicSpline => 8.0 / PI,
            KernelKind::QuinticSpline => 27.0 / (120.0 * PI),
            KernelKind::Quadratic | KernelKind::Viscosity => 15.0 / (2.0 * PI),
            KernelKind::Quartic => 315.0 / (26.0 * PI),
            KernelKind::WendlandC2 => 21.0 / (2.0 * PI),
            // That of Wendland C6: a Laplacian integrates to nothing.
            KernelKind::WendlandNotch => 1365.0 / (64.0 * PI),
            KernelKind::Poly6 => 315.0 / (64.0 * PI),
            KernelKind::Spiky => 15.0 / PI,
        }
    }

    /// `f(q)` for `0 <= q < 1`.
    pub fn shape(self, q: f64) -> f64 {
        let p = 1.0 - q;
        match self {
            KernelKind::Gaussian => (-9.0 * q * q).exp() - (-9.0_f64).exp(),
            KernelKind::CubicSpline if q < 0.5 => 1.0 - 6.0 * q * q * p,
            KernelKind::CubicSpline => 2.0 * p * p * p,
            KernelKind::QuinticSpline => {
                let s = 3.0 * q;
                (3.0 - s).powi(5) - 6.0 * (2.0 - s).max(0.0).powi(5) + 15.0 * (1.0 - s).max(0.0).powi(5)
            }
            KernelKind::Quadratic => p * p,
            KernelKind::Quartic => 2.0 / 3.0 + q * q * (-9.0 / 2.0 + q * (19.0 / 3.0 - 5.0 / 2.0 * q)),
            KernelKind::WendlandC2 => p.powi(4) * (4.0 * q + 1.0),
            KernelKind::WendlandNotch => p.powi(4) * polynomial(&NOTCH_SHAPE, q),
            KernelKind::Poly6 => (1.0 - q * q).powi(3),
            KernelKind::Spiky => p * p * p,
            KernelKind::Viscosity => -0.5 * q * q * q + q * q + 0.5 / q - 1.0,
        }
    }

    /// `f'(q)` for `0 <= q < 1`; at 0 the limit from outside.
    fn slope(self, q: f64) -> f64 {
        let p = 1.0 - q;
        match self {
            KernelKind::Quadratic => -2.0 * p,
            KernelKind::Spiky => -3.0 * p * p,
            KernelKind::Viscosity => -1.5 * q * q + 2.0 * q - 0.5 / (q * q),
            _ => q * self.slope_over_q(q),
        }
    }

    /// `f'(q) / q` for `0 <= q < 1`; 0 at the centre where it has no limit.
    fn slope_over_q(self, q: f64) -> f64 {
        let p = 1.0 - q;
        match self {
            KernelKind::Gaussian => -18.0 * (-9.0 * q * q).exp(),
            KernelKind::CubicSpline if q < 0.5 => -12.0 + 18.0 * q,
            KernelKind::CubicSpline => -6.0 * p * p / q,
            KernelKind::QuinticSpline => {
                let s = 3.0 * q;
                if s < 1.0 {
                    // The three brackets multiplied out: their terms without s cancel, which the division needs.
                    9.0 * (-120.0 + s * s * (120.0 - 50.0 * s))
                } else {
                    9.0 * (-5.0 * (3.0 - s).powi(4) + 30.0 * (2.0 - s).max(0.0).powi(4)) / s
                }
            }
            KernelKind::Quartic => -p * (9.0 - 10.0 * q),
            KernelKind::WendlandC2 => -20.0 * p * p * p,
            KernelKind::WendlandNotch => p.powi(3) * polynomial(&NOTCH_SLOPE, q),
            KernelKind::Poly6 => -6.0 * (1.0 - q * q).powi(2),
            KernelKind::Quadratic | KernelKind::Spiky | KernelKind::Viscosity => {
                if q == 0.0 {
                    0.0
                } else {
                    self.slope(q) / q
                }
            }
        }
    }

    /// `f''(q) + 2 f'(q) / q` for `0 <= q < 1`; 0 at the centre where it has no limit.
    fn laplacian_shape(self, q: f64) -> f64 {
        let p = 1.0 - q;
        match self {
            KernelKind::Gaussian => (324.0 * q * q - 54.0) * (-9.0 * q * q).exp(),
            KernelKind::CubicSpline if q < 0.5 => -36.0 + 72.0 * q,
            KernelKind::CubicSpline => 12.0 * p - 12.0 * p * p / q,
            KernelKind::QuinticSpline => {
                let s = 3.0 * q;
                if s < 1.0 {
                    9.0 * (-360.0 + s * s * (600.0 - 300.0 * s))
                } else {
                    let (a, b) = (3.0 - s, (2.0 - s).max(0.0));
                    let second = 20.0 * a.powi(3) - 120.0 * b.powi(3);
                    9.0 * (second + 2.0 * (-5.0 * a.powi(4) + 30.0 * b.powi(4)) / s)
                }
            }
            KernelKind::Quadratic if q == 0.0 => 0.0,
            KernelKind::Quadratic => 2.0 - 4.0 * p / q,
            KernelKind::Quartic => -27.0 + q * (76.0 - 50.0 * q),
            KernelKind::WendlandC2 => -60.0 * p * p * (1.0 - 2.0 * q),
            KernelKind::WendlandNotch => {
                // With f' = q g: f'' + 2 f'/q = 3 g + q g'.
                let slope = polynomial(&NOTCH_SLOPE, q);
                let steeper: f64 =
                    NOTCH_SLOPE.iter().zip(0..).skip(1).map(|(c, n)| f64::from(n) * c * q.powi(n - 1)).sum();
                p * p * (3.0 * (p - q) * slope + q * p * steeper)
            }
            KernelKind::Poly6 => -6.0 * (1.0 - q * q) * (3.0 - 7.0 * q * q),
            KernelKind::Spiky if q == 0.0 => 0.0,
            KernelKind::Spiky => 6.0 * p - 6.0 * p * p / q,
            KernelKind::Viscosity => 6.0 * p,
        }
    }
}

/// `f(q)/(1 - q)^4` of [`KernelKind::WendlandNotch`], lowest power first: with `g = (1 - q)^8 (1 + 8 q + 25 q^2 + 32 q^3)` that of
/// `g + 2 lap g/k^2 + lap lap g/k^4`, `k^2 = 188.5`.
pub const NOTCH_SHAPE: [f64; 8] = [
    0.522_630_849_439_593_6,
    2.090_523_397_758_374_4,
    -2.690_295_435_836_458_4,
    28.714_927_987_954_603,
    -99.334_217_506_631_29,
    144.816_976_127_320_97,
    -103.0,
    32.0,
];

/// `f'(q)/(q (1 - q)^3)` of the same.
pub const NOTCH_SLOPE: [f64; 7] = [
    -15.833_207_860_464_79,
    102.286_556_578_882_57,
    -598.341_365_942_207_3,
    1_518.758_620_689_655_3,
    -1_921.352_785_145_889,
    1_254.0,
    -352.0,
];

/// A polynomial at `q`, its coefficients from the lowest power on.
fn polynomial(coefficients: &[f64], q: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * q + coefficient)
}

/// A kernel on a given support radius: a pair of particles `r` apart weighs [`Kernel::value`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kernel {
    kind: KernelKind,
    support_radius: f32,
    inverse_radius: f64,
    value_scale: f64,
}

impl Kernel {
    /// A kernel on the support radius `support_radius`, in metres.
    ///
    /// # Errors
    /// If the radius is not within [`MIN_SUPPORT_RADIUS`]`..=`[`MAX_SUPPORT_RADIUS`].
    pub fn new(kind: KernelKind, support_radius: f32) -> Result<Self, InvalidInput> {
        check_range("support_radius", support_radius, MIN_SUPPORT_RADIUS, MAX_SUPPORT_RADIUS, "m")?;
        let inverse_radius = 1.0 / f64::from(support_radius);
        let value_scale = kind.normalisation() * inverse_radius.powi(3);
        Ok(Self { kind, support_radius, inverse_radius, value_scale })
    }

    /// Which kernel it is.
    pub fn kind(&self) -> KernelKind {
        self.kind
    }

    /// The support radius `H`, in metres: at and beyond it everything is exactly zero.
    pub fn support_radius(&self) -> f32 {
        self.support_radius
    }

    /// W(r) in 1/m3, for a distance `r >= 0` in metres (of a negative one the size counts).
    ///
    /// Infinite at `r = 0` for [`KernelKind::Viscosity`], which is meant for its Laplacian only.
    pub fn value(&self, r: f64) -> f64 {
        self.inside(r, 0, KernelKind::shape)
    }

    /// dW/dr in 1/m4 for a distance `r >= 0` in metres; at 0 the limit from outside.
    ///
    /// That limit is not zero for [`KernelKind::Quadratic`] and [`KernelKind::Spiky`], and minus infinity for
    /// [`KernelKind::Viscosity`].
    pub fn derivative(&self, r: f64) -> f64 {
        self.inside(r, 1, KernelKind::slope)
    }

    /// (dW/dr)/r in 1/m5 for a distance `r >= 0` in metres, with its limit at `r = 0`.
    ///
    /// [`KernelKind::Quadratic`], [`KernelKind::Spiky`] and [`KernelKind::Viscosity`] have no finite limit; there it is 0 at
    /// `r = 0`, so that two particles on one spot exert no force rather than an undefined one.
    pub fn derivative_over_r(&self, r: f64) -> f64 {
        self.inside(r, 2, KernelKind::slope_over_q)
    }

    /// The three-dimensional Laplacian `W'' + 2 W'/r` in 1/m5 for a distance `r >= 0` in metres.
    ///
    /// Of [`KernelKind::Quadratic`] and [`KernelKind::Spiky`] it grows without bound towards `r = 0` and is taken as 0 there.
    /// Poly6: `-945 / (32 pi H^9) (H^2 - r^2) (3 H^2 - 7 r^2)`, without the leading `-r` that P 2.44 prints.
    pub fn laplacian(&self, r: f64) -> f64 {
        self.inside(r, 2, KernelKind::laplacian_shape)
    }

    /// What stands for (dW/dr)/r in Morris' viscosity, in 1/m5 for a distance `r >= 0` in metres.
    ///
    /// Of [`KernelKind::Viscosity`] half its Laplacian with the other sign, `-45 / (2 pi H^5) (1 - q)`: Mueller, Charypar & Gross 2003, eq. 14, sum velocities
    /// by the Laplacian, Morris, Fox & Zhu 1997, eq. 22, by twice the slope over the distance, and with this both are one. Of any other kernel
    /// [`derivative_over_r`](Self::derivative_over_r).
    pub fn viscous_over_r(&self, r: f64) -> f64 {
        match self.kind {
            KernelKind::Viscosity => -0.5 * self.laplacian(r),
            _ => self.derivative_over_r(r),
        }
    }

    /// The gradient of W in 1/m4 with respect to `x_a`, for `x_ab = x_a - x_b` in metres; zero for `x_ab = 0`.
    pub fn gradient(&self, x_ab: Vec3) -> Vec3 {
        let x_ab = x_ab.as_dvec3();
        (self.derivative_over_r(x_ab.length()) * x_ab).as_vec3()
    }

    /// `A / H^(3 + derivatives) f(q)` inside the support and exactly 0 outside; not-a-number stays not-a-number.
    fn inside(&self, r: f64, derivatives: i32, f: impl Fn(KernelKind, f64) -> f64) -> f64 {
        // r is compared with H itself: r / H may round to just below one.
        if r.abs() >= f64::from(self.support_radius) {
            return 0.0;
        }
        let q = (r * self.inverse_radius).abs();
        self.value_scale * self.inverse_radius.powi(derivatives) * f(self.kind, q)
    }

    /// `S = d^3 sum W` over the cubic lattice of spacing `d` metres, the particle itself included; no unit.
    ///
    /// A fluid placed on that lattice with `m = rho0 d^3` sums up to `S rho0`; dividing by S makes a block at rest have its
    /// rest density (METHODS, "Density"; E §7.3 is what happens without). At `H = 2 d`: cubic spline 1.000, Wendland C2
    /// 1.034, poly6 1.010, spiky 1.236; one in the limit of many neighbours.
    ///
    /// Infinite for [`KernelKind::Viscosity`]; not a number unless `spacing` is positive. A lattice finer than `H/64` is
    /// taken as `H/64`.
    pub fn lattice_sum(&self, spacing: f32) -> f64 {
        self.over_lattice(spacing, |r| self.value(r))
    }

    /// `G = -(1/3) d^3 sum r W'(r)` over the cubic lattice of spacing `d` metres; no unit.
    ///
    /// The factor by which the SPH gradient of a linear field, such as hydrostatic pressure, comes out too large or too
    /// small on that lattice: for `f = g . x`, `sum d^3 (f_b - f_a) grad W_ab = G g` by the symmetry of the lattice. One in
    /// the continuum, by parts.
    ///
    /// Not a number unless `spacing` is positive. A lattice finer than `H/64` is taken as `H/64`.
    pub fn lattice_gradient_sum(&self, spacing: f32) -> f64 {
        self.over_lattice(spacing, |r| if r == 0.0 { 0.0 } else { -r * self.derivative(r) / 3.0 })
    }

    /// `-(1/3) d^3 sum F r^4/(r^2 + 0.01 h^2)` over the same lattice, with `h = H/2` and `F` as in [`viscous_over_r`](Self::viscous_over_r); no unit.
    ///
    /// The factor by which Morris' viscosity comes out too small on that lattice: for a velocity `v = k (e . x)^2` along `n`,
    /// with unit vectors `e` and `n` along the lattice, its sum of pairs is this times the exact `2 nu k`.
    pub fn lattice_viscous_sum(&self, spacing: f32) -> f64 {
        let softening = 0.0025 * f64::from(self.support_radius).powi(2);
        let weight = |r: f64| r * r / (r * r + softening);
        self.over_lattice(spacing, |r| -r * r * self.viscous_over_r(r) / 3.0 * weight(r))
    }

    /// The same for planes of particles `d` apart that slide past each other, so that each sees the next at every offset: `-d sum z^2 2 pi int F r^3/(r^2 + 0.01 h^2) dr` over planes
    /// at z = `d`, `2 d`, ... on both sides, the integral from z to H; no unit.
    ///
    /// A smooth kernel has both within a hundredth (Wendland C2 on 2 d: 0.975 and 0.977). [`KernelKind::Viscosity`] ends with a kink, and what it sums depends on where
    /// neighbours are (on 2 d: 0.982 on the lattice at rest, 0.932 where it is sheared).
    pub fn sheared_viscous_sum(&self, spacing: f32) -> f64 {
        const STEPS: u32 = 400;
        let (d, reach) = (f64::from(spacing), f64::from(self.support_radius));
        let softening = 0.0025 * reach * reach;
        let plane = |z: f64| {
            let step = (reach - z) / f64::from(STEPS);
            let at = |r: f64| -self.viscous_over_r(r) * r.powi(3) / (r * r + softening);
            let sum: f64 = (0..STEPS).map(|i| at(z + (f64::from(i) + 0.5) * step)).sum();
            std::f64::consts::TAU * z * z * sum * step
        };
        2.0 * d * (1..).map(|k| f64::from(k) * d).take_while(|z| *z < reach).map(plane).sum::<f64>()
    }

    /// How the cubic lattice of spacing `d` metres resists shear under pressure: its two shear moduli over the pressure, `[C44, C']`; no unit.
    ///
    /// Particles under an even pressure `P` have the energy `-P` times what their volumes grow by, and volumes are inverse density sums. A strain that
    /// keeps the volume changes the sum of a lattice in second order, by `1/2 c gamma^2`, so that the fluid resists it as a solid of modulus `P c / n` would,
    /// with `n = G/S` of [`lattice_gradient_sum`](Self::lattice_gradient_sum) and [`lattice_sum`](Self::lattice_sum) and
    /// `c = (d^3/S) sum ((W'' - W'/r) s^2/r^2 + W' r/3)`: `s = x y` for a shear along the axes (C44), `s = (x^2 - y^2)/2` for a stretch along one and a squeeze along
    /// another (C'). A fluid has none. Where one is negative the lattice gives way by itself.
    ///
    /// A standing wave on deep water along the lattice then swings with `omega^2 = g k (1 + C44 + C')` (derived: twice the mean of both, as the strain is one half of
    /// each): with Wendland C2 at `H = 2 d` they are 0.038 and 0.184 and its period is a tenth too short, at 2.15 d 0.025 and -0.005. Measured beside this in
    /// `freshet_lab pareto`, scene *standing wave*.
    ///
    /// Not numbers unless `spacing` is positive, nor where kernels have no second derivative on the lattice, as the B-splines between their pieces, any better than the mean of
    /// both sides. A lattice finer than `H/64` is taken as `H/64`.
    pub fn lattice_shear(&self, spacing: f32) -> [f64; 2] {
        let slope = |r: f64| self.derivative(r);
        let step = 1e-4 * f64::from(self.support_radius);
        let modulus = |strain: fn([f64; 3]) -> f64| {
            let sum = self.over_places(spacing, |place| {
                let r = place.iter().map(|x| x * x).sum::<f64>().sqrt();
                if r == 0.0 {
                    return 0.0;
                }
                let curvature = (slope(r + step) - slope(r - step)) / (2.0 * step);
                (curvature - slope(r) / r) * (strain(place) / r).powi(2) + slope(r) * r / 3.0
            });
            sum / self.lattice_gradient_sum(spacing)
        };
        [modulus(|[x, y, _]| x * y), modulus(|[x, y, _]| 0.5 * (x * x - y * y))]
    }

    /// `d^3 sum f(r)` over the cubic lattice inside the support.
    fn over_lattice(&self, spacing: f32, f: impl Fn(f64) -> f64) -> f64 {
        self.over_places(spacing, |place| f(place.iter().map(|x| x * x).sum::<f64>().sqrt()))
    }

    /// `d^3 sum f(x)` over the same places, for an `f` that is even in each coordinate.
    fn over_places(&self, spacing: f32, f: impl Fn([f64; 3]) -> f64) -> f64 {
        let Some((d, reach)) = self.lattice_reach(spacing) else { return f64::NAN };
        // One octant with its face, edge and corner points counted as often as they recur.
        let times = |i: i32| if i == 0 { 1.0 } else { 2.0 };
        let mut sum = 0.0;
        for k in 0..=reach {
            for j in 0..=reach {
                for i in 0..=reach {
                    let r = d * f64::from(i * i + j * j + k * k).sqrt();
                    if r < f64::from(self.support_radius) {
                        sum += times(i) * times(j) * times(k) * f([i, j, k].map(|index| d * f64::from(index)));
                    }
                }
            }
        }
        sum * d.powi(3)
    }

    /// The spacing used in lattice sums, in metres, and how many nodes the support reaches along an axis.
    fn lattice_reach(&self, spacing: f32) -> Option<(f64, i32)> {
        let (d, radius) = (f64::from(spacing), f64::from(self.support_radius));
        if d.is_nan() || d <= 0.0 {
            return None;
        }
        let d = d.max(radius * FINEST_LATTICE);
        Some((d, (radius / d).ceil() as i32))
    }
}

/// The support radius in metres that holds `neighbours` particles on average, for particles `spacing` metres apart.
///
/// `H = d cbrt(3 n / (4 pi))`: P 4.1, `h = cbrt(3 V n / (4 pi N))`, with the volume a particle `V / N = d^3`. The particle
/// itself is one of the `neighbours`; `H = 2 d` holds 33.5.
///
/// # Errors
/// If `spacing` is not within 1e-6..=1e4 m, `neighbours` not within 1..=10000, or the radius out of [`Kernel::new`]'s range.
pub fn support_radius_for_neighbours(spacing: f32, neighbours: f32) -> Result<f32, InvalidInput> {
    check_range("spacing", spacing, 1.0e-6, 1.0e4, "m")?;
    check_range("neighbours", neighbours, 1.0, 1.0e4, "particles")?;
    let radius = (f64::from(spacing) * (3.0 * f64::from(neighbours) / (4.0 * PI)).cbrt()) as f32;
    check_range("support_radius", radius, MIN_SUPPORT_RADIUS, MAX_SUPPORT_RADIUS, "m")?;
    Ok(radius)
}

/// How many particles, `spacing` metres apart, a ball of radius `support_radius` metres holds on average, its own included.
///
/// The inverse of [`support_radius_for_neighbours`]: `n = 4 pi / 3 (H / d)^3`.
///
/// # Errors
/// If `spacing` is not within 1e-6..=1e4 m or `support_radius` is out of [`Kernel::new`]'s range.
pub fn neighbours_in_support(spacing: f32, support_radius: f32) -> Result<f32, InvalidInput> {
    check_range("spacing", spacing, 1.0e-6, 1.0e4, "m")?;
    check_range("support_radius", support_radius, MIN_SUPPORT_RADIUS, MAX_SUPPORT_RADIUS, "m")?;
    Ok((4.0 * PI / 3.0 * (f64::from(support_radius) / f64::from(spacing)).powi(3)) as f32)
}
