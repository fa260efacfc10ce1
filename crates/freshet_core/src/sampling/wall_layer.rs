//! Where a single layer of boundary samples has to lie, and what it has to weigh, to stand for a whole wall.
//!
//! A wall enters the density of the fluid, `rho_a = (1/S) (sum_b m W_ab + rho0 sum_k V_k W_ak)`, and its force follows from
//! that density as the fluid's own does, `-(1/G) rho0 sum_k V_k P_a grad W_ak`: the force then is the gradient of an energy, and
//! a fluid at rest stays at rest. (The usual mirrored force, `2 P_a`, is not: with it a column of 2,000 particles never came
//! to rest, its particles went on at 0.2 m/s.) The price is that a layer half a spacing behind the face, weighted for the
//! right density (Akinci et al. 2012), pushes half as hard as the fluid it replaces, and the first layer of fluid sinks in.
//!
//! Two conditions on the first layer of fluid, `d/2` in front of the face, decide both unknowns. With `A(z)` the sum of W over
//! a plane of samples at distance z, averaged along the plane, as fluid in motion sees it:
//!
//! - its density is that at rest: `V A(z) = d^3 sum_k A(k d)`;
//! - under even pressure the wall balances the fluid above: `V A'(z) = 2 d^3 sum_k A'(k d)`; twice, as a pair of fluid particles
//!   has two pressures and a wall none.
//!
//! Their ratio gives the distance z, hence the depth `z - d/2` of the layer behind the face (0.92 d for Wendland C2 at H = 2d),
//! and then the weight.

use std::f64::consts::PI;

use glam::Vec3;

use super::boundary::{sample_box_surface, sample_container, sample_plane, sample_sphere_surface};
use super::quasi_fluid::DEPTHS;
use super::volume_weights::volume_weights;
use crate::error::InvalidInput;
use crate::kernel::Kernel;
use crate::periodic::Periodic;
use crate::wall_method::WallMethod;

/// Depth and weight of boundary samples for a kernel and a spacing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallLayer {
    kernel: Kernel,
    spacing: f32,
    /// How far behind the visible surface the samples lie, m.
    pub depth: f32,
    /// Gamma of the volume weights `V_b = gamma / sum_k W_bk`; no unit.
    pub gamma: f32,
    /// Where a solid is thinner than twice the depth, the depth over half of its thickness.
    most: f32,
}

impl WallLayer {
    /// Solves the two conditions of the module's text for fluid `spacing` metres apart.
    pub fn new(kernel: &Kernel, spacing: f32) -> Self {
        Self::of_terms(kernel, kernel, spacing)
    }

    /// Largest gamma of [kernels of terms](Self::of_terms): what has more lies where values are nearly zero, so that a particle a little nearer to it is pressed by a multiple.
    pub const MOST_GAMMA: f32 = 100.0;

    /// The same for a fluid with a kernel of its own for [pressure forces](crate::scene::Settings::pressure_kernel), on the same support: values are those of `kernel`, slopes those of `pressure`.
    ///
    /// Where `pressure` falls much faster towards its end than `kernel`, no layer meets both conditions: the one found then lies at the end of the support with a gamma
    /// above [`MOST_GAMMA`](Self::MOST_GAMMA), and plans refuse it.
    pub fn of_terms(kernel: &Kernel, pressure: &Kernel, spacing: f32) -> Self {
        let (d, reach) = (f64::from(spacing), f64::from(kernel.support_radius()));
        let planes = || (1..).map(|k| k as f64 * d).take_while(|z| *z < reach);
        let value: f64 = planes().map(|z| plane_sum(kernel, z)).sum();
        let slope: f64 = planes().map(|z| plane_slope(pressure, z)).sum();
        // -A'/A grows from the first plane, where the condition asks for twice the slope, to the end of the support.
        let (mut near, mut far) = (d.min(reach), reach);
        for _ in 0..60 {
            let z = 0.5 * (near + far);
            if plane_slope(pressure, z) * value > 2.0 * slope * plane_sum(kernel, z) { near = z } else { far = z }
        }
        let z = near;
        let volume_per_area = value / plane_sum(kernel, z).max(f64::MIN_POSITIVE);
        // A sample of a square lattice stands for d^2 of the plane; A is a sum per area times d^2, so d^3 cancels to V.
        let volume = d.powi(3) * volume_per_area;
        Self {
            kernel: *kernel,
            spacing,
            depth: (z - 0.5 * d) as f32,
            gamma: (volume * own_sum(kernel, d)) as f32,
            most: 0.5,
        }
    }

