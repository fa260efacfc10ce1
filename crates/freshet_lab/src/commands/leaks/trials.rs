//! What is tried: walls and fluid that meet at up to 10 m/s.

use std::f32::consts::{PI, TAU};

use freshet_core::geometry::{HeightField, TriangleMesh};
use freshet_core::scene::{Body, Boundary, BoundaryShape, FluidScene, FluidSide, Volume};
use glam::{Quat, Vec3};

use super::gate::Gate;
use crate::error::LabError;

/// Spacing of the fluid, m; the walls that are sheets are as thick.
pub const SPACING: f32 = 0.05;

/// Time between two looks, s: what is as fast as 10 m/s goes 0.8 spacings.
const TICK: f64 = 1.0 / 240.0;

/// The same as in a game.
const GAME_TICK: f64 = 1.0 / 60.0;

/// Particles fired at each shape.
pub const FIRED: usize = 10_000;

/// One trial.
pub struct Trial {
    /// What happens.
    pub what: String,
    /// How fast.
    pub pace: String,
    /// Fluid, walls, and at most one body, which moves as it is told.
    pub scene: FluidScene,
    /// Where the body is at a time; it is not pushed.
    pub motion: Option<Motion>,
    /// What nothing may go through: in the frame of the body, where there is one.
    pub gates: Vec<Gate>,
    /// Particles that are fired at the walls instead of fluid.
    pub shots: usize,
    /// Speed of these, m/s.
    pub speed: f32,
    /// How long, s.
    pub seconds: f64,
    /// Time between two looks, s.
    pub tick: f64,
}

impl Trial {
    /// What happens, and how fast.
    pub fn name(&self) -> String {
        format!("{}, {}", self.what, self.pace)
    }
}

/// Position and orientation of a body at a time, s.
pub type Motion = Box<dyn Fn(f64) -> (Vec3, Quat)>;

/// All trials; the short form has the fastest of each kind, and a tenth of the shots.
pub fn trials(quick: bool) -> Result<Vec<Trial>, LabError> {
    let speeds: &[f32] = if quick { &[10.0] } else { &[0.5, 2.0, 10.0] };
    let mut trials = Vec::new();
    for kind in [plate, cup_pulled, piston, paddle, bowl, valley] {
        for &speed in speeds {
            trials.push(kind(speed)?);
        }
    }
    trials.push(cup_tilted()?);
    let shots = if quick { FIRED / 10 } else { FIRED };
    for (name, shape) in shapes()? {
        trials.push(shot(name, shape, shots));
    }
    Ok(trials)
}

/// A scene in which things are as fast as `speed`, in a closed room around the origin.
fn room(speed: f32) -> FluidScene {
    let mut scene = FluidScene {
        boundaries: vec![Boundary::closed_box(Vec3::new(2.4, 3.0, 2.4), Vec3::ZERO)],
        ..FluidScene::with_spacing(SPACING)
    };
    // What falls through the room is faster than what moves slowly in it.
    scene.settings.expected_speed = Some(speed.max((2.0f32 * 9.81 * 3.0).sqrt()));
    scene
}

fn still(what: &str, pace: String, scene: FluidScene, gates: Vec<Gate>, seconds: f64) -> Trial {
    Trial { what: what.to_owned(), pace, scene, motion: None, gates, shots: 0, speed: 0.0, seconds, tick: TICK }
}

/// A block that is thrown at a plate one spacing thick.
fn plate(speed: f32) -> Result<Trial, LabError> {
    let mut scene = room(speed);
    let thrown = Vec3::new(0.0, -speed, 0.0);
    scene.volumes = vec![Volume { velocity: thrown, ..Volume::block(Vec3::splat(0.25), Vec3::Y * 0.4) }];
    let half = Vec3::new(0.9, 0.5 * SPACING, 0.9);
    scene.boundaries.push(Boundary::new(BoundaryShape::Box { half_extents: half }, Vec3::ZERO));
    // Splashes round its corners up to a tenth of a spacing inside the visible edge: who passes there passes over the rim.
    let gate = Gate::Rectangle { half_extents: [half.x, half.z].map(|edge| edge - 0.1 * SPACING) };
    Ok(still("a block thrown at a thin plate", format!("{speed} m/s"), scene, vec![gate], 0.6))
}

/// Room of the cup: radius and half height, m.
const CUP: [f32; 2] = [0.4, 0.35];

fn cup(speed: f32) -> Result<(FluidScene, Gate), LabError> {
    let mut scene = room(speed);
    let [radius, half_height] = CUP;
    scene.boundaries.clear();
    scene.volumes = vec![Volume::block(Vec3::new(0.225, 0.225, 0.225), Vec3::Y * -0.1)];
    scene.bodies = vec![Body { samples: scene.wall_layer()?.cup(radius, half_height, SPACING)?, ..Body::default() }];
    // What leaves it over its rim falls for as long as the trial lasts.
    scene.settings.bounds = Some((Vec3::splat(-60.0), Vec3::splat(60.0)));
    let middle = 0.5 * SPACING;
    Ok((scene, Gate::Cup { radius: radius + middle, bottom: -half_height - middle, rim: half_height }))
}

