//! A column of water at rest: pressure, and what still moves.

use freshet_core::field::Field;
use glam::Vec3;

use super::{Benchmark, Measured};
use crate::commands::pareto::trial::{Watched, watch};
use crate::measure::column::PressureProfile;
use crate::measure::statistics::mean;
use crate::reference::hydrostatics;
use crate::scenes::GRAVITY;
use crate::scenes::column::{BASE, DEPTH, walled};

/// Half a metre of water.
pub const AT_REST: Benchmark = Benchmark {
    name: "column",
    title: "column at rest",
    about: "water at rest, 0.5 m deep, for 3 s: pressure against depth over rho g D (root mean square over bins of a support radius) and mean speed over \
            sqrt(g D), both in the last second, and the largest mean compression, root of the sum of their squares; exact",
    parts: &["pressure", "speed", "compression"],
    simulate: |job| {
        let scene = walled(BASE as f32, DEPTH, (DEPTH / f64::from(job.across)) as f32);
        watch(job, &scene, follow)
    },
};

/// Time to simulate, s.
const END: f64 = 3.0;
/// The last part of it, which is measured, s.
const LATE: f64 = 1.0;
/// Duration of a tick, s.
const TICK: f64 = 1.0 / 60.0;

fn follow(run: &mut Watched) -> Measured {
    run.within(Vec3::new(-BASE as f32 / 2.0, 0.0, -BASE as f32 / 2.0), Vec3::splat(BASE as f32 / 2.0));
    run.keeps_energy();
    let support = f64::from(run.parameters().support_radius);
    let mut profile = PressureProfile::new(DEPTH, support);
    let mut speeds = Vec::new();
    for tick in 1..=(END / TICK).round() as u32 {
        run.tick(TICK)?;
        if f64::from(tick) * TICK > END - LATE {
            let (positions, pressures) = (run.positions()?, run.scalars(Field::Pressure)?);
            positions.iter().zip(&pressures).for_each(|(x, &pressure)| profile.add(x.y, pressure));
            speeds.extend(run.scalars(Field::Speed)?.into_iter().map(f64::from));
        }
    }
    let reference = |height: f64| hydrostatics::pressure(1000.0, GRAVITY, DEPTH - height);
    let pressure = profile.deviation(reference).unwrap_or(f64::NAN) / reference(0.0);
    let speed = mean(speeds).unwrap_or(f64::NAN) / (GRAVITY * DEPTH).sqrt();
    Ok(vec![pressure, speed, run.compression()])
}
