//! Collapsing columns: where the front is.

use glam::Vec3;

use super::{Benchmark, Job, Measured};
use crate::commands::pareto::trial::{Outcome, Watched, watch};
use crate::error::LabError;
use crate::measure::curve::Curve;
use crate::measure::front::front;
use crate::measure::reference_error::{LARGEST_SHIFT, Measure, ReferenceError};
use crate::reference::dam_break::DamBreakExperiment;
use crate::reference::{lobovsky_2014, martin_moyce_1952};
use crate::scenes::{GRAVITY, slab};

/// Martin & Moyce's square column.
pub const SQUARE: Benchmark = Benchmark {
    name: "dam_break",
    title: "dam break",
    about: "a column of water, 5.7 cm, collapses: front against Martin & Moyce 1952, root mean square of what it is off, relative, with the best \
            shift of the clock (up to 0.2), and the largest mean compression, root of the sum of their squares",
    parts: PARTS,
    simulate: |job| simulate(job, &martin_moyce_1952::SQUARE),
};

/// Lobovsky's, ten times as large, of another laboratory.
pub const LARGE: Benchmark = Benchmark {
    name: "large_dam_break",
    title: "dam break of another laboratory",
    about: "a column of water, 60 cm, collapses: front against Lobovsky et al. 2014, as of the small one",
    parts: PARTS,
    simulate: |job| simulate(job, &lobovsky_2014::SQUARE),
};

const PARTS: &[&str] = &["front", "compression"];

/// Time between two samples of the front, in units of `T`. An incompressible fluid may take steps as long.
const SAMPLE: f64 = 0.04;

fn simulate(job: &Job, experiment: &'static DamBreakExperiment) -> Outcome {
    watch(job, &slab::scene(experiment, job.across), |run| follow(run, job, experiment))
}

fn follow(run: &mut Watched, job: &Job, experiment: &'static DamBreakExperiment) -> Measured {
    run.within(Vec3::ZERO, slab::tank(experiment, job.across));
    run.keeps_energy();
    let unit = experiment.time_unit(GRAVITY);
    let spacing = (experiment.width / f64::from(job.across)) as f32;
    let samples = ((experiment.window.1 + LARGEST_SHIFT) / SAMPLE).ceil() as u32;
    let mut fronts: Curve = [(0.0, 1.0)].into_iter().collect();
    for _ in 0..samples {
        run.tick(SAMPLE * unit)?;
        let front = front(&run.positions()?, spacing).unwrap_or(f64::NAN);
        fronts.push(run.time() / unit, front / experiment.width);
    }
    let error = ReferenceError::between(&fronts, experiment.points, experiment.window, Measure::Relative);
    let error = error.ok_or_else(|| LabError::Measure {
        what: "the error of the front",
        reason: format!("the run ended at T = {:.3}, before the last point", run.time() / unit),
    })?;
    Ok(vec![error.rms_shifted, run.compression()])
}