    /// What a viscosity with a [kernel of its own](crate::scene::Settings::viscosity_kernel) has to be multiplied with at the layer's samples, so that a sheared fluid
    /// hands the wall as much momentum as it hands on inside; no unit.
    ///
    /// In a fluid of planes of particles `k d` apart, k pairs of planes lie across any surface between two of them at each distance `k d`: they exchange
    /// `sum k E(k d)`, with E the exchange of a pair of planes. Next to the wall the planes at `d/2, 3d/2, ...` exchange with the layer alone. Twice the one over the other,
    /// as walls act with half the viscosity of a pair. For the kernel of pressure, where planes two spacings apart feel nothing of each other, this is one
    /// by the layer's own condition on slopes.
    pub fn viscous_share(&self, viscosity: &Kernel) -> f64 {
        let (d, reach) = (f64::from(self.spacing), f64::from(viscosity.support_radius()));
        let up_to_reach = |offset: f64| {
            (1..).map(move |k| (f64::from(k), f64::from(k) * d + offset)).take_while(move |(_, z)| *z < reach)
        };
        let fluid: f64 = up_to_reach(0.0).map(|(k, z)| k * plane_exchange(viscosity, z)).sum();
        let layer: f64 = up_to_reach(f64::from(self.depth) - 0.5 * d).map(|(_, z)| plane_exchange(viscosity, z)).sum();
        let volume_per_area = f64::from(self.gamma) / (own_sum(&self.kernel, d) * d.powi(3));
        2.0 * fluid / (volume_per_area * layer)
    }

    /// The [three layers](super::quasi_fluid) of samples each of which stands for one layer of particles.
    pub fn quasi_fluid(&self) -> [Self; 3] {
        let d = f64::from(self.spacing);
        let gamma = (d.powi(3) * own_sum(&self.kernel, d)) as f32;
        DEPTHS.map(|depth| Self { depth: depth * self.spacing, gamma, most: 0.95, ..*self })
    }

    /// The layer of samples by which a [method](crate::wall_method) pushes.
    pub fn of_method(&self, method: WallMethod) -> Self {
        Self { depth: method.depth(&self.kernel, self.spacing).unwrap_or(self.depth), ..*self }
    }

    /// How deep the layer lies in a solid in which a ball of `largest_ball` metres fits, m.
    pub(super) fn depth_in(&self, largest_ball: f64) -> f64 {
        f64::from(self.depth).min(f64::from(self.most) * largest_ball)
    }

    /// The kernel it is for.
    pub fn kernel(&self) -> &Kernel {
        &self.kernel
    }

    /// The spacing of the fluid, m.
    pub fn spacing(&self) -> f32 {
        self.spacing
    }

    /// Volume weights of the samples of one boundary, m3.
    pub fn volumes(&self, samples: &[Vec3]) -> Vec<f32> {
        volume_weights(samples, &self.kernel, f64::from(self.gamma))
    }

    /// The same in a domain that repeats itself, where samples near its ends have neighbours beyond them.
    pub fn volumes_among(&self, samples: &[Vec3], periodic: &Periodic) -> Vec<f32> {
        let images = periodic.images(samples, self.kernel.support_radius());
        let mut volumes = self.volumes(&[samples, &images].concat());
        volumes.truncate(samples.len());
        volumes
    }

