//! Counts what goes through walls.
//!
//! A particle leaks when its centre gets deeper into a wall than the wall's samples lie ([`WallLayer::depth`], 0.92 spacings by default),
//! or, where a wall is thinner than twice that, past its middle: into the part whose nearest face is the one behind it. Its way between
//! two looks is taken to be straight, and looked at in the wall's own frame, so that a wall that sweeps over fluid counts too. Each
//! particle counts once, however often it goes through, and wherever it goes then.
//!
//! Walls do not move particles, so that there is nobody who could bring one back unseen. What has no way to be told
//! does not count: a particle that goes around the rim of an open surface, or leaves the bounds. Where one goes around an edge by more than about three
//! spacings between two looks, its straight way may cut the edge off: look more often, once for each two spacings of way.
//!
//! The lab's trials count by formulas of their own instead (`freshet_lab::commands::leaks`), so that this is not judged by itself.

use std::collections::HashMap;

use glam::{Quat, Vec3};

use crate::sampling::wall_layer::WallLayer;
use crate::scene::{Boundary, BoundaryShape};
use crate::solid::{Solid, SolidShape};

/// Length of a stride along a way inside a wall, over the spacing.
const STRIDE: f32 = 0.05;

/// Cosine between the normal of the face through which a particle came and that of the face that is nearest to it now, below which it is
/// past the wall's middle. In an edge of 90 degrees it is 0, and what cuts off such an edge is not behind the wall.
const OPPOSITE: f32 = -0.5;

/// Distance from a face, over the stride, nearer than which rounding turns normals about.
const AT_FACE: f32 = 0.01;

/// Where a wall is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallPose {
    /// Centre, m.
    pub center: Vec3,
    /// Orientation, a unit quaternion.
    pub rotation: Quat,
}

impl WallPose {
    fn to_local(self, point: Vec3) -> Vec3 {
        self.rotation.conjugate() * (point - self.center)
    }
}

/// A wall in its own frame.
struct Wall {
    solids: Vec<Solid>,
    before: WallPose,
    now: WallPose,
}

/// A particle at the last look.
#[derive(Clone, Copy)]
struct Seen {
    position: Vec3,
    /// It has to go at least so far before it can be in a wall, m.
    slack: f32,
    /// What it is in or at.
    entry: Option<Entry>,
    leaked: bool,
}

/// How a particle came into a solid.
#[derive(Clone, Copy)]
struct Entry {
    /// Which wall, and which of its solids.
    of: [usize; 2],
    /// Normal of the nearest face, in the wall's frame.
    normal: Vec3,
}

/// What became of a particle on its way.
enum Followed {
    /// It went through a wall.
    Through,
    /// How far it is from the nearest wall, m, and what it is in or at.
    Held(f32, Option<Entry>),
}

/// Follows particles by their ids, and counts those that go through walls.
///
/// ```
/// use freshet_core::leaks::LeakWatch;
/// use freshet_core::prelude::*;
/// let scene = FluidScene::with_spacing(0.1);
/// let plate = BoundaryShape::Box { half_extents: Vec3::new(1.0, 0.05, 1.0) };
/// let mut watch = LeakWatch::new(&scene.wall_layer()?, &[Boundary::new(plate, Vec3::ZERO)]);
/// assert_eq!(watch.look(&[7, 8], &[Vec3::Y * 0.1, Vec3::new(2.0, 0.1, 0.0)]), 0);
/// // The first goes through the plate, the second past it.
/// assert_eq!(watch.look(&[7, 8], &[Vec3::Y * -0.1, Vec3::new(2.0, -0.1, 0.0)]), 1);
/// # Ok::<(), SceneError>(())
/// ```
pub struct LeakWatch {
    walls: Vec<Wall>,
    stride: f32,
    limit: f32,
    seen: HashMap<u32, Seen>,
    total: u64,
}

impl LeakWatch {
    /// Watches walls at the poses that they have now.
    pub fn new(layer: &WallLayer, walls: &[Boundary]) -> Self {
        let mut watch = Self { walls: Vec::new(), stride: 0.0, limit: 0.0, seen: HashMap::new(), total: 0 };
        watch.set_walls(layer, walls);
        watch
    }

    /// Goes on with other walls, or with the same at other places: what has leaked stays counted, and nothing that was
    /// between a wall's old place and its new one.
    pub fn set_walls(&mut self, layer: &WallLayer, walls: &[Boundary]) {
        self.stride = STRIDE * layer.spacing();
        self.limit = layer.depth;
        let wall = |wall: &Boundary| {
            let pose = WallPose { center: wall.center, rotation: wall.rotation };
            let shape = match &wall.shape {
                // Beyond the edges of its rectangle fluid may fall: a wall of the rectangle's size, not the half of all space.
                &BoundaryShape::HalfSpace { half_extents } => BoundaryShape::Plane { half_extents },
                shape => shape.clone(),
            };
            Wall { solids: Boundary::new(shape, Vec3::ZERO).solids(layer), before: pose, now: pose }
        };
        self.walls = walls.iter().map(wall).collect();
        // What a particle came into is said by a wall's place in the list that is gone.
        self.seen.values_mut().for_each(|seen| (seen.slack, seen.entry) = (0.0, None));
    }

