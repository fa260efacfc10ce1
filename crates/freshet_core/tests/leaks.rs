//! Leaks are counted: of ways that go through walls by a formula of their own, and none of those that do not.

use freshet_core::geometry::{HeightField, TriangleMesh};
use freshet_core::leaks::{LeakWatch, WallPose};
use freshet_core::prelude::*;
use freshet_core::sampling::wall_layer::WallLayer;

const SPACING: f32 = 0.1;

fn layer() -> WallLayer {
    FluidScene::with_spacing(SPACING).wall_layer().unwrap()
}

fn watch(shape: BoundaryShape) -> LeakWatch {
    LeakWatch::new(&layer(), &[Boundary::new(shape, Vec3::ZERO)])
}

/// Uniform, -1 to 1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 23) as f32 - 1.0
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }
}

/// Whether a particle that was seen at these places, one after the other, has leaked.
fn leaks(shape: &BoundaryShape, places: &[Vec3]) -> bool {
    let mut watch = watch(shape.clone());
    for place in places {
        watch.look(&[3], &[*place]);
    }
    watch.total() > 0
}

fn square_sheet() -> TriangleMesh {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    TriangleMesh::new(corners.map(|(x, z)| Vec3::new(x, 0.0, z)).to_vec(), vec![[0, 2, 1], [0, 3, 2]]).unwrap()
}

#[test]
fn random_ways_leak_where_they_cross_the_middle_of_a_plate() {
    // Thin, as thick as two depths, and a sheet: ends are outside of them, nearer than a spacing and a half.
    let depth = layer().depth;
    let box_of = |half: f32| BoundaryShape::Box { half_extents: Vec3::new(1.0, half, 1.0) };
    let cases = [
        (box_of(0.0005), 0.0005),
        (box_of(0.5 * SPACING), 0.5 * SPACING),
        (box_of(depth), depth),
        (BoundaryShape::mesh(square_sheet()), depth),
        // Its wall lies below it.
        (BoundaryShape::Plane { half_extents: [1.0, 1.0] }, depth),
        (BoundaryShape::HalfSpace { half_extents: [1.0, 1.0] }, depth),
    ];
    let mut random = Random(1);
    for (shape, half) in cases {
        let below = matches!(shape, BoundaryShape::Plane { .. } | BoundaryShape::HalfSpace { .. });
        let middle = if below { -depth } else { 0.0 };
        let mut watch = watch(shape.clone());
        let (mut expected, mut ids) = (0, Vec::new());
        let (mut starts, mut ends) = (Vec::new(), Vec::new());
        while ids.len() < 2000 {
            let ways = [(); 2].map(|()| {
                let v = random.vector();
                // Ends well inside the rectangle, or well beside it.
                let side = v.y.signum() * (half + 0.15 * SPACING * (1.0 + 9.0 * v.y.abs()));
                Vec3::new(1.4 * v.x, middle + side, 0.85 * v.z)
            });
            let [from, to] = ways;
            let crosses = (from.y > middle) != (to.y > middle);
            let at = from.lerp(to, (from.y - middle) / (from.y - to.y));
            // What may come in by an edge is another matter.
            let is_beside = |p: Vec3| p.x.abs() > 1.0;
            let is_near_edge = |p: Vec3| (p.x.abs() - 1.0).abs() < 2.0 * half + SPACING;
            let by_an_edge = is_beside(from) != is_beside(to) || is_beside(from) && from.x * to.x < 0.0;
            if is_near_edge(from) || is_near_edge(to) || by_an_edge {
                continue;
            }
            expected += u32::from(crosses && at.x.abs() < 1.0);
            ids.push(ids.len() as u32);
            starts.push(from);
            ends.push(to);
        }
        assert_eq!(watch.look(&ids, &starts), 0, "{shape:?}: all begin outside");
        let found = watch.look(&ids, &ends);
        assert!(expected > 300, "{shape:?}: {expected}");
        assert_eq!(found, expected, "{shape:?}");
        // Once each.
        watch.look(&ids, &starts);
        let again = watch.look(&ids, &ends);
        assert!(again <= found && watch.total() >= u64::from(found), "{shape:?}");
    }
}

