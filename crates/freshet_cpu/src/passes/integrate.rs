//! Stage `integrate`: semi-implicit Euler, `v += a dt`, `x += v dt`; lifetimes run down. What leaves a period through one end
//! comes back through the other. Where the plan has XSPH, `v += a dt` comes first, for all particles, and what they move with
//! besides, `x += (v + e) dt`. An incompressible fluid moves by the trapezoidal rule, `x += (v + lead a) dt`.

use freshet_core::periodic::Periodic;

use crate::particles::Particles;
use crate::tasks::Tasks;
use crate::workers::{Chunk, Workers};

/// Changes the velocities over `dt` seconds and leaves particles where they are.
pub fn accelerate(
    workers: &Workers,
    chunks: &[Chunk],
    particles: &mut Particles,
    acceleration: &[Vec<f32>; 3],
    dt: f32,
) {
    let velocities = particles.velocity.each_mut().map(Vec::as_mut_slice);
    workers.share(Tasks::new(chunks, (), velocities), |(chunk, (), velocities)| {
        for (velocity, acceleration) in velocities.into_iter().zip(acceleration) {
            for (v, a) in velocity.iter_mut().zip(&acceleration[chunk.particles.clone()]) {
                *v += a * dt;
            }
        }
    });
}

/// Moves all particles over `dt` seconds, with velocities `lead` seconds after those at the end; with a `drift`, m/s, velocities are those
/// after the substep already.
pub fn integrate(
    workers: &Workers,
    chunks: &[Chunk],
    particles: &mut Particles,
    acceleration: &[Vec<f32>; 3],
    drift: Option<&[Vec<f32>; 3]>,
    periodic: &Periodic,
    lifetimes: bool,
    [dt, lead]: [f32; 2],
) {
    // All axes of a chunk together: the thread that computed its accelerations most likely still holds them.
    let positions = particles.position.each_mut().map(Vec::as_mut_slice);
    let velocities = particles.velocity.each_mut().map(Vec::as_mut_slice);
    let tasks = Tasks::new(chunks, (), (positions, velocities));
    workers.share(tasks, |(chunk, (), (positions, velocities))| {
        for (axis, (position, velocity)) in positions.into_iter().zip(velocities).enumerate() {
            let acceleration = &acceleration[axis][chunk.particles.clone()];
            if let Some(drift) = drift {
                let drift = &drift[axis][chunk.particles.clone()];
                for (((a, e), x), v) in acceleration.iter().zip(drift).zip(&mut *position).zip(velocity) {
                    *x += (*v + e + lead * a) * dt;
                }
            } else {
                for ((a, x), v) in acceleration.iter().zip(&mut *position).zip(velocity) {
                    *v += a * dt;
                    *x += (*v + lead * a) * dt;
                }
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
