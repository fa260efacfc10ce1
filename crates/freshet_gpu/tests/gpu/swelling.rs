//! Bodies that come into a fluid push it out gently, as on the CPU.

use freshet_core::prelude::*;

use crate::common::solver;

#[path = "../../../freshet_cpu/tests/common/growing.rs"]
mod growing;
use growing::{ball, exchanged_with_what_appears, free_block, pool};

#[test]
fn a_ball_that_grows_and_one_that_is_put_into_a_full_pool_push_the_water_out_gently() {
    for method in [PressureSolver::WeaklyCompressible, PressureSolver::DivergenceFree(DivergenceFree::default())] {
        let scene = pool(method);
        let scene = FluidScene { bodies: vec![ball(&scene, 0.1)], ..scene };
        growing::assert_bodies_push_fluid_out_gently(&mut solver(&scene), &scene, 15);
    }
}

#[test]
fn a_body_swells_as_long_as_it_pushes() {
    for method in [PressureSolver::WeaklyCompressible, PressureSolver::DivergenceFree(DivergenceFree::default())] {
        let scene = pool(method);
        let scene = FluidScene { bodies: vec![ball(&scene, 0.1)], ..scene };
        growing::assert_bodies_swell_as_long_as_they_push(&mut solver(&scene));
    }
}

#[test]
fn a_body_that_swells_gets_what_the_fluid_loses() {
    for method in [PressureSolver::WeaklyCompressible, PressureSolver::DivergenceFree(DivergenceFree::default())] {
        let scene = free_block(method);
        let [given, lost] = exchanged_with_what_appears(&mut solver(&scene), &scene);
        assert!(given.length() > 0.3 && (given - lost).length() < 1e-4 * given.length(), "{method:?}: {given}, {lost}");
    }
}
