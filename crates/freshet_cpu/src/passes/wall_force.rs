//! Stage `wall_force`: what walls push by forces of their own, see [`wall_method`](freshet_core::wall_method), and the images of the fluid in them. Added to the accelerations before
//! the substep is chosen, which has to bear it.

use freshet_core::kernel::Kernel;
use freshet_core::wall_method::WallMethod;
use glam::Vec3;

use super::acceleration::Maxima;
use crate::near_walls::{Around, NearWalls, each_particle};
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
    /// Of plans with images.
    pub images: Option<Pairs<'a>>,
}

/// What particles and images need of each other.
#[derive(Clone, Copy)]
pub struct Pairs<'a> {
    /// First particle of each cell.
    pub starts: &'a [u32],
    /// kg/m3.
    pub density: &'a [f32],
    /// `p / rho^2`, m5/(kg s2).
    pub pressure_term: &'a [f32],
    /// The kernel.
    pub kernel: Kernel,
    /// `-m/G`.
    pub factor: f64,
    /// `2 alpha c h`.
    pub viscosity: f32,
    /// `2 mu G / G'`, Pa s.
    pub physical: f32,
    /// `0.01 h^2`, m2.
    pub softening: f32,
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
            + match &inputs.images {
                Some(pairs) => of_images(inputs, pairs, i, &around, &mut workspace.near_walls),
                None => push(inputs, &around, inputs.particles.velocity_of(i), &mut workspace.near_walls),
            };
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

/// Acceleration of particle `a` by images, m/s2.
fn of_images(
    inputs: &Inputs<'_>,
    pairs: &Pairs<'_>,
    a: usize,
    around: &Around<'_>,
    memory: &mut Vec<(usize, Vec3)>,
) -> Vec3 {
    let (particles, grid) = (inputs.particles, &inputs.near.plan.grid);
    let (at, velocity) = (particles.position_of(a), particles.velocity_of(a));
    let mut sum = Vec3::ZERO;
    for image in inputs.near.images(around, memory).iter() {
        each_particle(grid, pairs.starts, particles, at + image.way, |b, apart, squared| {
            let x = image.mirrored(apart);
            let apart = velocity - image.velocity(particles.velocity_of(b));
            let [own, other] = [a, b].map(|i| pairs.density[i]);
            let softened = squared + pairs.softening;
            let slope = (pairs.factor * pairs.kernel.derivative_over_r(f64::from(squared).sqrt())) as f32;
            let artificial = pairs.viscosity * apart.dot(x) / (softened * (own + other));
            let strength = pairs.pressure_term[a] + pairs.pressure_term[b] - artificial;
            let exchange = pairs.physical * squared / (softened * own * other);
            sum += slope * (strength * x - exchange * apart);
        });
    }
    sum
}
