//! One column at one resolution on one backend.

use freshet_core::plan::Plan;
use freshet_core::scene::FluidScene;

use super::inviscid;
use crate::backend::Backend;
use crate::drive::{Account, Drive};
use crate::error::LabError;
use crate::measure::containment::escaped;
use crate::measure::curve::Curve;
use crate::measure::front::front;
use crate::measure::reference_error::{LARGEST_SHIFT, Measure, ReferenceError};
use crate::measure::wall_height::wall_height;
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
    /// Against potential flow, over the same time: it has no clock to shift.
    pub inviscid_error: ReferenceError,
    /// Height `H` of the column at the back wall over `T`.
    pub height: Curve,
    /// That against the experiment; none where it was not measured.
    pub height_error: Option<HeightError>,
    /// Particles that went through a wall.
    pub escaped: usize,
    /// What it cost.
    pub account: Account,
}

/// How far the height of a column is from the experiment's, over all measured points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightError {
    /// In units of the height at the start, as it is, and with the shift of the clock that is best for it.
    pub error: ReferenceError,
    /// Root mean square with the shift that is best for the front: one clock for both.
    pub rms_with_shift_of_front: f64,
    /// Over what is left of the height.
    pub relative: ReferenceError,
}

impl HeightError {
    /// None where the height was not measured, or the curve ends before the last measured point.
    pub fn between(experiment: &DamBreakExperiment, height: &Curve, shift_of_front: f64) -> Option<Self> {
        let (points, all) = (experiment.heights_over_time(), (0.0, f64::INFINITY));
        Some(Self {
            error: ReferenceError::between(height, &points, all, Measure::InUnits)?,
            rms_with_shift_of_front: ReferenceError::with_shift(
                height,
                &points,
                all,
                Measure::InUnits,
                shift_of_front,
            )?,
            relative: ReferenceError::between(height, &points, all, Measure::Relative)?,
        })
    }
}

/// Time between two samples of front and height, in units of `T`.
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
    simulate_with(experiment, resolution, |scene| method.on(scene), backend, threads, progress)
}

/// The same with a scene that has been changed otherwise.
pub fn simulate_with(
    experiment: &'static DamBreakExperiment,
    resolution: u32,
    change: impl FnOnce(FluidScene) -> FluidScene,
    backend: Backend,
    threads: Option<usize>,
    progress: &mut Progress,
) -> Result<Run, LabError> {
    let plan = Plan::new(&change(slab::scene(experiment, resolution)))?;
    let (particles, spacing) = (plan.positions.len(), plan.parameters.spacing);
    let unit = experiment.time_unit(GRAVITY);
    let samples = ((experiment.end() + LARGEST_SHIFT) / SAMPLE).ceil() as u32;

    let (mut fronts, mut heights) = (Curve::default(), Curve::default());
    let mut sample = |time: f64, positions: &[glam::Vec3]| match front(positions, spacing) {
        Some(x) => {
            let height = wall_height(positions, slab::DEPTH_IN_SPACINGS, spacing);
            fronts.push(time / unit, x / experiment.width);
            heights.push(time / unit, height / experiment.height());
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
    let error = ReferenceError::between(&fronts, experiment.points, experiment.window, Measure::Relative);
    let error = error.ok_or_else(|| {
        let reason = format!("the run ended at T = {:.3}, before the last point", drive.time() / unit);
        LabError::Measure { what: "the error of the front", reason }
    })?;
    let inviscid = inviscid::front(experiment, f64::from(resolution).recip());
    let inviscid_error = ReferenceError::between(&fronts, &inviscid, experiment.window, Measure::Relative);
    let inviscid_error = inviscid_error.ok_or_else(|| {
        let reason = "the run does not cover the time of the potential flow".to_owned();
        LabError::Measure { what: "the error of the front", reason }
    })?;
    let height_error = HeightError::between(experiment, &heights, error.shift);
    if height_error.is_none() && !experiment.heights.is_empty() {
        let reason = format!("the run ended at T = {:.3}, before the last point", drive.time() / unit);
        return Err(LabError::Measure { what: "the error of the height", reason });
    }
    let escaped = escaped(&drive.positions()?, glam::Vec3::ZERO, slab::tank(experiment, resolution));
    let account = drive.account().clone();
    Ok(Run {
        experiment,
        backend,
        resolution,
        particles,
        front: fronts,
        error,
        inviscid_error,
        height: heights,
        height_error,
        escaped,
        account,
    })
}
