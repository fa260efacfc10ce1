//! Emitters: however time is split into ticks, and whatever of it is simulated, the same fluid flows in.

use std::f64::consts::PI;

use freshet_core::emitter::EmitterFlow;
use freshet_core::plan::Plan;
use freshet_core::prelude::*;
use freshet_core::run::SimulatedClock;
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

/// When the layers of a list cross the disc, s.
fn times(layers: &[NewParticles]) -> Vec<f64> {
    layers.iter().filter_map(|layer| layer.at).collect()
}

/// Distance between layers, m.
fn gap(emitter: &Emitter, spacing: f32) -> f64 {
    emitter.interval(spacing) * f64::from(emitter.speed)
}

#[test]
fn a_layer_fills_the_disc_with_a_spacing_between_particles() {
    for direction in [Vec3::X, Vec3::NEG_Y, Vec3::Y, Vec3::new(1.0, -2.0, 3.0)] {
        let emitter = Emitter { direction, ..jet() };
        for spacing in [0.01, 0.03, 0.1, 0.5] {
            let layer = emitter.layer(spacing);
            for (index, a) in layer.iter().enumerate() {
                assert!(a.length() <= emitter.radius + 0.23 * spacing);
                assert!(a.dot(direction.normalize()).abs() < 1e-6);
                assert!(layer[..index].iter().all(|b| a.distance(*b) > 0.999 * spacing));
            }
            assert!(layer.iter().sum::<Vec3>().length() < 1e-6 * layer.len() as f32, "centred");
        }
        assert_eq!(emitter.layer(1.0), [Vec3::ZERO]);
    }
}

#[test]
fn the_flow_is_that_of_the_disc_whatever_its_radius_and_nothing_is_too_near() {
    let (spacing, speed) = (0.05f32, 2.0f32);
    for step in 0..400 {
        let ratio = 0.05 + 0.05 * step as f32;
        let emitter = Emitter { radius: ratio * spacing, speed, ..jet() };
        let layer = emitter.layer(spacing);
        // In each interval a layer comes in, whose particles stand for d^3.
        let flow = layer.len() as f64 * f64::from(spacing).powi(3) / emitter.interval(spacing);
        let wanted = PI * f64::from(emitter.radius).powi(2) * f64::from(speed);
        assert!((flow / wanted - 1.0).abs() < 1e-6, "r = {ratio} d: {flow} m3/s, not {wanted}");
        // Behind each particle the next is a gap away; within a layer they are a spacing apart.
        let gap = gap(&emitter, spacing) / f64::from(spacing);
        assert!(gap > 0.8499, "r = {ratio} d: layers are {gap} d apart");
        if ratio >= 2.0 {
            assert!((gap - 1.0).abs() < 0.04, "r = {ratio} d: layers are {gap} d apart");
        }
        let reach = layer.iter().map(|point| point.length()).fold(0.0, f32::max);
        assert!(reach < (ratio + 0.22) * spacing, "r = {ratio} d: a particle {} d from the axis", reach / spacing);
        for (index, a) in layer.iter().enumerate() {
            assert!(layer[..index].iter().all(|b| a.distance(*b) > 0.999 * spacing), "r = {ratio} d");
        }
        // The layer covers the disc: its second moment is the disc's, from where there are enough particles for that.
        let moment = layer.iter().map(|point| f64::from(point.length_squared())).sum::<f64>() / layer.len() as f64;
        let of_disc = f64::from(emitter.radius).powi(2) / 2.0;
        assert!(ratio < 2.0 || (moment / of_disc - 1.0).abs() < 0.05, "r = {ratio} d: {moment}, not {of_disc}");
    }
}

#[test]
fn layers_lie_in_the_disc_at_the_time_they_say_with_the_speed_of_the_flow() {
    let (emitter, spacing) = (jet(), 0.02);
    let mut flow = EmitterFlow::new(0.37);
    let span = 0.37..0.37 + 1.0 / 60.0;
    let layers = emitter.layers(spacing, &mut flow, &span);
    // 4.76/60/0.02 = 3.97 layers.
    assert_eq!(layers.len(), 4);
    assert_eq!(layers[0].at, Some(0.37), "the first one at once");
    for layer in &layers {
        assert!(span.contains(&layer.at.unwrap()));
        assert_eq!(layer.lifetime, f32::INFINITY);
        assert_eq!(layer.positions.len(), layer.velocities.len());
        for (position, point) in layer.positions.iter().zip(emitter.layer(spacing)) {
            assert!((*position - emitter.center).distance(point) < 1e-6 && position.x.abs() < 1e-6);
        }
        assert!(layer.velocities.iter().all(|velocity| (*velocity - Vec3::X * 4.76).length() < 1e-6));
    }
    assert!(emitter.layers(spacing, &mut flow, &span).is_empty(), "each is sent once");
}

