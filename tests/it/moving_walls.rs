//! Walls that move push the fluid with their own velocity, and nothing is planned anew while they do.

use std::f32::consts::TAU;

use bevy::mesh::PrimitiveTopology;
use bevy::prelude::*;
use bevy_freshet::prelude::*;

use crate::components::positions;
use crate::harness::{ALL, TestApp};

/// How a wall moves by itself.
#[derive(Component, Clone, Copy)]
struct Moves {
    /// m/s.
    way: Vec3,
    /// rad/s about z.
    turn: f32,
}

fn moving_app() -> TestApp {
    TestApp::with(|app| {
        let step = |time: Res<Time>, mut walls: Query<(&mut Transform, &Moves)>| {
            let seconds = time.delta_secs();
            for (mut pose, moves) in &mut walls {
                pose.translation += seconds * moves.way;
                pose.rotate_z(seconds * moves.turn);
            }
        };
        app.add_systems(FixedUpdate, step.before(FreshetSystems::Plan));
    })
}

const SPACING: f32 = 0.1;

/// A channel 0.5 m wide with a lid, and a block of water of 5 x 4 x 5 particles in it.
fn channel(test: &mut TestApp, (backend, mode): (FluidBackend, FluidMode)) -> Entity {
    let mut domain = FluidDomain { count_leaks: true, ..FluidDomain::with_spacing(SPACING).on(backend).in_mode(mode) };
    domain.settings.expected_speed = Some(6.0);
    let domain = test.spawn(domain);
    test.spawn((FluidContainer::closed_box(3.0, 0.5, 0.5), Transform::from_xyz(1.5, 0.25, 0.25)));
    test.spawn((FluidVolume::from(Cuboid::new(0.5, 0.4, 0.5)), Transform::from_xyz(0.65, 0.2, 0.25)));
    domain
}

/// Mean of positions.
fn mean(points: &[Vec3]) -> Vec3 {
    points.iter().sum::<Vec3>() / points.len() as f32
}

/// Mean energy above the floor, J/kg.
fn energy(State { positions, velocities }: &State) -> f32 {
    let of = |(x, v): (&Vec3, &Vec3)| 0.5 * v.length_squared() + 9.81 * x.y;
    positions.iter().zip(velocities).map(of).sum::<f32>() / positions.len() as f32
}

/// Mean velocity over the next tick, m/s; reads twice.
fn velocity(test: &mut TestApp, domain: Entity) -> Vec3 {
    let before = mean(&positions(test, domain));
    (mean(&positions(test, domain)) - before) * 64.0
}

/// Thin walls of any kind that fill the channel's cross section, with their thin side along x.
fn pistons(test: &mut TestApp) -> Vec<(&'static str, FluidBoundary)> {
    let slab = Cuboid::new(SPACING, 0.5, 0.5);
    let mut meshes = test.world().resource_mut::<Assets<Mesh>>();
    let mesh = meshes.add(Mesh::from(slab));
    // Open: one rectangle, turned so that it stands across the channel.
    let mut sheet = Mesh::new(PrimitiveTopology::TriangleList, default());
    let corners = [[0.0, -0.25, -0.25], [0.0, 0.25, -0.25], [0.0, 0.25, 0.25], [0.0, -0.25, 0.25]];
    let soup = [0, 1, 2, 0, 2, 3].map(|corner: usize| corners[corner]).to_vec();
    sheet.insert_attribute(Mesh::ATTRIBUTE_POSITION, soup);
    let sheet = meshes.add(sheet);
    vec![
        ("box", FluidBoundary::from(slab)),
        ("mesh", FluidBoundary::mesh(mesh.clone())),
        ("hull", FluidBoundary::convex_hull(mesh)),
        ("sheet", FluidBoundary::mesh(sheet)),
    ]
}

