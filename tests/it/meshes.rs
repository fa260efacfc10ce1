//! Walls of meshes, convex hulls, height fields and images.

use std::time::Duration;

use bevy::asset::RenderAssetUsages;
use bevy::mesh::PrimitiveTopology;
use bevy::prelude::*;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};
use bevy_freshet::prelude::*;
use bevy_rapier3d::prelude::*;
use freshet_core::geometry::{HeightField, TriangleMesh};
use freshet_core::scene::{Boundary, BoundaryShape, FluidScene, FluidSide, Volume};

use crate::components::{front, positions};
use crate::harness::{ALL, Tank, TestApp, WATER};

/// Spacing of all domains here, m.
const SPACING: f32 = 0.1;

/// How far fluid that falls on a wall for a second sinks into it (docs/boundaries.md): a quarter of the spacing, m.
const SINKS: f32 = 0.25 * SPACING;

fn add<A: Asset>(test: &mut TestApp, asset: A) -> Handle<A> {
    test.world().resource_mut::<Assets<A>>().add(asset)
}

/// A mesh without indices.
fn mesh_of(topology: PrimitiveTopology, vertices: Vec<Vec3>) -> Mesh {
    Mesh::new(topology, RenderAssetUsages::default()).with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vertices)
}

/// Half a sphere, open at the top, with a straight collar as high as its radius on its rim, its centre in the middle of the rim.
fn bowl(radius: f32) -> Mesh {
    const AROUND: u32 = 24;
    let arc = (0..=8).map(|step| (step as f32 / 8.0 * std::f32::consts::FRAC_PI_2).sin_cos());
    let mut profile: Vec<Vec2> = arc.map(|(sin, cos)| radius * Vec2::new(sin, -cos)).collect();
    profile.push(Vec2::splat(radius));
    let place = |point: Vec2, step: u32| {
        let (sin, cos) = ((step % AROUND) as f32 / AROUND as f32 * std::f32::consts::TAU).sin_cos();
        Vec3::new(point.x * cos, point.y, point.x * sin)
    };
    let mut vertices = Vec::new();
    for pair in profile.windows(2) {
        for step in 0..AROUND {
            let [a, b] = [step, step + 1].map(|step| place(pair[0], step));
            let [c, d] = [step, step + 1].map(|step| place(pair[1], step));
            vertices.extend([a, b, c, c, b, d]);
        }
    }
    mesh_of(PrimitiveTopology::TriangleList, vertices)
}

/// A ball of water of 0.3 m that falls, in a domain without walls.
fn falling_ball(test: &mut TestApp, (backend, mode): (FluidBackend, FluidMode)) -> Entity {
    let domain = test.spawn(FluidDomain::with_spacing(SPACING).on(backend).in_mode(mode));
    test.spawn((FluidVolume::from(Sphere::new(0.3)), Transform::from_xyz(0.0, 0.65, 0.0), FluidInDomain(domain)));
    domain
}

#[test]
fn a_bowl_of_triangles_holds_water_poured_into_it() {
    let radius = 0.6;
    let center = Vec3::new(0.0, radius, 0.0);
    for choice in [ALL[0], ALL[2]] {
        let mut test = TestApp::new();
        let domain = falling_ball(&mut test, choice);
        // Made for a size of one: the scale is the entity's.
        let mesh = add(&mut test, bowl(1.0));
        let pose = Transform::from_translation(center).with_scale(Vec3::splat(radius));
        test.spawn((FluidBoundary::mesh(mesh), pose, FluidInDomain(domain)));
        test.tick(1);
        let start = test.settle(domain).particles;
        assert!(start > 100, "{start}");
        for _ in 0..8 {
            test.tick(12);
            let positions = positions(&mut test, domain);
            assert_eq!(positions.len() as u32, start, "{choice:?}");
            for position in positions {
                let local = position - center;
                let (around, below) = (local.xz().length(), local.y < 0.0 && local.length() > radius);
                assert!(around < radius && !below && local.y < radius, "{choice:?}: {position} has left the bowl");
            }
        }
        // It has come to the bottom, and lies at rest on it.
        let lowest = positions(&mut test, domain).iter().fold(f32::INFINITY, |low, position| low.min(position.y));
        assert!(lowest > 0.0 && lowest < 2.0 * SPACING, "{choice:?}: the lowest is at {lowest}");
        let stats = test.settle(domain);
        assert!(stats.removed == 0 && stats.max_speed < 1.0, "{choice:?}: {stats:?}");
        test.expect_no_complaints();
    }
}

