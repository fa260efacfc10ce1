//! How pressure is found: from density by an equation of state, or as what keeps the fluid from being compressed.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

use crate::error::{InvalidInput, check_range};
use crate::kernel::Kernel;
use crate::position_based::PositionBased;
use crate::pressure_corrected::PressureCorrected;
use crate::pressure_poisson::PressurePoisson;

/// How a fluid's pressure is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum PressureSolver {
    /// From the density, by an [equation of state](crate::equation_of_state): cheap substeps, as short as its sound demands.
    #[default]
    WeaklyCompressible,
    /// As large as it has to be for the fluid not to be compressed: substeps as long as the flow allows, each with some
    /// iterations.
    DivergenceFree(DivergenceFree),
    /// None: particles are moved apart a fixed number of times, and that is part of their motion. Substeps as long as the flow allows.
    PositionBased(PositionBased),
    /// From what is too dense where particles would be without it, a fixed number of times: by velocities, as part of their motion. Substeps as long as the flow allows.
    PressureCorrected(PressureCorrected),
    /// From the same by a Poisson equation, in as many iterations as it takes. Substeps as long as the flow allows.
    PressurePoisson(PressurePoisson),
}

impl PressureSolver {
    /// Name, as in errors and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::WeaklyCompressible => "weakly compressible",
            Self::DivergenceFree(_) => "divergence-free",
            Self::PositionBased(_) => "position-based",
            Self::PressureCorrected(_) => "pressure-corrected",
            Self::PressurePoisson(_) => "pressure Poisson",
        }
    }

    /// Whether particles go where they would be without pressure and are moved apart there, in stage `position_solve`: see [`position_based`](crate::position_based).
    pub fn moves_apart(self) -> bool {
        matches!(self, Self::PositionBased(_) | Self::PressureCorrected(_) | Self::PressurePoisson(_))
    }
}