#[test]
fn a_piston_pushes_fluid_along_and_lets_it_alone_when_it_stops() {
    for (backend, mode) in ALL {
        let count = pistons(&mut TestApp::new()).len();
        for index in 0..count {
            if mode == FluidMode::Pipelined && index > 0 {
                continue;
            }
            let mut test = moving_app();
            let domain = channel(&mut test, (backend, mode));
            let (kind, boundary) = pistons(&mut test).swap_remove(index);
            let piston = test.spawn((boundary.moving(), Transform::from_xyz(0.25, 0.25, 0.25)));
            test.tick(8);
            let start = mean(&positions(&mut test, domain));
            let plannings = test.stats(domain).plannings;
            // 1 m at 2 m/s, faster than water waves run away from it in so shallow a channel.
            let way = Vec3::X * 2.0;
            test.world().entity_mut(piston).insert(Moves { way, turn: 0.0 });
            test.tick(31);
            let State { positions: place, velocities } = state(&mut test, domain);
            let face = test.world().get::<Transform>(piston).unwrap().translation.x;
            let pushed = mean(&velocities);
            println!("{backend:?} {mode:?} {kind}: {pushed} {start} {} {face}", mean(&place));
            // None gets slower than the piston for good, and what it hits elastically gets twice as fast.
            assert!(pushed.x > 1.9 && pushed.x < 4.0, "{backend:?} {kind}: pushed with 2 m/s, it flows with {pushed}");
            let at_piston: Vec<Vec3> = place
                .iter()
                .zip(&velocities)
                .filter(|(place, _)| place.x < face + 2.5 * SPACING)
                .map(|(_, velocity)| *velocity)
                .collect();
            let speed = mean(&at_piston).x;
            assert!(
                !at_piston.is_empty() && (speed - 2.0).abs() < 0.2,
                "{backend:?} {kind}: {speed} m/s at the piston"
            );
            // 0.1 m3 in a channel of 0.25 m2 are 0.4 m long at least, with their middle half of that before the piston's face.
            let ahead = mean(&place).x - face - 0.5 * SPACING;
            assert!(ahead > 0.19, "{backend:?} {kind}: the water is {ahead} m ahead");
            let behind = place.iter().filter(|place| place.x < face).count();
            assert_eq!(behind, 0, "{backend:?} {kind}: particles behind the piston at {face}");
            // It stops: walls that stand do no work, and splashes use up most of what energy there is; with 0.12 m of water 0.6 J/kg remain at rest.
            test.world().entity_mut(piston).remove::<Moves>();
            test.tick(1);
            let before = energy(&state(&mut test, domain));
            test.tick(64);
            let later = energy(&state(&mut test, domain));
            println!("{backend:?} {mode:?} {kind}: {before} J/kg, {later} J/kg a second later");
            assert!(
                later < 0.4 * before,
                "{backend:?} {kind}: it stands, and the fluid has {later} J/kg after {before}"
            );
            let stats = test.settle(domain);
            assert_eq!(stats.plannings, plannings, "{backend:?} {kind}");
            assert_eq!((stats.leaks, stats.removed, stats.particles), (Some(0), 0, 100), "{backend:?} {kind}");
            assert!(stats.max_speed < 8.0 && stats.max_compression < 0.2, "{backend:?} {kind}: {stats:?}");
            test.expect_no_complaints();
        }
    }
}

#[test]
fn a_piston_raises_the_level_by_what_it_displaces() {
    for choice in [ALL[0], ALL[2]] {
        let mut test = moving_app();
        let domain =
            FluidDomain { count_leaks: true, ..FluidDomain::with_spacing(SPACING).on(choice.0).in_mode(choice.1) };
        let domain = test.spawn(domain);
        // 1.5 m x 0.5 m of water, 0.4 m deep, between the piston and the end of a tank.
        test.spawn((FluidContainer::open_box(2.0, 1.2, 0.5), Transform::from_xyz(1.0, 0.6, 0.25)));
        test.spawn((FluidVolume::from(Cuboid::new(1.5, 0.4, 0.5)), Transform::from_xyz(1.25, 0.2, 0.25)));
        let piston = FluidBoundary::cuboid(0.3, 1.2, 0.5).moving();
        // v = 0.5 m/s for t = 1 s displace v t A = 0.5 m x 0.5 m of ground, of which what is left is 1 m long.
        let piston = test.spawn((piston, Transform::from_xyz(0.35, 0.6, 0.25)));
        test.tick(8);
        let begin = level(&positions(&mut test, domain));
        test.world().entity_mut(piston).insert(Moves { way: Vec3::X * 0.5, turn: 0.0 });
        test.tick(64);
        test.world().entity_mut(piston).remove::<Moves>();
        // Two times to the end and back, of waves at sqrt(g D).
        test.tick(96);
        let end = level(&positions(&mut test, domain));
        println!("{choice:?}: {begin} m, {end} m");
        assert!((begin - 0.4).abs() < 0.01 && (end - 0.6).abs() < 0.015, "{choice:?}: {begin} m, {end} m");
        let stats = test.settle(domain);
        assert_eq!((stats.leaks, stats.removed, stats.particles), (Some(0), 0, 300), "{choice:?}");
        test.expect_no_complaints();
    }
}

