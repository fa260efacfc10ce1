//! A viscous flow between plates that it sticks to, from rest.

use freshet_core::field::Field;
use glam::DVec3;

use super::{Benchmark, Measured};
use crate::commands::pareto::trial::{Watched, watch};
use crate::reference::poiseuille;
use crate::scenes::channel::{Drive, GAP, SPEED, kinematic_viscosity, wide_scene};

/// Under a force.
pub const DRIVEN: Benchmark = Benchmark {
    name: "channel",
    title: "viscous channel",
    about: "flow between plates under a force at Re 10, from rest: velocities of all particles at four times against the series of Morris et al. 1997, L2 norm",
    parts: &[],
    simulate: |job| watch(job, &wide_scene(Drive::Force, job.across), follow),
};

/// Times at which velocities are compared, `nu t / L^2`.
const TIMES: [f64; 4] = [0.045, 0.1125, 0.225, 0.45];
/// Longest tick, s.
const TICK: f64 = 0.05;

fn follow(run: &mut Watched) -> Measured {
    let (mut off, mut whole) = (0.0, 0.0);
    for time in TIMES {
        let end = time * GAP * GAP / kinematic_viscosity();
        let ticks = ((end - run.time()) / TICK).ceil();
        let duration = (end - run.time()) / ticks;
        for _ in 0..ticks as u32 {
            run.tick(duration)?;
        }
        for (position, velocity) in run.positions()?.iter().zip(run.vectors(Field::Velocity)?) {
            let wanted = poiseuille::velocity(f64::from(position.y) / GAP, time);
            off += (velocity.as_dvec3() / SPEED).distance_squared(DVec3::X * wanted);
            whole += wanted * wanted;
        }
    }
    Ok(vec![f64::sqrt(off / whole)])
}
