//! Samples of rapier shapes.

use freshet_core::prelude::{Body, FluidScene, Solid};
use freshet_core::sampling::wall_layer::WallLayer;
use freshet_rapier::{SamplingError, body_from_rigid_body, sample_shape};
use glam::{Quat, Vec3, Vec3Swizzles};
use rapier3d::parry::shape::HeightFieldCellStatus;
use rapier3d::parry::utils::Array2;
use rapier3d::prelude::*;

const SPACING: f32 = 0.05;

fn layer() -> WallLayer {
    FluidScene::with_spacing(SPACING).wall_layer().unwrap()
}

#[test]
fn a_balls_samples_lie_the_layers_depth_inside() {
    let samples = sample_shape(&*SharedShape::ball(0.15), &layer()).unwrap();
    for sample in &samples {
        assert!((0.15 - sample.length() - layer().depth).abs() < 1e-5, "{sample}");
    }
    let area = 4.0 * std::f32::consts::PI * 0.15 * 0.15;
    let share = area / samples.len() as f32 / (SPACING * SPACING);
    assert!((0.9..1.1).contains(&share), "{share} of a spacing squared each");
}

#[test]
fn a_cuboids_samples_lie_the_layers_depth_inside() {
    let half = Vec3::new(0.1, 0.2, 0.15);
    for sample in sample_shape(&*SharedShape::cuboid(half.x, half.y, half.z), &layer()).unwrap() {
        let depth = (half - sample.abs()).min_element();
        assert!((depth - layer().depth).abs() < 1e-5, "{sample}");
    }
}

#[test]
fn samples_are_about_the_centre_of_mass() {
    let mut world = PhysicsWorld::new();
    let turned = RigidBodyBuilder::dynamic().translation(Vec3::ONE).rotation(Vec3::new(0.2, 0.3, 0.4));
    let offset = ColliderBuilder::cuboid(0.1, 0.2, 0.15).translation(Vec3::X).rotation(Vec3::Z * 0.5).density(500.0);
    let (handle, _) = world.insert(turned, offset);
    let body = body_from_rigid_body("box", &world.bodies[handle], &world.colliders, &layer()).unwrap();
    let mean = body.samples.iter().sum::<Vec3>() / body.samples.len() as f32;
    assert!(mean.length() < 1e-5, "{mean}");
    let back = glam::Quat::from_rotation_z(-0.5);
    for sample in &body.samples {
        let depth = (Vec3::new(0.1, 0.2, 0.15) - (back * *sample).abs()).min_element();
        assert!((depth - layer().depth).abs() < 1e-5, "{sample}");
    }
    // What is solid lies as they do.
    let [ref solid] = body.solids[..] else { panic!("{:?}", body.solids) };
    let (inside, outside) = (Vec3::new(0.09, 0.19, 0.14), Vec3::new(0.11, 0.19, 0.14));
    let turn = back.conjugate();
    assert!(solid.contains(turn * inside, 0.0) && !solid.contains(turn * outside, 0.0), "{solid:?}");
}

#[test]
fn two_balls_have_the_samples_of_both() {
    let mut world = PhysicsWorld::new();
    let (handle, _) = world.insert(RigidBodyBuilder::dynamic(), ColliderBuilder::ball(0.15).translation(Vec3::X * 0.3));
    world.insert_collider(ColliderBuilder::ball(0.15).translation(Vec3::X * -0.3), Some(handle));
    world.insert_collider(ColliderBuilder::capsule_y(1.0, 1.0).sensor(true), Some(handle));
    let one = sample_shape(&*SharedShape::ball(0.15), &layer()).unwrap().len();
    world.bodies[handle].recompute_mass_properties_from_colliders(&world.colliders);
    let body = body_from_rigid_body("dumbbell", &world.bodies[handle], &world.colliders, &layer()).unwrap();
    assert_eq!(body.samples.len(), 2 * one, "and none of the sensor");
    assert_eq!(body.solids.len(), 2, "and none of the sensor");
    for x in [-0.44, -0.16, 0.16, 0.44] {
        let point = Vec3::X * x;
        assert!(body.solids.iter().any(|solid| solid.contains(point, 0.0)), "{x}");
    }
    for x in [-0.46, -0.14, 0.0, 0.14, 0.46] {
        assert!(!body.solids.iter().any(|solid| solid.contains(Vec3::X * x, 0.0)), "{x}");
    }
}

