//! Fluid in and on walls of every shape: nothing gets through.

use std::f32::consts::{PI, TAU};

use freshet_core::prelude::*;
use freshet_cpu::{CpuOptions, CpuSolver};

const D: f32 = 0.05;

/// Steps a second and asserts that nothing is removed and nothing is where no fluid may be, by more than a quarter of a spacing: so
/// much fluid that falls on a wall sinks in before it is stopped.
fn holds(name: &str, boundary: Boundary, volume: Volume) {
    holds_within(name, boundary, volume, 0.25 * D);
}

fn holds_within(name: &str, boundary: Boundary, volume: Volume, tolerance: f32) {
    let mut boundaries = vec![boundary];
    // What runs off a solid falls on a floor.
    if !matches!(boundaries[0].shape, BoundaryShape::HeightField { .. } | BoundaryShape::HalfSpace { .. }) {
        boundaries.push(Boundary::closed_box(Vec3::new(2.4, 3.0, 2.4), Vec3::ZERO));
    }
    let scene = FluidScene { volumes: vec![volume], boundaries, ..FluidScene::with_spacing(D) };
    let plan = Plan::new(&scene).unwrap_or_else(|error| panic!("{name}: {error}"));
    let count = plan.positions.len();
    assert!(count > 100, "{name}: {count} particles");
    let mut solver = CpuSolver::new(plan, CpuOptions::default()).unwrap();
    for tick in 0..60 {
        let report = solver.step(&StepInput { tick, duration: 1.0 / 60.0, ..StepInput::default() }).unwrap();
        assert_eq!((report.removed, report.refused, report.inside_solids), (0, 0, 0), "{name}, tick {tick}");
        assert_eq!(report.particles as usize, count, "{name}, tick {tick}");
    }
    let FieldData::Vector(positions) = solver.read(Field::Position).unwrap() else { panic!("{name}") };
    let is_through = |x: &&Vec3| scene.boundaries.iter().any(|wall| wall.is_on_wrong_side(**x, tolerance));
    let through: Vec<&Vec3> = positions.iter().filter(is_through).collect();
    assert!(
        through.is_empty(),
        "{name}: {} of {count} went through, at {:?}",
        through.len(),
        &through[..through.len().min(5)]
    );
}

fn at_origin(shape: BoundaryShape) -> Boundary {
    Boundary::new(shape, Vec3::ZERO)
}

#[test]
fn rooms_hold_fluid() {
    let fluid = FluidSide::Inside;
    let block = Volume::block(Vec3::splat(0.2), Vec3::ZERO);
    for (name, shape) in [
        ("sphere", BoundaryShape::Sphere { radius: 0.45, fluid }),
        ("cylinder", BoundaryShape::Cylinder { radius: 0.4, half_height: 0.4, fluid }),
        ("capsule", BoundaryShape::Capsule { radius: 0.35, half_height: 0.2, fluid }),
        ("cone", BoundaryShape::Cone { radius: 0.6, half_height: 0.6, fluid }),
        ("cup", BoundaryShape::Cup { radius: 0.35, half_height: 0.45, thickness: 0.06 }),
    ] {
        holds(name, at_origin(shape), block.clone());
    }
}

