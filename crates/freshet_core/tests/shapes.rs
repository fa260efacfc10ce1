//! Layers of curved walls and of meshes, held against dense points of them that are made here.

use std::f32::consts::{PI, TAU};

use freshet_core::prelude::*;
use freshet_core::sampling::wall_layer::WallLayer;
use glam::vec3;

const D: f32 = 0.1;

fn layer() -> WallLayer {
    FluidScene::with_spacing(D).wall_layer().unwrap()
}

fn samples(shape: BoundaryShape) -> Vec<Vec3> {
    freshet_core::plan::sample_boundary(&Boundary::new(shape, Vec3::ZERO), &layer()).unwrap()
}

/// Numbers from 0 to 1.
struct Random(u32);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / 16_777_216.0
    }

    fn direction(&mut self) -> Vec3 {
        let (y, angle) = (2.0 * self.next() - 1.0, TAU * self.next());
        let ring = (1.0 - y * y).max(0.0).sqrt();
        vec3(ring * angle.cos(), y, ring * angle.sin())
    }
}

/// Largest distance of the points from the nearest sample and smallest one of two samples, over the spacing.
fn spread(samples: &[Vec3], points: &[Vec3]) -> (f32, f32) {
    let nearest = |point: &Vec3| samples.iter().map(|x| x.distance_squared(*point)).fold(f32::INFINITY, f32::min);
    let gap = points.iter().map(nearest).fold(0.0, f32::max).sqrt();
    let mut closest = f32::INFINITY;
    for (i, a) in samples.iter().enumerate() {
        closest = samples[..i].iter().map(|b| a.distance_squared(*b)).fold(closest, f32::min);
    }
    (gap / D, closest.sqrt() / D)
}

fn assert_covers(name: &str, samples: &[Vec3], points: &[Vec3]) {
    assert!(!samples.is_empty() && points.len() > 50, "{name}: {} samples, {} points", samples.len(), points.len());
    let (gap, closest) = spread(samples, points);
    assert!(gap <= 0.75, "{name}: {} samples, a point of the layer is {gap} spacings from the nearest", samples.len());
    assert!(closest >= 0.5, "{name}: two samples are {closest} spacings apart");
}

/// Points of the surface that a polyline of (distance from the axis, height) makes when it turns about the y axis.
fn turned(outline: &[(f32, f32)], random: &mut Random) -> Vec<Vec3> {
    let mut points = Vec::new();
    for ends in outline.windows(2) {
        for step in 0..4000 {
            // Ends too: they are edges.
            let share = if step < 600 {
                0.0
            } else if step < 1200 {
                1.0
            } else {
                random.next()
            };
            let (radius, y) =
                (ends[0].0 + share * (ends[1].0 - ends[0].0), ends[0].1 + share * (ends[1].1 - ends[0].1));
            let angle = TAU * random.next();
            points.push(vec3(radius * angle.cos(), y, radius * angle.sin()));
        }
    }
    points
}

/// Points of a rounded edge: a torus about the y axis, of which those `outside` of its ring and above or below it.
fn rim(radius: f32, y: f32, thickness: f32, up: f32, random: &mut Random) -> Vec<Vec3> {
    (0..2000)
        .map(|_| {
            let (angle, tilt) = (TAU * random.next(), 0.5 * PI * random.next());
            let ring = radius + thickness * tilt.cos();
            vec3(ring * angle.cos(), y + up * thickness * tilt.sin(), ring * angle.sin())
        })
        .collect()
}

#[test]
fn layers_of_round_solids_are_whole() {
    let (depth, random) = (layer().depth, &mut Random(1));
    for (radius, half) in [(0.5, 0.4), (0.13, 0.6), (0.7, 0.08), (0.05, 0.05), (0.071, 0.9)] {
        let inner = depth.min(0.5 * radius).min(0.5 * half);
        let (r, h) = (radius - inner, half - inner);
        let points = turned(&[(0.0, -h), (r, -h), (r, h), (0.0, h)], random);
        let shape = BoundaryShape::Cylinder { radius, half_height: half, fluid: FluidSide::Outside };
        assert_covers(&format!("cylinder {radius} {half}"), &samples(shape), &points);

        let r = radius - depth.min(0.5 * radius);
        let mut points = turned(&[(r, -half), (r, half)], random);
        points.extend((0..4000).map(|_| random.direction()).map(|way| way * r + Vec3::Y * half.copysign(way.y)));
        let shape = BoundaryShape::Capsule { radius, half_height: half, fluid: FluidSide::Outside };
        assert_covers(&format!("capsule {radius} {half}"), &samples(shape), &points);
    }
    for (radius, half) in [(0.5f32, 0.4f32), (0.2, 0.8), (0.9, 0.15)] {
        // The largest ball in it touches base and side; a cone moved inwards is the cone shrunk towards its centre.
        let ball = radius * 2.0 * half / (radius + radius.hypot(2.0 * half));
        let scale = 1.0 - depth.min(0.5 * ball) / ball;
        let (r, low, tip) = (radius * scale, -half + ball * (1.0 - scale), -half + ball + (2.0 * half - ball) * scale);
        let points = turned(&[(0.0, low), (r, low), (0.0, tip)], random);
        let shape = BoundaryShape::Cone { radius, half_height: half, fluid: FluidSide::Outside };
        assert_covers(&format!("cone {radius} {half}"), &samples(shape), &points);
    }
}