/// How deep below a shape's surface rapier finds a point, m.
fn depth(shape: &dyn Shape, point: Vec3) -> f32 {
    match shape.as_typed_shape() {
        TypedShape::RoundCuboid(round) => return depth(&round.inner_shape, point) + round.border_radius,
        TypedShape::RoundCylinder(round) => return depth(&round.inner_shape, point) + round.border_radius,
        TypedShape::RoundCone(round) => return depth(&round.inner_shape, point) + round.border_radius,
        TypedShape::RoundConvexPolyhedron(round) => return depth(&round.inner_shape, point) + round.border_radius,
        TypedShape::ConvexPolyhedron(hull) => {
            // Inside it the nearest plane of a face is exact.
            let below = |face: &Triangle| -> f32 { face.scaled_normal().normalize().dot(face.a - point) };
            let (vertices, triangles) = hull.to_trimesh();
            let faces = triangles.iter().map(|corners| corners.map(|index| vertices[index as usize]));
            let least = faces.map(|[a, b, c]| below(&Triangle::new(a, b, c))).fold(f32::INFINITY, f32::min);
            if least > 0.0 {
                return least;
            }
        }
        _ => {}
    }
    let projection = shape.project_local_point(point, false);
    let distance = projection.point.distance(point);
    // Of a mesh rapier knows the surface only; that of these tests is a box.
    let is_in_mesh = shape.shape_type() == ShapeType::TriMesh && shape.compute_local_aabb().contains_local_point(point);
    if projection.is_inside || is_in_mesh { distance } else { -distance }
}

const TRIES: u32 = 60_000;

/// Points in the box around a shape, and outside of it by `beyond`, m.
fn points_around(shape: &dyn Shape, beyond: f32) -> impl Iterator<Item = Vec3> {
    let bounds = shape.compute_local_aabb().loosened(beyond);
    let mut state = 5u32;
    let mut random = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 16_777_216.0
    };
    let size = bounds.maxs - bounds.mins;
    (0..TRIES).map(move |_| bounds.mins + size * Vec3::new(random(), random(), random()))
}

/// Points of the layer of a shape, found by trying, and the area of the layer, m2.
fn points_of_layer(shape: &dyn Shape) -> (Vec<Vec3>, f32) {
    let (near, deep) = (0.05 * SPACING, layer().depth);
    let tries = points_around(shape, 0.0);
    let found: Vec<Vec3> = tries.filter(|&point| (depth(shape, point) - deep).abs() < near).collect();
    let share = found.len() as f32 / TRIES as f32;
    let area = share * shape.compute_local_aabb().extents().element_product() / (2.0 * near);
    (found, area)
}

fn closest_pair(samples: &[Vec3]) -> f32 {
    let pairs = samples.iter().enumerate().flat_map(|(i, a)| samples[..i].iter().map(move |b| a.distance(*b)));
    pairs.fold(f32::INFINITY, f32::min)
}

fn nearest(samples: &[Vec3], point: Vec3) -> f32 {
    samples.iter().map(|sample| sample.distance(point)).fold(f32::INFINITY, f32::min)
}

