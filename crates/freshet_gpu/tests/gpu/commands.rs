//! Spawning, removing, lifetimes, capacity.

use freshet_core::prelude::*;

use crate::common::{dam_break, device, solver, tick, tick_with};

fn cloud(count: usize, corner: Vec3, lifetime: f32) -> Command {
    let edge = (count as f32).cbrt().ceil() as usize;
    let place =
        |i: usize| corner + 0.05 * Vec3::new((i % edge) as f32, (i / edge % edge) as f32, (i / edge / edge) as f32);
    Command::Spawn(NewParticles {
        positions: (0..count).map(place).collect(),
        velocities: vec![Vec3::ZERO; count],
        lifetime,
        at: None,
    })
}

/// Without gravity or walls: nothing moves unless pushed.
fn empty(max_particles: u32) -> FluidScene {
    FluidScene {
        gravity: Vec3::ZERO,
        settings: Settings {
            max_particles: Some(max_particles),
            expected_speed: Some(1.0),
            bounds: Some((Vec3::splat(-50.0), Vec3::splat(50.0))),
            ..Default::default()
        },
        ..FluidScene::with_spacing(0.05)
    }
}

#[test]
fn spawned_particles_get_the_next_ids_in_order() {
    let mut solver = solver(&empty(5000));
    let report = solver.step(&tick(0, 0.001)).unwrap();
    assert_eq!((report.particles, report.time_scale), (0, 1.0));
    let commands = vec![cloud(30, Vec3::ZERO, f32::INFINITY), cloud(20, Vec3::X * 3.0, f32::INFINITY)];
    let report = solver.step(&tick_with(1, 0.001, commands)).unwrap();
    assert_eq!((report.particles, report.refused), (50, 0));
    let snapshot = solver.snapshot().unwrap();
    assert!(snapshot.ids.iter().copied().eq(0..50));
    assert_eq!(snapshot.next_id, 50);
    assert!((snapshot.positions[30].x - 3.0).abs() < 0.01, "the second spawn comes second");
}

#[test]
fn commands_are_carried_out_in_order() {
    let mut solver = solver(&empty(5000));
    let everything = Command::RemoveInBox { min: Vec3::splat(-1.0), max: Vec3::splat(10.0) };
    let commands = vec![
        cloud(10, Vec3::ZERO, f32::INFINITY),
        everything,
        cloud(10, Vec3::ZERO, f32::INFINITY),
        Command::RemoveIds { first: 12, count: 3 },
    ];
    let report = solver.step(&tick_with(0, 0.001, commands)).unwrap();
    assert_eq!((report.particles, report.retired, report.removed), (7, 13, 0));
    let ids = solver.snapshot().unwrap().ids;
    assert_eq!(ids, [10, 11, 15, 16, 17, 18, 19], "ids stay with their particles");
}

#[test]
fn lifetimes_run_out() {
    let mut solver = solver(&empty(5000));
    let commands = vec![cloud(8, Vec3::ZERO, 0.015), cloud(5, Vec3::X * 3.0, f32::INFINITY)];
    solver.step(&tick_with(0, 0.01, commands)).unwrap();
    let lives = solver.read(Field::RemainingLife).unwrap().scalars().unwrap();
    assert_eq!(lives.iter().filter(|life| (**life - 0.005).abs() < 1e-6).count(), 8);
    let first = solver.step(&tick(1, 0.01)).unwrap();
    let second = solver.step(&tick(2, 0.01)).unwrap();
    assert_eq!(first.retired + second.retired, 8);
    assert_eq!(second.particles, 5);
}

#[test]
fn new_particles_are_put_where_they_are_when_the_tick_begins() {
    let mut solver = solver(&empty(5000));
    solver.step(&tick(0, 0.25)).unwrap();
    let new = |x: f32, at| {
        Command::Spawn(NewParticles {
            positions: vec![Vec3::X * x],
            velocities: vec![Vec3::Y * 4.0],
            lifetime: 1.0,
            at,
        })
    };
    // Of the 0.25 s of each of these two nothing is known when the commands are given.
    solver.prepare(&device().queue, &tick(1, 0.25)).unwrap();
    solver.prepare(&device().queue, &tick(2, 0.25)).unwrap();
    let commands = vec![new(0.0, None), new(1.0, Some(0.5)), new(2.0, Some(1.0)), new(3.0, None), new(4.0, Some(-2.0))];
    solver.prepare(&device().queue, &tick_with(3, 0.0, commands)).unwrap();
    // The last one's time was over when it came.
    let report = solver.step(&tick(4, 0.0)).unwrap();
    let late = solver.collect(&device().device).unwrap();
    assert_eq!((report.particles, late[2].tick, late[2].retired), (4, 3, 1));
    let state = solver.snapshot().unwrap();
    let wanted = [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0), Vec3::new(2.0, -1.0, 0.0), Vec3::X * 3.0];
    for (index, (position, life)) in wanted.into_iter().zip([1.0, 0.75, 1.25, 1.0]).enumerate() {
        // The clock counts in 6e-8 s, and the substeps of a tick add up to within rounding.
        assert!(state.positions[index].distance(position) < 1e-5, "{index}: {}", state.positions[index]);
        assert!((state.remaining_lives[index] - life).abs() < 1e-5, "{index}: {}", state.remaining_lives[index]);
    }
    assert_eq!(state.emitted, Some(1.0));
    // A restored solver is at the snapshot's time.
    solver.restore(&state).unwrap();
    solver.step(&tick_with(5, 0.0, vec![new(5.0, Some(0.75))])).unwrap();
    let last = *solver.snapshot().unwrap().positions.last().unwrap();
    assert!(last.distance(Vec3::X * 5.0) < 1e-5, "{last}");
}