#[test]
fn layers_of_round_rooms_are_whole() {
    let (depth, random) = (layer().depth, &mut Random(2));
    for (radius, half) in [(0.5, 0.4), (0.1, 0.6), (0.05, 0.05)] {
        let mut points = turned(&[(0.0, -half - depth), (radius, -half - depth)], random);
        points.extend(turned(&[(0.0, half + depth), (radius, half + depth)], random));
        points.extend(turned(&[(radius + depth, -half), (radius + depth, half)], random));
        points.extend(rim(radius, half, depth, 1.0, random));
        points.extend(rim(radius, -half, depth, -1.0, random));
        let shape = BoundaryShape::Cylinder { radius, half_height: half, fluid: FluidSide::Inside };
        assert_covers(&format!("cylinder {radius} {half}"), &samples(shape), &points);

        let points: Vec<Vec3> = (0..4000).map(|_| random.direction() * (radius + depth)).collect();
        let sphere = samples(BoundaryShape::Sphere { radius, fluid: FluidSide::Inside });
        assert_covers(&format!("sphere {radius}"), &sphere, &points);
        // A spiral: no more than the area asks for.
        assert!((sphere.len() as f32 - 4.0 * PI * ((radius + depth) / D).powi(2)).abs() <= 1.0);
    }
}

#[test]
fn sheets_have_their_layer_on_the_surface() {
    let random = &mut Random(3);
    let (radius, half) = (0.4, 0.3);
    let fluid = FluidSide::Both;
    let points = turned(&[(0.0, -half), (radius, -half), (radius, half), (0.0, half)], random);
    let cylinder = samples(BoundaryShape::Cylinder { radius, half_height: half, fluid });
    assert_covers("cylinder", &cylinder, &points);
    for x in cylinder {
        let ring = x.x.hypot(x.z);
        assert!((ring - radius).abs().min((x.y.abs() - half).abs()) < 1e-6, "{x}");
    }
    let points: Vec<Vec3> = (0..4000).map(|_| random.direction() * radius).collect();
    assert_covers("sphere", &samples(BoundaryShape::Sphere { radius, fluid }), &points);
}

#[test]
fn cups_have_a_layer_in_walls_thick_and_thin() {
    let (depth, random) = (layer().depth, &mut Random(4));
    let (radius, half) = (0.4, 0.5);
    for thickness in [0.001, 0.05, 0.15] {
        let shape = BoundaryShape::Cup { radius, half_height: half, thickness };
        let (middle, bottom) = (radius + 0.5 * thickness, -half - 0.5 * thickness);
        let points = turned(&[(0.0, bottom), (middle, bottom), (middle, half - 0.5 * thickness)], random);
        assert_covers(&format!("cup {thickness}"), &samples(shape), &points);
    }
    // Twice the depth and more: the layer goes round within the wall.
    let t: f32 = 0.3;
    let outer = radius + t - depth;
    let mut points = turned(&[(0.0, -half - t + depth), (outer, -half - t + depth), (outer, half - depth)], random);
    points.extend(turned(&[(outer, half - depth), (radius + depth, half - depth), (radius + depth, -half)], random));
    points.extend(turned(&[(0.0, -half - depth), (radius, -half - depth)], random));
    points.extend(rim(radius, -half, depth, -1.0, random));
    assert_covers("thick cup", &samples(BoundaryShape::Cup { radius, half_height: half, thickness: t }), &points);
}

#[test]
fn ground_has_its_layer_below_it() {
    let (depth, random) = (layer().depth, &mut Random(5));
    let heights: Vec<f32> = (0..12 * 9).map(|_| 0.5 * random.next()).collect();
    let field = HeightField::new([2.2, 1.6], [12, 9], heights).unwrap();
    let samples = samples(BoundaryShape::HeightField { field: field.clone() });
    // Points of the surface, moved down along its normal: of the layer where no other place is nearer.
    let random_place = |random: &mut Random| (2.2 * (random.next() - 0.5), 1.6 * (random.next() - 0.5));
    let surface: Vec<Vec3> =
        (0..60_000).map(|_| random_place(random)).map(|(x, z)| vec3(x, field.height(x, z), z)).collect();
    let points: Vec<Vec3> = surface
        .iter()
        .step_by(20)
        .map(|&p| p - depth * field.normal(p.x, p.z))
        .filter(|x| x.x.abs() < 1.1 && x.z.abs() < 0.8)
        .filter(|x| surface.iter().all(|p| p.distance_squared(*x) > (0.999 * depth).powi(2)))
        .collect();
    assert_covers("ground", &samples, &points);
    // At peaks sharper than the depth a sample is on the surface: of triangles, which miss the warped ground by up to 2 mm.
    assert!(samples.iter().all(|x| x.y < field.height(x.x, x.z) + 0.003));
    let too_near = |x: &&Vec3| surface.iter().any(|p| p.distance(**x) < 0.9 * depth);
    // In ridges too sharp for the depth the layer is in the middle.
    assert!(samples.iter().filter(too_near).count() * 10 < samples.len());
}