/// Every shape that is one solid, thicker than twice the depth of the layer.
fn solid_shapes() -> Vec<SharedShape> {
    let corners: Vec<Vec3> =
        (0..8).map(|i| Vec3::from([i & 1, i >> 1 & 1, i >> 2].map(|bit| bit as f32 - 0.5))).collect();
    let wedge: Vec<Vec3> = corners.iter().map(|corner| *corner * Vec3::new(0.5, 0.4, 0.5 + 0.2 * corner.y)).collect();
    let (vertices, triangles) = Cuboid::new(Vec3::new(0.2, 0.15, 0.1)).to_trimesh();
    vec![
        SharedShape::capsule_y(0.2, 0.15),
        SharedShape::capsule(Vec3::new(-0.2, 0.1, 0.0), Vec3::new(0.1, 0.3, 0.2), 0.12),
        SharedShape::capsule(Vec3::X, Vec3::X, 0.15),
        SharedShape::cylinder(0.2, 0.18),
        SharedShape::cone(0.25, 0.3),
        // Less rounded than the layer is deep, as much, and more.
        SharedShape::round_cuboid(0.15, 0.2, 0.1, 0.02),
        SharedShape::round_cuboid(0.15, 0.2, 0.1, layer().depth),
        SharedShape::round_cuboid(0.1, 0.15, 0.05, 0.1),
        SharedShape::round_cylinder(0.15, 0.15, 0.03),
        SharedShape::round_cylinder(0.15, 0.01, 0.08),
        SharedShape::round_cone(0.15, 0.2, 0.03),
        SharedShape::round_cone(0.15, 0.2, 0.08),
        SharedShape::convex_hull(&wedge).unwrap(),
        SharedShape::round_convex_hull(&wedge, 0.03).unwrap(),
        SharedShape::round_convex_hull(&wedge, 0.06).unwrap(),
        SharedShape::trimesh_with_flags(vertices, triangles, TriMeshFlags::ORIENTED).unwrap(),
    ]
}

#[test]
fn the_layer_of_every_shape_is_whole_at_its_depth_and_as_heavy_as_its_area() {
    let weight = |samples: &[Vec3]| layer().volumes(samples).iter().sum::<f32>();
    // Of a square metre.
    let plane = weight(&layer().plane(Vec3::Y, 0.5, 0.5).unwrap());
    for shape in solid_shapes() {
        let name = format!("{:?}", shape.shape_type());
        let samples = sample_shape(&*shape, &layer()).unwrap();
        for &sample in &samples {
            let off = (depth(&*shape, sample) - layer().depth) / SPACING;
            assert!(off.abs() < 0.06, "{name}: {off} spacings off the depth");
        }
        let (points, area) = points_of_layer(&*shape);
        assert!(points.len() > 300, "{name}: {}", points.len());
        let gap = points.iter().map(|&point| nearest(&samples, point)).fold(0.0, f32::max) / SPACING;
        // The points are as much as 0.05 off the layer.
        assert!(gap < 0.78, "{name}: a point of the layer is {gap} spacings from the nearest sample");
        let closest = closest_pair(&samples) / SPACING;
        assert!(closest >= 0.5, "{name}: two samples are {closest} spacings apart");
        // Balls have as many samples as their visible surface has spacings squared, which weigh as much.
        let density = samples.len() as f32 * SPACING * SPACING / area;
        assert!((1.0..2.1).contains(&density), "{name}: {density} samples for each spacing squared");
        // Those along an edge have more neighbours than on a plane.
        let share = weight(&samples) / (area * plane);
        assert!((0.85..1.05).contains(&share), "{name}: {share} of the weight of a plane of its area");
    }
}

/// A body with one collider, its centre of mass at the origin.
fn body_of(shape: SharedShape) -> Body {
    let mut world = PhysicsWorld::new();
    let (handle, _) = world.insert(RigidBodyBuilder::fixed(), ColliderBuilder::new(shape).density(0.0));
    body_from_rigid_body("body", &world.bodies[handle], &world.colliders, &layer()).unwrap()
}

fn is_solid(body: &Body, point: Vec3) -> bool {
    body.solids.iter().any(|solid: &Solid| solid.contains(point, 0.0))
}

#[test]
fn every_shape_is_solid_where_rapiers_is() {
    for shape in solid_shapes() {
        let body = body_of(shape.clone());
        assert_eq!(body.samples, sample_shape(&*shape, &layer()).unwrap());
        let (mut inside, mut outside) = (0, 0);
        for point in points_around(&*shape, SPACING).step_by(30) {
            let deep = depth(&*shape, point);
            if deep.abs() > 0.01 * SPACING {
                assert_eq!(is_solid(&body, point), deep > 0.0, "{:?}: {point}, {deep} m deep", shape.shape_type());
                if deep > 0.0 { inside += 1 } else { outside += 1 }
            }
        }
        assert!(inside > 100 && outside > 100, "{:?}: {inside} in, {outside} out", shape.shape_type());
    }
}