#[test]
fn solids_keep_fluid_out() {
    let fluid = FluidSide::Outside;
    let block = Volume::block(Vec3::splat(0.15), Vec3::Y * 0.85);
    let points: Vec<Vec3> =
        (0..8).map(|i| 0.4 * Vec3::from([i & 1, i >> 1 & 1, i >> 2].map(|bit| 2.0 * bit as f32 - 1.0))).collect();
    for (name, shape) in [
        ("sphere", BoundaryShape::Sphere { radius: 0.45, fluid }),
        ("cylinder", BoundaryShape::Cylinder { radius: 0.4, half_height: 0.4, fluid }),
        ("capsule", BoundaryShape::Capsule { radius: 0.35, half_height: 0.2, fluid }),
        ("hull", BoundaryShape::ConvexHull { points }),
    ] {
        holds(name, at_origin(shape), block.clone());
    }
    // Samples behind an edge lie in its middle plane, as deep as below each face: farther from the edge the sharper it is. Fluid
    // comes as near to them as to any others and so cuts the edge, if it is sharper than 81 degrees: see docs/boundaries.md.
    let (radius, half_height) = (0.5f32, 0.5f32);
    let depth = FluidScene::with_spacing(D).wall_layer().unwrap().depth;
    let half_angle = 0.5 * (2.0 * half_height).atan2(radius);
    let cut = depth / half_angle.sin() - (depth + 0.5 * D);
    assert!((0.3..0.36).contains(&(cut / D)), "{cut}");
    holds_within("cone", at_origin(BoundaryShape::Cone { radius, half_height, fluid }), block, cut + 0.25 * D);
    let ground = BoundaryShape::HalfSpace { half_extents: [2.0, 2.0] };
    holds("half-space", at_origin(ground), Volume::block(Vec3::splat(0.15), Vec3::Y * 0.3));
}

/// Half a ball, open at the top, of triangles.
fn bowl(radius: f32) -> TriangleMesh {
    let (rows, columns) = (10u32, 32u32);
    let mut vertices = Vec::new();
    for i in 0..=rows {
        let ((sin, cos), y) = ((0.5 * PI * i as f32 / rows as f32).sin_cos(), -radius);
        vertices.extend((0..columns).map(|j| {
            let (s, c) = (TAU * j as f32 / columns as f32).sin_cos();
            Vec3::new(radius * sin * c, y * cos, radius * sin * s)
        }));
    }
    let quad = |i: u32, j: u32| {
        let (a, b) = (i * columns + j, i * columns + (j + 1) % columns);
        [[a, b, b + columns], [a, b + columns, a + columns]]
    };
    let triangles = (0..rows).flat_map(|i| (0..columns).flat_map(move |j| quad(i, j))).collect();
    TriangleMesh::new(vertices, triangles).unwrap()
}

/// Whether a way crosses a triangle.
fn crosses(from: Vec3, to: Vec3, [a, b, c]: [Vec3; 3]) -> bool {
    let normal = (b - a).cross(c - a);
    let (before, after) = ((from - a).dot(normal), (to - a).dot(normal));
    if (before > 0.0) == (after > 0.0) {
        return false;
    }
    let hit = from.lerp(to, before / (before - after));
    let is_left = |p: Vec3, q: Vec3| normal.cross(q - p).dot(hit - p) >= 0.0;
    is_left(a, b) && is_left(b, c) && is_left(c, a)
}

#[test]
fn a_way_crosses_a_triangle_or_passes_it() {
    let triangle = [Vec3::ZERO, Vec3::X, Vec3::Z];
    let at = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
    assert!(crosses(at(0.2, 1.0, 0.2), at(0.2, -1.0, 0.2), triangle));
    assert!(crosses(at(0.2, -0.1, 0.2), at(0.3, 0.1, 0.2), triangle));
    assert!(!crosses(at(0.7, 1.0, 0.7), at(0.7, -1.0, 0.7), triangle), "beside it");
    assert!(!crosses(at(0.2, 1.0, 0.2), at(0.2, 0.5, 0.2), triangle), "before it");
}