/// Divergence-free SPH (DFSPH, Bender & Koschier 2015) with positions corrected apart from velocities (Hu & Adams 2007).
///
/// With `P = p / rho^2` the acceleration by pressure is that of every plan,
/// `a_a(P) = -(1/G) [ m sum_b (P_a + P_b) grad W_ab + rho0 sum_k V_k P_a grad W_ak ]`, and a density changes at the rate
/// `D_a(v) = (1/S) [ m sum_b (v_a - v_b) . grad W_ab + rho0 sum_k V_k (v_a - v_k) . grad W_ak ]`. `D` is linear and, but for the factor
/// `G/S`, minus the transpose of `a`: the system `D(a(P))` is symmetric. Its diagonal is `-rho0 K_a`,
/// `K_a = m^2 / (S G rho0) (|g_a|^2 + sum_b |grad W_ab|^2)`, with `g_a = sum_b grad W_ab + rho0/m sum_k V_k grad W_ak`
/// (Bender & Koschier 2015, eqs. 8 and 9, with what walls add). `v_k` of samples is zero for walls, which stay where they are even if
/// their surface moves as a belt does; those of bodies move with `v + omega x r_k`.
///
/// *Bodies* that can move answer to pressures as the fluid does: `v` changes by force over mass and `omega` by inverse inertia times
/// torque in every iteration, so that fluid and bodies are solved for as one (Batty, Bertails & Bridson 2007; Gissler et al. 2019 iterate
/// between two solvers). With `g_aB = sum_k V_k grad W_ak` and `t_aB = sum_k V_k r_k x grad W_ak` over the samples of body `B`, it takes
/// `(rho0/S) (v . g_aB + omega . t_aB)` from `D_a`, and the fluid pushes it by `(m rho0/G) sum_a P_a g_aB` and turns it by the same of
/// `t_aB`. What its answer adds to the system, `C_ab = (m rho0/(S G)) sum_B (g_aB . g_bB/m_B + t_aB . I_B^-1 t_bB)`, is symmetric, has no negative
/// eigenvalue, and joins all who touch a body: with `c_aB` the root of the part of `B` in `C_aa`, no row of its part sums up to more than
/// `c_aB sum_b c_bB` (Cauchy & Schwarz). That, over the largest eigenvalue of the lattice, is added to `K_a`: then Jacobi steps are as stable as
/// without bodies, however light these are (Gershgorin).
///
/// A substep solves the system twice, each time for `P >= 0` with `R <= 0`, and `R = 0` where `P > 0`:
///
/// - *Divergence solve*: velocities. `R_a = s_a + dt/rho0 D_a(v + dt a)`, where `a` holds all that accelerates. `s_a` is what
///   the substep may or must change of the relative density `e_a = rho_a/rho0 - 1`. What is thinner than at rest may be
///   compressed; what is denser is pushed apart by velocities only in so far as the flow is fast, [`share`](Self::share).
/// - *Density solve*: positions. `R_a = E_a + dt^2/rho0 D_a(a(P))`, where `E_a` is the density that the velocities leave too much. It
///   moves particles by `dt^2 a(P)` about bodies that stand still, pushes none of them and changes no velocity: a correction by
///   velocity, `e d/dt`, is kinetic energy that comes from nowhere, and a column corrected by it never comes to rest.
///
/// Then particles move by the trapezoidal rule: `x += dt (v + lead a)`, `v` the velocity after the substep, `a` all that has accelerated it,
/// [`lead`](Self::lead) half of a substep (Adams & Bashforth's second order, where all are as long). The divergence solve makes velocities those of the places where
/// a substep begins. To move by them alone is to move along the tangents of curved paths: neighbours that go around each other get farther
/// from each other, by `v^2 dt^2 / 2r` a substep, and others closer, with nothing in the velocities that would undo it. The density solve
/// puts right what it sees of that, against gravity, and so lifts a column that falls back: energy from nowhere, in proportion to `v^2 dt`.
/// The trapezoid has none of that order. It also damps oscillations of particles about their places, see [`pressure_frequency`]: a fluid
/// without viscosity comes to rest by that.
///
/// Both solves iterate by Jacobi steps of `omega R_a / (dt^2 K_a)` with Nesterov's momentum of at least [`MOMENTUM`](Self::MOMENTUM), from the
/// pressures of the last substep in the one, from none in the other. `omega` follows from [`largest_eigenvalue`]. Divergence
/// iterations end by the mean of `|R|` where it counts (not where `P = 0` and `R < 0`): with `max(R, 0)`, the usual measure, a column
/// with too much pressure is accepted as it is and takes off. The mean is that over all particles, or that over those that touch a body which
/// can move, if it is larger: a light ball in a large tank is seen by few of them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DivergenceFree {
    /// Mean of `max(rho / rho0 - 1, 0)` over the particles, with which positions are left as they are, 1e-6 to 0.1; of `|R|` once they
    /// are corrected.
    pub compression: f32,
    /// Mean relative change of density in a substep at which divergence iterations end, 1e-6 to 0.1. In a flow slower than
    /// [`courant_factor`](crate::scene::Settings::courant_factor) allows it is smaller in proportion, down to
    /// [`LEAST_DIVERGENCE`](Self::LEAST_DIVERGENCE): water at rest is solved as well as it can be.
    pub divergence: f32,
    /// Most iterations of each of the two solves in a substep, 2 to 10,000: the first only finds out what is left to do.
    pub max_iterations: u32,
}

impl Default for DivergenceFree {
    fn default() -> Self {
        Self { compression: 1e-3, divergence: 1e-3, max_iterations: 200 }
    }
}

