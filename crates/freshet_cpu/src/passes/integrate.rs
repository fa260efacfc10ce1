//! Stage `integrate`: semi-implicit Euler, `v += a dt`, `x += v dt`; lifetimes run down. What leaves a period through one end
//! comes back through the other. Where the plan has XSPH, `v += a dt` comes first, for all particles, and what they move with
//! besides, `x += (v + e) dt`. An incompressible fluid moves by the trapezoidal rule, `x += (v + lead a) dt`. Plans with another
//! integrator have [its rules](freshet_core::integrator::past) instead, and particles a past.

use freshet_core::integrator::{Integrator, Past};
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

/// What the particles of a chunk keep, a slice for each number.
type Pasts<'a> = [Option<&'a mut [f32]>; Integrator::MOST_WORDS];

fn pasts(particles: &mut Particles) -> ([&mut [f32]; 3], [&mut [f32]; 3], Pasts<'_>) {
    let kept = particles.history.each_mut().map(|values| Some(&mut **values).filter(|values| !values.is_empty()));
    let positions = particles.position.each_mut().map(Vec::as_mut_slice);
    (positions, particles.velocity.each_mut().map(Vec::as_mut_slice), kept)
}

/// What a particle keeps along an axis; zero for what its integrator does not keep.
fn past(kept: &Pasts<'_>, axis: usize, index: usize) -> Past {
    let word = |word: usize| kept[word].as_ref().map_or(0.0, |values| values[index]);
    Past { step: word(0), first: word(1 + axis), step_before: word(4), second: word(5 + axis) }
}

/// [`accelerate`] by the rules of an integrator.
pub fn accelerate_by(
    integrator: Integrator,
    workers: &Workers,
    chunks: &[Chunk],
    particles: &mut Particles,
    acceleration: &[Vec<f32>; 3],
    dt: f32,
) {
    let (_, velocities, kept) = pasts(particles);
    workers.share(Tasks::new(chunks, (), (velocities, kept)), |(chunk, (), (velocities, kept))| {
        for (axis, velocity) in velocities.into_iter().enumerate() {
            let acceleration = &acceleration[axis][chunk.particles.clone()];
            for (i, (v, &a)) in velocity.iter_mut().zip(acceleration).enumerate() {
                *v = integrator.velocity(*v, a, past(&kept, axis, i), dt);
            }
        }
    });
}

/// [`integrate`] by the rules of an integrator.
pub fn integrate_by(
    integrator: Integrator,
    workers: &Workers,
    chunks: &[Chunk],
    particles: &mut Particles,
    acceleration: &[Vec<f32>; 3],
    drift: Option<&[Vec<f32>; 3]>,
    periodic: &Periodic,
    dt: f32,
) {
    if drift.is_none() {
        accelerate_by(integrator, workers, chunks, particles, acceleration, dt);
    }
    let (positions, velocities, kept) = pasts(particles);
    let tasks = Tasks::new(chunks, (), (positions, velocities, kept));
    workers.share(tasks, |(chunk, (), (positions, velocities, mut kept))| {
        for (axis, (position, velocity)) in positions.into_iter().zip(velocities).enumerate() {
            let acceleration = &acceleration[axis][chunk.particles.clone()];
            for (i, ((x, &mut v), &a)) in position.iter_mut().zip(velocity).zip(acceleration).enumerate() {
                let before = past(&kept, axis, i);
                let motion = integrator.motion(v, a, before, dt);
                let after = integrator.keep(a, motion, before, dt);
                *x += (motion + drift.map_or(0.0, |drift| drift[axis][chunk.particles.start + i])) * dt;
                for (word, value) in [(1 + axis, after.first), (5 + axis, after.second)] {
                    if let Some(values) = &mut kept[word] {
                        values[i] = value;
                    }
                }
            }
            if periodic.along(axis).is_some() {
                for x in position {
                    *x = periodic.wrap_along(axis, *x);
                }
            }
        }
        let [step, _, _, _, step_before, ..] = kept;
        if let (Some(step), Some(step_before)) = (&step, step_before) {
            step_before.copy_from_slice(step);
        }
        if let Some(step) = step {
            step.fill(dt);
        }
    });
}

/// Lifetimes run down.
pub fn age(particles: &mut Particles, dt: f32) {
    for life in &mut particles.life {
        *life -= dt;
    }
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
}