#[test]
fn what_is_thinner_than_two_layers_has_one_in_its_middle() {
    let half = 0.6 * layer().depth;
    let corners: Vec<Vec3> =
        (0..8).map(|i| Vec3::from([i & 1, i >> 1 & 1, i >> 2].map(|bit| bit as f32 - 0.5))).collect();
    let plate: Vec<Vec3> = corners.iter().map(|corner| *corner * Vec3::new(0.5, 2.0 * half, 0.4)).collect();
    for shape in [
        SharedShape::convex_hull(&plate).unwrap(),
        SharedShape::round_cuboid(0.25, 0.5 * half, 0.2, 0.5 * half),
        SharedShape::cuboid(0.25, half, 0.2),
    ] {
        let samples = sample_shape(&*shape, &layer()).unwrap();
        assert!(samples.len() > 50, "{:?}: {}", shape.shape_type(), samples.len());
        let off = samples.iter().map(|sample| sample.y.abs()).fold(0.0, f32::max) / SPACING;
        assert!(off < 0.25, "{:?}: {off} spacings off the middle", shape.shape_type());
    }
    // Half way to the middle, as those of walls.
    let cylinder = SharedShape::cylinder(0.2, half);
    for sample in sample_shape(&*cylinder, &layer()).unwrap() {
        let off = (depth(&*cylinder, sample) - 0.5 * half) / SPACING;
        assert!(off.abs() < 0.06, "{sample}: {off} spacings off");
    }
}

#[test]
fn parts_of_a_compound_that_overlap_have_the_layer_of_both() {
    // A cross of two bars.
    let (long, thick) = (0.4, 0.15);
    let bars = [SharedShape::cuboid(long, thick, thick), SharedShape::cuboid(thick, long, thick)];
    let turn = Pose::from_parts(Vec3::new(0.1, -0.2, 0.3), Quat::from_rotation_x(0.5));
    let cross = SharedShape::compound(bars.iter().map(|bar| (turn, bar.clone())).collect());
    let body = body_of(cross.clone());
    assert_eq!(body.samples, sample_shape(&*cross, &layer()).unwrap());
    let alone: usize = bars.iter().map(|bar| sample_shape(&**bar, &layer()).unwrap().len()).sum();
    // Each bar crosses four faces of the other, of which nine samples each lie deeper than the layer of both.
    assert!(alone - body.samples.len() >= 36, "{} of {alone}", body.samples.len());
    let deepest = |point: Vec3| bars.iter().map(|bar| depth(&**bar, point)).fold(f32::NEG_INFINITY, f32::max);
    let deep = layer().depth;
    for &sample in &body.samples {
        let off = (deepest(turn.inverse() * sample) - deep) / SPACING;
        assert!(off.abs() < 0.11, "{off} spacings off the depth");
    }
    let mut points = 0;
    for point in points_around(&*cross, 0.0) {
        let local = deepest(turn.inverse() * point);
        if (local - deep).abs() < 0.05 * SPACING {
            let gap = nearest(&body.samples, point) / SPACING;
            assert!(gap < 0.8, "{gap} spacings from the nearest sample");
            points += 1;
        }
        assert!(local.abs() < 1e-5 || is_solid(&body, point) == (local > 0.0), "{point}");
    }
    assert!(points > 300, "{points}");
}

/// Inner half width and wall of a cup without a lid.
const ROOM: f32 = 0.25;
const WALL: f32 = 0.06;