impl DivergenceFree {
    /// Relaxation times the [largest eigenvalue](largest_eigenvalue) of the lattice, no unit: particles in disorder have
    /// eigenvalues up to a tenth above it, and Jacobi steps with momentum need less than one over the largest.
    pub const RELAXATION: f32 = 0.88;
    /// Share of the last step that is taken again, at least; no unit.
    pub const MOMENTUM: f32 = 0.8;
    /// Smallest divergence that is asked for: what single precision still resolves; no unit.
    pub const LEAST_DIVERGENCE: f32 = 1e-7;
    /// Substep over that of `omega dt = 2`, see [`pressure_frequency`]: with a [lead](Self::lead) particles under pressure stay in place up
    /// to 0.71, by lattice theory, in fact up to 0.7 to 0.75.
    pub const PRESSURE_FACTOR: f32 = 0.6;
    /// Share of a lack of density of up to [`LACK`](Self::LACK) that a substep may make up for in a slow flow; no unit.
    pub const FILLING: f32 = 0.1;
    /// Least diagonal over that of the lattice: what has next to no neighbours is not thrown by them; no unit.
    pub const LEAST_DIAGONAL: f32 = 0.02;
    /// Shortest substep that is solved, s: in less nothing moves that single precision could tell.
    pub const SHORTEST: f32 = 1e-9;
    /// Lack of density of water that is only a little uneven; what lacks more is on a surface or flies. No unit.
    pub const LACK: f32 = 0.01;

    /// Up to which rate velocities correct a density too large, over the expected speed and spacing:
    /// [`most_by_velocity`](crate::plan::Parameters::most_by_velocity). A fifth in a substep of a flow as fast as expected, at a Courant factor of 0.4.
    pub const RATE_BY_VELOCITY: f32 = 0.5;
    /// Farthest that positions are corrected in a substep, spacings. The corrections of all layers of a fluid that is too dense add up, and are right as long as
    /// they are small.
    pub const LONGEST_CORRECTION: f32 = 0.02;

    /// Share of a density too large that velocities correct: the square of the way of the fastest particle, over the longest that
    /// a substep allows. A flow at that limit has kinetic energy of its own beside which that of corrections is nothing.
    pub fn share(way: f32) -> f32 {
        way * way
    }

    /// How far ahead of the end of a substep of `dt` seconds the velocities are that particles move with, s: half of it or of the `last`
    /// one, whichever is shorter, less what velocities [correct](Self::share).
    pub fn lead(way: f32, last: f32, dt: f32) -> f32 {
        0.5 * (1.0 - Self::share(way)) * last.min(dt)
    }

    /// `s` of the divergence solve from `e = rho / rho0 - 1`, for a [share](Self::share) and what velocities correct [at most](Self::by_velocity).
    pub fn source(excess: f32, share: f32, most: f32) -> f32 {
        let filling = share.max(Self::FILLING);
        (excess + Self::LACK).min(0.0)
            + filling * excess.clamp(-Self::LACK, 0.0)
            + Self::by_velocity(excess, share, most)
    }

    /// What velocities correct in a substep of a density too large, no unit: a [share](Self::share) of it or of
    /// [`most`](crate::plan::Parameters::most_by_velocity), if that is less. Positions correct the rest.
    pub fn by_velocity(excess: f32, share: f32, most: f32) -> f32 {
        share * excess.clamp(0.0, most)
    }

    pub(crate) fn validate(&self) -> Result<(), InvalidInput> {
        check_range("compression", self.compression, 1e-6, 0.1, "")?;
        check_range("divergence", self.divergence, 1e-6, 0.1, "")?;
        if !(2..=10_000).contains(&self.max_iterations) {
            return Err(InvalidInput::new("max_iterations", self.max_iterations, "2 to 10000"));
        }
        Ok(())
    }
}

/// Steps of a wave number from zero to the lattice's edge.
const WAVES: i32 = 12;

/// The largest eigenvalue of the system of [`DivergenceFree`] over its diagonal, on a cubic lattice of `spacing` metres; no unit.
///
/// For a plane wave `exp(i k.x)` it is `|sum_b grad W sin(k.x_b)|^2 / sum_b |grad W|^2`. It grows with the number of
/// neighbours: 2.6 for Wendland C2 at H = 2d, 6.2 at 3d.
pub fn largest_eigenvalue(kernel: &Kernel, spacing: f32) -> f64 {
    let neighbours = neighbours(kernel, spacing);
    let diagonal: f64 = neighbours.iter().map(|near| near.slope * near.slope).sum();
    let of_wave = |wave: DVec3| {
        let sum: DVec3 = neighbours.iter().map(|near| near.direction * near.slope * near.phase(wave).sin()).sum();
        sum.length_squared() / diagonal
    };
    waves().map(of_wave).fold(0.0, f64::max)
}

