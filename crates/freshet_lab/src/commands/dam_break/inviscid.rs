//! The dam breaks of a liquid without viscosity, once for each experiment: seconds of work.

use std::sync::LazyLock;

use crate::reference::dam_break::DamBreakExperiment;
use crate::reference::potential_flow::{Collapse, collapse};

static COLLAPSES: LazyLock<Vec<Collapse>> = LazyLock::new(|| {
    let of =
        |experiment: &&DamBreakExperiment| collapse(experiment.aspect, experiment.end() / experiment.aspect.sqrt());
    DamBreakExperiment::ALL.iter().map(of).collect()
});

/// Front over `T`, in widths of the column, measured as particles are: half a spacing, in widths, farther than most of the liquid.
pub fn front(experiment: &'static DamBreakExperiment, spacing: f64) -> Vec<(f64, f64)> {
    let n = experiment.aspect.sqrt();
    points(experiment, |collapse| {
        collapse.front.samples().iter().map(|&(tau, front)| (n * tau, front + spacing / 2.0)).collect()
    })
}

/// Height of the column at the back wall over `tau`, in heights at the start.
pub fn height(experiment: &'static DamBreakExperiment) -> Vec<(f64, f64)> {
    points(experiment, |collapse| collapse.height.samples().to_vec())
}

fn points(experiment: &'static DamBreakExperiment, of: impl Fn(&Collapse) -> Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let mut collapses = DamBreakExperiment::ALL.into_iter().zip(COLLAPSES.iter());
    collapses.find(|pair| pair.0 == experiment).map_or_else(Vec::new, |pair| of(pair.1))
}
