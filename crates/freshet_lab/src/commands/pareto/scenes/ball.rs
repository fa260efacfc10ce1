//! A ball that is drawn out: a free surface alone, exact.

use super::{Benchmark, Measured};
use crate::commands::pareto::trial::{Watched, watch};
use crate::measure::statistics::mean;
use crate::reference::ellipsoid;
use crate::scenes::ball::{RADIUS, RATE, scene, velocity};

/// Drawn to twice its length.
pub const DRAWN_OUT: Benchmark = Benchmark {
    name: "ball",
    title: "ball drawn out",
    about: "a free ball of inviscid fluid is drawn out to twice its length: semi-axis against the exact ellipsoid, root mean square over time of what it is \
            off, over the root mean square of how far it moves",
    parts: &[],
    simulate: |job| watch(job, &scene(job.across), follow),
};

/// Time to simulate, over the rate at the start: to twice the length.
const END: f64 = 0.45;
/// Ticks in it.
const TICKS: u32 = 30;

fn follow(run: &mut Watched) -> Measured {
    run.set_velocities(velocity)?;
    run.keeps_energy();
    let exact = ellipsoid::polar_axis(END);
    let start = semi_axis(run)?;
    let (mut off, mut way) = (0.0, 0.0);
    for tick in 1..=TICKS {
        run.tick(END / RATE / f64::from(TICKS))?;
        let wanted = exact.at(END * f64::from(tick) / f64::from(TICKS)).unwrap_or(f64::NAN);
        off += (semi_axis(run)? / start - wanted).powi(2);
        way += (wanted - 1.0).powi(2);
    }
    Ok(vec![(off / way).sqrt()])
}

/// Along z, of an ellipsoid with the second moment of the particles: `c^2 = 5 <z^2>`. Over that at the start it does not depend on how well a lattice fills a ball.
fn semi_axis(run: &mut Watched) -> Result<f64, crate::error::LabError> {
    let moment = mean(run.positions()?.iter().map(|x| f64::from(x.z).powi(2))).unwrap_or(f64::NAN);
    Ok((5.0 * moment).sqrt() / RADIUS)
}
