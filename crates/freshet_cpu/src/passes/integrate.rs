//! Stage `integrate`: semi-implicit Euler, `v += a dt`, `x += v dt`; lifetimes run down. What leaves a period through one end
//! comes back through the other.

use freshet_core::periodic::Periodic;

use crate::particles::Particles;
use crate::tasks::Tasks;
use crate::workers::{Chunk, Workers};

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
    let positions = particles.position.each_mut().map(Vec::as_mut_slice);
    let velocities = particles.velocity.each_mut().map(Vec::as_mut_slice);
    let tasks = Tasks::new(chunks, (), (positions, velocities));
    workers.share(tasks, |(chunk, (), (positions, velocities))| {
        for (axis, (position, velocity)) in positions.into_iter().zip(velocities).enumerate() {
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