/// A cup of water that is pulled away at so many m/s2, for a second.
fn cup_pulled(acceleration: f32) -> Result<Trial, LabError> {
    let (scene, gate) = cup(10.0)?;
    let place = move |time: f64| {
        // It stands for 0.2 s first.
        let pulled = (time - 0.2).max(0.0) as f32;
        (Vec3::X * (0.5 * acceleration * pulled * pulled), Quat::IDENTITY)
    };
    let pulled = still("a cup of water pulled away", format!("{acceleration} m/s2"), scene, vec![gate], 1.2);
    Ok(Trial { motion: Some(Box::new(place)), ..pulled })
}

/// A cup of water that is turned upside down within a second.
fn cup_tilted() -> Result<Trial, LabError> {
    let (scene, gate) = cup(5.0)?;
    let place = |time: f64| (Vec3::ZERO, Quat::from_rotation_z(PI * ((time - 0.2) as f32).clamp(0.0, 1.0)));
    let turned = still("a cup of water turned over", "1 s".to_owned(), scene, vec![gate], 1.2);
    Ok(Trial { motion: Some(Box::new(place)), ..turned })
}

/// A piston that pushes a column along a channel with a lid, into the air at its end.
fn piston(speed: f32) -> Result<Trial, LabError> {
    let mut scene = room(speed);
    let size = Vec3::new(2.0, 0.6, 0.4);
    scene.boundaries = vec![Boundary::closed_box(size, Vec3::ZERO)];
    scene.volumes = vec![Volume::block(Vec3::new(0.3, 0.25, 0.2), Vec3::new(-0.3, -0.05, 0.0))];
    // Across the whole channel, thin along y in its own frame, which is x of the channel.
    let half = Vec3::new(0.5 * size.y, 0.5 * SPACING, 0.5 * size.z);
    scene.bodies = vec![Body { samples: scene.wall_layer()?.box_surface(half)?, ..Body::default() }];
    let upright = Quat::from_rotation_z(-0.5 * PI);
    let start = -0.6 - SPACING;
    let place = move |time: f64| (Vec3::X * (start + (speed * time as f32).min(0.7)), upright);
    let gate = Gate::Rectangle { half_extents: [half.x, half.z] };
    let seconds = f64::from(0.7 / speed) + 0.1;
    let pushed = still("a piston that pushes a column", format!("{speed} m/s"), scene, vec![gate], seconds);
    Ok(Trial { motion: Some(Box::new(place)), ..pushed })
}

/// A paddle whose ends are that fast, in a tank of water.
fn paddle(speed: f32) -> Result<Trial, LabError> {
    let mut scene = room(speed);
    scene.boundaries = vec![Boundary::closed_box(Vec3::new(1.2, 1.2, 0.6), Vec3::ZERO)];
    scene.volumes = vec![Volume::block(Vec3::new(0.6, 0.4, 0.3), Vec3::Y * -0.2)];
    let half = Vec3::new(0.35, 0.5 * SPACING, 0.2);
    scene.bodies = vec![Body {
        samples: scene.wall_layer()?.box_surface(half)?,
        solids: vec![freshet_core::solid::Solid::block(half, Vec3::ZERO)],
        ..Body::default()
    }];
    let place =
        move |time: f64| (Vec3::Y * -0.1, Quat::from_rotation_z((f64::from(speed / half.x) * time) as f32 % TAU));
    let gate = Gate::Rectangle { half_extents: [half.x, half.z] };
    let stirred = still("a paddle in water, its ends", format!("{speed} m/s"), scene, vec![gate], 0.5);
    // A game's ticks serve up to 2 m/s, by both methods. At 10 m/s it turns by 27 degrees in one: straight ways in its frame cut up to 1 cm off
    // the arcs round its ends, and one of 4,608 particles counts (weakly compressible; none of the incompressible fluid).
    let tick = if speed > 2.0 { TICK } else { GAME_TICK };
    Ok(Trial { motion: Some(Box::new(place)), tick, ..stirred })
}

/// Half a ball of triangles, open at the top.
fn bowl_mesh(radius: f32) -> Result<TriangleMesh, LabError> {
    let (rows, columns) = (12u32, 36u32);
    let mut vertices = Vec::new();
    for i in 0..=rows {
        let (sin, cos) = (0.5 * PI * i as f32 / rows as f32).sin_cos();
        vertices.extend((0..columns).map(|j| {
            let (s, c) = (TAU * j as f32 / columns as f32).sin_cos();
            radius * Vec3::new(sin * c, -cos, sin * s)
        }));
    }
    let quad = |i: u32, j: u32| {
        let (a, b) = (i * columns + j, i * columns + (j + 1) % columns);
        [[a, b, b + columns], [a, b + columns, a + columns]]
    };
    let triangles = (0..rows).flat_map(|i| (0..columns).flat_map(move |j| quad(i, j))).collect();
    Ok(TriangleMesh::new(vertices, triangles)?)
}