#[test]
fn a_cup_of_cuboids_is_hollow() {
    let (middle, whole) = (ROOM + 0.5 * WALL, ROOM + WALL);
    let side = |x: f32, z: f32, half: Vec3| {
        (Pose::from_translation(Vec3::new(x, 0.0, z)), SharedShape::cuboid(half.x, half.y, half.z))
    };
    let bottom = SharedShape::cuboid(whole, 0.5 * WALL, whole);
    let cup = SharedShape::compound(vec![
        (Pose::from_translation(Vec3::NEG_Y * middle), bottom),
        side(middle, 0.0, Vec3::new(0.5 * WALL, ROOM, whole)),
        side(-middle, 0.0, Vec3::new(0.5 * WALL, ROOM, whole)),
        side(0.0, middle, Vec3::new(ROOM, ROOM, 0.5 * WALL)),
        side(0.0, -middle, Vec3::new(ROOM, ROOM, 0.5 * WALL)),
    ]);
    check_cup(&body_of(cup));
}

#[test]
fn a_cup_of_triangles_is_hollow() {
    // The outline of half a section, turned in steps of a quarter: a square cup.
    let whole = ROOM + WALL;
    let outline = [(0.0, -whole), (whole, -whole), (whole, ROOM), (ROOM, ROOM), (ROOM, -ROOM), (0.0, -ROOM)];
    let corner = |(half, y): (f32, f32), turn: u32| {
        Quat::from_rotation_y(std::f32::consts::FRAC_PI_2 * turn as f32) * Vec3::new(half, y, half)
    };
    let vertices: Vec<Vec3> = outline.iter().flat_map(|&at| (0..4).map(move |turn| corner(at, turn))).collect();
    let quads = (0..outline.len() as u32 - 1).flat_map(|row| (0..4).map(move |turn| (4 * row, turn, (turn + 1) % 4)));
    let triangles: Vec<[u32; 3]> =
        quads.flat_map(|(row, a, b)| [[row + a, row + b, row + 4 + a], [row + b, row + 4 + b, row + 4 + a]]).collect();
    check_cup(&body_of(SharedShape::trimesh(vertices, triangles).unwrap()));
}

fn check_cup(body: &Body) {
    for point in [Vec3::ZERO, Vec3::splat(0.9 * ROOM), Vec3::new(0.0, -0.99 * ROOM, 0.0), Vec3::Y * 1.1 * ROOM] {
        assert!(!is_solid(body, point), "{point} is in the cup");
    }
    let middle = ROOM + 0.5 * WALL;
    for point in [Vec3::NEG_Y, Vec3::X, Vec3::NEG_Z].map(|way| middle * way) {
        assert!(is_solid(body, point), "{point} is in its wall");
    }
    let outside = |sample: &Vec3| sample.abs().max_element() > ROOM + WALL + 1e-4;
    let in_room = |sample: &Vec3| sample.xz().abs().max_element() < ROOM && sample.y > -ROOM;
    assert!(!body.samples.iter().any(|sample| outside(sample) || in_room(sample)));
    for &way in &[Vec3::NEG_Y, Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z] {
        let (u, v) = way.any_orthonormal_pair();
        for (i, j) in (-9..=9).flat_map(|i| (-9..=9).map(move |j| (i as f32 / 10.0, j as f32 / 10.0))) {
            let gap = nearest(&body.samples, middle * way + ROOM * (i * u + j * v)) / SPACING;
            assert!(gap < 0.8, "{gap} spacings from the nearest sample");
        }
    }
}

#[test]
fn a_mesh_with_holes_is_a_sheet() {
    let vertices = [(-0.3, -0.3), (0.3, -0.3), (0.3, 0.3), (-0.3, 0.3)].map(|(x, z)| Vec3::new(x, 0.0, z)).to_vec();
    let body = body_of(SharedShape::trimesh(vertices, vec![[0, 1, 2], [0, 2, 3]]).unwrap());
    assert!(body.samples.len() > 140 && body.samples.iter().all(|sample| sample.y == 0.0), "{}", body.samples.len());
    for (height, inside) in [(0.9, true), (-0.9, true), (1.1, false), (-1.1, false)] {
        assert_eq!(is_solid(&body, Vec3::Y * height * layer().depth), inside, "{height}");
    }
}

fn ground(scale: Vec3) -> HeightField {
    // Rows along z, columns along x.
    let slope = |row: usize, column: usize| 0.1 * row as f32 + 0.02 * column as f32;
    let heights = (0..5).flat_map(|column| (0..4).map(move |row| slope(row, column))).collect();
    HeightField::new(Array2::new(4, 5, heights), scale)
}