#[test]
fn a_valley_of_heights_keeps_its_water() {
    // Its rim is 1.6 m high, the highest water begins at 0.95 m: it has not the energy to leave.
    let (size, counts, floor) = (Vec2::splat(2.0), UVec2::splat(21), |x: f32, z: f32| 1.6 * (x * x + z * z));
    let heights: Vec<f32> =
        (0..21).flat_map(|j| (0..21).map(move |i| floor(0.1 * i as f32 - 1.0, 0.1 * j as f32 - 1.0))).collect();
    // As it was meant, without the plugin's help.
    let field = HeightField::new([2.0; 2], [21; 2], heights.clone()).expect("a field");
    let ground = Boundary::new(BoundaryShape::HeightField { field }, Vec3::ZERO);
    let pixels = heights.iter().flat_map(|height| (height / 3.2).to_le_bytes()).collect();
    let extent = Extent3d { width: 21, height: 21, depth_or_array_layers: 1 };
    let image = Image::new(extent, TextureDimension::D2, pixels, TextureFormat::R32Float, RenderAssetUsages::default());
    for (choice, kind) in [(ALL[0], "function"), (ALL[0], "image"), (ALL[0], "numbers"), (ALL[2], "function")] {
        let mut test = TestApp::new();
        let domain = falling_ball(&mut test, choice);
        let boundary = match kind {
            "function" => FluidBoundary::height_function(size, counts, floor),
            "image" => FluidBoundary::height_image(add(&mut test, image.clone()), size, 3.2),
            _ => FluidBoundary::height_field(size, counts, heights.clone()),
        };
        test.spawn((boundary, FluidInDomain(domain)));
        test.tick(1);
        let start = test.settle(domain).particles;
        for _ in 0..5 {
            test.tick(12);
            let positions = positions(&mut test, domain);
            assert_eq!(positions.len() as u32, start);
            for position in positions {
                let is_out = ground.is_on_wrong_side(position, SINKS) || position.xz().abs().max_element() > 1.0;
                assert!(!is_out, "{choice:?} by {kind}: {position}");
            }
        }
        test.expect_no_complaints();
    }
}

#[test]
fn a_scaled_mesh_of_a_box_is_the_box() {
    for choice in [ALL[0], ALL[2]] {
        let by = |kind: &str| {
            let mut test = TestApp::new();
            let tank = Tank::spawn(&mut test, choice);
            let member = FluidInDomain(tank.domain);
            let (size, at) = (Vec3::new(0.1, 1.0, 0.5), Transform::from_xyz(0.6, 0.5, 0.25));
            match kind {
                "box" => {
                    test.spawn((FluidBoundary::cuboid(size.x, size.y, size.z), at, member));
                }
                kind => {
                    let mesh = add(&mut test, Mesh::from(Cuboid::new(2.0, 0.25, 0.5)));
                    let boundary =
                        if kind == "hull" { FluidBoundary::convex_hull(mesh) } else { FluidBoundary::mesh(mesh) };
                    // A part of the scale is the parent's, and one axis is mirrored.
                    let parent = test.spawn(at.with_scale(Vec3::new(0.1, 2.0, -1.0)));
                    let rest = Transform::from_scale(Vec3::new(0.5, 2.0, 1.0));
                    test.spawn((boundary, rest, ChildOf(parent), member));
                }
            }
            test.tick(31);
            let found = positions(&mut test, tank.domain);
            test.expect_no_complaints();
            let wall = Boundary::new(BoundaryShape::Box { half_extents: 0.5 * size }, at.translation);
            for &position in &found {
                assert!(!wall.is_on_wrong_side(position, SINKS), "{choice:?} by {kind}: {position}");
            }
            let front = front(&mut test, tank.domain);
            let height = found.iter().map(|position| f64::from(position.y)).sum::<f64>() / found.len() as f64;
            (front, height)
        };
        let (front, height) = by("box");
        assert!(front < 0.55, "{choice:?}: the wall's face is at 0.55 m, the water at {front}");
        for kind in ["mesh", "hull"] {
            let (found, found_height) = by(kind);
            println!("{choice:?} {kind}: {front} {found}, {height} {found_height}");
            // The samples behind the face lie on other lattices; a tenth of a spacing is no leak and no gap.
            assert!((found - front).abs() < 0.1 * SPACING, "{choice:?} {kind}: {front} {found}");
            assert!((found_height - height).abs() < 0.1 * f64::from(SPACING), "{kind}: {height} {found_height}");
        }
    }
}