#[test]
fn a_new_speed_or_a_pause_leaves_room_behind_the_last_layer() {
    let (slow, spacing) = (Emitter { speed: 1.0, ..jet() }, 0.05);
    let (interval, mut flow) = (slow.interval(spacing), EmitterFlow::new(0.0));
    // The last of these is hardly out when the speed changes.
    let before = times(&slow.layers(spacing, &mut flow, &(0.0..4.01 * interval)));
    assert_eq!(before.len(), 5);
    let fast = Emitter { speed: 3.0, ..jet() };
    let after = times(&fast.layers(spacing, &mut flow, &(4.01 * interval..6.0 * interval)));
    assert!((after[0] - 5.0 * interval).abs() < 1e-9, "{after:?}");
    assert!((after[1] - after[0] - interval / 3.0).abs() < 1e-9, "{after:?}");

    // Switched off for less than an interval it stays in phase, for longer it starts when it is switched on.
    let next = after.last().unwrap() + interval / 3.0;
    flow.pause(next - 1e-3);
    assert!((times(&fast.layers(spacing, &mut flow, &(next..next + 1e-3)))[0] - next).abs() < 1e-9);
    flow.pause(next + 10.0);
    let again = times(&fast.layers(spacing, &mut flow, &(next + 10.0..next + 10.0 + 1e-3)));
    assert_eq!(again, [next + 10.0]);
}

#[test]
fn a_run_sends_what_its_emitters_make() {
    let emitter = Emitter { lifetime: 1.0, ..jet() };
    let scene = FluidScene { emitters: vec![emitter.clone(), emitter.clone()], ..FluidScene::with_spacing(0.05) };
    let plan = Plan::new(&scene).unwrap();
    let mut run = SceneRun::new();
    let mut sent = Vec::new();
    for tick in 0..120 {
        let input = run.next(&plan, 1.0 / 60.0, Vec::new());
        assert_eq!(input.tick, tick);
        input.validate(0).unwrap();
        for command in input.commands {
            let Command::Spawn(particles) = command else { panic!("{command:?}") };
            assert_eq!(particles.lifetime, 1.0);
            sent.push(particles);
        }
        run.hear(&StepReport { tick, simulated: f64::from(1.0f32 / 60.0), ..StepReport::default() });
    }
    let all = emitter.layers(0.05, &mut EmitterFlow::new(0.0), &(0.0..run.time()));
    assert_eq!(sent.len(), 2 * all.len());
    assert!(all.iter().all(|layer| sent.iter().filter(|other| *other == layer).count() == 2));
    assert!((run.time() - 2.0).abs() < 1e-6);
    assert_eq!(run.tick(), 120);
}

#[test]
fn a_run_continues_in_phase_from_a_snapshot() {
    let other = Emitter { speed: 1.3, center: Vec3::ZERO, ..jet() };
    let scene = FluidScene {
        emitters: vec![Emitter { lifetime: 1.0, ..jet() }, Emitter { lifetime: 1.0, ..other }],
        ..FluidScene::with_spacing(0.05)
    };
    let plan = Plan::new(&scene).unwrap();
    // Ticks cover less than they are asked to, so that layers have been sent ahead.
    let duration = 1.0f32 / 30.0;
    let tick = |run: &mut SceneRun| {
        let input = run.next(&plan, duration, Vec::new());
        run.hear(&StepReport { tick: input.tick, simulated: 0.6 * f64::from(duration), ..StepReport::default() });
        input
    };
    for before in [0, 1, 7, 50] {
        let mut whole = SceneRun::new();
        let commands: Vec<Command> = (0..before).flat_map(|_| tick(&mut whole).commands).collect();
        let at = |command: &Command| if let Command::Spawn(particles) = command { particles.at } else { None };
        let emitted = commands.iter().filter_map(at).reduce(f64::max);
        let snapshot = Snapshot { tick: whole.tick(), time: whole.time(), emitted, ..Snapshot::default() };
        let mut resumed = SceneRun::resume(&snapshot);
        for _ in 0..40 {
            assert_eq!(tick(&mut resumed), tick(&mut whole), "after {before} ticks");
        }
    }
}