#[test]
fn beyond_the_capacity_spawns_are_refused_and_counted() {
    let mut solver = solver(&empty(100));
    let report = solver.step(&tick_with(0, 0.001, vec![cloud(70, Vec3::ZERO, f32::INFINITY)])).unwrap();
    assert_eq!((report.particles, report.refused), (70, 0));
    let report = solver.step(&tick_with(1, 0.001, vec![cloud(70, Vec3::X * 5.0, f32::INFINITY)])).unwrap();
    assert_eq!((report.particles, report.refused), (100, 40));
    assert_eq!(solver.snapshot().unwrap().next_id, 100);
    let report = solver.step(&tick(2, 0.001)).unwrap();
    assert_eq!((report.particles, report.refused), (100, 0), "counted in their own tick only");
}

#[test]
fn gravity_is_set_from_the_tick_on() {
    let mut solver = solver(&empty(100));
    let commands = vec![cloud(1, Vec3::ZERO, f32::INFINITY), Command::SetGravity(Vec3::X * 2.0)];
    solver.step(&tick_with(0, 0.01, commands)).unwrap();
    solver.step(&tick(1, 0.01)).unwrap();
    let velocity = solver.snapshot().unwrap().velocities[0];
    assert!((velocity - Vec3::X * 0.04).length() < 1e-6, "{velocity}");
    assert_eq!(solver.snapshot().unwrap().gravity, Vec3::X * 2.0);
}

#[test]
fn memory_grows_with_spawns_and_shrinks_after_removal() {
    let mut solver = solver(&empty(100_000));
    let small = solver.schedule().capacity;
    let mut total = 0;
    for n in 0..4 {
        let corner = Vec3::new(3.0 * n as f32 - 10.0, 0.0, 0.0);
        total += 1500;
        let report = solver.step(&tick_with(n, 1e-4, vec![cloud(1500, corner, f32::INFINITY)])).unwrap();
        assert_eq!((report.particles, report.refused), (total, 0));
    }
    let large = solver.schedule().capacity;
    assert!((6000..16_000).contains(&large) && large > small, "{small} {large}");
    let snapshot = solver.snapshot().unwrap();
    assert!(snapshot.ids.iter().copied().eq(0..6000), "growing keeps every particle");

    let report = solver.step(&tick_with(4, 1e-4, vec![Command::RemoveIds { first: 100, count: 5900 }])).unwrap();
    assert_eq!((report.particles, report.retired), (100, 5900));
    for n in 5..12 {
        assert_eq!(solver.step(&tick(n, 1e-4)).unwrap().particles, 100);
    }
    assert_eq!(solver.schedule().capacity, small);
    assert!(solver.snapshot().unwrap().ids.iter().copied().eq(0..100), "shrinking keeps every particle");
}

#[test]
fn spawning_with_ticks_in_flight_gives_what_lockstep_gives() {
    let inputs: Vec<StepInput> = (0..6)
        .map(|n| tick_with(n, 0.002, vec![cloud(700, Vec3::new(3.0 * n as f32 - 10.0, 0.0, 0.0), f32::INFINITY)]))
        .collect();
    let mut lockstep = solver(&empty(3000));
    let wanted: Vec<u32> = inputs.iter().map(|input| lockstep.step(input).unwrap().refused).collect();
    assert_eq!(wanted, [0, 0, 0, 0, 500, 700]);

    let mut pipelined = solver(&empty(3000));
    let opened = device();
    let mut reports = Vec::new();
    for input in &inputs {
        pipelined.prepare(&opened.queue, input).unwrap();
        let mut encoder = opened.device.create_command_encoder(&Default::default());
        pipelined.encode(&mut encoder).unwrap();
        opened.queue.submit([encoder.finish()]);
        reports.extend(pipelined.collect(&opened.device).unwrap());
    }
    while pipelined.ticks_in_flight() > 0 {
        reports.extend(pipelined.collect(&opened.device).unwrap());
    }
    assert_eq!(reports.iter().map(|report| report.refused).collect::<Vec<_>>(), wanted);
    assert!(pipelined.snapshot().unwrap() == lockstep.snapshot().unwrap());
}

#[test]
fn a_snapshot_brings_back_the_same_future() {
    let mut solver = solver(&dam_break(0.05));
    solver.step(&tick(0, 1.0 / 60.0)).unwrap();
    let saved = solver.snapshot().unwrap();
    solver.step(&tick(1, 1.0 / 60.0)).unwrap();
    let wanted = solver.snapshot().unwrap();
    solver.restore(&saved).unwrap();
    assert!(solver.snapshot().unwrap() == saved);
    solver.step(&tick(1, 1.0 / 60.0)).unwrap();
    assert!(solver.snapshot().unwrap() == wanted);
}
