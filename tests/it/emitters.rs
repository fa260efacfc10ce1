//! Emitters: the pool grows, recycles, and says when it is full.

use bevy::prelude::*;
use bevy_freshet::prelude::*;

use crate::harness::{ALL, TestApp};

fn jet(lifetime: f32) -> (FluidEmitter, Transform) {
    // A layer of four particles each 50 ms.
    let pose = Transform::from_xyz(0.0, 1.0, 0.0).looking_to(Vec3::X, Vec3::Y);
    (FluidEmitter::disc(0.1, 2.0, lifetime), pose)
}

#[test]
fn particles_flow_in_and_are_retired() {
    for (backend, mode) in ALL {
        let mut test = TestApp::new();
        let domain = test.spawn(FluidDomain::with_spacing(0.1).on(backend).in_mode(mode));
        let emitter = test.spawn(jet(0.25));
        test.tick(16);
        let young = test.settle(domain);
        assert!((16..=24).contains(&young.particles), "{backend:?} {mode:?}: {young:?}");
        test.tick(32);
        let steady = test.settle(domain);
        assert!(steady.particles <= 28, "as many are retired as flow in: {steady:?}");
        assert!(steady.particles <= steady.capacity && steady.refused == 0, "{steady:?}");
        assert!(steady.retired >= 32, "{steady:?}");
        test.change::<FluidEmitter>(emitter, |emitter| emitter.enabled = false);
        test.tick(20);
        assert_eq!(test.settle(domain).particles, 0, "{backend:?} {mode:?}");
        test.expect_no_complaints();
    }
}

#[test]
fn a_full_pool_refuses_and_says_so() {
    for (backend, mode) in ALL {
        let mut test = TestApp::new();
        let mut settings = FluidDomain::with_spacing(0.1).on(backend).in_mode(mode);
        settings.max_particles = Some(12);
        let domain = test.spawn(settings);
        test.spawn(jet(f32::INFINITY));
        test.tick(32);
        let stats = test.settle(domain);
        assert_eq!((stats.particles, stats.capacity), (12, 12), "{backend:?} {mode:?}");
        assert!(stats.refused >= 16, "{stats:?}");
        test.expect_no_complaints();
    }
}

#[test]
fn an_emitter_that_flows_for_ever_needs_a_limit() {
    let mut test = TestApp::new();
    test.spawn(FluidDomain::with_spacing(0.1));
    test.spawn(jet(f32::INFINITY));
    test.tick(3);
    let complaints = test.complaints();
    assert_eq!(complaints.len(), 1, "{complaints:?}");
    assert!(complaints[0].message.contains("max_particles"), "{complaints:?}");
}
