//! Walls that push by themselves: their forces against the formulas, and single particles against exact motions.

use freshet_core::prelude::*;
use freshet_cpu::{CpuOptions, CpuSolver};
use glam::DVec3;

const D: f32 = 0.05;

fn solver(plan: &Plan) -> CpuSolver {
    CpuSolver::new(plan.clone(), CpuOptions { threads: Some(2), ..CpuOptions::default() }).unwrap()
}

fn forces() -> impl Iterator<Item = WallMethod> {
    WallMethod::ALL.into_iter().filter(|method| method.is_force())
}

/// Water that fills the bottom of an open box, one corner of which is the origin.
fn tank(method: WallMethod) -> FluidScene {
    let size = Vec3::new(8.0, 6.0, 7.0) * D;
    let mut scene = FluidScene {
        volumes: vec![Volume::block(size / 2.0, size / 2.0)],
        boundaries: vec![Boundary::open_box(size + 4.0 * D * Vec3::Y, size / 2.0 + 2.0 * D * Vec3::Y)],
        ..FluidScene::with_spacing(D)
    };
    scene.settings.wall_method = method;
    scene
}

/// A single particle above a floor at height zero.
fn alone(method: WallMethod, gravity: f32, at: Vec3, velocity: Vec3) -> (Plan, Snapshot) {
    alone_on(Friction::default(), method, gravity, at, velocity)
}

/// The same on a floor with friction.
fn alone_on(friction: Friction, method: WallMethod, gravity: f32, at: Vec3, velocity: Vec3) -> (Plan, Snapshot) {
    let half_space = BoundaryShape::HalfSpace { half_extents: [1.0, 1.0] };
    let floor = Boundary::new(half_space, Vec3::ZERO).with_friction(friction);
    let mut scene = FluidScene {
        gravity: gravity * Vec3::NEG_Y,
        volumes: vec![Volume::block(Vec3::splat(0.5 * D), Vec3::Y)],
        boundaries: vec![floor],
        ..FluidScene::with_spacing(D)
    };
    scene.settings.expected_speed = Some(1.0);
    scene.settings.wall_method = method;
    let plan = Plan::new(&scene).unwrap();
    let mut state = solver(&plan).snapshot().unwrap();
    assert_eq!(state.ids.len(), 1);
    (state.positions[0], state.velocities[0]) = (at, velocity);
    (plan, state)
}

/// Heights and velocities after each of so many ticks.
fn follow(plan: &Plan, state: &Snapshot, ticks: u64, duration: f32) -> Vec<(Vec3, Vec3)> {
    let mut solver = solver(plan);
    solver.restore(state).unwrap();
    let step = |tick| {
        let report = solver.step(&StepInput { tick, duration, ..StepInput::default() }).unwrap();
        assert_eq!((report.particles, report.time_scale), (1, 1.0));
        let vector = |solver: &mut CpuSolver, field| solver.read(field).unwrap().vectors().unwrap()[0];
        (vector(&mut solver, Field::Position), vector(&mut solver, Field::Velocity))
    };
    (0..ticks).map(step).collect()
}

/// The forces of samples, from the formulas of the module's text in double precision.
fn of_samples(plan: &Plan, at: Vec3) -> DVec3 {
    let p = &plan.parameters;
    let (d, v, c) = (f64::from(p.spacing), f64::from(p.expected_speed), f64::from(p.sound_speed));
    let kernel = p.kernel().unwrap();
    let of_sample = |sample: &Vec3| {
        let x = (at - *sample).as_dvec3();
        let r = x.length();
        let away = x / r.max(0.5 * d);
        match p.wall_method {
            WallMethod::LennardJones if r < d => {
                let s = d / r.max(0.5 * d);
                v * v * s / d * (s.powi(12) - s.powi(6)) * away
            }
            WallMethod::KernelForcing => 8.0 * v * v / d * d.powi(3) * kernel.value(r) * away,
            WallMethod::MonaghanRepulsion => {
                let q = r / f64::from(p.smoothing_length);
                let shape = match q {
                    q if q < 2.0 / 3.0 => 2.0 / 3.0,
                    q if q < 1.0 => 2.0 * q - 1.5 * q * q,
                    q if q < 2.0 => 0.5 * (2.0 - q).powi(2),
                    _ => 0.0,
                };
                0.01 * c * c / r.max(0.5 * d) * shape * away
            }
            _ => DVec3::ZERO,
        }
    };
    plan.boundary.positions.iter().map(of_sample).sum()
}

