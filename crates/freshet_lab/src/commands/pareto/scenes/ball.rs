//! A ball that is drawn out: a free surface alone, exact.

use glam::{DVec2, Vec3};

use super::{Benchmark, Measured};
use crate::commands::pareto::trial::{Watched, watch};
use crate::reference::ellipsoid;
use crate::scenes::ball::{RATE, axis, scene, velocity};

/// Drawn to twice its length.
pub const DRAWN_OUT: Benchmark = Benchmark {
    name: "ball",
    title: "ball drawn out",
    about: "a free ball of inviscid fluid is drawn out to twice its length, in no direction of the lattice: length and width against the exact ellipsoid, \
            root mean square over time of what they are off, over the root mean square of how far they move, root of the sum of their squares",
    parts: &["length", "width"],
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
    let start = semi_axes(&run.positions()?);
    let (mut off, mut way) = (DVec2::ZERO, DVec2::ZERO);
    for tick in 1..=TICKS {
        run.tick(END / RATE / f64::from(TICKS))?;
        let length = exact.at(END * f64::from(tick) / f64::from(TICKS)).unwrap_or(f64::NAN);
        let wanted = DVec2::new(length, length.powf(-0.5));
        off += (semi_axes(&run.positions()?) / start - wanted).powf(2.0);
        way += (wanted - 1.0).powf(2.0);
    }
    let shares = off / way;
    Ok(vec![shares.x.sqrt(), shares.y.sqrt()])
}

/// Along the axis and across it, m, of an ellipsoid with the second moments of the particles: `c^2 = 5 <z^2>`. Over those at the start they do not
/// depend on how well a lattice fills a ball.
fn semi_axes(positions: &[Vec3]) -> DVec2 {
    let axis = axis();
    let moments = |x: &Vec3| {
        let (along, square) = (x.as_dvec3().dot(axis), x.as_dvec3().length_squared());
        DVec2::new(along * along, (square - along * along) / 2.0)
    };
    let sum: DVec2 = positions.iter().map(moments).sum();
    (5.0 * sum / positions.len() as f64).powf(0.5)
}