// Meshes

fn triangles(mesh: &TriangleMesh) -> Vec<[Vec3; 3]> {
    mesh.triangles().iter().map(|t| t.map(|index| mesh.vertices()[index as usize])).collect()
}

/// Dense points of a mesh: as many as its area asks for, and of each triangle at least a few, its corners and edges among them.
fn points_on(mesh: &TriangleMesh, random: &mut Random) -> Vec<(Vec3, Vec3)> {
    let all = triangles(mesh);
    let area = |[a, b, c]: &[Vec3; 3]| 0.5 * (*b - *a).cross(*c - *a).length();
    let whole: f32 = all.iter().map(area).sum();
    let mut points = Vec::new();
    for triangle @ [a, b, c] in &all {
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let length = a.distance(*b).max(b.distance(*c)).max(c.distance(*a));
        let share = (6000.0 * area(triangle) / whole.max(1e-12)) as u32;
        let along = ((4.0 * length / D) as u32).clamp(2, 400);
        points.extend([a, b, c].map(|&corner| (corner, normal)));
        for _ in 0..along {
            let t = random.next();
            points.extend([a.lerp(*b, t), b.lerp(*c, t), c.lerp(*a, t)].map(|point| (point, normal)));
        }
        for _ in 0..share {
            let (mut u, mut v) = (random.next(), random.next());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            points.push((a + (b - a) * u + (c - a) * v, normal));
        }
    }
    points
}

/// Distance from a triangle, by its plane and its edges.
fn distance(point: Vec3, [a, b, c]: [Vec3; 3]) -> f32 {
    let segment = |p: Vec3, q: Vec3| {
        let along = q - p;
        let t = ((point - p).dot(along) / along.length_squared().max(1e-30)).clamp(0.0, 1.0);
        point.distance(p + along * t)
    };
    let edges = segment(a, b).min(segment(b, c)).min(segment(c, a));
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let is_above = |p: Vec3, q: Vec3| normal.cross(q - p).dot(point - p) >= 0.0;
    if normal != Vec3::ZERO && is_above(a, b) && is_above(b, c) && is_above(c, a) {
        edges.min((point - a).dot(normal).abs())
    } else {
        edges
    }
}

/// How often a ray crosses the mesh, counted by direction: how deep a point is in.
fn depth_by_ray(point: Vec3, all: &[[Vec3; 3]]) -> i32 {
    let way = vec3(0.4711, 0.7321, 0.4917).normalize();
    all.iter()
        .map(|&[a, b, c]| {
            let volume = |p: Vec3, q: Vec3| way.dot((p - point).cross(q - point));
            let (u, v, w) = (volume(a, b), volume(b, c), volume(c, a));
            let is_hit = (u > 0.0 && v > 0.0 && w > 0.0) || (u < 0.0 && v < 0.0 && w < 0.0);
            let normal = (b - a).cross(c - a);
            let ahead = (a - point).dot(normal) * way.dot(normal).signum() > 0.0;
            if is_hit && ahead { way.dot(normal).signum() as i32 } else { 0 }
        })
        .sum()
}

/// Dense points as far as `depth` from a mesh on one side of it: from points of the mesh along normals and any other way.
fn points_of_layer(mesh: &TriangleMesh, depth: f32, inside: bool, random: &mut Random) -> Vec<Vec3> {
    let all = triangles(mesh);
    let mut found = Vec::new();
    let points = points_on(mesh, random);
    // Each is held against every triangle.
    let stride = (points.len() / 6000).max(1) | 1;
    for (index, (point, normal)) in points.into_iter().step_by(stride).enumerate() {
        let way = match index % 4 {
            0 => normal,
            1 => -normal,
            _ => random.direction(),
        };
        let there = point + way * depth;
        let is_near = |triangle: &[Vec3; 3]| distance(there, *triangle) < 0.999 * depth;
        if way != Vec3::ZERO && !all.iter().any(is_near) && (depth_by_ray(there, &all) != 0) == inside {
            found.push(there);
        }
    }
    found
}

