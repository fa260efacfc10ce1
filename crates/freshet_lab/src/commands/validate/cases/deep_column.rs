//! Ten metres of water at rest, six spacings wide: how far its own weight compresses it.

use freshet_core::field::Field;
use freshet_core::plan::Plan;
use glam::Vec3;

use super::super::{Case, Job, Level, Study, Trace};
use crate::drive::Drive;
use crate::error::LabError;
use crate::measure::column::{PressureProfile, surface_level};
use crate::measure::crowding::{Crowding, Tank};
use crate::measure::statistics::percentile;
use crate::method::Method;
use crate::progress::Progress;
use crate::reference::hydrostatics;
use crate::scenes::GRAVITY;
use crate::scenes::column::walled;
use crate::verdict::{Bound, Check};

/// The case, weakly compressible.
pub const CASE: Case = Case {
    name: "deep-column",
    about: "a column of water, 10 m, at rest between walls: compression under 1 % by a cubic-spline sum; pressure against depth is drawn and has no bound",
    run: |job| WEAKLY_COMPRESSIBLE.run(job),
};

/// The same with the incompressible solver.
pub const DIVERGENCE_FREE: Case = Case {
    name: "deep-column-dfsph",
    about: "the same with divergence-free SPH: compression under 1 % by a cubic-spline sum; pressure against depth is drawn and has no bound",
    run: |job| INCOMPRESSIBLE.run(job),
};

const WEAKLY_COMPRESSIBLE: Study = Study {
    name: "deep-column",
    title: "Water at rest, 10 m deep",
    measure: "mean compression, the largest of any moment",
    bound: 0.01,
    coarse_bound: Some(0.01),
    smooth: false,
    resolutions: [25, 50, 100],
    quick: &[25, 50],
    axes: ["depth / D", "pressure / (rho g D)"],
    simulate: |job, resolution, progress| simulate(job, Method::WeaklyCompressible, resolution, progress),
};

const INCOMPRESSIBLE: Study = Study {
    name: "deep-column-dfsph",
    title: "Water at rest, 10 m deep, by DFSPH",
    simulate: |job, resolution, progress| simulate(job, Method::DivergenceFree, resolution, progress),
    ..WEAKLY_COMPRESSIBLE
};

/// Depth of the water, m.
const DEPTH: f64 = 10.0;
/// Width, spacings.
const WIDTH: u32 = 6;
/// Time to simulate, s; that of the quick form.
const END: [f64; 2] = [5.0, 1.0];
/// Duration of a tick, s.
const TICK: f64 = 1.0 / 60.0;
/// Ticks between two looks.
const STRIDE: u32 = 6;

fn simulate(job: &Job, method: Method, resolution: u32, progress: &mut Progress) -> Result<Level, LabError> {
    let spacing = DEPTH / f64::from(resolution);
    let base = f64::from(WIDTH) * spacing;
    let plan = Plan::new(&method.on(walled(base as f32, DEPTH, spacing as f32)))?;
    let (particles, support) = (plan.positions.len(), f64::from(plan.parameters.support_radius));
    let mut drive = Drive::open(job.backend, plan, job.threads.count(), Vec::new())?;
    // Its lid is out of reach of the surface.
    let height = spacing * f64::from(resolution + 4);
    let tank = Tank { size: Vec3::new(base as f32, height as f32, base as f32), spacing: spacing as f32 };
    let corner = Vec3::new(base as f32 / 2.0, 0.0, base as f32 / 2.0);
    let ticks = (END[usize::from(job.quick)] / TICK).round() as u32;
    let (mut worst, mut inside) = (Crowding::default(), 0.0f64);
    for tick in 1..=ticks {
        drive.tick(TICK)?;
        progress.at(f64::from(tick) / f64::from(ticks));
        if tick % STRIDE == 0 {
            let positions: Vec<Vec3> = drive.positions()?.into_iter().map(|x| x + corner).collect();
            let found = tank.crowding(&positions);
            worst.mean = worst.mean.max(found.mean);
            worst.percentile_99 = worst.percentile_99.max(found.percentile_99);
            worst.maximum = worst.maximum.max(found.maximum);
            inside = inside.max(percentile_inside(&tank, &positions));
        }
    }
    let (positions, pressures) = (drive.positions()?, drive.scalars(Field::Pressure)?);
    let mut profile = PressureProfile::new(DEPTH, support);
    positions.iter().zip(&pressures).for_each(|(x, &pressure)| profile.add(x.y, pressure));
    let whole = hydrostatics::pressure(1000.0, GRAVITY, DEPTH);
    let point = |(height, pressure): (f64, f64)| (1.0 - height / DEPTH, pressure / whole, reference(height) / whole);
    let level = surface_level(&positions, (WIDTH * WIDTH) as usize, spacing as f32).unwrap_or(f64::NAN);
    Ok(Level {
        resolution,
        particles,
        error: worst.mean / 100.0,
        traces: vec![Trace { name: "pressure".to_owned(), points: profile.points().map(point).collect() }],
        checks: vec![
            Check::new(
                "99th percentile of the compression away from walls, the largest",
                inside,
                "%",
                Bound::Below(1.0),
            ),
            Check::new("surface level over the depth", 100.0 * level / DEPTH, "%", Bound::Within(99.0, 101.0)),
        ],
        remarks: vec![format!(
            "walls included: 99th percentile {:.3} %, largest {:.3} %; pressure at the end {:.3} % RMS of rho g D",
            worst.percentile_99,
            worst.maximum,
            100.0 * profile.deviation(reference).unwrap_or(f64::NAN) / whole,
        )],
        account: drive.account().clone(),
    })
}

/// The 99th percentile of the compression of particles farther than a spacing from walls and floor, in percent. Beside a wall the sum takes what
/// is behind it for a lattice of fluid, and fluid that has found its place before one layer of samples is no lattice's neighbour.
fn percentile_inside(tank: &Tank, positions: &[Vec3]) -> f64 {
    let far = |x: &Vec3| x.min(tank.size - *x).min_element() > tank.spacing;
    let all = tank.densities(positions);
    let inside = positions.iter().zip(&all).filter(|(x, _)| far(x)).filter_map(|(_, density)| *density);
    let mut excess: Vec<f32> = inside.map(|density| (density - 1.0).max(0.0) as f32).collect();
    100.0 * percentile(&mut excess, 99.0).unwrap_or(f64::NAN)
}

/// Pressure at a height, Pa.
fn reference(height: f64) -> f64 {
    hydrostatics::pressure(1000.0, GRAVITY, DEPTH - height)
}