#[test]
fn a_domain_waits_for_a_mesh_that_loads_later() {
    for (choice, kind) in
        [(ALL[0], "mesh"), (ALL[1], "mesh"), (ALL[2], "mesh"), (ALL[3], "mesh"), (ALL[0], "hull"), (ALL[0], "image")]
    {
        let mut test = TestApp::new();
        let tank = Tank::spawn(&mut test, choice);
        let member = FluidInDomain(tank.domain);
        let mesh = test.world().resource_mut::<Assets<Mesh>>().reserve_handle();
        let image = test.world().resource_mut::<Assets<Image>>().reserve_handle();
        let boundary = match kind {
            "mesh" => FluidBoundary::mesh(mesh.clone()),
            "hull" => FluidBoundary::convex_hull(mesh.clone()),
            // Ground has no sides: it is below the tank, out of the way.
            _ => FluidBoundary::height_image(image.clone(), Vec2::ONE, -0.5),
        };
        let wall = test.spawn((boundary.clone(), Transform::from_xyz(0.7, 0.0, 0.25), member));
        test.tick(5);
        let stats = test.stats(tank.domain);
        assert_eq!((stats.ticks, stats.ticks_in_flight, stats.waiting_for.as_slice()), (0, 0, &[wall][..]), "{kind}");
        let load = |test: &mut TestApp, mesh: &Handle<Mesh>, image: &Handle<Image>| {
            let grey = Extent3d { width: 2, height: 2, depth_or_array_layers: 1 };
            let (format, usage) = (TextureFormat::R8Unorm, RenderAssetUsages::default());
            let pixels = Image::new(grey, TextureDimension::D2, vec![255; 4], format, usage);
            test.world().resource_mut::<Assets<Image>>().insert(image, pixels).expect("a reserved handle");
            let solid = Mesh::from(Cuboid::new(0.2, 1.0, 0.5));
            test.world().resource_mut::<Assets<Mesh>>().insert(mesh, solid).expect("a reserved handle");
        };
        load(&mut test, &mesh, &image);
        test.tick(4);
        let stats = test.settle(tank.domain);
        assert_eq!((stats.particles, stats.waiting_for.len()), (WATER, 0), "{choice:?} {kind}: {stats:?}");
        assert!(stats.ticks >= 3, "{choice:?} {kind}: {stats:?}");
        // Another one, while it runs: the fluid stands still until it is there, and goes on where it was.
        let other_mesh = test.world().resource_mut::<Assets<Mesh>>().reserve_handle();
        let other_image = test.world().resource_mut::<Assets<Image>>().reserve_handle();
        let boundary = match kind {
            "mesh" => FluidBoundary::mesh(other_mesh.clone()),
            "hull" => FluidBoundary::convex_hull(other_mesh.clone()),
            _ => FluidBoundary::height_image(other_image.clone(), Vec2::ONE, -0.5),
        };
        let other = test.spawn((boundary, Transform::from_xyz(0.9, 0.0, 0.25), member));
        test.tick(5);
        let waiting = test.stats(tank.domain);
        assert_eq!((waiting.ticks, waiting.ticks_in_flight), (stats.ticks, 0), "{choice:?} {kind}");
        assert_eq!(waiting.waiting_for, [other], "{choice:?} {kind}");
        load(&mut test, &other_mesh, &other_image);
        test.tick(31);
        let front = front(&mut test, tank.domain);
        let is_held = front < 0.6 + SINKS;
        assert_eq!(
            is_held,
            kind != "image",
            "{choice:?} {kind}: the first wall's face is at 0.6 m, the water at {front}"
        );
        let end = test.stats(tank.domain);
        assert!(end.ticks > stats.ticks + 25 && end.waiting_for.is_empty(), "{choice:?} {kind}: {end:?}");
        assert_eq!((end.particles, end.removed), (WATER, 0), "{choice:?} {kind}");
        test.expect_no_complaints();
    }
}

