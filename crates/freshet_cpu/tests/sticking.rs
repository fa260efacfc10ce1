//! Fluid that sticks to bodies, against sums over all pairs in double precision, and what must come of it.

mod common;
#[path = "common/sticking.rs"]
mod sticking;

use common::solver;
use freshet_core::prelude::*;
use sticking::{assert_a_ball_is_braked, sticking_errors, sticking_scene};

#[test]
fn a_viscous_fluid_drags_bodies_and_they_drag_it() {
    for kernel in [KernelKind::WendlandC2, KernelKind::CubicSpline] {
        let found = sticking_errors(&mut solver(&sticking_scene(kernel), 2));
        assert!(found.iter().all(|&error| error < 1.0), "{kernel:?}: {found:?}");
    }
}

#[test]
fn a_ball_is_braked_by_what_the_fluid_gets() {
    assert_a_ball_is_braked(&mut |scene| Box::new(solver(scene, 2)));
}

#[test]
fn fluid_slips_along_bodies_without_a_viscosity_model() {
    let mut scene = sticking_scene(KernelKind::WendlandC2);
    assert!(Plan::new(&scene).unwrap().has(freshet_core::plan::StageKind::BodyDrag));
    scene.settings.viscosity_model = None;
    assert!(!Plan::new(&scene).unwrap().has(freshet_core::plan::StageKind::BodyDrag));
    scene.settings.viscosity_model = Some(ViscosityModel::Morris1997);
    scene.bodies.clear();
    assert!(!Plan::new(&scene).unwrap().has(freshet_core::plan::StageKind::BodyDrag));
}
