//! The pool, the ball, and rapier's world around them.

use std::f64::consts::PI;

use freshet_core::plan::Plan;
use freshet_core::scene::{Boundary, FluidScene, Volume};
use freshet_core::step::Command;
use freshet_rapier::body_from_rigid_body;
use glam::Vec3;
use rapier3d::dynamics::{RigidBodyBuilder, RigidBodyHandle};
use rapier3d::geometry::ColliderBuilder;
use rapier3d::pipeline::PhysicsWorld;

use crate::error::LabError;
use crate::method::Method;
use crate::scenes::GRAVITY;

/// Density of the ball, kg/m3.
pub const BALL_DENSITY: f32 = 500.0;
/// Distance of particles, m.
pub const SPACING: f32 = 0.05;
/// Duration of a tick, s.
pub const TICK: f32 = 1.0 / 60.0;
/// Height above where the ball should float from which it is released, over its diameter.
const RELEASE: f32 = 0.1;
/// Height of the walls above the water, spacings.
const HEADROOM: u32 = 8;

/// Sizes in spacings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pool {
    /// Of the ball.
    pub diameter: u32,
    /// Edge of the square floor.
    pub width: u32,
    /// Of the water with the ball afloat.
    pub depth: u32,
}

impl Pool {
    /// The pool for a ball of so many spacings.
    pub fn for_ball(diameter: u32) -> Option<Self> {
        match diameter {
            6 => Some(Self { diameter, width: 20, depth: 12 }),
            12 => Some(Self { diameter, width: 36, depth: 20 }),
            _ => None,
        }
    }

    /// About how many particles.
    pub fn particles(&self) -> f64 {
        f64::from(self.width).powi(2) * f64::from(self.depth)
    }

    /// Radius of the ball, m.
    pub fn radius(&self) -> f32 {
        self.diameter as f32 * SPACING / 2.0
    }

    /// Area of the floor, m2.
    pub fn area(&self) -> f64 {
        f64::from(self.width as f32 * SPACING).powi(2)
    }

    /// Volume of the ball's part below `level`, m3, with its centre at `height`, m.
    pub fn submerged(&self, height: f64, level: f64) -> f64 {
        let radius = f64::from(self.radius());
        let depth = (level - height + radius).clamp(0.0, 2.0 * radius);
        PI * depth * depth * (radius - depth / 3.0)
    }

    /// Level of `water` m3 with the ball's centre at `height`, m: what the water and the ball's submerged part fill.
    pub fn level(&self, water: f64, height: f64) -> f64 {
        let (mut low, mut high) = (0.0, (water + self.submerged(height, f64::INFINITY)) / self.area());
        for _ in 0..60 {
            let level = (low + high) / 2.0;
            let filled = level * self.area() - self.submerged(height, level);
            if filled < water { low = level } else { high = level }
        }
        (low + high) / 2.0
    }
}

/// What is simulated.
pub struct Scene {
    /// For the solver.
    pub plan: Plan,
    /// For its first tick: takes out the water where the ball is.
    pub carve: Vec<Command>,
    /// With the ball and the pool's walls.
    pub world: PhysicsWorld,
    /// The ball.
    pub ball: RigidBodyHandle,
    /// Volume of the water, m3.
    pub water: f64,
}

/// Builds a pool, floor at y = 0 around the origin.
pub fn scene(pool: &Pool, method: Method) -> Result<Scene, LabError> {
    let (width, depth) = (pool.width as f32 * SPACING, pool.depth as f32 * SPACING);
    let walls = depth + (HEADROOM + pool.diameter) as f32 * SPACING;
    let mut world = PhysicsWorld::new();
    world.gravity = Vec3::new(0.0, -GRAVITY as f32, 0.0);
    world.integration_parameters.dt = TICK;
    let release = Vec3::Y * (depth + RELEASE * 2.0 * pool.radius());
    let (ball, _) = world.insert(
        // A ball at rest would fall asleep; here it is to be measured.
        RigidBodyBuilder::dynamic().translation(release).can_sleep(false),
        ColliderBuilder::ball(pool.radius()).density(BALL_DENSITY),
    );
    insert_walls(&mut world, width, walls);
    let mut fluid = method.on(fluid(pool, width, depth, walls));
    let ball_body = body_from_rigid_body("ball", &world.bodies[ball], &world.colliders, &fluid.wall_layer()?)
        .map_err(|error| LabError::Measure { what: "the ball", reason: error.to_string() })?;
    fluid.bodies.push(ball_body);
    let plan = Plan::new(&fluid)?;
    let carve = carve(&plan, release, pool.radius() + SPACING / 2.0);
    let left = plan.positions.len() - carve.iter().map(removed).sum::<usize>();
    let water = left as f64 * f64::from(SPACING).powi(3);
    Ok(Scene { plan, carve, world, ball, water })
}