#[test]
fn bodies_go_on_while_their_fluid_waits_and_float_again_afterwards() {
    for choice in [ALL[0], ALL[1]] {
        let mut test = TestApp::new();
        let tank = Tank::spawn(&mut test, choice);
        let member = FluidInDomain(tank.domain);
        let ball = (RigidBody::Dynamic, Collider::ball(0.1), ColliderMassProperties::Density(100.0));
        let at = Transform::from_xyz(0.25, 0.65, 0.25);
        let ball = test.spawn((ball, FluidBody::default(), Velocity::default(), at, member));
        let height = |test: &mut TestApp| test.world().get::<Transform>(ball).expect("a ball").translation.y;
        test.tick(6);
        let mesh = test.world().resource_mut::<Assets<Mesh>>().reserve_handle();
        test.spawn((FluidBoundary::mesh(mesh.clone()), Transform::from_xyz(0.9, 0.5, 0.25), member));
        test.tick(6);
        let before = height(&mut test);
        test.tick(2);
        let after = height(&mut test);
        assert!(after < before, "{choice:?}: it falls on, {before} {after}");
        let wall = Mesh::from(Cuboid::new(0.1, 1.0, 0.5));
        test.world().resource_mut::<Assets<Mesh>>().insert(&mesh, wall).expect("a reserved handle");
        test.tick(80);
        assert_eq!(test.settle(tank.domain).particles, WATER, "{choice:?}");
        // The water is about 0.2 m high by now; the ball would lie at 0.1 m without it.
        let end = height(&mut test);
        assert!(end > 0.15, "{choice:?}: it floats at {end}");
        test.expect_no_complaints();
    }
}

