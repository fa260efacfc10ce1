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
    // All axes of a chunk together: the thread that computed its accelerations most likely still holds them.
    let mut tasks: Vec<_> = chunks.iter().map(|chunk| (chunk, Vec::with_capacity(3))).collect();
    for (positions, velocities) in particles.position.iter_mut().zip(&mut particles.velocity) {
        let parts = split(positions, chunks).into_iter().zip(split(velocities, chunks));
        for ((_, axes), part) in tasks.iter_mut().zip(parts) {
            axes.push(part);
        }
    }
    workers.map(tasks, |(chunk, axes)| {
        for (axis, (position, velocity)) in axes.into_iter().enumerate() {
            let acceleration = &acceleration[axis][chunk.particles.clone()];
            for ((a, x), v) in acceleration.iter().zip(&mut *position).zip(velocity) {
                *v += a * dt;
                *x += *v * dt;
            }
            if periodic.along(axis).is_some() {
                for x in position {
                    *x = periodic.wrap_along(axis, *x);
                }
            }
        }
    });
    if lifetimes {
        for life in &mut particles.life {
            *life -= dt;
        }
    }
}