fn mesh(vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> TriangleMesh {
    TriangleMesh::new(vertices, triangles).unwrap()
}

fn joined(meshes: &[TriangleMesh]) -> TriangleMesh {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for mesh in meshes {
        let first = vertices.len() as u32;
        vertices.extend_from_slice(mesh.vertices());
        triangles.extend(mesh.triangles().iter().map(|t| t.map(|index| index + first)));
    }
    mesh(vertices, triangles)
}

fn flipped(solid: &TriangleMesh) -> TriangleMesh {
    mesh(solid.vertices().to_vec(), solid.triangles().iter().map(|&[a, b, c]| [a, c, b]).collect())
}

fn block(half: Vec3, center: Vec3) -> TriangleMesh {
    let corner = |i: u32| center + half * Vec3::from([i & 1, i >> 1 & 1, i >> 2].map(|bit| 2.0 * bit as f32 - 1.0));
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    mesh((0..8).map(corner).collect(), triangles)
}

/// Rows of quads between points at (row, column); `around`: the last column is the first.
fn grid(rows: u32, columns: u32, around: bool, at: impl Fn(f32, f32) -> Vec3) -> TriangleMesh {
    let wide = if around { columns } else { columns + 1 };
    let mut vertices = Vec::new();
    for i in 0..=rows {
        vertices.extend((0..wide).map(|j| at(i as f32 / rows as f32, j as f32 / columns as f32)));
    }
    let mut triangles = Vec::new();
    for i in 0..rows {
        for j in 0..columns {
            let (next, k) = ((j + 1) % wide, i * wide);
            triangles.extend([[k + j, k + wide + j, k + wide + next], [k + j, k + wide + next, k + next]]);
        }
    }
    mesh(vertices, triangles)
}

/// Latitudes from the top down to `bottom`, 1 for a whole ball.
fn ball(radius: f32, bottom: f32, rows: u32) -> TriangleMesh {
    grid(rows, 2 * rows, true, |i, j| {
        let (sin, cos) = (PI * i * bottom).sin_cos();
        // Exactly one point at each pole, so that the mesh is closed.
        let sin = if i == 0.0 || (i == 1.0 && bottom == 1.0) { 0.0 } else { sin };
        let (along, across) = (TAU * j).sin_cos();
        radius * vec3(sin * across, cos, -sin * along)
    })
}

fn torus(large: f32, small: f32) -> TriangleMesh {
    let open = grid(16, 32, true, |i, j| {
        let ((s, c), (t, d)) = ((TAU * i).sin_cos(), (TAU * j).sin_cos());
        vec3((large + small * c) * d, small * s, (large + small * c) * -t)
    });
    let wrapped = |index: u32| if index >= 16 * 32 { index - 16 * 32 } else { index };
    flipped(&mesh(open.vertices().to_vec(), open.triangles().iter().map(|t| t.map(wrapped)).collect()))
}

fn icosphere(radius: f32, rounds: u32) -> TriangleMesh {
    let mut faces: Vec<[Vec3; 3]> = Vec::new();
    for sign in 0..8u32 {
        let [x, y, z] = [sign & 1, sign >> 1 & 1, sign >> 2].map(|bit| 1.0 - 2.0 * bit as f32);
        let corners = [Vec3::X * x, Vec3::Y * y, Vec3::Z * z];
        faces.push(if x * y * z > 0.0 { corners } else { [corners[0], corners[2], corners[1]] });
    }
    for _ in 0..rounds {
        let cut = |[a, b, c]: [Vec3; 3]| {
            let [p, q, r] = [a + b, b + c, c + a].map(Vec3::normalize);
            [[a, p, r], [p, b, q], [r, q, c], [p, q, r]]
        };
        faces = faces.into_iter().flat_map(cut).collect();
    }
    TriangleMesh::from_soup(faces.into_iter().flatten().map(|x| radius * x).collect()).unwrap()
}

/// An L, pulled up: concave along one edge.
fn angle() -> TriangleMesh {
    let outline = [(0.0, 0.0), (1.2, 0.0), (1.2, 0.5), (0.5, 0.5), (0.5, 1.2), (0.0, 1.2)];
    let vertices = [0.0, 0.6].iter().flat_map(|&y| outline.map(|(x, z)| vec3(x, y, z))).collect();
    let base: [[u32; 3]; 4] = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]];
    let mut triangles = base.to_vec();
    triangles.extend(base.map(|[a, b, c]| [a + 6, c + 6, b + 6]));
    triangles.extend((0..6).flat_map(|i| [[i, i + 6, (i + 1) % 6], [(i + 1) % 6, i + 6, (i + 1) % 6 + 6]]));
    mesh(vertices, triangles)
}