/// The springs of the tank, from its faces.
fn of_faces(plan: &Plan, spring: SpringDamper, at: Vec3, velocity: Vec3) -> DVec3 {
    let (d, size) = (f64::from(D), (Vec3::new(8.0, 0.0, 7.0) * D).as_dvec3());
    let w = 4.0 * f64::from(plan.parameters.expected_speed) / d;
    let (at, velocity) = (at.as_dvec3(), velocity.as_dvec3());
    let faces = [
        (DVec3::X, at.x),
        (DVec3::NEG_X, size.x - at.x),
        (DVec3::Y, at.y),
        (DVec3::Z, at.z),
        (DVec3::NEG_Z, size.z - at.z),
    ];
    let push = |(normal, distance): (DVec3, f64)| {
        let nearer = 0.5 * d - distance;
        let push = w * w * nearer - 2.0 * f64::from(spring.damping_ratio) * w * velocity.dot(normal);
        if nearer > 0.0 { push.max(0.0) * normal } else { DVec3::ZERO }
    };
    faces.into_iter().map(push).sum()
}

#[test]
fn walls_push_as_their_formulas_say_and_are_in_no_sum() {
    for method in forces() {
        let plan = Plan::new(&tank(method)).unwrap();
        let mut state = solver(&plan).snapshot().unwrap();
        let mut random = 7u32;
        let mut next = || {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (random >> 8) as f32 / 16_777_216.0 - 0.5
        };
        // Some of them behind the face.
        for (position, velocity) in state.positions.iter_mut().zip(&mut state.velocities) {
            *position += 1.4 * D * Vec3::new(next(), next(), next());
            *velocity = 2.0 * Vec3::new(next(), next(), next());
        }
        let without = |kind: StageKind| Plan {
            stages: plan.stages.iter().filter(|stage| stage.kind != kind).cloned().collect(),
            ..plan.clone()
        };
        let found = |plan: &Plan| {
            let mut solver = solver(plan);
            solver.restore(&state).unwrap();
            solver.step(&StepInput::default()).unwrap();
            let ids = solver.read(Field::Id).unwrap().integers().unwrap();
            let mut by_id = |field| solver.read(field).unwrap().sorted_by_id(&ids);
            (by_id(Field::Acceleration).vectors().unwrap(), by_id(Field::Density).scalars().unwrap())
        };
        let ((before, _), (after, density)) = (found(&without(StageKind::WallForce)), found(&plan));
        let wall_less = FluidScene { boundaries: Vec::new(), ..tank(method) };
        assert_eq!(found(&Plan::new(&wall_less).unwrap()).1, density, "walls are in the sums of {method:?}");
        let mut pushed = 0;
        for (i, (&at, &velocity)) in state.positions.iter().zip(&state.velocities).enumerate() {
            let expected = match method {
                WallMethod::SpringDamper(spring) => of_faces(&plan, spring, at, velocity),
                _ => of_samples(&plan, at),
            };
            let found = after[i].as_dvec3() - before[i].as_dvec3();
            // Steep forces multiply what positions are rounded by.
            let size = before[i].as_dvec3().length() + 100.0 + 10.0 * expected.length();
            assert!((found - expected).length() < 1e-5 * size, "{method:?} {i} at {at}: {found}, not {expected}");
            pushed += usize::from(expected != DVec3::ZERO);
        }
        assert!(pushed > 50 && pushed < state.ids.len(), "{method:?}: {pushed} of {}", state.ids.len());
    }
}