#[test]
fn a_height_field_is_ground() {
    for scale in [Vec3::new(0.8, 1.0, 0.6), Vec3::new(1.0, 0.5, 0.8)] {
        let field = ground(scale);
        let body = body_of(SharedShape::new(field.clone()));
        assert!(body.samples.len() > 150, "{}", body.samples.len());
        for &sample in &body.samples {
            let off = (field.project_local_point(sample, false).point.distance(sample) - layer().depth) / SPACING;
            assert!(off.abs() < 0.06, "{scale}: {off} spacings off the depth");
        }
        for triangle in field.triangles() {
            let middle = triangle.center();
            assert!(is_solid(&body, middle - 0.1 * SPACING * Vec3::Y), "{scale}: below {middle}");
            assert!(!is_solid(&body, middle + 0.1 * SPACING * Vec3::Y), "{scale}: above {middle}");
        }
    }
}

#[test]
fn a_height_field_with_holes_is_a_sheet() {
    let mut field = ground(Vec3::new(0.8, 1.0, 0.6));
    field.set_cell_status(1, 1, HeightFieldCellStatus::CELL_REMOVED);
    let hole = Vec3::new(-0.1, field.heights()[(1, 1)], 0.0);
    let body = body_of(SharedShape::new(field.clone()));
    for &sample in &body.samples {
        assert!(field.project_local_point(sample, false).point.distance(sample) < 1e-4, "{sample}");
    }
    let whole = sample_shape(&ground(field.scale()), &layer()).unwrap().len();
    assert!(body.samples.len() < whole && nearest(&body.samples, hole) > 0.5 * SPACING, "{hole}");
}

#[test]
fn what_cannot_be_sampled_says_so() {
    let refused = |shape: SharedShape| sample_shape(&*shape, &layer()).unwrap_err();
    for (shape, name) in [
        (SharedShape::halfspace(Vec3::Y), "HalfSpace"),
        (SharedShape::segment(Vec3::ZERO, Vec3::X), "Segment"),
        (SharedShape::triangle(Vec3::ZERO, Vec3::X, Vec3::Y), "Triangle"),
        (SharedShape::polyline(vec![Vec3::ZERO, Vec3::X], None), "Polyline"),
        (SharedShape::compound(vec![(Pose::IDENTITY, SharedShape::halfspace(Vec3::Y))]), "HalfSpace"),
    ] {
        let error = refused(shape);
        assert!(matches!(error, SamplingError::Unsupported { .. }), "{error}");
        let text = error.to_string();
        assert!(
            text.contains(name) && text.contains("Ball, Cuboid, Capsule") && text.contains("HeightField"),
            "{text}"
        );
    }
    let tiny = 0.2 * SPACING;
    for (shape, field) in [
        (SharedShape::ball(tiny), "radius"),
        (SharedShape::cuboid(1.0, tiny, 1.0), "half_extents.y"),
        (SharedShape::capsule_y(1.0, tiny), "radius"),
        (SharedShape::capsule_y(0.0, tiny), "radius"),
        (SharedShape::cylinder(tiny, 1.0), "half_height"),
        (SharedShape::cone(1.0, tiny), "radius"),
        (SharedShape::round_cylinder(1.0, tiny, tiny), "radius"),
        (SharedShape::round_cone(1.0, tiny, tiny), "radius"),
        (SharedShape::ball(f32::NAN), "radius"),
    ] {
        let name = format!("{:?}", shape.shape_type());
        let error = refused(shape);
        assert!(matches!(&error, SamplingError::Invalid(error) if error.field == field), "{name}: {error}");
    }
    let error = refused(SharedShape::cylinder(1e4, 1e4));
    assert!(error.to_string().contains("samples"), "{error}");
    let mut world = PhysicsWorld::new();
    let handle = world.insert_body(RigidBodyBuilder::dynamic());
    let error = body_from_rigid_body("ghost", &world.bodies[handle], &world.colliders, &layer()).unwrap_err();
    assert!(error.to_string().contains("ghost"), "{error}");
}