/// Depth of water on a floor at zero: its middle is half as high.
fn level(positions: &[Vec3]) -> f32 {
    2.0 * mean(positions).y
}

#[test]
fn a_wall_that_is_moved_for_the_first_time_is_planned_once() {
    for choice in [ALL[0], ALL[2]] {
        let mut test = moving_app();
        let domain = channel(&mut test, choice);
        let piston = test.spawn((FluidBoundary::cuboid(SPACING, 0.5, 0.5), Transform::from_xyz(0.25, 0.25, 0.25)));
        test.tick(8);
        let before = test.settle(domain).plannings;
        assert_eq!(before, 1);
        test.world().entity_mut(piston).insert(Moves { way: Vec3::X * 2.0, turn: 0.0 });
        test.tick(24);
        assert_eq!(test.stats(domain).plannings, before + 1, "{choice:?}");
        let notes = test.stats(domain).notes;
        let named = format!("FluidBoundary of entity {piston} moves because it has been moved (motion: Auto)");
        assert_eq!(notes.iter().filter(|note| note.starts_with(&named)).count(), 1, "{choice:?}: {notes:?}");
        let pushed = velocity(&mut test, domain);
        let front = mean(&positions(&mut test, domain));
        let stats = test.stats(domain);
        println!("{choice:?}: {pushed} {front} {stats:?}");
        assert!(pushed.x > 1.2 && pushed.x < 3.0, "{choice:?}: {pushed}");
        assert_eq!((stats.leaks, stats.removed), (Some(0), 0), "{choice:?}");
        // What stands is put elsewhere, each time by a plan, and pushes nothing.
        test.change::<FluidBoundary>(piston, |wall| wall.motion = FluidWallMotion::Still);
        test.world().entity_mut(piston).remove::<Moves>();
        test.tick(2);
        let before = test.settle(domain).plannings;
        test.change::<Transform>(piston, |pose| pose.translation.x = 0.2);
        test.tick(1);
        test.change::<Transform>(piston, |pose| pose.translation.x = 0.15);
        test.tick(1);
        let stats = test.settle(domain);
        assert_eq!((stats.plannings, stats.leaks), (before + 2, Some(0)), "{choice:?}");
        test.expect_no_complaints();
    }
}

/// Angular momentum of particles of unit mass about the z axis through a centre, m2/s.
fn swirl(test: &mut TestApp, domain: Entity, center: Vec3) -> f32 {
    let State { positions, velocities } = state(test, domain);
    positions.iter().zip(&velocities).map(|(x, v)| (*x - center).cross(*v).z).sum()
}

/// What was read last.
#[derive(Resource, Clone, Default)]
struct State {
    positions: Vec<Vec3>,
    velocities: Vec<Vec3>,
}

fn state(test: &mut TestApp, domain: Entity) -> State {
    if test.world().get_resource::<State>().is_none() {
        test.world().init_resource::<State>();
        test.world().add_observer(|read: On<FluidReadbackComplete>, mut state: ResMut<State>| {
            let get = |field| read.get(field).cloned().and_then(|data| data.vectors()).unwrap_or_default();
            state.positions = get(FluidField::Position);
            state.velocities = get(FluidField::Velocity);
        });
    }
    test.world().entity_mut(domain).insert(FluidReadback::new([FluidField::Position, FluidField::Velocity]));
    test.settle(domain);
    test.world().entity_mut(domain).remove::<FluidReadback>();
    test.world().resource::<State>().clone()
}