/// Water in an open container, without the ball.
fn fluid(pool: &Pool, width: f32, depth: f32, walls: f32) -> FluidScene {
    let (water, container) = (Vec3::new(width, depth, width), Vec3::new(width, walls, width));
    FluidScene {
        name: format!("ball of {} spacings", pool.diameter),
        volumes: vec![Volume::block(water / 2.0, Vec3::Y * depth / 2.0)],
        boundaries: vec![Boundary::open_box(container, Vec3::Y * walls / 2.0)],
        ..FluidScene::with_spacing(SPACING)
    }
}

/// Floor and sides, half a metre thick.
fn insert_walls(world: &mut PhysicsWorld, width: f32, height: f32) {
    let (half, thick) = (width / 2.0, 0.25);
    let mut wall = |half_extents: Vec3, center: Vec3| {
        let collider = ColliderBuilder::cuboid(half_extents.x, half_extents.y, half_extents.z).translation(center);
        world.insert_collider(collider, None);
    };
    wall(Vec3::new(half, thick, half), Vec3::Y * -thick);
    for side in [-1.0, 1.0] {
        wall(Vec3::new(thick, height / 2.0, half), Vec3::new(side * (half + thick), height / 2.0, 0.0));
        wall(Vec3::new(half, height / 2.0, thick), Vec3::new(0.0, height / 2.0, side * (half + thick)));
    }
}

/// Commands that remove the particles within `radius` of a point.
fn carve(plan: &Plan, center: Vec3, radius: f32) -> Vec<Command> {
    let mut commands: Vec<Command> = Vec::new();
    for (id, position) in (0..).zip(&plan.positions) {
        if position.distance(center) >= radius {
            continue;
        }
        match commands.last_mut() {
            Some(Command::RemoveIds { first, count }) if *first + *count == id => *count += 1,
            _ => commands.push(Command::RemoveIds { first: id, count: 1 }),
        }
    }
    commands
}

fn removed(command: &Command) -> usize {
    if let Command::RemoveIds { count, .. } = command { *count as usize } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_half_under_displaces_half_of_itself() {
        let pool = Pool::for_ball(6).unwrap();
        let whole = 4.0 / 3.0 * PI * 0.15f64.powi(3);
        assert!((pool.submerged(1.0, 1.0) - whole / 2.0).abs() < 1e-8);
        assert!((pool.submerged(1.0, 5.0) - whole).abs() < 1e-8);
        assert_eq!(pool.submerged(1.0, 0.5), 0.0);
    }

    #[test]
    fn the_level_is_where_water_and_ball_fill_the_pool() {
        let pool = Pool::for_ball(6).unwrap();
        for (water, height) in [(0.6, 0.6), (0.6, 5.0), (0.6, 0.2), (0.55, 0.5)] {
            let level = pool.level(water, height);
            assert!((level * pool.area() - pool.submerged(height, level) - water).abs() < 1e-6, "{water} {height}");
        }
    }

    #[test]
    fn no_water_is_left_in_the_ball() {
        let pool = Pool::for_ball(6).unwrap();
        let scene = scene(&pool, Method::default()).unwrap();
        let center = scene.world.bodies[scene.ball].translation();
        let mut left = vec![true; scene.plan.positions.len()];
        for command in &scene.carve {
            let Command::RemoveIds { first, count } = command else { panic!("{command:?}") };
            left[*first as usize..(first + count) as usize].fill(false);
        }
        for (position, _) in scene.plan.positions.iter().zip(&left).filter(|(_, left)| **left) {
            assert!(position.distance(center) >= 0.175);
        }
        // About half a ball is gone.
        let gone = left.iter().filter(|left| !**left).count();
        assert!((40..120).contains(&gone), "{gone}");
    }
}
