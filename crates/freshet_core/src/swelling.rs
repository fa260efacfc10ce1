//! How a body gets to its place in a fluid: it swells.
//!
//! A body that is new, has been put elsewhere or has got another shape may find fluid where it is. Samples that were there at once
//! would double densities, and throw off with hundreds of metres a second what they find. So its samples begin where they push
//! nothing, and go to their places no faster than [`Parameters::push_out_speed`]:
//!
//! `s_k(g) = c_k + g (s_k - c_k)`, with the weight `g^2 V_k`, for a share `g` from 0 to 1,
//!
//! with `c_k` the middle of the solid that the sample is part of. A layer that is shrunk by `g` has `g^2` of its area, so that it weighs
//! at every `g` what a wall's does. A shell narrower than a support radius pushes what is in its middle outwards, too (the density
//! that a shell smaller than a spacing adds is largest there), so that nothing is enclosed. Samples of what has no middle, a sheet,
//! ground or the wall around a room, stay and get heavier.
//!
//! Nothing else is new: the fluid is pushed by the pressures of the samples, equal and opposite as ever, and the body's mass is its own from
//! the start. An incompressible fluid, too, is pushed by what is too dense: of particles that touch a body that swells its
//! [velocities correct](crate::pressure_solver::DivergenceFree::source) in a substep of `dt` seconds up to [`Parameters::push_out_rate`]` dt` of it, what a wall adds
//! that comes with twice the push-out speed, and positions the rest, which gives no impulse. While no sample reaches a particle there is nothing to push, and the body swells as fast as no sample can jump over
//! one: a body that is put into the air is whole within a few substeps.

use glam::Vec3;

use crate::plan::{Parameters, Plan, PlannedBody};
use crate::pressure_solver::DivergenceFree;
use crate::snapshot::{BodyPose, carried_over};
use crate::solid::{Solid, SolidShape};

/// Push-out speed over the expected speed.
const PUSH_OUT: f32 = 0.25;
/// Steps in which the share is looked for that a body keeps.
const STEPS: u32 = 64;

impl Parameters {
    /// How fast the surface of a body that swells goes outwards at most, m/s: a quarter of the expected speed, and so a fortieth of
    /// the speed of sound.
    pub fn push_out_speed(&self) -> f32 {
        PUSH_OUT * self.expected_speed
    }

    /// Up to which rate of a relative density, 1/s, the velocities of an incompressible fluid correct what is too dense beside a body that
    /// swells.
    pub fn push_out_rate(&self) -> f32 {
        2.0 * self.push_out_speed() / self.spacing
    }

    /// What of a relative density too large velocities correct beside a body that swells, beyond the [share](crate::pressure_solver::DivergenceFree::share) that
    /// they correct anywhere, in a substep of `dt` seconds.
    pub fn pushed_out(&self, excess: f32, share: f32, dt: f32) -> f32 {
        let anyway = DivergenceFree::by_velocity(excess, share, self.most_by_velocity(dt));
        (excess.max(0.0).min(self.push_out_rate() * dt) - anyway).max(0.0)
    }

    /// How far samples that reach no particle may go outwards in a substep, m: what they meet they meet a spacing away.
    pub fn swelling_way(&self) -> f32 {
        self.support_radius - self.spacing
    }

    /// Whether a body that went this way, m, and turned by this angle, rad, within no time may find fluid where it is.
    /// `reach` is its [`PlannedBody::reach`].
    pub fn is_put_elsewhere(&self, way: f32, angle: f32, reach: f32) -> bool {
        way + angle * reach > 0.5 * self.spacing
    }
}

impl PlannedBody {
    /// A sample of a body that has swollen to a share, relative to the centre of mass, m.
    pub fn sample(&self, index: usize, swollen: f32) -> Vec3 {
        let (sample, root) = (self.samples[index], self.roots[index]);
        // Exactly where it belongs at the end.
        if swollen < 1.0 { root + swollen * (sample - root) } else { sample }
    }

    /// What samples weigh over their volumes.
    pub fn weight(swollen: f32) -> f32 {
        swollen * swollen
    }

    /// The share after a substep of `dt` seconds, in which its samples reached a particle or not.
    pub fn swell(&self, swollen: f32, is_wet: bool, dt: f32, parameters: &Parameters) -> f32 {
        let way = if is_wet { parameters.push_out_speed() * dt } else { parameters.swelling_way() };
        (swollen + way / self.swelling_reach).min(1.0)
    }

    /// What a body may keep of its size that was `before`: the largest share with all samples as deep inside of what was there as its layer was.
    pub fn kept(&self, before: &PlannedBody, depth: f32) -> f32 {
        if self.at_once || self.has_shape_of(before) {
            return 1.0;
        }
        let was_there = |swollen: f32| {
            (0..self.samples.len()).all(|index| {
                let sample = self.sample(index, swollen);
                before.solids.iter().any(|solid| solid.contains(sample, depth))
            })
        };
        let shares = (1..=STEPS).rev().map(|step| step as f32 / STEPS as f32);
        shares.into_iter().find(|&share| was_there(share)).unwrap_or(0.0)
    }

    /// Whether it has the same samples, seen from any centre of mass.
    fn has_shape_of(&self, other: &PlannedBody) -> bool {
        let Some((&one, &its)) = self.samples.first().zip(other.samples.first()) else { return false };
        let is_same = |(a, b): (&Vec3, &Vec3)| (*a - one).abs_diff_eq(*b - its, 1e-4 * self.swelling_reach);
        self.samples.len() == other.samples.len() && self.samples.iter().zip(&other.samples).all(is_same)
    }
}

impl Plan {
    /// Where bodies are and how far they have swollen, from what is known of those of an earlier plan, in that plan's order.
    pub fn poses_from(&self, earlier: &Plan, known: &[Option<BodyPose>]) -> Vec<Option<BodyPose>> {
        let before = self.bodies_of(earlier);
        let depth = self.parameters.boundary_depth;
        let swell = |((body, index), pose): ((&PlannedBody, &Option<usize>), Option<BodyPose>)| {
            let kept = body.kept(&earlier.bodies[(*index)?], depth);
            pose.map(|pose| BodyPose { swollen: pose.swollen * kept, ..pose })
        };
        self.bodies.iter().zip(&before).zip(carried_over(known, &before)).map(swell).collect()
    }
}

/// Where each sample of a body swells from, and how far the farthest is from there, m, at least a spacing.
pub(crate) fn roots(samples: &[Vec3], solids: &[Solid], spacing: f32) -> (Vec<Vec3>, f32) {
    let middles: Vec<Option<Vec3>> = solids.iter().map(middle).collect();
    let root_of = |&sample: &Vec3| {
        let owner = match solids.len() {
            1 => Some(0),
            _ => {
                let depth = |index: &usize| solids[*index].distance_from(sample).0;
                (0..solids.len()).min_by(|a, b| depth(a).total_cmp(&depth(b)))
            }
        };
        owner.and_then(|owner| middles[owner]).unwrap_or(sample)
    };
    let roots: Vec<Vec3> = samples.iter().map(root_of).collect();
    let farthest = samples.iter().zip(&roots).map(|(sample, root)| sample.distance(*root)).fold(spacing, f32::max);
    (roots, farthest)
}

/// The middle of the box around a solid, m; none of what only has a surface.
fn middle(solid: &Solid) -> Option<Vec3> {
    match solid.shape {
        SolidShape::HalfSpace
        | SolidShape::Ground { .. }
        | SolidShape::Around { .. }
        | SolidShape::Skin { .. }
        | SolidShape::Cup { .. } => None,
        _ => Some(solid.center + solid.reach().0),
    }
}