/// `d^6 sum_b |grad W|^2` on a cubic lattice of `spacing` metres, 1/m2: `K` of a particle in it is `rho0 / (S G)` times this.
pub fn lattice_diagonal(kernel: &Kernel, spacing: f32) -> f64 {
    let squares: f64 = neighbours(kernel, spacing).iter().map(|near| near.slope * near.slope).sum();
    f64::from(spacing).powi(6) * squares
}

/// The largest frequency `omega` of particles on a cubic lattice of `spacing` metres under an even pressure `p`, as
/// `omega d / sqrt(p / rho)`; no unit.
///
/// Under pressure every pair pushes, which keeps particles in their places as springs would. Pressures are what a solver finds
/// them to be, but within a substep they are constant, and semi-implicit Euler follows an oscillator up to `omega dt = 2`: beyond
/// it, a column boils at its bottom. With a [`lead`](DivergenceFree::lead) of half a substep the growth `z` of an oscillation in one obeys
/// `z^2 - (2 - 3 mu/2) z + 1 - mu/2 = 0`, `mu = (omega dt)^2`: it is damped by `mu/4` a substep, and grows from `omega dt = sqrt 2` on. The
/// dynamical matrix is `2 (p/rho) d^3 sum_b grad grad W (1 - cos k.x_b)`. With Wendland C2 at H = 2d the limits are
/// `dt sqrt(p/rho) / d = 0.65` and 0.46.
pub fn pressure_frequency(kernel: &Kernel, spacing: f32) -> f64 {
    let neighbours = neighbours(kernel, spacing);
    let d = f64::from(spacing);
    let of_wave = |wave: DVec3| {
        let along = |axis: DVec3| {
            let sum: DVec3 = neighbours.iter().map(|near| near.stiffness(axis) * (1.0 - near.phase(wave).cos())).sum();
            2.0 * d.powi(5) * sum
        };
        let matrix = DMat3::from_cols(along(DVec3::X), along(DVec3::Y), along(DVec3::Z));
        // The largest eigenvalue by magnitude, by squaring: 2^-6 of the logarithm of three is lost at most.
        let mut power = matrix;
        let mut scale = 0.0;
        for _ in 0..6 {
            let size = power.to_cols_array().iter().fold(0.0f64, |size, value| size.max(value.abs()));
            if size == 0.0 {
                return 0.0;
            }
            power *= 1.0 / size;
            power = power * power;
            scale = 2.0 * (scale + size.ln());
        }
        let trace = power.x_axis.x + power.y_axis.y + power.z_axis.z;
        ((scale + trace.max(f64::MIN_POSITIVE).ln()) / 64.0).exp()
    };
    waves().map(of_wave).fold(0.0, f64::max).sqrt()
}

/// A neighbour on the lattice.
struct Near {
    direction: DVec3,
    distance: f64,
    /// `dW/dr` and the second derivative.
    slope: f64,
    curvature: f64,
    spacing: f64,
}

impl Near {
    /// `k.x` for a wave number in units of one over the spacing.
    fn phase(&self, wave: DVec3) -> f64 {
        wave.dot(self.direction) * self.distance / self.spacing
    }

    /// `grad grad W` times an axis.
    fn stiffness(&self, axis: DVec3) -> DVec3 {
        let along = self.direction * self.direction.dot(axis);
        along * self.curvature + (axis - along) * (self.slope / self.distance)
    }
}

fn neighbours(kernel: &Kernel, spacing: f32) -> Vec<Near> {
    let (d, reach) = (f64::from(spacing), f64::from(kernel.support_radius()));
    let nodes = (reach / d).ceil() as i32;
    let row = || -nodes..=nodes;
    let places = row().flat_map(|i| row().flat_map(move |j| row().map(move |k| DVec3::from([i, j, k].map(f64::from)))));
    let step = 1e-5 * reach;
    places
        .map(|place| place * d)
        .filter(|place| place.length() > 0.5 * d && place.length() < reach)
        .map(|place| {
            let distance = place.length();
            let curvature = (kernel.derivative(distance + step) - kernel.derivative(distance - step)) / (2.0 * step);
            let direction = place / distance;
            Near { direction, distance, slope: kernel.derivative(distance), curvature, spacing: d }
        })
        .collect()
}