#[test]
fn a_paddle_stirs_water_the_way_it_turns() {
    for choice in [ALL[0], ALL[2]] {
        let mut found = Vec::new();
        for turn in [4.0, -4.0] {
            let mut test = moving_app();
            let mut domain =
                FluidDomain { count_leaks: true, ..FluidDomain::with_spacing(SPACING).on(choice.0).in_mode(choice.1) };
            domain.settings.expected_speed = Some(6.0);
            let domain = test.spawn(domain);
            test.spawn((FluidContainer::closed_box(1.2, 1.2, 0.6), Transform::from_xyz(0.6, 0.6, 0.3)));
            test.spawn((FluidVolume::from(Cuboid::new(1.2, 0.8, 0.6)), Transform::from_xyz(0.6, 0.4, 0.3)));
            let center = Vec3::new(0.6, 0.5, 0.3);
            let paddle = (FluidBoundary::cuboid(0.7, SPACING, 0.4).moving(), Transform::from_translation(center));
            test.spawn((paddle, Moves { way: Vec3::ZERO, turn }));
            // Three quarters of a turn.
            test.tick((0.75 * TAU / 4.0 * 64.0) as u32);
            found.push(swirl(&mut test, domain, center));
            let stats = test.settle(domain);
            assert_eq!((stats.plannings, stats.leaks, stats.removed), (1, Some(0), 0), "{choice:?} {stats:?}");
            assert!(stats.max_speed < 8.0, "{choice:?} {stats:?}");
            // Particles of the start that are in the paddle are left out, and said to be.
            let complaints = test.complaints();
            assert!(complaints.iter().all(|said| said.message.contains("left out")), "{complaints:?}");
        }
        println!("{choice:?}: {found:?}");
        let &[with, against] = found.as_slice() else { panic!("two ways") };
        // The paddle's ends make 1.4 m/s; of 500 particles those in its circle, at half of that half way out, have some tens of m2/s.
        assert!(with > 10.0 && against < -10.0, "{choice:?}: {with} {against}");
    }
}

#[test]
fn a_cup_carries_water_tilts_and_pours_it_out() {
    for choice in [ALL[0], ALL[2]] {
        let mut test = moving_app();
        let mut domain =
            FluidDomain { count_leaks: true, ..FluidDomain::with_spacing(0.05).on(choice.0).in_mode(choice.1) };
        domain.settings.expected_speed = Some(5.0);
        let domain = test.spawn(domain);
        test.spawn((FluidVolume::from(Cuboid::new(0.3, 0.3, 0.3)), Transform::from_xyz(0.0, -0.05, 0.0)));
        let shape = FluidBoundaryShape::Cup { radius: 0.25, half_height: 0.25, thickness: 0.05 };
        let cup = test.spawn((FluidBoundary::new(shape).moving(), Transform::default()));
        test.tick(8);
        let particles = test.settle(domain).particles;
        // It is carried to the side and up, a third of a second.
        test.world().entity_mut(cup).insert(Moves { way: Vec3::new(1.0, 0.5, 0.0), turn: 0.0 });
        test.tick(21);
        let center = test.world().get::<Transform>(cup).unwrap().translation;
        let held = positions(&mut test, domain);
        let inside = held.iter().filter(|at| (**at - center).xz().length() < 0.25 && at.y > center.y - 0.26).count();
        assert!(inside as u32 > particles * 9 / 10, "{choice:?}: {inside} of {particles} are in the cup");
        assert!(center.x > 0.3 && mean(&held).x > 0.25, "{choice:?}: {center} {}", mean(&held));
        // It is turned upside down within half a second, and empties.
        test.world().entity_mut(cup).insert(Moves { way: Vec3::ZERO, turn: TAU });
        test.tick(32);
        test.world().entity_mut(cup).remove::<Moves>();
        test.tick(24);
        let poured = positions(&mut test, domain);
        let center = test.world().get::<Transform>(cup).unwrap().translation;
        let above = poured.iter().filter(|at| at.y > center.y + 0.3).count();
        assert_eq!(above, 0, "{choice:?}: none is left above the bottom of a cup that is upside down");
        assert!(mean(&poured).y < center.y - 0.3, "{choice:?}: {} {center}", mean(&poured));
        let stats = test.settle(domain);
        assert_eq!((stats.plannings, stats.leaks, stats.particles), (1, Some(0), particles), "{choice:?} {stats:?}");
        test.expect_no_complaints();
    }
}