#[test]
fn the_meshes_of_these_tests_face_outwards() {
    for solid in [block(Vec3::ONE, Vec3::ZERO), ball(1.0, 1.0, 9), torus(1.0, 0.3), icosphere(1.0, 2), angle()] {
        assert!(solid.is_closed());
        let volume: f32 = triangles(&solid).iter().map(|[a, b, c]| a.dot(b.cross(*c))).sum();
        assert!(volume > 0.0, "{volume}");
    }
    assert!(!ball(1.0, 0.5, 9).is_closed());
}

#[test]
fn closed_meshes_have_their_layer_at_its_depth() {
    let (depth, random) = (layer().depth, &mut Random(6));
    let cube = || block(Vec3::splat(0.5), Vec3::ZERO);
    let crossing = joined(&[cube(), block(Vec3::new(0.25, 0.3, 0.8), vec3(0.3, 0.35, 0.1))]);
    let soup = TriangleMesh::from_soup(triangles(&cube()).concat()).unwrap();
    let twice = joined(&[cube(), mesh(vec![Vec3::ZERO, Vec3::X, Vec3::X * 2.0], vec![[0, 1, 2], [0, 0, 1]])]);
    let hollow = joined(&[block(Vec3::ONE, Vec3::ZERO), flipped(&block(Vec3::splat(0.4), Vec3::ZERO))]);
    let unused = {
        let mut vertices = cube().vertices().to_vec();
        vertices.push(Vec3::splat(50.0));
        mesh(vertices, cube().triangles().to_vec())
    };
    // One face's edges have corners of others along them.
    let (mut vertices, mut faces) = (cube().vertices().to_vec(), cube().triangles().to_vec());
    vertices.push(vec3(0.1, 0.5, -0.5));
    let cut = faces.iter().position(|face| face.contains(&2) && face.contains(&3) && face.contains(&7)).unwrap();
    let at = faces[cut].iter().position(|&corner| corner == 7).unwrap();
    let [seven, next, last] = [0, 1, 2].map(|k| faces[cut][(at + k) % 3]);
    faces[cut] = [seven, next, 8];
    faces.push([8, last, seven]);
    let junction = mesh(vertices, faces);
    for (name, solid) in [
        ("box", cube()),
        ("crossing boxes", crossing),
        ("inside out", flipped(&cube())),
        ("soup", soup),
        ("with triangles of no area", twice),
        ("hollow", hollow),
        ("box in a box", joined(&[block(Vec3::ONE, Vec3::ZERO), cube()])),
        ("with a vertex unused", unused),
        ("T-junction", junction),
        ("L", angle()),
        ("torus", torus(0.8, 0.35)),
        ("ball", ball(0.6, 1.0, 20)),
        ("icosphere", icosphere(0.7, 3)),
        ("fan at the poles", ball(0.6, 1.0, 40)),
    ] {
        let kept = samples(BoundaryShape::Mesh { mesh: solid.clone(), fluid: Some(FluidSide::Outside) });
        let mut points = points_of_layer(&solid, depth, true, random);
        if name == "box in a box" {
            // Inside twice: its faces are within.
            points.retain(|x| x.abs().max_element() > 0.5 + 2.0 * depth);
        }
        assert_covers(name, &kept, &points);
        let rooms = samples(BoundaryShape::Mesh { mesh: solid.clone(), fluid: Some(FluidSide::Inside) });
        let points = points_of_layer(&solid, depth, false, random);
        assert_covers(&format!("room in a {name}"), &rooms, &points);
    }
}

#[test]
fn thin_parts_keep_a_layer_in_their_middle() {
    let random = &mut Random(7);
    for thickness in [0.5, 0.9, 1.7].map(|share| share * D) {
        let plate = block(Vec3::new(0.6, 0.5 * thickness, 0.4), Vec3::ZERO);
        let kept = samples(BoundaryShape::mesh(plate));
        let reach = vec3(0.6, 0.0, 0.4) - vec3(1.0, 0.0, 1.0) * 0.5 * thickness;
        let points: Vec<Vec3> =
            (0..4000).map(|_| reach * (2.0 * vec3(random.next(), 0.0, random.next()) - 1.0)).collect();
        assert_covers(&format!("plate {thickness}"), &kept, &points);
        for x in &kept {
            assert!(x.y.abs() < 1e-3, "plate {thickness}: {x} is not in the middle");
        }
        assert!(kept.len() < 160, "one layer of 96 cells, and not two: {}", kept.len());
    }
    // Whatever it is, no part of the surface is without a sample.
    let shell = joined(&[ball(0.5, 1.0, 20), flipped(&ball(0.47, 1.0, 20))]);
    let needle = mesh(
        vec![Vec3::ZERO, vec3(2.0, 0.02, 0.0), vec3(2.0, 0.0, 0.02), vec3(2.0, -0.02, -0.02)],
        vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]],
    );
    let wedge = mesh(
        vec![
            vec3(0.0, 0.0, -0.5),
            vec3(0.0, 0.0, 0.5),
            vec3(1.5, -0.25, -0.5),
            vec3(1.5, -0.25, 0.5),
            vec3(1.5, 0.25, -0.5),
            vec3(1.5, 0.25, 0.5),
        ],
        vec![[0, 2, 3], [0, 3, 1], [0, 1, 5], [0, 5, 4], [2, 4, 5], [2, 5, 3], [0, 4, 2], [1, 3, 5]],
    );
    let tiny = mesh(
        vec![Vec3::ZERO, Vec3::X * 0.01, Vec3::Y * 0.01, Vec3::Z * 0.01],
        vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
    );
    for (name, solid) in [("shell", shell), ("needle", needle), ("wedge", wedge), ("tiny", tiny)] {
        assert!(solid.is_closed(), "{name}");
        let kept = samples(BoundaryShape::mesh(solid.clone()));
        let surface: Vec<Vec3> = points_on(&solid, random).into_iter().map(|(point, _)| point).collect();
        let (gap, closest) = spread(&kept, &surface);
        // A layer at its depth leaves the corner of a box 1.74 depths from the layer's own corner, the diagonal of a cube, and no
        // point of a layer is farther than 0.75 spacings from a sample. Where there is no room for the layer, no part of the surface
        // may be worse off than that; where exactly its samples lie depends on the shape, so that nothing closer can be asked of all.
        let most = 1.74 * layer().depth / D + 0.75;
        assert!(
            gap <= most,
            "{name}: {} samples, a point of the surface is {gap} spacings from the nearest",
            kept.len()
        );
        assert!(closest >= 0.5, "{name}: two samples are {closest} spacings apart");
    }
}

