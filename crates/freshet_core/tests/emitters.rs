//! Emitters: however time is split into ticks, the same fluid flows in.

use freshet_core::plan::Plan;
use freshet_core::prelude::*;
use proptest::prelude::*;

fn jet() -> Emitter {
    Emitter {
        center: Vec3::new(0.0, 3.5, 0.0),
        direction: Vec3::new(2.0, 0.0, 0.0),
        radius: 0.1,
        speed: 4.76,
        lifetime: f32::INFINITY,
    }
}

/// Where everything emitted in the ticks would be at their end, m downstream of the disc, layer by layer.
fn layers(emitter: &Emitter, spacing: f32, ticks: &[f64]) -> Vec<f64> {
    let end: f64 = ticks.iter().sum();
    let (mut start, mut layers) = (0.0, Vec::new());
    let direction = emitter.direction.normalize();
    let in_layer = emitter.layer(spacing).len();
    for &duration in ticks {
        let particles = emitter.emit(spacing, start, duration);
        assert_eq!(particles.positions.len(), particles.velocities.len());
        assert_eq!(particles.positions.len() % in_layer, 0);
        for layer in particles.positions.chunks(in_layer) {
            let center = layer.iter().sum::<Vec3>() / in_layer as f32;
            layers.push(f64::from((center - emitter.center).dot(direction)) + f64::from(emitter.speed) * (end - start));
        }
        start += duration;
    }
    layers
}

#[test]
fn a_layer_fills_the_disc_with_a_spacing_between_particles() {
    for direction in [Vec3::X, Vec3::NEG_Y, Vec3::Y, Vec3::new(1.0, -2.0, 3.0)] {
        let emitter = Emitter { direction, ..jet() };
        for spacing in [0.01, 0.03, 0.1, 0.5] {
            let layer = emitter.layer(spacing);
            for (index, a) in layer.iter().enumerate() {
                assert!(a.length() <= emitter.radius * 1.000_01);
                assert!(a.dot(direction.normalize()).abs() < 1e-6);
                assert!(layer[..index].iter().all(|b| a.distance(*b) > 0.999 * spacing));
            }
            // The lattice's share of the disc is off by about its rim, 2 pi r d.
            let (area, rim) = (std::f32::consts::PI * 0.01, std::f32::consts::TAU * 0.1 * spacing);
            assert!((layer.len() as f32 * spacing * spacing - area).abs() < rim.max(spacing * spacing), "{spacing}");
            assert!(layer.iter().sum::<Vec3>().length() < 1e-5, "centred");
        }
        assert_eq!(emitter.layer(1.0), [Vec3::ZERO]);
    }
}

#[test]
fn particles_start_upstream_with_the_speed_of_the_flow() {
    let emitter = jet();
    let (spacing, start, duration) = (0.02, 0.37, 1.0 / 60.0);
    let particles = emitter.emit(spacing, start, duration);
    // 4.76/60/0.02 = 3.97 layers.
    assert!([3, 4].contains(&(particles.positions.len() / emitter.layer(spacing).len())));
    assert_eq!(particles.lifetime, f32::INFINITY);
    for (position, velocity) in particles.positions.iter().zip(&particles.velocities) {
        assert!((*velocity - Vec3::new(4.76, 0.0, 0.0)).length() < 1e-6);
        let upstream = -position.x;
        assert!(upstream > -1e-5 && upstream < 4.76 * duration as f32 + 1e-5, "{upstream}");
    }
    assert!(emitter.emit(spacing, start, 0.0).positions.is_empty());
}

#[test]
fn a_run_sends_what_its_emitters_make() {
    let emitter = Emitter { lifetime: 1.0, ..jet() };
    let scene = FluidScene { emitters: vec![emitter.clone(), emitter.clone()], ..FluidScene::with_spacing(0.05) };
    let plan = Plan::new(&scene).unwrap();
    let mut run = SceneRun::new();
    let mut spawned = 0;
    for tick in 0..120 {
        let input = run.next(&plan, 1.0 / 60.0, Vec::new());
        assert_eq!(input.tick, tick);
        input.validate(0).unwrap();
        for command in &input.commands {
            let Command::Spawn(particles) = command else { panic!("{command:?}") };
            assert_eq!(particles.lifetime, 1.0);
            spawned += particles.positions.len();
        }
    }
    assert_eq!(spawned, 2 * emitter.emit(0.05, 0.0, run.time()).positions.len());
    assert!((run.time() - 2.0).abs() < 1e-6);
    assert_eq!(run.tick(), 120);
}