/// Straight down on a sample and back. What is lost on the way down is `K/12 ((d/r)^6 - 1)^2` for each sample within a spacing.
#[test]
fn lennard_jones_turns_where_its_potential_says() {
    let (plan, mut state) = alone(WallMethod::LennardJones, 0.0, Vec3::ZERO, Vec3::new(0.0, -0.9, 0.0));
    let middle = plan.boundary.positions.iter().copied().min_by(|a, b| a.length().total_cmp(&b.length())).unwrap();
    state.positions[0] = middle + 1.5 * D * Vec3::Y;
    let way = follow(&plan, &state, 700, 2e-4);
    let lowest = way.iter().map(|(x, _)| x.y).fold(f32::INFINITY, f32::min);
    let at = Vec3::new(middle.x, lowest, middle.z);
    let near = plan.boundary.positions.iter().map(|sample| f64::from(D / sample.distance(at))).filter(|&s| s > 1.0);
    let potential: f64 = near.map(|s| (s.powi(6) - 1.0).powi(2) / 12.0).sum();
    assert!((potential / 0.405 - 1.0).abs() < 5e-3, "{potential} m2/s2 at {lowest}, not 0.405");
    let left = way[way.len() - 1].1;
    assert!((left.y / 0.9 - 1.0).abs() < 1e-3 && left.x.hypot(left.z) < 1e-3, "{left}");
}

/// Anywhere on a sample's cell, at the expected speed: nothing comes through, and all speed comes back.
#[test]
fn what_comes_at_the_expected_speed_is_held_everywhere_and_keeps_its_energy() {
    let undamped = WallMethod::SpringDamper(SpringDamper { damping_ratio: 0.0, ..SpringDamper::default() });
    for method in forces().map(|method| if matches!(method, WallMethod::SpringDamper(_)) { undamped } else { method }) {
        for [x, z] in [[0.0, 0.0], [0.5, 0.5], [0.5, 0.0], [0.3, 0.2]] {
            let from = D * Vec3::new(x, 2.5, z);
            let (plan, state) = alone(method, 0.0, from, Vec3::new(0.0, -1.0, 0.0));
            let way = follow(&plan, &state, 1200, 2e-4);
            let lowest = way.iter().map(|(x, _)| x.y).fold(f32::INFINITY, f32::min);
            let speed = way[way.len() - 1].1.length();
            assert!(lowest > -0.5 * D, "{method:?} over {x} {z}: down to {} d", lowest / D);
            assert!((speed - 1.0).abs() < 4e-3, "{method:?} over {x} {z}: leaves with {speed} m/s");
        }
    }
}

/// About where the floor carries it: `A exp(-z w t) cos(...)`.
#[test]
fn a_spring_is_the_damped_oscillator() {
    let (w, z, g) = (24.0f32, 0.15f32, 9.81f32);
    let method = WallMethod::SpringDamper(SpringDamper { frequency: Some(w), damping_ratio: z });
    let (rest, amplitude) = (0.5 * D - g / (w * w), 0.008);
    let (plan, state) = alone(method, g, Vec3::new(0.01, rest + amplitude, 0.02), Vec3::ZERO);
    let dt = 1e-4;
    let way = follow(&plan, &state, 8000, dt);
    let free = w * (1.0 - z * z).sqrt();
    for (number, (x, _)) in way.iter().enumerate() {
        let t = dt * (number + 1) as f32;
        let exact = amplitude * (-z * w * t).exp() * ((free * t).cos() + z * w / free * (free * t).sin());
        assert!((x.y - rest - exact).abs() < 0.01 * amplitude, "after {t} s: {}, not {exact}", x.y - rest);
    }
}

/// `v^2/(2 mu g)`, and then it stays.
#[test]
fn friction_of_springs_ends_a_slide_after_the_way_that_coulomb_says() {
    let (g, mu, speed) = (9.81f32, 0.4f32, 0.5f32);
    let spring = SpringDamper { frequency: Some(80.0), ..SpringDamper::default() };
    let at = Vec3::new(-0.2, 0.5 * D - g / 6400.0, 0.013);
    let friction = Friction { at_rest: 1.2 * mu, sliding: mu };
    let method = WallMethod::SpringDamper(spring);
    let (plan, state) = alone_on(friction, method, g, at, Vec3::new(0.6, 0.0, 0.8) * speed);
    let way = follow(&plan, &state, 1000, 2e-4);
    let (end, velocity) = way[way.len() - 1];
    let gone = (end - at).length();
    let expected = speed * speed / (2.0 * mu * g);
    assert!((gone / expected - 1.0).abs() < 5e-3, "{gone} m, not {expected}");
    assert!(velocity.length() < 1e-5, "{velocity}");
    // Less than what sticks bears, and it stays; a little more, and it goes.
    for (slope, expected) in [(1.1 * mu, 0.0), (1.3 * mu, 0.3 * mu * g * 0.04)] {
        let mut state = state.clone();
        state.velocities[0] = Vec3::ZERO;
        state.gravity = Vec3::new(slope * g, -g, 0.0);
        let speed = follow(&plan, &state, 200, 2e-4)[199].1.length();
        assert!((speed - expected).abs() < 1e-5 + 0.01 * expected, "slope {slope}: {speed} m/s, not {expected}");
    }
}