/// Spawns a wall that is of no use beside a tank; expects one problem about it, and that the tank goes on.
fn refuses(make: impl FnOnce(&mut TestApp) -> FluidBoundary, words: &[&str]) {
    let mut test = TestApp::new();
    let tank = Tank::spawn(&mut test, ALL[0]);
    test.tick(1);
    let boundary = make(&mut test);
    let wall = test.spawn((boundary, FluidInDomain(tank.domain), Transform::from_xyz(0.8, 0.0, 0.25)));
    let mut complaints = Vec::new();
    // What fails to load does so on another thread.
    for _ in 0..500 {
        test.tick(1);
        complaints = test.complaints();
        if !complaints.is_empty() {
            break;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let before = test.settle(tank.domain).ticks;
    test.tick(8);
    complaints.extend(test.complaints());
    assert_eq!(complaints.len(), 1, "{complaints:?}");
    assert_eq!((complaints[0].entity, complaints[0].component), (wall, "FluidBoundary"), "{complaints:?}");
    for word in words {
        assert!(complaints[0].message.contains(word), "{word} in {complaints:?}");
    }
    let stats = test.settle(tank.domain);
    assert_eq!((stats.particles, stats.waiting_for.len()), (WATER, 0));
    assert!(stats.ticks >= before + 8, "the tank goes on");
}

#[test]
fn meshes_of_no_use_are_refused_with_the_reason() {
    let points = |test: &mut TestApp| {
        let points = mesh_of(PrimitiveTopology::PointList, vec![Vec3::ZERO, Vec3::X, Vec3::Y]);
        FluidBoundary::mesh(add(test, points))
    };
    refuses(points, &["shape.mesh.primitive_topology: PointList", "allowed: TriangleList or TriangleStrip"]);
    let missing = |test: &mut TestApp| {
        FluidBoundary::mesh(test.world().resource::<AssetServer>().load::<Mesh>("no/such/mesh.glb#Mesh0/Primitive0"))
    };
    refuses(missing, &["shape.mesh: no/such/mesh.glb#Mesh0/Primitive0", "allowed: an asset that loads"]);
    let broken = |test: &mut TestApp| {
        let server = test.world().resource::<AssetServer>();
        let failing = async { Err::<Mesh, std::io::Error>(std::io::Error::other("the generator gave up")) };
        FluidBoundary::convex_hull(server.add_async(failing))
    };
    refuses(broken, &["shape.mesh", "allowed: an asset that loads", "the generator gave up"]);
    let flat = |test: &mut TestApp| FluidBoundary::convex_hull(add(test, Mesh::from(Plane3d::new(Vec3::Y, Vec2::ONE))));
    refuses(flat, &["shape.mesh.points", "plane"]);
    let uneven = |_: &mut TestApp| FluidBoundary::height_field(Vec2::ONE, UVec2::new(3, 2), vec![0.0; 5]);
    refuses(uneven, &["shape.heights: 5 of them", "allowed: 6"]);
    let endless = |_: &mut TestApp| FluidBoundary::height_function(Vec2::ONE, UVec2::MAX, |_, _| 0.0);
    refuses(endless, &["shape.counts"]);
}

#[test]
fn only_meshes_may_be_scaled_and_not_by_zero() {
    let scaled = |boundary: FluidBoundary, scale: Vec3| {
        let mut test = TestApp::new();
        let tank = Tank::spawn(&mut test, ALL[0]);
        test.spawn((boundary, Transform::from_xyz(0.8, 0.0, 0.25).with_scale(scale), FluidInDomain(tank.domain)));
        test.tick(2);
        let complaints = test.complaints();
        assert_eq!(complaints.len(), 1, "{complaints:?}");
        assert!(complaints[0].message.starts_with("Transform: scale"), "{complaints:?}");
        assert_eq!(test.settle(tank.domain).particles, WATER);
    };
    let triangles = FluidMesh::Triangles {
        vertices: vec![Vec3::ZERO, 0.1 * Vec3::X, 0.1 * Vec3::Z, 0.1 * Vec3::Y],
        triangles: vec![[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]],
    };
    scaled(FluidBoundary::mesh(triangles), Vec3::new(1.0, 0.0, 1.0));
    scaled(FluidBoundary::height_field(0.2 * Vec2::ONE, UVec2::splat(2), vec![0.0; 4]), Vec3::splat(2.0));
}

#[test]
fn a_mesh_that_is_modified_is_a_new_wall() {
    for choice in ALL {
        let mut test = TestApp::new();
        let tank = Tank::spawn(&mut test, choice);
        let mesh = add(&mut test, Mesh::from(Cuboid::new(0.1, 1.0, 0.5)));
        let at = Transform::from_xyz(0.6, 0.5, 0.25);
        test.spawn((FluidBoundary::mesh(mesh.clone()), at, FluidInDomain(tank.domain)));
        test.tick(31);
        let held = front(&mut test, tank.domain);
        assert!(held < 0.55 + SINKS, "{choice:?}: the wall's face is at 0.55 m, the water at {held}");
        let mut meshes = test.world().resource_mut::<Assets<Mesh>>();
        meshes.get_mut(&mesh).expect("the mesh is there").translate_by(0.2 * Vec3::X);
        test.tick(31);
        let held = front(&mut test, tank.domain);
        assert!(held > 0.6 && held < 0.75 + SINKS, "{choice:?}: the wall's face is at 0.75 m, the water at {held}");
        assert_eq!(test.settle(tank.domain).particles, WATER);
        test.expect_no_complaints();
    }
}

#[test]
fn a_scene_of_a_file_has_its_meshes_hulls_and_height_fields() {
    let size = 0.6;
    let corners: Vec<Vec3> =
        (0..8).map(|corner| Vec3::new((corner & 1) as f32, (corner >> 1 & 1) as f32, (corner >> 2) as f32)).collect();
    let room = {
        let (a, b, c, d, e, f, g, h) = (0, 1, 2, 3, 4, 5, 6, 7);
        let faces = [[a, c, d, b], [e, f, h, g], [a, b, f, e], [c, g, h, d], [a, e, g, c], [b, d, h, f]];
        let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let vertices = corners.iter().map(|corner| 2.0 * size * (*corner - 0.5)).collect();
        TriangleMesh::new(vertices, triangles).expect("a box")
    };
    let field = HeightField::new([2.0 * size; 2], [2; 2], vec![0.1; 4]).expect("a field");
    let rock = corners.iter().map(|corner| 0.3 * (*corner - 0.5)).collect();
    let scene = FluidScene {
        name: "room".to_owned(),
        volumes: vec![Volume::block(Vec3::splat(0.2), Vec3::new(0.2, 0.3, 0.2))],
        boundaries: vec![
            Boundary::new(BoundaryShape::Mesh { mesh: room, fluid: Some(FluidSide::Inside) }, Vec3::Y * 0.5),
            Boundary::new(BoundaryShape::HeightField { field }, Vec3::NEG_Y * 0.1),
            Boundary::new(BoundaryShape::ConvexHull { points: rock }, Vec3::new(-0.25, 0.15, -0.25)),
        ],
        ..FluidScene::with_spacing(SPACING)
    };
    let mut test = TestApp::new();
    let spawned = test.world().commands().spawn_fluid_scene(&scene, |domain| domain.backend = FluidBackend::Cpu);
    let domain = spawned.expect("a scene");
    test.world().flush();
    test.tick(2);
    let start = test.settle(domain).particles;
    assert_eq!(start, 64);
    test.tick(40);
    let positions = positions(&mut test, domain);
    assert_eq!(positions.len() as u32, start);
    for position in positions {
        for boundary in &scene.boundaries {
            assert!(!boundary.is_on_wrong_side(position, SINKS), "{position} by {boundary:?}");
        }
    }
    test.expect_no_complaints();
}
