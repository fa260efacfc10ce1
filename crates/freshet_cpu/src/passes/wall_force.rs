//! Stage `wall_force`: what walls push by forces of their own, see [`wall_method`](freshet_core::wall_method). Added to the accelerations before
//! the substep is chosen, which has to bear it.

use freshet_core::wall_method::WallMethod;
use glam::Vec3;

use super::acceleration::Maxima;
use crate::near_walls::{Around, NearWalls};
use crate::particles::Particles;
use crate::workers::Chunk;
use crate::workspace::Workspace;

/// What a chunk needs.
#[derive(Clone, Copy)]
pub struct Inputs<'a> {
    /// The walls.
    pub near: NearWalls<'a>,
    /// Sorted particles.
    pub particles: &'a Particles,
}

/// Adds what walls push to the accelerations of a chunk's particles; returns the largest of those that are pushed.
pub fn wall_force(
    inputs: &Inputs<'_>,
    chunk: &Chunk,
    workspace: &mut Workspace,
    acceleration: [&mut [f32]; 3],
) -> Maxima {
    let [ax, ay, az] = acceleration;
    let mut maxima = Maxima::default();
    for i in chunk.particles.clone() {
        let Some(around) = inputs.near.around(inputs.particles.position_of(i)) else { continue };
        let at = i - chunk.particles.start;
        let pushed = Vec3::new(ax[at], ay[at], az[at])
            + push(inputs, &around, inputs.particles.velocity_of(i), &mut workspace.near_walls);
        (ax[at], ay[at], az[at]) = pushed.into();
        maxima.acceleration_squared = maxima.acceleration_squared.max(pushed.length_squared());
    }
    maxima
}

/// Acceleration by the walls around a particle, m/s2.
fn push(inputs: &Inputs<'_>, around: &Around<'_>, velocity: Vec3, memory: &mut Vec<(usize, Vec3)>) -> Vec3 {
    let parameters = &inputs.near.plan.parameters;
    let (method, strength, spacing) = (parameters.wall_method, parameters.wall_strength, parameters.spacing);
    if let WallMethod::SpringDamper(spring) = method {
        let (planes, count) = inputs.near.planes(around, memory);
        let of_plane = |normal: Vec3, distance: f32| {
            spring.push(strength, 0.5 * spacing - distance, velocity.dot(normal)) * normal
        };
        return planes[..count].iter().map(|plane| of_plane(plane.normal, plane.distance)).sum();
    }
    let kernel = (parameters.kernel, parameters.support_radius);
    let mut sum = Vec3::ZERO;
    around.each(parameters.support_radius, |_, x, squared| {
        sum += method.push_over_r(strength, spacing, kernel, squared.sqrt()) * x;
    });
    sum
}