#[test]
fn open_meshes_have_their_layer_on_them() {
    let random = &mut Random(8);
    let one = mesh(vec![Vec3::ZERO, Vec3::X, Vec3::Z * 0.7], vec![[0, 1, 2]]);
    let needle = mesh(vec![Vec3::ZERO, vec3(3.0, 0.0, 0.0), vec3(1.4, 1e-4, 0.0)], vec![[0, 1, 2]]);
    let repeated = mesh(one.vertices().to_vec(), vec![[0, 1, 2], [0, 1, 2], [2, 1, 0], [1, 1, 1], [0, 2, 0]]);
    let nothing = mesh(vec![Vec3::ZERO, Vec3::X, Vec3::X * 0.5], vec![[0, 1, 2]]);
    let fan = grid(1, 500, true, |i, j| {
        let (s, c) = (TAU * j).sin_cos();
        i * vec3(c, 0.2 * (5.0 * TAU * j).sin(), s)
    });
    let moebius = grid(60, 4, false, |i, j| {
        let ((s, c), (t, u)) = ((TAU * i).sin_cos(), (PI * i).sin_cos());
        let wide = 0.6 * (j - 0.5);
        vec3((0.7 + wide * u) * c, wide * t, (0.7 + wide * u) * s)
    });
    let bowl = ball(0.6, 0.5, 16);
    let tiny = mesh(vec![Vec3::ZERO, Vec3::X * 0.02, Vec3::Z * 0.02], vec![[0, 1, 2]]);
    let huge = mesh(vec![Vec3::splat(-4.0), vec3(4.0, -4.0, 3.0), vec3(0.0, 5.0, 0.0)], vec![[0, 1, 2]]);
    let sheets =
        joined(&[one.clone(), mesh(one.vertices().iter().map(|x| *x + Vec3::Y * 0.02).collect(), vec![[0, 2, 1]])]);
    for (name, sheet) in [
        ("triangle", one),
        ("needle", needle),
        ("repeated triangles", repeated),
        ("no area", nothing),
        ("fan", fan),
        ("Moebius strip", moebius),
        ("bowl", bowl),
        ("tiny", tiny),
        ("huge triangle", huge),
        ("two sheets nearer than half a spacing", sheets),
    ] {
        assert!(!sheet.is_closed(), "{name}");
        let surface: Vec<Vec3> = points_on(&sheet, random).into_iter().map(|(point, _)| point).collect();
        let kept = samples(BoundaryShape::mesh(sheet.clone()));
        let surface: Vec<Vec3> = surface.into_iter().cycle().take(6000).collect();
        assert_covers(name, &kept, &surface);
        let all = triangles(&sheet);
        for x in kept {
            assert!(all.iter().any(|&triangle| distance(x, triangle) < 1e-4), "{name}: {x} is not on it");
        }
    }
}

#[test]
fn hulls_have_their_layer_within() {
    let random = &mut Random(9);
    let points: Vec<Vec3> = (0..60).map(|_| random.direction() * vec3(0.8, 0.5, 0.6)).collect();
    let solid = freshet_core::geometry::convex_hull(&points).unwrap();
    let kept = samples(BoundaryShape::ConvexHull { points });
    assert_covers("hull", &kept, &points_of_layer(&solid, layer().depth, true, random));
}

