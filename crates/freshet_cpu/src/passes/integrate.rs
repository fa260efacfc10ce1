//! Stage `integrate`: semi-implicit Euler, `v += a dt`, `x += v dt`; lifetimes run down.

use crate::particles::Particles;
use crate::workers::{Chunk, Workers, split};

/// Moves all particles over `dt` seconds.
pub fn integrate(
    workers: &Workers,
    chunks: &[Chunk],
    particles: &mut Particles,
    acceleration: &[Vec<f32>; 3],
    lifetimes: bool,
    dt: f32,
) {
    let mut tasks = Vec::new();
    let axes = acceleration.iter().zip(particles.position.iter_mut().zip(&mut particles.velocity));
    for (accelerations, (positions, velocities)) in axes {
        let parts = split(positions, chunks).into_iter().zip(split(velocities, chunks));
        for (chunk, (position, velocity)) in chunks.iter().zip(parts) {
            tasks.push((&accelerations[chunk.particles.clone()], position, velocity));
        }
    }
    workers.map(tasks, |(acceleration, position, velocity)| {
        for ((a, x), v) in acceleration.iter().zip(position).zip(velocity) {
            *v += a * dt;
            *x += *v * dt;
        }
    });
    if lifetimes {
        for life in &mut particles.life {
            *life -= dt;
        }
    }
}