#[test]
fn a_wall_that_is_put_elsewhere_or_scaled_does_not_throw_the_fluid() {
    for choice in ALL {
        let mut test = moving_app();
        let domain = channel(&mut test, choice);
        let mesh = test.world().resource_mut::<Assets<Mesh>>().add(Mesh::from(Cuboid::new(0.1, 0.3, 0.3)));
        let wall = test.spawn((FluidBoundary::mesh(mesh).moving(), Transform::from_xyz(1.5, 0.25, 0.25)));
        test.tick(12);
        let plannings = test.settle(domain).plannings;
        // Over the water to its other side: 1.5 m in a tick.
        test.change::<Transform>(wall, |pose| pose.translation.x = 2.9);
        test.tick(4);
        let stats = test.settle(domain);
        assert_eq!((stats.plannings, stats.leaks), (plannings, Some(0)), "{choice:?}");
        // The water falls from 0.4 m, and gets as fast as a dam break's front, twice a wave: the wall, at 88 m/s, gives it nothing.
        let front = 2.0 * (9.81f32 * 0.4).sqrt();
        assert!(stats.max_speed < front, "{choice:?}: {} m/s", stats.max_speed);
        // Another scale is another shape: planned once.
        test.change::<Transform>(wall, |pose| pose.scale = Vec3::new(1.0, 0.5, 0.5));
        test.tick(6);
        let stats = test.settle(domain);
        assert_eq!((stats.plannings, stats.leaks), (plannings + 1, Some(0)), "{choice:?}");
        assert!(stats.max_speed < 6.0, "{choice:?}: {stats:?}");
        test.expect_no_complaints();
        // One without volume is refused, once, and the fluid goes on without the wall.
        test.change::<Transform>(wall, |pose| pose.scale = Vec3::ZERO);
        test.tick(6);
        let complaints = test.complaints();
        assert_eq!(complaints.len(), 1, "{choice:?}: {complaints:?}");
        assert_eq!((complaints[0].entity, complaints[0].component), (wall, "FluidBoundary"));
        assert!(complaints[0].message.contains("scale"), "{complaints:?}");
        // It is back.
        test.change::<Transform>(wall, |pose| pose.scale = Vec3::ONE);
        test.tick(6);
        let stats = test.settle(domain);
        assert_eq!((stats.plannings, stats.leaks), (plannings + 3, Some(0)), "{choice:?}");
        test.expect_no_complaints();
    }
}

#[test]
fn a_tank_that_goes_out_of_the_bounds_is_named_before_its_water_is_lost() {
    for choice in [ALL[0], ALL[2]] {
        let mut test = moving_app();
        let mut domain = FluidDomain::with_spacing(SPACING).on(choice.0).in_mode(choice.1);
        domain.settings.bounds = Some((Vec3::splat(-1.0), Vec3::splat(1.0)));
        let domain = test.spawn(domain);
        let tank = FluidContainer::open_box(0.5, 0.5, 0.5).moving();
        let tank = test.spawn((tank, Moves { way: Vec3::X * 2.0, turn: 0.0 }));
        test.spawn((FluidVolume::from(Cuboid::new(0.4, 0.3, 0.4)), Transform::from_xyz(0.0, -0.05, 0.0)));
        // Its samples lie less than a spacing outside: it reaches the bounds after 0.65 m.
        test.tick(20);
        test.expect_no_complaints();
        test.tick(4);
        let complaints = test.complaints();
        assert_eq!(complaints.len(), 1, "{choice:?}: {complaints:?}");
        assert_eq!((complaints[0].entity, complaints[0].component), (tank, "FluidContainer"));
        let message = &complaints[0].message;
        assert!(
            message.contains("[-1, -1, -1] to [1, 1, 1] m") && message.contains("FluidSettings::bounds"),
            "{message}"
        );
        assert_eq!(test.stats(domain).removed, 0, "{choice:?}");
        // Once only, and the water is lost.
        test.tick(16);
        test.expect_no_complaints();
        let end = test.settle(domain);
        assert!(end.removed > 0 && end.not_finite == 0, "{choice:?}: {end:?}");
    }
}