    /// Moves a wall, counted as given: it gets there by the next look.
    pub fn move_wall(&mut self, index: usize, pose: WallPose) {
        if let Some(wall) = self.walls.get_mut(index) {
            wall.now = pose;
        }
    }

    /// Puts a wall elsewhere: nothing on its way there counts.
    pub fn put_wall(&mut self, index: usize, pose: WallPose) {
        if let Some(wall) = self.walls.get_mut(index) {
            (wall.before, wall.now) = (pose, pose);
            self.seen.values_mut().for_each(|seen| seen.slack = 0.0);
        }
    }

    /// Particles that have leaked so far.
    pub fn total(&self) -> u64 {
        self.total
    }

    /// Looks at all particles there are; returns how many have leaked since the last look. A particle that was not there then has no way
    /// yet: it leaks if it is deeper in a wall than samples lie, where the wall is now. Lists of different lengths end with the shorter.
    pub fn look(&mut self, ids: &[u32], positions: &[Vec3]) -> u32 {
        let mut seen = HashMap::with_capacity(ids.len());
        let mut count = 0;
        for (&id, &position) in ids.iter().zip(positions) {
            let before = self.seen.get(&id);
            let from = before.map(|before| before.position);
            let new = Seen { position, slack: 0.0, entry: None, leaked: false };
            let mut now = before.map_or(new, |before| Seen { position, ..*before });
            if !now.leaked {
                now.slack -= from.map_or(0.0, |from| self.way(from, position));
                // A comparison with not-a-number is false: what is nowhere is not followed.
                if now.slack <= 0.0 && position.is_finite() {
                    match self.follow(from, position, now.entry) {
                        Followed::Through => now.leaked = true,
                        Followed::Held(slack, entry) => (now.slack, now.entry) = (slack, entry),
                    }
                    count += u32::from(now.leaked);
                }
            }
            seen.insert(id, now);
        }
        self.seen = seen;
        for wall in &mut self.walls {
            wall.before = wall.now;
        }
        self.total += u64::from(count);
        count
    }

    /// How far a particle goes at most, seen from a wall, m.
    fn way(&self, from: Vec3, to: Vec3) -> f32 {
        let moved = self.walls.iter().filter(|wall| wall.before != wall.now);
        let seen = moved.map(|wall| wall.before.to_local(from).distance(wall.now.to_local(to)));
        seen.fold(from.distance(to), f32::max)
    }

    /// What becomes of a particle that came as `entry` says into what it is in; without a place where it was it has just come.
    fn follow(&self, from: Option<Vec3>, to: Vec3, entry: Option<Entry>) -> Followed {
        let (mut nearest, mut at) = (f32::INFINITY, None);
        for (i, wall) in self.walls.iter().enumerate() {
            let to = wall.now.to_local(to);
            let from = from.map_or(to, |from| wall.before.to_local(from));
            for (j, solid) in wall.solids.iter().enumerate() {
                let of = [i, j];
                let came = entry.filter(|entry| entry.of == of).map(|entry| entry.normal);
                match self.follow_in(solid, from, to, came) {
                    None => return Followed::Through,
                    Some((distance, normal)) if distance < nearest => {
                        nearest = distance;
                        at = normal.map(|normal| Entry { of, normal });
                    }
                    Some(_) => {}
                }
            }
        }
        Followed::Held(nearest.max(0.0), at)
    }

    /// The same for one solid, in its wall's frame: how far the end is from it, and if it is in it the normal where it came in. None if
    /// it goes through.
    fn follow_in(&self, solid: &Solid, from: Vec3, to: Vec3, mut came: Option<Vec3>) -> Option<(f32, Option<Vec3>)> {
        let length = from.distance(to);
        // What is farther from the box around it than the way is long need not be followed.
        let apart = solid.distance_of_bounds(to);
        if apart > length + self.stride {
            return Some((apart, None));
        }
        // Around the rim of a sheet one comes to the other side without going through it: only a leap of the normal tells that. The
        // middle of a thin rod has none.
        let is_sheet = matches!(solid.shape, SolidShape::Skin { .. });
        let mut gone = 0.0;
        loop {
            let at = if gone > 0.0 { from.lerp(to, gone / length) } else { from };
            let (distance, normal) = solid.distance_from(at);
            if distance > self.stride {
                came = None;
            } else if distance.abs() > AT_FACE * self.stride {
                if distance < -self.limit || came.is_some_and(|came| came.dot(normal) < OPPOSITE) {
                    return None;
                }
                came = came.filter(|_| !is_sheet).or(Some(normal));
            }
            if gone >= length {
                return Some((distance, came));
            }
            // Outside, nothing is nearer than the surface. A place in front of it says from where the particle comes.
            gone = (gone + (distance - 0.5 * self.stride).max(self.stride)).min(length);
        }
    }
}
