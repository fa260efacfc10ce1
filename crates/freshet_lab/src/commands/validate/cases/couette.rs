//! Plane Couette flow: a plate that moves from the start drags a fluid at rest along.

use super::super::{Case, Study};
use super::channel;
use crate::reference::couette::velocity;
use crate::scenes::channel::{Drive, scene};

/// The case.
pub const CASE: Case = Case {
    name: "couette",
    about: "flow between a plate at rest and a moving one at Re 10, from rest, against the series of Morris et al. 1997",
    run: |job| STUDY.run(job),
};

const STUDY: Study = Study {
    name: "couette",
    title: "Plane Couette flow from rest, Re 10",
    measure: "L2 error of the velocity",
    bound: 0.02,
    coarse_bound: Some(0.05),
    smooth: true,
    resolutions: [10, 20, 40],
    quick: &[8, 16],
    axes: ["y / L", "velocity / velocity of the plate"],
    simulate: |job, resolution, progress| {
        channel::simulate(job, &scene(Drive::Plate, resolution), resolution, velocity, progress)
    },
};