#[test]
fn the_count_of_an_emitter_with_absurd_numbers_does_not_overflow() {
    let emitter = Emitter { lifetime: f32::MAX, speed: 1e3, ..jet() };
    assert_eq!(emitter.steady_count(1e-3), Some(u64::MAX));
    assert_eq!(jet().steady_count(1e-3), None);
    assert!(emitter.check_flow(1e-4).is_err());
    // pi/100 of a particle in each spacing: it drips.
    let drip = Emitter { radius: 1e-5, speed: 1e3, ..jet() };
    assert!(drip.check_flow(1e-4).is_ok());
    assert!((gap(&drip, 1e-4) / 1e-4 - 100.0 / PI).abs() < 1e-3);
    let error = Emitter { radius: 0.1, speed: 1e3, ..jet() }.check_flow(1e-3).unwrap_err().to_string();
    let broad = Emitter { radius: 1e3, speed: 1e-3, ..jet() }.check_flow(0.1).unwrap_err().to_string();
    assert!(broad.contains("radius: 1000") && broad.contains("67108864") && broad.contains("3.142e8"), "{broad}");
    assert!(error.contains("speed: 1000") && error.contains("67108864") && error.contains("3.142e10"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(200) })]

    #[test]
    fn no_layer_is_lost_or_made_twice_whatever_is_simulated_and_known(
        ticks in proptest::collection::vec((
            prop_oneof![0.0..0.05f32, Just(1.0 / 60.0), Just(1.0 / 64.0), 0.05..1.0f32],
            0.0..2.0f64,
            0..4usize,
        ), 1..80),
        speed in 0.1..20.0f32,
        spacing in 0.02..0.2f32,
    ) {
        let emitter = Emitter { speed, ..jet() };
        let (mut clock, mut flow) = (SimulatedClock::default(), EmitterFlow::new(0.0));
        let (mut late, mut simulated, mut found, mut end) = (Vec::new(), 0.0, Vec::new(), 0.0);
        for (tick, (duration, covered, latency)) in ticks.into_iter().enumerate() {
            while late.len() > latency {
                clock.hear(&late.remove(0));
            }
            let span = clock.span(duration);
            prop_assert!(span.end <= simulated + f64::from(StepInput::MAX_DURATION), "ahead of time by more than a second");
            end = f64::max(end, span.end);
            found.extend(times(&emitter.layers(spacing, &mut flow, &span)));
            clock.send(tick as u64, duration);
            let covered = f64::from(duration) * covered;
            simulated += covered;
            late.push(StepReport { tick: tick as u64, simulated: covered, ..StepReport::default() });
        }
        let interval = emitter.interval(spacing);
        // One layer at each multiple of the interval up to the end, and no other.
        prop_assert!(found.iter().enumerate().all(|(index, at)| *at == index as f64 * interval), "{found:?}");
        prop_assert!(found.last().is_none_or(|last| *last < end) && found.len() as f64 * interval >= end);
    }

    #[test]
    fn never_more_are_alive_than_the_steady_count(
        ticks in proptest::collection::vec((prop_oneof![0.001..0.03f32, 0.001..1.0f32], 0.2..1.5f64), 1..80),
        lifetime in 0.01..3.0f32,
        speed in 0.1..20.0f32,
    ) {
        let emitter = Emitter { speed, lifetime, radius: 0.06, ..jet() };
        let spacing = 0.05;
        let most = emitter.steady_count(spacing).unwrap() as usize;
        let (mut clock, mut flow) = (SimulatedClock::default(), EmitterFlow::new(0.0));
        let mut alive: Vec<NewParticles> = Vec::new();
        for (tick, (duration, covered)) in ticks.into_iter().enumerate() {
            // Those whose time is over retire in the substep after it.
            alive.retain(|layer| layer.at.unwrap() + f64::from(lifetime) > clock.time());
            alive.extend(emitter.layers(spacing, &mut flow, &clock.span(duration)));
            let count: usize = alive.iter().map(|layer| layer.positions.len()).sum();
            prop_assert!(count <= most, "{count} > {most}");
            clock.send(tick as u64, duration);
            let simulated = covered * f64::from(duration);
            clock.hear(&StepReport { tick: tick as u64, simulated, ..StepReport::default() });
        }
    }
}
