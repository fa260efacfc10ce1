//! Each stability aid in a case that fails without it.

mod common;

use common::{run, solver};
use freshet_core::prelude::*;

/// Two blocks of 0.3 m that meet head on at twice the speed of sound each, without weight and without viscosity; one's lattice is half a
/// spacing off the other's, so that particles come upon gaps. By symmetry nothing of a fluid crosses the plane in the middle.
fn colliding_blocks(xsph: f32) -> FluidScene {
    let off = Vec3::new(0.0, 0.005, 0.005);
    let block = |side: f32| Volume {
        velocity: Vec3::X * -2.0 * side,
        hydrostatic: false,
        ..Volume::block(Vec3::splat(0.15), side * (Vec3::X * 0.16 + off))
    };
    let mut scene =
        FluidScene { gravity: Vec3::ZERO, volumes: vec![block(-1.0), block(1.0)], ..FluidScene::with_spacing(0.02) };
    scene.settings.sound_speed = Some(1.0);
    scene.settings.allow_compressible = true;
    scene.settings.artificial_viscosity = 0.0;
    scene.settings.xsph = xsph;
    scene
}

/// The share of particles that are more than a spacing beyond the middle after 0.05 s, and where the centre of mass is, m.
fn penetration(scene: &FluidScene) -> (f32, Vec3) {
    let mut solver = solver(scene, 2);
    run(&mut solver, 3);
    let (spacing, first) = (solver.plan().parameters.spacing, solver.plan().volume_ids[1].0);
    let snapshot = solver.snapshot().unwrap();
    let beyond = |(&id, x): (&u32, &Vec3)| if id < first { x.x > spacing } else { -x.x > spacing };
    let many = snapshot.ids.iter().zip(&snapshot.positions).filter(|&one| beyond(one)).count();
    let center = snapshot.positions.iter().sum::<Vec3>() / snapshot.ids.len() as f32;
    (many as f32 / snapshot.ids.len() as f32, center)
}

/// Monaghan 1989, "On the problem of penetration in particle methods".
#[test]
fn xsph_keeps_streams_that_meet_from_passing_through_each_other() {
    let (without, _) = penetration(&colliding_blocks(0.0));
    let (half, _) = penetration(&colliding_blocks(0.5));
    let (with, center) = penetration(&colliding_blocks(1.0));
    assert!(without > 0.1, "without it {without} of the particles are on the wrong side");
    assert!(half < 0.3 * without, "with half of it {half}, without {without}");
    assert!(with < 0.02, "with it {with}");
    assert!(center.length() < 1e-4, "pairs move as much to one side as to the other: {center}");
}

/// What XSPH moves particles by is no part of what the pressures are solved for; the next substep finds what it did to densities.
#[test]
fn an_incompressible_fluid_with_xsph_is_compressed_less_than_twice_as_much_as_without() {
    let compression = |xsph: f32| {
        let mut scene = FluidScene {
            volumes: vec![Volume::block(Vec3::splat(0.2), Vec3::splat(0.2))],
            boundaries: vec![Boundary::open_box(Vec3::new(0.8, 0.8, 0.4), Vec3::new(0.4, 0.4, 0.2))],
            ..FluidScene::with_spacing(0.04)
        };
        scene.settings.pressure_solver = PressureSolver::DivergenceFree(DivergenceFree::default());
        scene.settings.xsph = xsph;
        let mut solver = solver(&scene, 2);
        let reports = run(&mut solver, 60);
        assert_eq!(reports.iter().map(|report| report.removed + report.unsolved).sum::<u32>(), 0);
        reports.iter().map(|report| report.mean_compression).sum::<f32>() / reports.len() as f32
    };
    let (without, with) = (compression(0.0), compression(0.5));
    assert!(with < 2.0 * without && with < 3e-3, "{with} with, {without} without");
}