    /// Samples of a box-shaped tank with the fluid inside; see [`sample_container`].
    pub fn container(&self, half_extents: Vec3, open: [bool; 6]) -> Result<Vec<Vec3>, InvalidInput> {
        sample_container(half_extents, open, self.spacing)?;
        // A channel ends where it is said to, so that a next one, or its own image, goes on without a seam.
        let beyond = [0, 2, 4].map(|face| if open[face] && open[face + 1] { 0.0 } else { self.beyond() });
        sample_container(half_extents + Vec3::from(beyond), open, self.spacing)
    }

    /// Samples of a box-shaped body with the fluid outside; see [`sample_box_surface`].
    ///
    /// In a body thinner than twice the depth they lie in its middle.
    pub fn box_surface(&self, half_extents: Vec3) -> Result<Vec<Vec3>, InvalidInput> {
        let thinnest = Vec3::splat(0.5 * self.spacing);
        sample_box_surface(half_extents, self.spacing)?;
        sample_box_surface((half_extents - self.beyond()).max(thinnest), self.spacing)
    }

    /// Samples of a ball with the fluid outside: as many as its visible surface has cells of `d^2`, at the depth of the layer.
    ///
    /// In a ball smaller than the depth they lie half way to its centre.
    pub fn sphere_surface(&self, radius: f32) -> Result<Vec<Vec3>, InvalidInput> {
        sample_sphere_surface(radius, self.spacing)?;
        let layer = (radius - self.depth).max((1.0 - self.most) * radius);
        // The sampler puts its layer half of its own spacing inside.
        let spacing = self.spacing * layer / radius;
        sample_sphere_surface(layer + 0.5 * spacing, spacing)
    }

    /// Samples of a rectangle with the fluid on the side of its normal; see [`sample_plane`].
    pub fn plane(&self, normal: Vec3, half_extent_u: f32, half_extent_v: f32) -> Result<Vec<Vec3>, InvalidInput> {
        let behind = self.beyond() * normal.normalize_or_zero();
        let samples = sample_plane(normal, half_extent_u, half_extent_v, self.spacing)?;
        Ok(samples.into_iter().map(|sample| sample - behind).collect())
    }

    /// How much deeper than the half spacing of the samplers, m.
    fn beyond(&self) -> f32 {
        self.depth - 0.5 * self.spacing
    }
}

/// `2 pi` times the integral of `W r dr` from z on: the sum of W over a plane at distance z, averaged along the plane, times the
/// area of a sample.
fn plane_sum(kernel: &Kernel, z: f64) -> f64 {
    over_plane(kernel, z, Kernel::value)
}

/// The sum of `F z` over the same plane, F being [`Kernel::viscous_over_r`].
fn plane_exchange(kernel: &Kernel, z: f64) -> f64 {
    z * over_plane(kernel, z, Kernel::viscous_over_r)
}

fn over_plane(kernel: &Kernel, z: f64, of: fn(&Kernel, f64) -> f64) -> f64 {
    const STEPS: u32 = 400;
    let reach = f64::from(kernel.support_radius());
    if z >= reach {
        return 0.0;
    }
    let step = (reach - z) / f64::from(STEPS);
    let sum: f64 = (0..STEPS).map(|i| z + (f64::from(i) + 0.5) * step).map(|r| of(kernel, r) * r).sum();
    2.0 * PI * sum * step
}

/// The derivative of [`plane_sum`] with respect to z.
fn plane_slope(kernel: &Kernel, z: f64) -> f64 {
    -2.0 * PI * z * kernel.value(z)
}

/// `sum_k W_bk` of a sample on a square lattice of spacing d.
fn own_sum(kernel: &Kernel, d: f64) -> f64 {
    let reach = (f64::from(kernel.support_radius()) / d).ceil() as i32;
    let offsets = move || -reach..=reach;
    offsets().flat_map(|i| offsets().map(move |j| d * f64::from(i * i + j * j).sqrt())).map(|r| kernel.value(r)).sum()
}
