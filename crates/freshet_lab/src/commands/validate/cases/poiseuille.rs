//! Plane Poiseuille flow: a force drives a fluid at rest between two plates it sticks to.

use freshet_core::kernel::KernelKind;

use super::super::{Case, Study};
use super::channel;
use crate::reference::poiseuille::velocity;
use crate::scenes::channel::{Drive, scene};

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
    simulate: |job, resolution, progress| {
        channel::simulate(job, &scene(Drive::Force, resolution), resolution, velocity, progress)
    },
};

/// The same with the kernels of Mueller, Charypar & Gross 2003.
pub const KERNELS: Case = Case {
    name: "poiseuille-kernels",
    about: "the same with poly6 for densities, spiky for pressures and the Laplacian of Mueller et al. 2003 for viscosity",
    run: |job| STUDY_OF_KERNELS.run(job),
};

const STUDY_OF_KERNELS: Study = Study {
    name: "poiseuille_kernels",
    title: "Plane Poiseuille flow from rest, Re 10, a kernel per term",
    simulate: |job, resolution, progress| {
        let mut scene = scene(Drive::Force, resolution);
        scene.settings.kernel = KernelKind::Poly6;
        scene.settings.pressure_kernel = Some(KernelKind::Spiky);
        scene.settings.viscosity_kernel = Some(KernelKind::Viscosity);
        channel::simulate(job, &scene, resolution, velocity, progress)
    },
    ..STUDY
};
