//! Particles that start in solids or too near to them: which those are, and which way out is.

use glam::Vec3;

use crate::periodic::Periodic;
use crate::plan::Plan;
use crate::solid::Solid;
use crate::step::{BodyInput, Command, StepInput};

/// What is less deep than this share of the spacing is not inside, and what is less near not beside: as far as positions are
/// told apart, at worst.
const TOLERANCE: f32 = 1.0 / 64.0;

/// Distance from a face of fluid at rest, over the spacing.
const CALM: f32 = 0.5;

/// Distance from a wall, over the spacing, nearer than which a lattice was not made to fit: a whole number of spacings in a
/// length begins a quarter to three quarters of one from its ends.
const FIT: f32 = 0.2;

/// Where a point is. The index is whose solid it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Place {
    /// In it.
    Inside(usize),
    /// In front of it, nearer than fluid at rest would be, by this way.
    Beside(usize, Vec3),
    /// Where fluid at rest can be.
    Free,
}

/// Solids that points of a set may lie in, each with an index of whose it is.
pub(crate) struct Obstacles {
    solids: Vec<(usize, Solid)>,
    periodic: Periodic,
    spacing: f32,
}

impl Obstacles {
    /// Of all solids those near the points.
    pub(crate) fn near(
        points: &[Vec3],
        all: impl Iterator<Item = (usize, Solid)>,
        periodic: Periodic,
        spacing: f32,
    ) -> Self {
        // Points may move by a spacing, and are beside what is half a spacing away.
        let margin = 2.0 * spacing;
        let low = points.iter().copied().fold(Vec3::INFINITY, Vec3::min) - margin;
        let high = points.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max) + margin;
        let is_near = |(_, solid): &(usize, Solid)| {
            let (middle, reach) = solid.reach();
            let middle = solid.center + middle;
            let way = middle.clamp(low, high) - middle;
            // Along an axis that repeats, images are anywhere.
            periodic.across(way).abs().cmple(reach).all()
        };
        let solids = if points.is_empty() { Vec::new() } else { all.filter(is_near).collect() };
        Self { solids, periodic, spacing }
    }

    /// Whether there are none.
    pub(crate) fn is_empty(&self) -> bool {
        self.solids.is_empty()
    }

    /// Where a point is: inside of the first it is inside of, or else beside the nearest.
    pub(crate) fn place(&self, point: Vec3) -> Place {
        let calm = CALM * self.spacing;
        let mut nearest = (calm - TOLERANCE * self.spacing, Place::Free);
        for &(owner, ref solid) in &self.solids {
            let (distance, normal) = solid.distance(self.periodic.nearest(point - solid.center));
            if distance < -TOLERANCE * self.spacing {
                return Place::Inside(owner);
            }
            if distance < nearest.0 {
                nearest = (distance, Place::Beside(owner, (calm - distance) * normal));
            }
        }
        nearest.1
    }

    /// Whether a point is beside a solid and nearer than the outermost layer of a lattice made to fit would be.
    pub(crate) fn is_too_near(&self, place: Place) -> bool {
        matches!(place, Place::Beside(_, needed) if needed.length() > (CALM - FIT) * self.spacing)
    }

    /// The way, up to half a spacing from each of three faces, by which all points together move to where each is free. None if
    /// there is no such.
    pub(crate) fn way_out(&self, points: &[Vec3]) -> Option<Vec3> {
        let mut way = Vec3::ZERO;
        // One round for each face of a corner, and one that finds nothing left.
        for _ in 0..4 {
            let mut most = Vec3::ZERO;
            for &point in points {
                match self.place(point + way) {
                    Place::Inside(_) => return None,
                    Place::Beside(_, needed) if needed.length_squared() > most.length_squared() => most = needed,
                    _ => {}
                }
            }
            if most == Vec3::ZERO {
                return Some(way);
            }
            way += most;
        }
        None
    }
}

/// Whose a solid is that a tick's particles may be in.
#[derive(Clone, Copy)]
enum Owner {
    Wall,
    Body,
}

/// A particle that a tick leaves out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Misplaced {
    /// Which, counted from zero.
    pub index: u32,
    /// Whether its centre is inside a wall or a body, and not just too near to one.
    pub inside: bool,
}

impl Plan {
    /// Which of the particles at `positions` have their centre inside a body, or nearer to one than half a spacing, in order.
    ///
    /// For solvers, which ask on the first tick of the particles they hold: before it bodies have no place. `bodies` are that
    /// tick's, in the plan's order.
    pub fn started_inside(&self, positions: &[Vec3], bodies: &[BodyInput]) -> Vec<Misplaced> {
        self.misplaced(positions, self.body_solids(bodies), true)
    }