/// How a plate gets from one side of some water to the other.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Put {
    /// By less than walls may move in a tick, while time stands still.
    Paused,
    /// Turned about its centre likewise.
    TurnedPaused,
    /// Farther than walls move in a tick.
    Far,
    /// Turned farther than that.
    TurnedFar,
}

#[test]
fn a_wall_that_is_put_to_the_other_side_of_water_leaves_it_at_rest() {
    for choice in ALL {
        for put in [Put::Paused, Put::TurnedPaused, Put::Far, Put::TurnedFar] {
            let mut test = moving_app();
            let mut domain = FluidDomain::with_spacing(SPACING).on(choice.0).in_mode(choice.1);
            domain.gravity = Some(Vec3::ZERO);
            domain.settings.expected_speed = Some(6.0);
            let domain = test.spawn(domain);
            // Walls may go 0.375 m in a tick. A plate of 0.6 m turns by 0.31 m at its ends, or by 0.47 m; it sweeps over the water between its
            // places. At all of these a spacing lies between them.
            let (turn, at) = match put {
                Put::Paused => (0.0, Vec3::ZERO),
                Put::Far => (0.0, Vec3::X * 0.1),
                Put::TurnedPaused => (1.04, 0.4 * Vec3::new(0.5f32.cos(), 0.5f32.sin(), 0.0)),
                Put::TurnedFar => (1.57, 0.3 * Vec3::new(0.785f32.cos(), 0.785f32.sin(), 0.0)),
            };
            let (long, size) = match put {
                Put::Paused | Put::Far => (Vec3::new(SPACING, 0.6, 0.6), Vec3::new(0.1, 0.3, 0.3)),
                Put::TurnedPaused => (Vec3::new(1.2, SPACING, 0.6), Vec3::new(0.1, 0.1, 0.3)),
                Put::TurnedFar => (Vec3::new(0.8, SPACING, 0.6), Vec3::new(0.1, 0.1, 0.3)),
            };
            test.spawn((FluidVolume::from(Cuboid::from_size(size)), Transform::from_translation(at)));
            let start = if turn == 0.0 { Vec3::X * -0.15 } else { Vec3::ZERO };
            let wall = FluidBoundary::from(Cuboid::from_size(long)).moving();
            let wall = test.spawn((wall, Transform::from_translation(start)));
            test.tick(4);
            let before = positions(&mut test, domain);
            test.change::<Transform>(wall, |pose| {
                pose.translation.x += match put {
                    Put::Paused => 0.3,
                    Put::Far => 0.5,
                    _ => 0.0,
                };
                pose.rotate_z(turn);
            });
            if matches!(put, Put::Paused | Put::TurnedPaused) {
                test.update();
            }
            test.tick(4);
            let after = positions(&mut test, domain);
            let moved = after.iter().zip(&before).map(|(after, before)| after.distance(*before)).fold(0.0, f32::max);
            println!("{choice:?} {put:?}: {moved} m");
            assert!(!before.is_empty() && moved < 0.01 * SPACING, "{choice:?} {put:?}: {moved} m");
            test.expect_no_complaints();
        }
    }
}

