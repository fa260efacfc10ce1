//! Three layers of quasi-fluid samples (Pirovano 2011, sections 3.5.3 and 3.5.5, after Crespo et al. 2007, in the adapted form of Solenthaler &
//! Pajarola 2008).
//!
//! The samples of a body lie where fluid would in its stead: 0.5, 1.5 and 2.5 spacings inside its surface, each of the volume of a
//! particle. They have a density and a pressure like the fluid's, from all that is around them, and exchange with a particle what two
//! particles exchange:
//!
//! `rho_k = (1/S) (m sum_a W_ak + rho0 sum_j V_j W_jk)`, `a_a = -(1/G) rho0 sum_k V_k (P_a + P_k) F x_ak`, `P = p(rho) / rho^2`.
//!
//! That is the *adapted* form: each counts its neighbours by their volume, as if they were all of its own kind. In it the body's own
//! density appears nowhere, which is rapier's affair, so that bodies of every density hold the same water off. In the plain form
//! a heavy body would be dense water to its neighbours, and push them away.
//!
//! Pirovano's algorithm (section 4.2.4) has the forces on the samples; what moves the body is here the sum of these, and rapier's equations: see METHODS for
//! what is wrong with those printed there (a turning body's `v = omega x b`, the missing `dt`, the missing gyroscopic term).
//!
//! [Walls](crate::wall_method::QuasiFluid) are sampled alike, as far as they are so thick, and the plain form is theirs only.
//!
//! A body is rigid, so that what its own samples add to each other's densities does not change: the plan sums it up once. Samples of other
//! bodies and of walls do not count, as what solids do to each other is rapier's affair.

use glam::Vec3;

use super::volume_weights::sums_around;
use super::wall_layer::WallLayer;
use crate::periodic::Periodic;
use crate::scene::{Body, BodySampling};
use crate::solid::Solid;

/// Depths of the layers, spacings.
pub const DEPTHS: [f32; 3] = [0.5, 1.5, 2.5];

/// How much nearer to the surface than its layer a sample may be, spacings: where a body is thin, samplers have layers in its middle.
const LEAST: f32 = 0.25;

impl Body {
    /// One body of three that are the same but for the depth of their layer, see [`WallLayer::quasi_fluid`]. What of the deeper layers has no room,
    /// as the body is not so thick there, is left out.
    pub fn quasi_fluid(layers: [Body; 3], spacing: f32) -> Self {
        let [first, second, third] = layers;
        let mut body = Body { samples: Vec::new(), ..first.clone() };
        let mut counts = [0; 3];
        for (index, samples) in [first.samples, second.samples, third.samples].into_iter().enumerate() {
            let before = body.samples.len();
            body.samples.extend(samples.into_iter().filter(|&sample| has_room(index, sample, &body.solids, spacing)));
            counts[index] = (body.samples.len() - before) as u32;
        }
        body.sampling = BodySampling::QuasiFluid { layers: counts };
        body
    }
}

/// Whether a sample of a layer is as deep inside as its layer: where a solid is thin, deeper layers have no room.
pub(crate) fn has_room(layer: usize, sample: Vec3, solids: &[Solid], spacing: f32) -> bool {
    let least = (DEPTHS[layer] - LEAST) * spacing;
    layer == 0 || solids.iter().any(|solid| -solid.distance_from(sample).0 >= least)
}

/// Volumes of samples, m3, layer by layer: that of a particle where they lie as far apart as particles do.
pub(crate) fn volumes(samples: &[Vec3], counts: [u32; 3], layer: &WallLayer, periodic: &Periodic) -> Vec<f32> {
    let mut rest = samples;
    let mut volumes = Vec::with_capacity(samples.len());
    for (of_layer, count) in layer.quasi_fluid().iter().zip(counts) {
        let (these, others) = rest.split_at(count as usize);
        volumes.extend(of_layer.volumes_among(these, periodic));
        rest = others;
    }
    volumes
}

/// What samples of a body, or of all walls, itself included, add to the density of each, over the density at rest; no unit.
pub(crate) fn own_densities(samples: &[Vec3], volumes: &[f32], layer: &WallLayer, periodic: &Periodic) -> Vec<f32> {
    let kernel = layer.kernel();
    let images = periodic.sources_and_images(samples, kernel.support_radius());
    let (sources, images): (Vec<usize>, Vec<Vec3>) = images.into_iter().unzip();
    let volume = |index: usize| volumes[index.checked_sub(samples.len()).map_or(index, |image| sources[image])];
    let calibration = kernel.lattice_sum(layer.spacing());
    let sums = sums_around(&[samples, &images].concat(), kernel, |index| f64::from(volume(index)));
    sums.into_iter().take(samples.len()).map(|sum| (sum / calibration) as f32).collect()
}

/// How often [`thin_out`] looks at the walls anew.
const ROUNDS: u32 = 3;

/// Makes samples stand for less where they are denser than fluid at rest, and returns their own densities: where walls meet or overlap, as a floor that goes on
/// under others does. They would have a pressure without any fluid.
pub(crate) fn thin_out(samples: &[Vec3], volumes: &mut [f32], layer: &WallLayer, periodic: &Periodic) -> Vec<f32> {
    for _ in 0..ROUNDS {
        let own = own_densities(samples, volumes, layer, periodic);
        for (volume, own) in volumes.iter_mut().zip(own) {
            *volume /= own.max(1.0);
        }
    }
    own_densities(samples, volumes, layer, periodic)
}
