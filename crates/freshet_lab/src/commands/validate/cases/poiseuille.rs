//! Plane Poiseuille flow: a force drives a fluid at rest between two plates it sticks to.

use super::super::{Case, Study};
use super::channel;
use crate::reference::poiseuille::velocity;
use crate::scenes::channel::Drive;

/// The case.
pub const CASE: Case = Case {
    name: "poiseuille",
    about: "flow between plates under a force at Re 10, from rest until steady, against the series of Morris et al. 1997",
    run: |job| STUDY.run(job),
};

const STUDY: Study = Study {
    name: "poiseuille",
    title: "Plane Poiseuille flow from rest, Re 10",
    measure: "L2 error of the velocity",
    bound: 0.02,
    coarse_bound: Some(0.05),
    smooth: true,
    resolutions: [10, 20, 40],
    quick: &[8, 16],
    axes: ["y / L", "velocity / steady velocity in the middle"],
    simulate: |job, resolution, progress| channel::simulate(job, Drive::Force, resolution, velocity, progress),
};