/// Water that is dropped into a bowl splashes over its rim, and then is outside: a leak is a particle whose way goes through a
/// triangle, in steps as short as 4 ms.
#[test]
fn a_bowl_of_triangles_holds_water_that_falls_into_it() {
    const RADIUS: f32 = 0.6;
    let mesh = bowl(RADIUS);
    assert!(!mesh.is_closed());
    let triangles: Vec<[Vec3; 3]> =
        mesh.triangles().iter().map(|t| t.map(|index| mesh.vertices()[index as usize])).collect();
    let scene = FluidScene {
        volumes: vec![Volume::block(Vec3::new(0.2, 0.1, 0.2), Vec3::Y * 0.1)],
        boundaries: vec![
            at_origin(BoundaryShape::mesh(mesh)),
            Boundary::closed_box(Vec3::new(2.4, 3.0, 2.4), Vec3::ZERO),
        ],
        ..FluidScene::with_spacing(D)
    };
    let plan = Plan::new(&scene).unwrap();
    let (count, depth) = (plan.positions.len(), plan.parameters.boundary_depth);
    let mut solver = CpuSolver::new(plan, CpuOptions::default()).unwrap();
    let by_id = |solver: &mut CpuSolver| {
        let (Ok(FieldData::Integer(ids)), Ok(FieldData::Vector(positions))) =
            (solver.read(Field::Id), solver.read(Field::Position))
        else {
            panic!()
        };
        let mut sorted = vec![Vec3::NAN; count];
        ids.iter().zip(positions).for_each(|(id, position)| sorted[*id as usize] = position);
        sorted
    };
    let mut before = by_id(&mut solver);
    for tick in 0..300 {
        let report = solver.step(&StepInput { tick, duration: 1.0 / 240.0, ..StepInput::default() }).unwrap();
        assert_eq!((report.removed, report.particles as usize), (0, count));
        let now = by_id(&mut solver);
        for (id, (&from, &to)) in before.iter().zip(&now).enumerate() {
            // No triangle is farther from the middle than the radius, nor nearer than 0.98 of it.
            if from.length().min(to.length()) > 1.01 * RADIUS || from.length().max(to.length()) < 0.97 * RADIUS {
                continue;
            }
            let leak = triangles.iter().find(|triangle| crosses(from, to, **triangle));
            assert!(leak.is_none(), "tick {tick}: particle {id} goes from {from} to {to} through {leak:?}");
        }
        before = now;
    }
    let (within, over): (Vec<&Vec3>, Vec<&Vec3>) = before.iter().partition(|x| x.y < 0.0 && x.length() < RADIUS);
    println!("{} of {count} in the bowl, {} over its rim", within.len(), over.len());
    assert!(within.len() > count / 2, "{} of {count} are in the bowl", within.len());
    // It stands off by the depth of the layer, as documented, and half a spacing.
    let farthest = within.iter().map(|x| x.length()).fold(0.0, f32::max);
    assert!(farthest < RADIUS - depth, "a particle is {farthest} m from the middle of a bowl of 0.6 m");
    assert!(farthest > RADIUS - depth - 1.5 * D, "the fluid lies on the bowl: {farthest} m");
}

#[test]
fn a_valley_holds_water() {
    let heights = (0..21 * 21).map(|i| {
        let [x, z] = [i % 21, i / 21].map(|k| (k as f32 - 10.0) / 10.0);
        0.8 * (x * x + z * z) + 0.05 * (9.0 * x).sin() * (7.0 * z).cos()
    });
    let field = HeightField::new([2.0, 2.0], [21, 21], heights.collect()).unwrap();
    let ground = at_origin(BoundaryShape::HeightField { field });
    holds("valley", ground, Volume::block(Vec3::new(0.25, 0.15, 0.25), Vec3::Y * 0.45));
}

#[test]
fn meshes_keep_fluid_in_and_out() {
    let corners = [-1.0f32, 1.0]
        .into_iter()
        .flat_map(|x| [-1.0f32, 1.0].into_iter().flat_map(move |y| [-1.0f32, 1.0].map(|z| Vec3::new(x, y, z))));
    let points: Vec<Vec3> = corners.map(|x| 0.45 * x).collect();
    let mesh = freshet_core::geometry::convex_hull(&points).unwrap();
    let turned = Quat::from_rotation_z(0.6) * Quat::from_rotation_x(0.6);
    let wall = |fluid| Boundary {
        rotation: turned,
        ..at_origin(BoundaryShape::Mesh { mesh: mesh.clone(), fluid: Some(fluid) })
    };
    holds("room", wall(FluidSide::Inside), Volume::block(Vec3::splat(0.2), Vec3::ZERO));
    holds("solid", wall(FluidSide::Outside), Volume::block(Vec3::splat(0.15), Vec3::Y * 1.1));
}
