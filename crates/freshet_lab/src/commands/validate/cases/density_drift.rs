//! A dam break with densities that particles carry: how far they go from those of where particles are.

use freshet_core::field::Field;
use freshet_core::plan::Plan;
use freshet_core::scene::{Boundary, FluidScene, Volume};
use glam::Vec3;

use super::super::{Case, Job, Level, Study, Trace};
use crate::drive::Drive;
use crate::error::LabError;
use crate::measure::crowding::Tank;
use crate::measure::statistics::mean;
use crate::method::Method;
use crate::progress::Progress;
use crate::verdict::{Bound, Check};

/// The case.
pub const CASE: Case = Case {
    name: "density-drift",
    about: "a dam breaks, 0.5 x 0.5 x 0.5 m, with densities that particles carry: how far they are from sums over the places of particles",
    run: |job| DRIFT.run(job),
};

const DRIFT: Study = Study {
    name: "density-drift",
    title: "A dam break, densities by continuity",
    measure: "carried minus summed density inside the fluid, RMS at the end over rho0",
    bound: 0.03,
    coarse_bound: Some(0.03),
    smooth: false,
    resolutions: [8, 12, 20],
    quick: &[8],
    axes: ["time (s)", "RMS inside the fluid / rho0; reference: sums of a fluid whose pressures they make"],
    simulate,
};

/// Edge of the column, m.
const EDGE: f32 = 0.5;
/// Time to simulate, s: the water has been at the far wall, come back and lies.
const END: f64 = 3.0;
/// Duration of a tick, s.
const TICK: f64 = 1.0 / 60.0;
/// Least density, summed, of what counts as inside the fluid, over that at rest.
const INSIDE: f64 = 0.95;

/// Densities of one moment, over that at rest.
struct Densities {
    carried: Vec<f64>,
    summed: Vec<Option<f64>>,
}

impl Densities {
    /// Of those inside.
    fn inside(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let both = self.carried.iter().zip(&self.summed);
        both.filter_map(|(&carried, summed)| Some((carried, (*summed)?))).filter(|(_, summed)| *summed > INSIDE)
    }

    fn root_mean_square(&self, of: impl Fn((f64, f64)) -> f64) -> f64 {
        mean(self.inside().map(|both| of(both).powi(2))).map_or(f64::NAN, f64::sqrt)
    }
}

fn simulate(job: &Job, resolution: u32, progress: &mut Progress) -> Result<Level, LabError> {
    let (spacing, size) = (EDGE / resolution as f32, Vec3::new(1.0, 1.0, EDGE));
    let scene = FluidScene {
        name: "density drift".to_owned(),
        volumes: vec![Volume::block(Vec3::splat(EDGE / 2.0), Vec3::splat(EDGE / 2.0))],
        boundaries: vec![Boundary::closed_box(size, size / 2.0)],
        ..FluidScene::with_spacing(spacing)
    };
    let tank = Tank { size, spacing };
    let ticks = (END / TICK).round() as u32;
    let run = |method: Method, progress: &mut Progress, from: f64| {
        let plan = Plan::new(&method.on(scene.clone()))?;
        let (particles, rest) = (plan.positions.len(), f64::from(plan.parameters.rest_density));
        let mut drive = Drive::open(job.backend, plan, job.threads.count(), Vec::new())?;
        let mut moments = Vec::new();
        for tick in 1..=ticks {
            drive.tick(TICK)?;
            progress.at(from + 0.5 * f64::from(tick) / f64::from(ticks));
            if tick % 6 == 0 {
                let carried = drive.scalars(Field::Density)?.into_iter().map(|rho| f64::from(rho) / rest).collect();
                let densities = Densities { carried, summed: tank.densities(&drive.positions()?) };
                moments.push((f64::from(tick) * TICK, densities));
            }
        }
        Ok::<_, LabError>((particles, moments, drive.account().clone()))
    };
    let (particles, carried, account) = run(Method::Continuity, progress, 0.0)?;
    let (_, summed, _) = run(Method::WeaklyCompressible, progress, 0.5)?;
    let drift = |densities: &Densities| densities.root_mean_square(|(carried, summed)| carried - summed);
    let uneven = |densities: &Densities| densities.root_mean_square(|(_, summed)| summed - 1.0);
    let points = carried.iter().zip(&summed).map(|((time, one), (_, other))| (*time, drift(one), drift(other)));
    let (last, of_sums) =
        (carried.last().map(|(_, densities)| densities), summed.last().map(|(_, densities)| densities));
    let at_end = |of: &dyn Fn(&Densities) -> f64, densities: Option<&Densities>| densities.map_or(f64::NAN, of);
    let crowded = |densities: &Densities| mean(densities.inside().map(|(_, summed)| summed - 1.0)).unwrap_or(f64::NAN);
    Ok(Level {
        resolution,
        particles,
        error: at_end(&drift, last),
        traces: vec![Trace { name: "drift".to_owned(), points: points.collect() }],
        checks: vec![
            Check::new(
                "summed density inside at the end, mean off rho0",
                100.0 * at_end(&crowded, last),
                "%",
                Bound::Within(-1.0, 1.0),
            ),
            Check::new(
                "summed density inside at the end, RMS off rho0",
                100.0 * at_end(&uneven, last),
                "%",
                Bound::AtMost(3.0),
            ),
            Check::new("the same where densities are sums", 100.0 * at_end(&uneven, of_sums), "%", Bound::AtMost(3.0)),
        ],
        remarks: vec![format!("sums of the solver that has them: {:.3} % off these", 100.0 * at_end(&drift, of_sums))],
        account,
    })
}