#[test]
fn the_same_input_gives_the_same_samples() {
    let bits = |points: Vec<Vec3>| points.iter().flat_map(|x| x.to_array().map(f32::to_bits)).collect::<Vec<_>>();
    let torus = || bits(samples(BoundaryShape::mesh(torus(0.8, 0.35))));
    assert_eq!(torus(), torus());
    let cup = || bits(samples(BoundaryShape::Cup { radius: 0.5, half_height: 0.5, thickness: 0.3 }));
    assert_eq!(cup(), cup());
}

/// How many samples there are for each spacing squared: what a wall costs.
#[test]
fn samples_are_no_denser_than_documented() {
    let density = |samples: usize, area: f32| samples as f32 * D * D / area;
    let plate = grid(1, 1, false, |i, j| vec3(3.0 * i, 0.0, 3.0 * j));
    let ball = icosphere(1.0 + layer().depth, 5);
    let cylinder = BoundaryShape::Cylinder { radius: 1.0, half_height: 1.0, fluid: FluidSide::Both };
    for (name, density) in [
        ("plate", density(samples(BoundaryShape::mesh(plate)).len(), 9.0)),
        ("ball", density(samples(BoundaryShape::mesh(ball)).len(), 4.0 * PI)),
        ("cylinder", density(samples(cylinder).len(), 6.0 * PI)),
    ] {
        println!("{name}: {density} samples for each spacing squared");
        assert!((0.8..1.5).contains(&density), "{name}: {density}");
    }
}

// Insides

/// Every closed shape of this file, as a boundary.
fn sided_shapes(fluid: FluidSide) -> Vec<BoundaryShape> {
    vec![
        BoundaryShape::Sphere { radius: 0.5, fluid },
        BoundaryShape::Cylinder { radius: 0.5, half_height: 0.4, fluid },
        BoundaryShape::Capsule { radius: 0.4, half_height: 0.3, fluid },
        BoundaryShape::Cone { radius: 0.6, half_height: 0.5, fluid },
        BoundaryShape::Mesh { mesh: torus(0.6, 0.3), fluid: Some(fluid) },
        BoundaryShape::Mesh { mesh: angle(), fluid: Some(fluid) },
    ]
}

#[test]
fn particles_that_would_start_in_a_wall_are_left_out() {
    for fluid in [FluidSide::Outside, FluidSide::Inside, FluidSide::Both] {
        for shape in sided_shapes(fluid) {
            let boundary =
                Boundary { rotation: Quat::from_rotation_x(0.3), ..Boundary::new(shape.clone(), vec3(0.2, 0.1, 0.0)) };
            let scene = FluidScene {
                volumes: vec![Volume::block(Vec3::splat(1.3), Vec3::ZERO)],
                boundaries: vec![boundary.clone()],
                ..FluidScene::with_spacing(D)
            };
            let plan = Plan::new(&scene).unwrap();
            let left = &plan.left_out[0];
            assert!(left.inside > 50, "{shape:?} {fluid:?}: {left:?}");
            assert_eq!(plan.positions.len() as u32 + left.inside + left.crowded, 26 * 26 * 26);
            // Those that stay are clear of all samples by more than the first layer of fluid would need at least.
            let least = plan.positions.iter().map(|x| {
                plan.boundary.positions.iter().map(|sample| sample.distance(*x)).fold(f32::INFINITY, f32::min)
            });
            let least = least.fold(f32::INFINITY, f32::min);
            assert!(least > layer().depth, "{shape:?} {fluid:?}: {least} m");
            if fluid == FluidSide::Outside {
                assert!(plan.positions.iter().all(|x| !boundary.is_on_wrong_side(*x, 0.0)), "{shape:?}");
            }
        }
    }
}