#[test]
fn the_count_of_an_emitter_with_absurd_numbers_does_not_overflow() {
    let emitter = Emitter { lifetime: f32::MAX, speed: 1e3, ..jet() };
    assert_eq!(emitter.steady_count(1e-3), Some(u64::MAX));
    assert_eq!(jet().steady_count(1e-3), None);
    assert!(emitter.check_flow(1e-4).is_err());
    // As many particles a second as there may be in all, and a few less.
    let most = |speed| Emitter { radius: 1e-5, speed, ..jet() }.check_flow(1e-4);
    assert!(most(1e3).is_ok());
    let error = Emitter { radius: 0.1, speed: 1e3, ..jet() }.check_flow(1e-3).unwrap_err().to_string();
    assert!(error.contains("speed: 1000") && error.contains("67108864") && error.contains("3.142e10"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(200) })]

    #[test]
    fn no_layer_is_lost_or_made_twice(
        ticks in proptest::collection::vec(prop_oneof![0.0..0.05f64, Just(1.0 / 60.0), Just(f64::from(1.0f32 / 64.0)), 0.05..1.0f64], 1..80),
        speed in 0.1..20.0f32,
        spacing in 0.02..0.2f32,
    ) {
        let emitter = Emitter { speed, ..jet() };
        let end: f64 = ticks.iter().sum();
        let mut found = layers(&emitter, spacing, &ticks);
        found.sort_by(f64::total_cmp);
        // The first layer crosses at time 0 and the others follow a spacing behind; none that crosses after the end.
        let (length, d) = (f64::from(speed) * end, f64::from(spacing));
        let expected = (length / d).ceil();
        // Rounding may decide about a layer that crosses just at the end.
        prop_assert!((found.len() as f64 - expected).abs() < 0.5 || (length / d - (length / d).round()).abs() < 1e-6);
        for pair in found.windows(2) {
            // Positions are f32: within 1e-6 of some 20 m.
            prop_assert!((pair[1] - pair[0] - d).abs() < 1e-4, "{pair:?}");
        }
        if let Some(first) = found.last() {
            prop_assert!((first - length).abs() < 1e-4);
        }
    }

    #[test]
    fn the_flow_is_density_times_area_times_speed(speed in 0.1..20.0f32, spacing in 0.01..0.1f32, seconds in 1.0..5.0f64) {
        let emitter = Emitter { speed, ..jet() };
        let in_layer = emitter.layer(spacing).len() as f64;
        let (rest_density, d) = (1000.0, f64::from(spacing));
        let mass = emitter.emit(spacing, 0.0, seconds).positions.len() as f64 * rest_density * d.powi(3);
        let flow = rest_density * in_layer * d * d * f64::from(speed);
        // To within one layer.
        prop_assert!((mass - flow * seconds).abs() <= rest_density * in_layer * d.powi(3) * 1.001);
    }

    #[test]
    fn never_more_are_alive_than_the_steady_count(
        ticks in proptest::collection::vec(prop_oneof![0.001..0.03f64, 0.001..1.0f64], 1..80),
        lifetime in 0.01..3.0f32,
        speed in 0.1..20.0f32,
    ) {
        let emitter = Emitter { speed, lifetime, radius: 0.01, ..jet() };
        let spacing = 0.05;
        let most = emitter.steady_count(spacing).unwrap() as usize;
        let (mut start, mut alive) = (0.0, Vec::new());
        for duration in ticks {
            alive.retain(|&(born, _)| born + f64::from(lifetime) > start);
            alive.push((start, emitter.emit(spacing, start, duration).positions.len()));
            let count: usize = alive.iter().map(|(_, count)| count).sum();
            prop_assert!(count <= most, "{count} > {most}");
            start += duration;
        }
    }
}