#[test]
fn what_bounces_or_goes_round_does_not_leak() {
    let at = Vec3::new;
    let plate = BoundaryShape::Box { half_extents: at(1.0, 0.05, 1.0) };
    let down_and_up = [at(0.0, 0.3, 0.0), at(0.0, 0.02, 0.0), at(0.1, 0.01, 0.0), at(0.1, 0.2, 0.0)];
    assert!(!leaks(&plate, &down_and_up), "it gets in by less than to the middle");
    let through = [at(0.0, 0.3, 0.0), at(0.0, 0.02, 0.0), at(0.0, -0.02, 0.0)];
    assert!(leaks(&plate, &through), "in two steps");
    let over = [at(0.9, 0.1, 0.0), at(1.1, 0.1, 0.0), at(1.1, -0.1, 0.0), at(0.9, -0.1, 0.0)];
    assert!(!leaks(&plate, &over), "over the rim");
    // Over the rim of a sheet, in the zone where its samples push: by steps, and all round it.
    let sheet = BoundaryShape::mesh(square_sheet());
    let around: Vec<Vec3> = (0..=20)
        .map(|i| (i as f32 / 20.0 - 0.5) * std::f32::consts::PI)
        .map(|angle| at(1.0 + 0.07 * angle.cos(), 0.07 * angle.sin(), 0.2))
        .collect();
    assert!(!leaks(&sheet, &around), "round the rim of a sheet");
    assert!(leaks(&sheet, &[at(0.5, 0.07, 0.2), at(0.5, -0.07, 0.2)]));
    // Around an edge of a thick box, its corner cut off.
    let block = BoundaryShape::Box { half_extents: Vec3::ONE };
    assert!(!leaks(&block, &[at(0.9, 1.05, 0.0), at(1.05, 0.9, 0.0)]));
    assert!(leaks(&block, &[at(0.0, 1.05, 0.0), at(0.0, 0.95, 0.0), at(0.0, 0.9, 0.0)]), "deeper than the samples");
    assert!(!leaks(&block, &[at(0.0, 1.05, 0.0), at(0.0, 0.95, 0.0), at(0.0, 1.05, 0.0)]));
    // Through a rod thinner than its samples would lie deep, off its axis.
    let rod = BoundaryShape::Cylinder { radius: 0.06, half_height: 1.0, fluid: FluidSide::Outside };
    assert!(leaks(&rod, &[at(-0.1, 0.0, 0.02), at(0.1, 0.0, 0.02)]));
    assert!(!leaks(&rod, &[at(-0.1, 0.0, 0.08), at(0.1, 0.0, 0.08)]), "past it");
}

#[test]
fn rooms_grounds_and_cups_leak_to_where_no_fluid_belongs() {
    let at = Vec3::new;
    let room = BoundaryShape::Sphere { radius: 0.5, fluid: FluidSide::Inside };
    assert!(leaks(&room, &[at(0.4, 0.0, 0.0), at(0.8, 0.0, 0.0)]));
    assert!(!leaks(&room, &[at(0.4, 0.0, 0.0), at(0.52, 0.0, 0.0), at(0.4, 0.1, 0.0)]));
    let tank = BoundaryShape::Container { half_extents: Vec3::ONE, open: [false, false, false, true, false, false] };
    assert!(leaks(&tank, &[at(0.9, 0.0, 0.0), at(1.3, 0.0, 0.0)]));
    assert!(leaks(&tank, &[at(0.9, -0.9, 0.0), at(1.3, -1.3, 0.0)]), "through its edge");
    assert!(
        !leaks(&tank, &[at(0.9, 0.9, 0.0), at(0.9, 1.2, 0.0), at(1.3, 1.2, 0.0), at(1.3, 0.0, 0.0)]),
        "over its rim"
    );
    let cup = BoundaryShape::Cup { radius: 0.4, half_height: 0.3, thickness: 0.05 };
    assert!(leaks(&cup, &[at(0.35, 0.0, 0.0), at(0.5, 0.0, 0.0)]));
    assert!(leaks(&cup, &[at(0.1, -0.25, 0.1), at(0.1, -0.4, 0.1)]));
    assert!(!leaks(&cup, &[at(0.35, 0.2, 0.0), at(0.35, 0.45, 0.0), at(0.55, 0.45, 0.0), at(0.55, 0.0, 0.0)]));
    let field = HeightField::new([2.0, 2.0], [3, 3], vec![0.2, 0.1, 0.2, 0.1, 0.0, 0.1, 0.2, 0.1, 0.2]).unwrap();
    let ground = BoundaryShape::HeightField { field };
    assert!(leaks(&ground, &[at(0.1, 0.1, 0.1), at(0.1, -0.3, 0.1)]));
    assert!(!leaks(&ground, &[at(0.1, 0.1, 0.1), at(1.5, 0.4, 0.1), at(1.5, -2.0, 0.1)]), "off its edge");
}