#[test]
fn the_wrong_side_of_each_shape() {
    for fluid in [FluidSide::Outside, FluidSide::Inside, FluidSide::Both] {
        for shape in sided_shapes(fluid) {
            let boundary = Boundary::new(shape.clone(), Vec3::X);
            let within = match &shape {
                BoundaryShape::Mesh { mesh, .. } if mesh.vertices().len() > 20 => vec3(0.6, 0.0, 0.0),
                BoundaryShape::Mesh { .. } => vec3(0.2, 0.3, 0.2),
                _ => Vec3::ZERO,
            };
            let (inside, outside) = (boundary.is_on_wrong_side(within + Vec3::X, 0.0), {
                boundary.is_on_wrong_side(Vec3::splat(9.0), 0.0)
            });
            assert_eq!((inside, outside), (fluid == FluidSide::Outside, fluid == FluidSide::Inside), "{shape:?}");
            assert!(!boundary.is_on_wrong_side(within + Vec3::X, 1.0), "less deep than the tolerance");
        }
    }
    let is_wrong =
        |shape: BoundaryShape, x: f32, y: f32| Boundary::new(shape, Vec3::ZERO).is_on_wrong_side(vec3(x, y, 0.0), 0.0);
    let cup = || BoundaryShape::Cup { radius: 0.4, half_height: 0.5, thickness: 0.1 };
    assert!(is_wrong(cup(), 0.45, 0.4) && is_wrong(cup(), 0.0, -0.55));
    assert!(!is_wrong(cup(), 0.0, 0.0) && !is_wrong(cup(), 0.55, 0.0) && !is_wrong(cup(), 0.0, -0.65));
    let half_space = || BoundaryShape::HalfSpace { half_extents: [1.0, 1.0] };
    assert!(
        is_wrong(half_space(), 0.0, -50.0) && !is_wrong(half_space(), 0.0, 0.1) && !is_wrong(half_space(), 1.1, -1.0)
    );
    let field = HeightField::new([2.0, 2.0], [2, 2], vec![0.0, 1.0, 0.0, 1.0]).unwrap();
    let ground = || BoundaryShape::HeightField { field: field.clone() };
    assert!(is_wrong(ground(), 0.0, 0.4) && is_wrong(ground(), 0.0, -9.0) && !is_wrong(ground(), 0.0, 0.6));
    let points = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z].to_vec();
    let hull = || BoundaryShape::ConvexHull { points: points.clone() };
    assert!(!is_wrong(hull(), 0.2, 0.9) && !is_wrong(hull(), -0.1, 0.2));
    let inner = Boundary::new(hull(), Vec3::ZERO);
    assert!(inner.is_on_wrong_side(Vec3::splat(0.2), 0.0) && !inner.is_on_wrong_side(Vec3::splat(0.4), 0.0));
    let tank = Boundary::closed_box(Vec3::ONE, Vec3::ZERO);
    assert!(tank.is_on_wrong_side(Vec3::X * 9.0, 0.0) && !tank.is_on_wrong_side(Vec3::X * 0.4, 0.0));
    assert!(
        !Boundary::open_box(Vec3::ONE, Vec3::ZERO).is_on_wrong_side(Vec3::X * 9.0, 0.0),
        "it may have come over the rim"
    );
}

#[test]
fn shapes_without_faces_are_viscous_everywhere_or_nowhere() {
    for (faces, expected) in [([false; 6], false), ([false, false, true, false, false, false], true)] {
        for shape in sided_shapes(FluidSide::Outside) {
            let boundaries = vec![Boundary::new(shape, Vec3::ZERO).with_viscous_faces(faces)];
            let plan = Plan::new(&FluidScene { boundaries, ..FluidScene::with_spacing(D) }).unwrap();
            assert!(plan.boundary.viscous.iter().all(|viscous| *viscous == expected));
        }
    }
    let boundary = Boundary::new(BoundaryShape::Sphere { radius: 1.0, fluid: FluidSide::Inside }, Vec3::ZERO);
    let mut scene = FluidScene { boundaries: vec![boundary.with_velocity(Vec3::X)], ..FluidScene::with_spacing(D) };
    scene.settings.viscosity_model = Some(ViscosityModel::Morris1997);
    let error = scene.validate().unwrap_err().to_string();
    assert!(
        error.starts_with("boundaries[0].velocity: [1, 0, 0] is not allowed; allowed: zero, as no vector"),
        "{error}"
    );
}

#[test]
fn what_asks_for_too_many_samples_is_refused_before_memory_is_taken() {
    let (radius, half_height, fluid) = (900.0, 900.0, FluidSide::Outside);
    let long = mesh(vec![Vec3::ZERO, Vec3::X * 1e6, Vec3::X * 5e5], vec![[0, 1, 2]]);
    let field = HeightField::new([900.0, 900.0], [2, 2], vec![0.0; 4]).unwrap();
    let start = std::time::Instant::now();
    for shape in [
        BoundaryShape::Cylinder { radius, half_height, fluid },
        BoundaryShape::Capsule { radius, half_height, fluid },
        BoundaryShape::Cone { radius, half_height, fluid },
        BoundaryShape::Cup { radius, half_height, thickness: 1.0 },
        BoundaryShape::mesh(block(Vec3::splat(900.0), Vec3::ZERO)),
        BoundaryShape::mesh(long),
        BoundaryShape::HeightField { field },
    ] {
        let scene = FluidScene {
            boundaries: vec![Boundary::new(shape.clone(), Vec3::ZERO)],
            ..FluidScene::with_spacing(if matches!(shape, BoundaryShape::Mesh { .. }) { 0.02 } else { D })
        };
        let error = Plan::new(&scene).unwrap_err().to_string();
        assert!(error.starts_with("resolution: spacing 0."), "{shape:?}: {error}");
        assert!(error.contains("samples; this one makes") && error.contains("in boundaries[0]"), "{error}");
    }
    assert!(start.elapsed().as_secs_f32() < 1.0);
}