#[test]
fn a_wall_that_stands_and_is_put_elsewhere_while_time_stands_still_still_stands() {
    let mut test = moving_app();
    let domain = channel(&mut test, ALL[0]);
    let wall = FluidBoundary::cuboid(SPACING, 0.4, 0.4);
    let moves = |notes: &[String]| notes.iter().any(|note| note.contains("moves because it has been moved"));
    let wall = test.spawn((wall, Transform::from_xyz(2.0, 0.25, 0.25)));
    test.tick(4);
    for (plannings, x) in [(2, 1.9), (3, 2.1)] {
        test.change::<Transform>(wall, |pose| pose.translation.x = x);
        test.update();
        let stats = test.settle(domain);
        assert_eq!(stats.plannings, plannings);
        assert!(!moves(&stats.notes), "{:?}", stats.notes);
    }
    test.change::<Transform>(wall, |pose| pose.translation.x = 2.0);
    test.tick(2);
    let notes = test.settle(domain).notes;
    assert!(moves(&notes), "{notes:?}");
    test.expect_no_complaints();
}

#[test]
fn what_goes_through_a_wall_is_counted() {
    for choice in [ALL[0], ALL[2]] {
        // Water thrown at a plate by 40,000 times the speed that was expected: its pressure holds nothing.
        let mut test = moving_app();
        let mut domain =
            FluidDomain { count_leaks: true, ..FluidDomain::with_spacing(SPACING).on(choice.0).in_mode(choice.1) };
        domain.gravity = Some(Vec3::ZERO);
        domain.settings.expected_speed = Some(1e-3);
        domain.settings.bounds = Some((Vec3::splat(-50.0), Vec3::splat(50.0)));
        let domain = test.spawn(domain);
        let thrown = FluidVolume::from(Cuboid::new(0.5, 0.5, 0.5)).with_velocity(Vec3::NEG_Y * 40.0);
        test.spawn((thrown, Transform::from_xyz(0.0, 1.0, 0.0)));
        test.spawn((FluidBoundary::cuboid(3.0, SPACING, 3.0), Transform::default()));
        test.tick(16);
        let stats = test.settle(domain);
        let below = positions(&mut test, domain).iter().filter(|at| at.y < -0.2).count() as u64;
        println!("{choice:?}: {:?} of {} leaked, {below} are below {stats:?}", stats.leaks, stats.particles);
        test.expect_no_complaints();
        assert!(below > 30, "{choice:?}: {below}");
        assert!(
            stats.leaks.is_some_and(|leaks| leaks >= below && leaks <= 125),
            "{choice:?}: {:?} {below}",
            stats.leaks
        );
        // Who does not ask is told nothing.
        test.change::<FluidDomain>(domain, |domain| domain.count_leaks = false);
        assert_eq!(test.settle(domain).leaks, None);
    }
}

#[test]
fn a_count_that_begins_when_a_cup_has_been_carried_away_counts_nothing_that_stays_in_it() {
    for choice in [ALL[0], ALL[2]] {
        let mut test = moving_app();
        let mut domain = FluidDomain::with_spacing(0.05).on(choice.0).in_mode(choice.1);
        domain.settings.expected_speed = Some(5.0);
        let domain = test.spawn(domain);
        test.spawn((FluidVolume::from(Cuboid::new(0.3, 0.3, 0.3)), Transform::from_xyz(0.0, -0.05, 0.0)));
        let shape = FluidBoundaryShape::Cup { radius: 0.25, half_height: 0.25, thickness: 0.05 };
        let moves = Moves { way: Vec3::new(1.0, 0.5, 0.0), turn: 0.0 };
        test.spawn((FluidBoundary::new(shape).moving(), Transform::default(), moves));
        test.tick(40);
        assert_eq!(test.stats(domain).leaks, None, "{choice:?}");
        test.change::<FluidDomain>(domain, |domain| domain.count_leaks = true);
        test.tick(8);
        let stats = test.settle(domain);
        assert_eq!((stats.leaks, stats.plannings), (Some(0), 1), "{choice:?}");
        test.expect_no_complaints();
    }
}

#[test]
fn a_count_asked_for_is_there_before_there_is_fluid() {
    let mut test = TestApp::new();
    let domain = test.spawn(FluidDomain { count_leaks: true, ..FluidDomain::with_spacing(SPACING) });
    test.tick(1);
    assert_eq!(test.stats(domain).leaks, Some(0));
}