#[test]
fn walls_that_move_leak_by_their_own_way_and_not_by_being_put_elsewhere() {
    let plate = || watch(BoundaryShape::Box { half_extents: Vec3::new(1.0, 0.02, 1.0) });
    let pose = |y: f32, angle: f32| WallPose { center: Vec3::Y * y, rotation: Quat::from_rotation_z(angle) };
    let still = [Vec3::new(0.5, 0.1, 0.0)];
    let mut watch = plate();
    watch.look(&[0], &still);
    watch.move_wall(0, pose(0.2, 0.0));
    assert_eq!(watch.look(&[0], &still), 1, "it sweeps over the particle");
    let mut watch = plate();
    watch.look(&[0], &still);
    watch.put_wall(0, pose(0.2, 0.0));
    assert_eq!(watch.look(&[0], &still), 0);
    // The fluid goes along, far and round.
    let mut watch = plate();
    let (mut angle, mut y) = (0.0f32, 0.0f32);
    for _ in 0..100 {
        (angle, y) = (angle + 0.1, y + 0.3);
        let place = pose(y, angle);
        watch.move_wall(0, place);
        assert_eq!(watch.look(&[0], &[place.center + place.rotation * still[0]]), 0);
    }
    // It turns through one that stands still far away from its centre.
    watch.move_wall(0, pose(y, angle + 0.5));
    let place = pose(y, angle);
    assert_eq!(watch.look(&[0], &[place.center + place.rotation * still[0]]), 1);
    assert_eq!(watch.total(), 1);
    // Particles that come into being behind a wall count, those in front do not.
    let mut watch =
        LeakWatch::new(&layer(), &[Boundary::new(BoundaryShape::Box { half_extents: Vec3::ONE }, Vec3::ZERO)]);
    assert_eq!(watch.look(&[1, 2, 3], &[Vec3::ZERO, Vec3::Y * 1.1, Vec3::NAN]), 1);
    // Without walls nothing does, and those that are gone are forgotten.
    watch.set_walls(&layer(), &[]);
    assert_eq!(watch.look(&[2], &[Vec3::ZERO]), 0);
}

#[test]
fn many_particles_far_from_walls_cost_little_and_are_not_missed_when_they_come() {
    // A stone's throw to the wall, in a hundred looks of random stride.
    let mut watch = watch(BoundaryShape::Box { half_extents: Vec3::new(5.0, 0.01, 5.0) });
    let mut random = Random(5);
    let mut places: Vec<Vec3> = (0..200).map(|_| Vec3::Y * 5.0 + random.vector()).collect();
    let ids: Vec<u32> = (0..200).rev().collect();
    while places.iter().any(|place| place.y > -1.0) {
        watch.look(&ids, &places);
        places.iter_mut().for_each(|place| place.y -= 0.2 * (1.0 + random.next()));
    }
    watch.look(&ids, &places);
    assert_eq!(watch.total(), 200);
}

#[test]
fn what_a_particle_came_into_is_not_asked_of_other_walls() {
    let plate = BoundaryShape::Box { half_extents: Vec3::new(1.0, 0.05, 1.0) };
    let at = |y: f32| Boundary::new(plate.clone(), Vec3::Y * y);
    // On a plate; then there is none below it, but one just above.
    let mut watch = LeakWatch::new(&layer(), &[at(-0.05)]);
    let place = [Vec3::Y * 0.001];
    watch.look(&[3], &place);
    watch.set_walls(&layer(), &[at(0.052)]);
    assert_eq!(watch.look(&[3], &place), 0);
    // It still counts what goes through that one.
    assert_eq!(watch.look(&[3], &[Vec3::Y * 0.11]), 1);
}

#[test]
fn what_comes_into_a_moving_cup_has_not_gone_through_it() {
    let cup = BoundaryShape::Cup { radius: 0.4, half_height: 0.3, thickness: 0.05 };
    let mut watch = watch(cup);
    let pose = |x: f32| WallPose { center: Vec3::X * x, rotation: Quat::IDENTITY };
    // 10 m/s, sixteen looks a second. An emitter in it pours a particle each tick; one that came in earlier goes with it.
    let (mut ids, mut inside) = (Vec::new(), Vec::new());
    for look in 0..8 {
        let x = 0.625 * look as f32;
        watch.move_wall(0, pose(x));
        ids.push(look);
        inside.push(Vec3::new(0.0, 0.1, 0.0));
        let places: Vec<Vec3> = inside.iter().map(|at| at + Vec3::X * x).collect();
        assert_eq!(watch.look(&ids, &places), 0, "look {look}");
    }
    // The cup leaves a particle behind: it goes through the side.
    watch.move_wall(0, pose(0.625 * 8.0));
    ids.push(8);
    inside.push(Vec3::ZERO);
    let mut places: Vec<Vec3> = inside.iter().map(|at| at + Vec3::X * 0.625 * 8.0).collect();
    places[0].x -= 0.625;
    assert_eq!(watch.look(&ids, &places), 1);
    let mut watch =
        LeakWatch::new(&layer(), &[Boundary::new(BoundaryShape::Box { half_extents: Vec3::ONE }, Vec3::ZERO)]);
    watch.look(&[], &[]);
    watch.move_wall(0, pose(3.0));
    // Where the wall was there is room, where it is there is none.
    assert_eq!(watch.look(&[1, 2], &[Vec3::ZERO, Vec3::X * 3.0]), 1);
}
