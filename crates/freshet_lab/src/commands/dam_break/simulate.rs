//! One column at one resolution on one backend.

use freshet_core::plan::Plan;

use crate::backend::Backend;
use crate::drive::{Account, Drive};
use crate::error::LabError;
use crate::measure::containment::escaped;
use crate::measure::curve::Curve;
use crate::measure::front::front;
use crate::measure::reference_error::{LARGEST_SHIFT, ReferenceError};
use crate::method::Method;
use crate::progress::Progress;
use crate::reference::dam_break::DamBreakExperiment;
use crate::scenes::{GRAVITY, slab};

/// A finished run.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// What was compared with.
    pub experiment: &'static DamBreakExperiment,
    /// Where it ran.
    pub backend: Backend,
    /// Particles along the width of the column.
    pub resolution: u32,
    /// Particles in all.
    pub particles: usize,
    /// Front `Z` over `T`.
    pub front: Curve,
    /// Against the experiment.
    pub error: ReferenceError,
    /// Particles that went through a wall.
    pub escaped: usize,
    /// What it cost.
    pub account: Account,
}

/// Time between two samples of the front, in units of `T`.
const SAMPLE: f64 = 0.02;

/// Simulates until the last point that counts, and as much longer as the clock may be shifted.
pub fn simulate(
    experiment: &'static DamBreakExperiment,
    resolution: u32,
    method: Method,
    backend: Backend,
    threads: Option<usize>,
    progress: &mut Progress,
) -> Result<Run, LabError> {
    let plan = Plan::new(&method.on(slab::scene(experiment, resolution)))?;
    let (particles, spacing) = (plan.positions.len(), plan.parameters.spacing);
    let unit = experiment.time_unit(GRAVITY);
    let samples = ((experiment.window.1 + LARGEST_SHIFT) / SAMPLE).ceil() as u32;

    let mut fronts = Curve::default();
    let mut sample = |time: f64, positions: &[glam::Vec3]| match front(positions, spacing) {
        Some(x) => {
            fronts.push(time / unit, x / experiment.width);
            Ok(())
        }
        None => Err(LabError::Measure { what: "the front", reason: "all particles are gone".to_owned() }),
    };
    sample(0.0, &plan.positions)?;
    let mut drive = Drive::open(backend, plan, threads, Vec::new())?;
    for index in 1..=samples {
        drive.tick(SAMPLE * unit)?;
        sample(drive.time(), &drive.positions()?)?;
        progress.at(f64::from(index) / f64::from(samples));
    }
    let error = ReferenceError::between(&fronts, experiment.points, experiment.window).ok_or_else(|| {
        let reason = format!("the run ended at T = {:.3}, before the last point", drive.time() / unit);
        LabError::Measure { what: "the error of the front", reason }
    })?;
    let escaped = escaped(&drive.positions()?, glam::Vec3::ZERO, slab::tank(experiment, resolution));
    let account = drive.account().clone();
    Ok(Run { experiment, backend, resolution, particles, front: fronts, error, escaped, account })
}
