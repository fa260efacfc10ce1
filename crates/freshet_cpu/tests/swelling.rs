//! Bodies that come into a fluid push it out gently.

mod common;
#[path = "common/growing.rs"]
mod growing;

use freshet_core::prelude::*;

use self::common::solver;
use self::growing::{ball, exchanged_with_what_appears, free_block, pool};

fn methods() -> [PressureSolver; 2] {
    [PressureSolver::WeaklyCompressible, PressureSolver::DivergenceFree(DivergenceFree::default())]
}

#[test]
fn a_ball_that_grows_and_one_that_is_put_into_a_full_pool_push_the_water_out_gently() {
    for method in methods() {
        let scene = pool(method);
        let scene = FluidScene { bodies: vec![ball(&scene, 0.1)], ..scene };
        println!("{method:?}");
        growing::assert_bodies_push_fluid_out_gently(&mut solver(&scene, 2), &scene, 60);
    }
}

#[test]
fn a_body_swells_as_long_as_it_pushes() {
    for method in methods() {
        let scene = pool(method);
        let scene = FluidScene { bodies: vec![ball(&scene, 0.1)], ..scene };
        growing::assert_bodies_swell_as_long_as_they_push(&mut solver(&scene, 2));
    }
}

#[test]
fn a_body_that_swells_gets_what_the_fluid_loses() {
    for method in methods() {
        let scene = free_block(method);
        let [given, lost] = exchanged_with_what_appears(&mut solver(&scene, 2), &scene);
        assert!(given.length() > 0.3 && (given - lost).length() < 1e-4 * given.length(), "{method:?}: {given}, {lost}");
    }
}
