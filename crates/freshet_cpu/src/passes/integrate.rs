//! Stage `integrate`: semi-implicit Euler, `v += a dt`, `x += v dt`; lifetimes run down. What leaves a period through one end
//! comes back through the other.

use freshet_core::periodic::Periodic;

use crate::particles::Particles;
use crate::workers::{Chunk, Workers, split};

/// Moves all particles over `dt` seconds.
pub fn integrate(
    workers: &Workers,
    chunks: &[Chunk],
    particles: &mut Particles,
    acceleration: &[Vec<f32>; 3],
    periodic: &Periodic,
    lifetimes: bool,
    dt: f32,
) {
    let mut tasks = Vec::new();
    let axes = acceleration.iter().zip(particles.position.iter_mut().zip(&mut particles.velocity));
    for (axis, (accelerations, (positions, velocities))) in axes.enumerate() {
        let parts = split(positions, chunks).into_iter().zip(split(velocities, chunks));
        for (chunk, (position, velocity)) in chunks.iter().zip(parts) {
            tasks.push((axis, &accelerations[chunk.particles.clone()], position, velocity));
        }
    }
    workers.map(tasks, |(axis, acceleration, position, velocity)| {
        for ((a, x), v) in acceleration.iter().zip(&mut *position).zip(velocity) {
            *v += a * dt;
            *x += *v * dt;
        }
        if periodic.along(axis).is_some() {
            for x in position {
                *x = periodic.wrap_along(axis, *x);
            }
        }
    });
    if lifetimes {
        for life in &mut particles.life {
            *life -= dt;
        }
    }
}