    /// Particles that a tick's commands are to spawn with their centre inside a wall or a body, counted over all
    /// [spawned](Command::Spawn) in the tick, in order. Those that do not flow in ([`NewParticles::at`](crate::step::NewParticles::at) is none) neither may be
    /// nearer to a body than half a spacing, nor to a wall than a fifth.
    ///
    /// Positions are taken as given, walls and bodies where they are at the start of the tick.
    pub fn spawned_inside(&self, input: &StepInput) -> Vec<Misplaced> {
        let mut first = 0;
        let mut all = Vec::new();
        for command in &input.commands {
            if let Command::Spawn(new) = command {
                let walls = self.boundary.solids.iter().map(|solid| (Owner::Wall as usize, solid.clone()));
                let solids = walls.chain(self.body_solids(&input.bodies));
                let found = self.misplaced(&new.positions, solids, new.at.is_none());
                all.extend(found.into_iter().map(|one| Misplaced { index: first + one.index, ..one }));
                first += new.positions.len() as u32;
            }
        }
        all
    }

    /// In world coordinates.
    fn body_solids(&self, bodies: &[BodyInput]) -> impl Iterator<Item = (usize, Solid)> {
        self.bodies
            .iter()
            .zip(bodies)
            .flat_map(|(planned, body)| planned.solids.iter().map(|solid| solid.placed(body.position, body.rotation)))
            .map(|solid| (Owner::Body as usize, solid))
    }

    fn misplaced(
        &self,
        points: &[Vec3],
        solids: impl Iterator<Item = (usize, Solid)>,
        is_still: bool,
    ) -> Vec<Misplaced> {
        let obstacles = Obstacles::near(points, solids, self.grid.periodic, self.parameters.spacing);
        if obstacles.is_empty() {
            return Vec::new();
        }
        let place = |(index, &point): (u32, &Vec3)| match obstacles.place(point) {
            Place::Inside(_) => Some(Misplaced { index, inside: true }),
            place @ Place::Beside(owner, _) if is_still => {
                // What fits between walls stays as it does in a plan; a body stands anywhere in the lattice.
                let leaves = owner == Owner::Body as usize || obstacles.is_too_near(place);
                leaves.then_some(Misplaced { index, inside: false })
            }
            Place::Beside(..) | Place::Free => None,
        };
        (0..).zip(points).filter_map(place).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Boundary, FluidScene};

    #[test]
    fn only_what_is_near_is_asked_and_images_are() {
        let solids = [Solid::ball(0.5, Vec3::ZERO), Solid::ball(0.5, Vec3::X * 9.0)];
        let numbered = || (0..).zip(solids.clone());
        let points = [Vec3::X * 8.0, Vec3::X * 8.8];
        let obstacles = Obstacles::near(&points, numbered(), Periodic::default(), 0.1);
        assert_eq!(obstacles.solids.len(), 1);
        assert_eq!(points.map(|point| obstacles.place(point)), [Place::Free, Place::Inside(1)]);
        assert!(Obstacles::near(&[], numbered(), Periodic::default(), 0.1).solids.is_empty());
        let periodic = Periodic { x: Some((-1.0, 9.2)), ..Periodic::default() };
        let obstacles = Obstacles::near(&points, numbered(), periodic, 0.1);
        assert_eq!(obstacles.place(Vec3::X * -0.9), Place::Inside(1), "the image of the second, across the end");
    }

    #[test]
    fn a_way_out_of_a_corner_and_none_from_between_walls() {
        let tank =
            Boundary::open_box(Vec3::ONE, Vec3::ZERO).solids(&FluidScene::with_spacing(0.1).wall_layer().unwrap());
        let way_out = |points: &[Vec3]| {
            let solids = tank.iter().map(|solid| (0, solid.clone()));
            Obstacles::near(points, solids, Periodic::default(), 0.1).way_out(points)
        };
        // 0.02, 0.05 and 0.01 m from three faces, where 0.05 m are needed.
        let way = way_out(&[Vec3::new(-0.48, -0.45, 0.49), Vec3::ZERO]).unwrap();
        assert!(way.distance(Vec3::new(0.03, 0.0, -0.04)) < 1e-6, "{way}");
        assert_eq!(way_out(&[Vec3::ZERO]), Some(Vec3::ZERO));
        assert_eq!(way_out(&[Vec3::X * -0.48, Vec3::X * 0.48]), None);
    }
}