/// Wave numbers of a cubic lattice up to its edge, in units of one over the spacing; by symmetry x >= y >= z.
fn waves() -> impl Iterator<Item = DVec3> {
    let at = |index: i32| f64::from(index) * PI / f64::from(WAVES);
    (0..=WAVES).flat_map(move |i| (0..=i).flat_map(move |j| (0..=j).map(move |k| DVec3::new(at(i), at(j), at(k)))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::KernelKind;

    /// From a program of its own, in another language, over 25 wave numbers an axis.
    #[test]
    fn eigenvalues_and_frequencies_of_the_lattice() {
        for (kind, support, eigenvalue, limit) in [
            (KernelKind::WendlandC2, 2.0, 2.605, 0.650),
            (KernelKind::WendlandC2, 2.5, 3.842, 1.025),
            (KernelKind::WendlandC2, 3.0, 6.240, 1.285),
            (KernelKind::CubicSpline, 2.0, 2.818, 0.685),
            (KernelKind::CubicSpline, 2.5, 4.381, 1.140),
        ] {
            for spacing in [1.0, 0.02] {
                let kernel = Kernel::new(kind, support * spacing).unwrap();
                let found = largest_eigenvalue(&kernel, spacing);
                assert!((found / eigenvalue - 1.0).abs() < 0.01, "{kind:?} {support}: {found}");
                let found = 2.0 / pressure_frequency(&kernel, spacing);
                assert!((found / limit - 1.0).abs() < 0.02, "{kind:?} {support}: {found}");
            }
        }
    }

    /// `v -= omega^2 x dt`, then `x += (v + lead a) dt`.
    #[test]
    fn oscillations_are_followed_up_to_the_limits_and_damped_by_the_lead() {
        let end = |omega: f32, way: f32| {
            let (mut x, mut v) = (1.0, 0.0);
            for _ in 0..2000 {
                let a = -omega * omega * x;
                v += a;
                x += v + DivergenceFree::lead(way, 1.0, 1.0) * a;
            }
            // What has grown beyond all numbers counts as much.
            f32::min(x * x + v * v / (omega * omega), 1e9)
        };
        assert!((0.5..2.0).contains(&end(0.1, 1.0)) && end(1.98, 1.0) < 1e6 && end(2.02, 1.0) > 1e6, "no lead");
        assert!(end(1.41, 0.0) < 1.0 && end(1.42, 0.0) > 1e6, "a lead of half a substep");
        assert_eq!(DivergenceFree::lead(0.0, 0.1, 0.02), 0.01, "after a longer substep half of this one");
        let damped = (-0.25 * 0.1f32.powi(2) * 2.0 * 2000.0).exp();
        assert!((end(0.1, 0.0) / damped).ln().abs() < 0.2, "{} for {damped}", end(0.1, 0.0));
    }

    #[test]
    fn sources_are_continuous_and_only_a_fast_flow_corrects_by_velocity() {
        for share in [0.0, 0.3, 1.0] {
            for edge in [-DivergenceFree::LACK, 0.0] {
                let [below, above] = [-1e-6, 1e-6].map(|step| DivergenceFree::source(edge + step, share, 0.1));
                assert!((above - below).abs() < 4e-6, "at {edge}");
            }
            assert!((DivergenceFree::source(0.02, share, 0.1) - 0.02 * share).abs() < 1e-7);
        }
        assert!((DivergenceFree::source(-0.5, 1.0, 0.1) + 0.5).abs() < 1e-6);
        assert!(DivergenceFree::source(-0.5, 0.0, 0.1) < -0.48);
        assert_eq!(DivergenceFree::source(3.0, 0.5, 0.1), 0.05);
    }
}