/// A single particle in a closed box without gravity, whose walls hold it half a spacing off: 6 x 5 x 4 spacings of room.
fn in_a_box(penalty: Penalty, velocity: Vec3) -> (Plan, Snapshot) {
    let mut scene = FluidScene {
        gravity: Vec3::ZERO,
        volumes: vec![Volume::block(Vec3::splat(0.5 * D), Vec3::ZERO)],
        boundaries: vec![Boundary::closed_box((ROOM + 1.0) * D, Vec3::ZERO)],
        ..FluidScene::with_spacing(D)
    };
    scene.settings.expected_speed = Some(1.0);
    scene.settings.wall_method = WallMethod::Penalty(penalty);
    let plan = Plan::new(&scene).unwrap();
    let mut state = solver(&plan).snapshot().unwrap();
    state.velocities[0] = velocity;
    (plan, state)
}

/// The room that the centre of that particle has, spacings.
const ROOM: Vec3 = Vec3::new(6.0, 5.0, 4.0);

/// Some fifty collisions, with single walls, in edges and near corners: it is where it would be by the law of reflection, to a thousandth of a spacing.
#[test]
fn mirrored_walls_keep_energy_and_way() {
    let velocity = Vec3::new(0.9, -0.7, 0.53);
    let (dt, ticks) = (2e-3, 3000);
    let end = |penalty| {
        let (plan, state) = in_a_box(penalty, velocity);
        follow(&plan, &state, ticks, dt)[ticks as usize - 1]
    };
    let (at, speed) = end(Penalty::MIRRORED);
    assert!((speed.length() / velocity.length() - 1.0).abs() < 1e-5, "{speed}");
    // A zigzag of the way without walls.
    let half = 0.5 * ROOM * D;
    let gone = velocity.as_dvec3() * f64::from(dt) * ticks as f64;
    let exact = (0..3).map(|axis| {
        let (room, turns) =
            (f64::from(2.0 * half[axis]), (gone[axis] + f64::from(half[axis])) / f64::from(2.0 * half[axis]));
        let within = (turns - 2.0 * (turns / 2.0).floor()) * room;
        (if within > room { 2.0 * room - within } else { within }) - 0.5 * room
    });
    let exact: Vec<f64> = exact.collect();
    let off = at.as_dvec3().distance(DVec3::new(exact[0], exact[1], exact[2]));
    assert!(off < 1e-3 * f64::from(D), "{at}, not {exact:?}");
    // The others keep the speed and lose the way, or lose both.
    let (other, speed) = end(Penalty { reflection: Reflection::Whole, ..Penalty::MIRRORED });
    assert!(
        (speed.length() / velocity.length() - 1.0).abs() < 1e-5 && other.distance(at) > 0.01 * D,
        "{other} {speed}"
    );
    let (_, speed) = end(Penalty::SHARE);
    assert!(speed.length() < 0.2 * velocity.length(), "{speed}");
}

/// What falls on a floor thirty times comes back as high.
#[test]
fn a_mirrored_floor_gives_back_the_height_of_a_fall() {
    let peaks = |penalty: Penalty| {
        let (plan, state) = alone(WallMethod::Penalty(penalty), 9.81, Vec3::new(0.01, 4.0 * D, 0.02), Vec3::ZERO);
        let way = follow(&plan, &state, 13_000, 1e-3);
        let is_peak = |three: &&[(Vec3, Vec3)]| three[0].1.y > 0.0 && three[2].1.y <= 0.0;
        way.windows(3).filter(is_peak).map(|three| (three[1].0.y / D - 0.5) / 3.5).collect::<Vec<f32>>()
    };
    let all = peaks(Penalty::MIRRORED);
    assert!(all.len() >= 25, "{}", all.len());
    assert!(all.iter().all(|height| (height - 1.0).abs() < 0.05), "{all:?}");
    // Two thirds of the energy a time.
    let all = peaks(Penalty::SHARE);
    assert!(all.iter().all(|&height| height < 0.9) && all.iter().take(6).any(|&height| height < 0.2), "{all:?}");
}

