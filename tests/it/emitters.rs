//! Emitters: the pool grows, recycles, and says when it is full.

use bevy::prelude::*;
use bevy_freshet::prelude::*;

use crate::harness::{ALL, TestApp};

fn jet(lifetime: f32) -> (FluidEmitter, Transform) {
    // pi 0.1^2 2 m3/s are 63 particles of 0.1^3 m3 a second: a layer of three each 48 ms.
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
        // 0.25 s of it are 16, in layers of three.
        assert!((13..=18).contains(&young.particles), "{backend:?} {mode:?}: {young:?}");
        test.tick(32);
        let steady = test.settle(domain);
        assert!(steady.particles <= 28, "as many are retired as flow in: {steady:?}");
        assert!(steady.particles <= steady.capacity && steady.refused == 0, "{steady:?}");
        // 48 ticks of 1/64 s bring 47, of which those of the last 0.25 s are there.
        assert!(steady.retired >= 27, "{steady:?}");
        test.change::<FluidEmitter>(emitter, |emitter| emitter.enabled = false);
        test.tick(20);
        assert_eq!(test.settle(domain).particles, 0, "{backend:?} {mode:?}");
        test.expect_no_complaints();
    }
}

/// Positions in the order of ids, as they were read last.
#[derive(Resource, Default)]
struct Jet(Vec<Vec3>);

fn keep(read: On<FluidReadbackComplete>, mut jet: ResMut<Jet>) {
    let ids = read.get(FluidField::Id).cloned().and_then(|ids| ids.integers());
    let positions = read.get(FluidField::Position).cloned().and_then(|positions| positions.vectors());
    let (Some(ids), Some(positions)) = (ids, positions) else { panic!("fields are missing") };
    let mut particles: Vec<_> = ids.into_iter().zip(positions).collect();
    particles.sort_by_key(|(id, _)| *id);
    jet.0 = particles.into_iter().map(|(_, position)| position).collect();
}

#[test]
fn a_jet_is_even_whatever_of_the_time_is_simulated() {
    for (backend, mode) in ALL {
        let mut test = TestApp::new();
        test.world().init_resource::<Jet>();
        test.world().add_observer(keep);
        let mut settings = FluidDomain::with_spacing(0.1).on(backend).in_mode(mode);
        settings.gravity = Some(Vec3::ZERO);
        // A tick takes nine substeps: more than half of the time is carried over, up to 0.3 s of it ...
        settings.max_substeps = 4;
        let domain = test.spawn(settings);
        test.spawn(jet(5.0));
        test.tick(40);
        let overloaded = test.stats(domain);
        assert!(overloaded.time > 0.1 && overloaded.time < 0.6 * 40.0 / 64.0, "{backend:?} {mode:?}: {overloaded:?}");
        // ... and then made up for, several ticks in one.
        test.change::<FluidDomain>(domain, |domain| domain.max_substeps = 40);
        test.tick(20);
        test.world().entity_mut(domain).insert(FluidReadback::new([FluidField::Id, FluidField::Position]));
        let settled = test.settle(domain);
        assert!((settled.time - 61.0 / 64.0).abs() < 1e-3, "{backend:?} {mode:?}: {settled:?}");

        let layers: Vec<f32> = test.world().resource::<Jet>().0.chunks(3).map(|layer| layer[0].x).collect();
        let gap = 3.0 * 0.1f32.powi(3) / (std::f32::consts::PI * 0.1f32.powi(2));
        for pair in layers.windows(2) {
            assert!(((pair[0] - pair[1]) / gap - 1.0).abs() < 0.05, "{backend:?} {mode:?}: {layers:?}");
        }
        assert!((layers[0] - 2.0 * settled.time as f32).abs() < 0.05, "{backend:?} {mode:?}: {layers:?}");
        assert!(layers.last().is_some_and(|last| *last < gap), "{backend:?} {mode:?}: {layers:?}");
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