/// A block that is thrown into a bowl of triangles.
fn bowl(speed: f32) -> Result<Trial, LabError> {
    let radius = 0.7;
    let mut scene = room(speed);
    let thrown = Vec3::new(0.0, -speed, 0.0);
    scene.volumes = vec![Volume { velocity: thrown, ..Volume::block(Vec3::splat(0.2), Vec3::ZERO) }];
    scene.boundaries.push(Boundary::new(BoundaryShape::mesh(bowl_mesh(radius)?), Vec3::ZERO));
    // Between the triangles' edges they are nearer to the middle than their corners are.
    let gates = vec![Gate::Bowl { radius: 0.995 * radius, rim: -0.02 }];
    Ok(still("a block thrown into a bowl", format!("{speed} m/s"), scene, gates, 0.6))
}

fn valley_field() -> Result<HeightField, LabError> {
    let heights = (0..21 * 21).map(|i| {
        let [x, z] = [i % 21, i / 21].map(|k| (k as f32 - 10.0) / 10.0);
        1.2 * (x * x + z * z) + 0.05 * (9.0 * x).sin() * (7.0 * z).cos()
    });
    Ok(HeightField::new([3.0, 3.0], [21, 21], heights.collect())?)
}

/// A block that is thrown into a valley.
fn valley(speed: f32) -> Result<Trial, LabError> {
    let mut scene = room(speed);
    let thrown = Vec3::new(0.0, -speed, 0.0);
    scene.volumes = vec![Volume { velocity: thrown, ..Volume::block(Vec3::splat(0.2), Vec3::Y * 0.5) }];
    // Nothing holds what splashes out of it.
    scene.boundaries = vec![Boundary::new(BoundaryShape::HeightField { field: valley_field()? }, Vec3::ZERO)];
    scene.settings.bounds = Some((Vec3::splat(-30.0), Vec3::splat(30.0)));
    Ok(still("a block thrown into a valley", format!("{speed} m/s"), scene, Vec::new(), 0.6))
}

/// Every shape a wall may have.
fn shapes() -> Result<Vec<(&'static str, BoundaryShape)>, LabError> {
    use FluidSide::{Both, Inside, Outside};
    let points: Vec<Vec3> =
        (0..8).map(|i| 0.4 * Vec3::from([i & 1, i >> 1 & 1, i >> 2].map(|bit| 2.0 * bit as f32 - 1.0))).collect();
    let ball = |fluid| BoundaryShape::Sphere { radius: 0.45, fluid };
    let tin = |fluid| BoundaryShape::Cylinder { radius: 0.4, half_height: 0.4, fluid };
    let pill = |fluid| BoundaryShape::Capsule { radius: 0.35, half_height: 0.2, fluid };
    let cone = |fluid| BoundaryShape::Cone { radius: 0.6, half_height: 0.6, fluid };
    let hull = freshet_core::geometry::convex_hull(&points)?;
    Ok(vec![
        ("a closed container", BoundaryShape::Container { half_extents: Vec3::splat(0.5), open: [false; 6] }),
        ("a box", BoundaryShape::Box { half_extents: Vec3::splat(0.4) }),
        ("a plane", BoundaryShape::Plane { half_extents: [1.25, 1.25] }),
        ("a half-space", BoundaryShape::HalfSpace { half_extents: [1.25, 1.25] }),
        ("a ball", ball(Outside)),
        ("a round room", ball(Inside)),
        ("a bubble, from both sides", ball(Both)),
        ("a cylinder", tin(Outside)),
        ("a tin", tin(Inside)),
        ("a capsule", pill(Outside)),
        ("a capsule's inside", pill(Inside)),
        ("a cone", cone(Outside)),
        ("a cone's inside", cone(Inside)),
        ("a cup", BoundaryShape::Cup { radius: 0.35, half_height: 0.45, thickness: 0.2 }),
        ("a convex hull", BoundaryShape::ConvexHull { points }),
        ("a mesh", BoundaryShape::Mesh { mesh: hull.clone(), fluid: Some(Outside) }),
        ("a room of triangles", BoundaryShape::Mesh { mesh: hull, fluid: Some(Inside) }),
        ("a height field", BoundaryShape::HeightField { field: valley_field()? }),
    ])
}

/// Single particles fired at a shape at 10 m/s.
fn shot(name: &str, shape: BoundaryShape, shots: usize) -> Trial {
    let speed = 10.0;
    let mut scene = room(speed);
    scene.gravity = Vec3::ZERO;
    scene.boundaries = vec![Boundary::new(shape, Vec3::ZERO)];
    scene.settings.max_particles = Some(shots as u32);
    scene.settings.bounds = Some((Vec3::splat(-10.0), Vec3::splat(10.0)));
    let fired = still(&format!("fired at {name}"), format!("{speed} m/s"), scene, Vec::new(), 0.0);
    Trial { shots, speed, ..fired }
}
