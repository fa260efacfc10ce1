//! A standing wave: how fast what gravity pulls level swings through it.

use super::{Benchmark, Measured};
use crate::commands::pareto::trial::{Watched, watch};
use crate::measure::curve::Curve;
use crate::measure::oscillation::Oscillation;
use crate::reference::standing_wave;
use crate::scenes::GRAVITY;
use crate::scenes::wave::{DEPTH, height, scene, velocity, wavenumber};

/// Of one wavelength.
pub const STANDING: Benchmark = Benchmark {
    name: "wave",
    title: "standing wave",
    about: "a wave on water twice as long as it is deep, ka = 0.1: its period against potential flow, from four times that it is level in two swings",
    parts: &[],
    simulate: |job| watch(job, &scene(job.across), follow),
};

/// Periods of potential flow to simulate at most: four crossings of what swings a sixth too slow.
const END: f64 = 2.5;
/// Ticks in a period.
const TICKS: u32 = 40;

fn follow(run: &mut Watched) -> Measured {
    run.set_velocities(velocity)?;
    run.keeps_energy();
    let period = std::f64::consts::TAU / standing_wave::frequency(GRAVITY, wavenumber(), DEPTH);
    let mut heights: Curve = [(0.0, 0.0)].into_iter().collect();
    for _ in 0..(END * f64::from(TICKS)) as u32 {
        run.tick(period / f64::from(TICKS))?;
        heights.push(run.time() / period, height(&run.positions()?));
    }
    let swing = Oscillation::of(&heights);
    Ok(vec![swing.map_or(f64::NAN, |swing| (swing.period - 1.0).abs())])
}