/// One substep: what comes back, what slips, and where it is put.
#[test]
fn a_collision_takes_its_shares() {
    let (dt, velocity) = (2e-4f32, Vec3::new(0.3, -1.0, 0.4));
    let from = Vec3::new(0.0, 0.5 * D + 1.5e-4, 0.0);
    let after = |penalty| {
        let (plan, state) = alone(WallMethod::Penalty(penalty), 0.0, from, velocity);
        follow(&plan, &state, 1, dt)[0]
    };
    // It gets 0.5e-4 m too far, a quarter of its way.
    let half = Penalty { bounce: 0.5, slip: 0.7, ..Penalty::DEFAULT };
    for (reflection, leaving, height) in
        [(Reflection::Whole, 0.5, 0.0), (Reflection::Share, 0.125, 0.0), (Reflection::Mirrored, 0.5, 0.25e-4)]
    {
        let (x, v) = after(Penalty { reflection, ..half });
        assert!(v.distance(Vec3::new(0.21, leaving, 0.28)) < 1e-3, "{reflection:?}: {v}");
        assert!((x.y - 0.5 * D - height).abs() < 1e-7, "{reflection:?}: {x}");
        assert!((x.x - 0.3 * dt).abs() < 1e-7, "{reflection:?}: {x}");
    }
    // One way only: a floor under what may sink is not there; it is for what may rise or go aside, however that moves.
    for way in [Vec3::Y, Vec3::new(0.5, 0.5, 0.0)] {
        let (x, v) = after(Penalty { one_way: Some(way), ..half });
        assert!(v == velocity && (x.y - from.y + dt).abs() < 1e-7, "{x} {v}");
    }
    for way in [3.0 * Vec3::NEG_Y, Vec3::X, Vec3::NEG_X, Vec3::new(1.0, 0.5, 0.0)] {
        assert!(after(Penalty { one_way: Some(way), ..half }).1.y > 0.49, "{way}");
    }
}

/// Water thrown about in a closed box whose ceiling is not there for what rises leaves it there and nowhere else.
#[test]
fn what_rises_leaves_a_box_by_its_ceiling_alone() {
    let size = Vec3::new(8.0, 6.0, 7.0) * D;
    let outside = |one_way: Option<Vec3>, speed: f32| {
        let mut scene = FluidScene {
            volumes: vec![Volume::block(size / 2.0, size / 2.0)],
            boundaries: vec![Boundary::closed_box(size, size / 2.0)],
            ..FluidScene::with_spacing(D)
        };
        scene.settings.wall_method = WallMethod::Penalty(Penalty { one_way, ..Penalty::MIRRORED });
        scene.settings.expected_speed = Some(speed);
        let mut solver = solver(&Plan::new(&scene).unwrap());
        let mut state = solver.snapshot().unwrap();
        for velocity in &mut state.velocities {
            *velocity = Vec3::new(0.6, 0.7, 0.4) * speed;
        }
        solver.restore(&state).unwrap();
        let (mut above, mut aside) = (0, 0);
        for tick in 0..40 {
            solver.step(&StepInput { tick, duration: 0.005, ..StepInput::default() }).unwrap();
            let positions = solver.read(Field::Position).unwrap().vectors().unwrap();
            above = positions.iter().filter(|x| x.y > size.y).count();
            let is_aside = |x: &&Vec3| x.y < size.y && (x.min_element() < 0.0 || x.x > size.x || x.z > size.z);
            aside += positions.iter().filter(is_aside).count();
        }
        (above, aside)
    };
    for speed in [1.0, 4.0] {
        assert_eq!(outside(None, speed), (0, 0), "{speed} m/s");
        let (above, aside) = outside(Some(Vec3::NEG_Y), speed);
        assert!(above > 30 && aside == 0, "{speed} m/s: {above} above, {aside} aside");
    }
}
