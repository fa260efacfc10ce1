//! What of the volumes does not start, because a wall is there.

use std::collections::HashMap;

use glam::{IVec3, Vec3};

use crate::misplaced::{Obstacles, Place};
use crate::periodic::Periodic;
use crate::sampling::wall_layer::WallLayer;
use crate::scene::{Boundary, Volume};
use crate::solid::Solid;

/// Particles of a volume that do not start because of a wall, and are none of the plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// Index of the volume in the scene.
    pub volume: usize,
    /// Index of the boundary in the scene; where several are in one place, of the first.
    pub boundary: usize,
    /// How many have their centre inside the wall.
    pub inside: u32,
    /// How many are outside, nearer than half a spacing, and cannot be moved away: the wall would blow them off.
    pub crowded: u32,
}

/// Particles of a scene's volumes.
pub(super) struct Start<'a> {
    pub positions: &'a mut Vec<Vec3>,
    pub velocities: &'a mut Vec<Vec3>,
    /// First particle and number of particles of each volume.
    pub ids: &'a mut [(u32, u32)],
}

/// Takes out particles whose centre is inside a wall, and makes room for the rest of their volume.
///
/// A lattice that a wall cuts may begin anywhere in front of it. What is left, each connected piece on its own, moves away from the
/// wall by up to half a spacing along each axis, so that it begins where fluid at rest does, half a spacing from the face. Where
/// something else is in the way, particles nearer than that are left out too. So it is with a volume that no wall cuts and that begins
/// nearer to one than a lattice made to fit; all others stay as they are.
pub(super) fn leave_out(
    start: Start<'_>,
    volumes: &[Volume],
    boundaries: &[Boundary],
    periodic: &Periodic,
    layer: &WallLayer,
) -> Vec<LeftOut> {
    let Start { positions, velocities, ids } = start;
    let numbered = boundaries.iter().enumerate();
    let solids: Vec<(usize, Solid)> = numbered
        .flat_map(|(index, boundary)| boundary.solids(layer).into_iter().map(move |solid| (index, solid)))
        .collect();
    let boxes: Vec<Bounds> =
        ids.iter().map(|&(first, count)| Bounds::of(&positions[first as usize..(first + count) as usize])).collect();
    let mut left_out: Vec<LeftOut> = Vec::new();
    let mut all = Vec::with_capacity(positions.len());
    let mut moving = Vec::with_capacity(positions.len());
    for (volume, (first, count)) in ids.iter_mut().enumerate() {
        let range = *first as usize..(*first + *count) as usize;
        let points = &positions[range.clone()];
        let obstacles = Obstacles::near(points, solids.iter().cloned(), *periodic, layer.spacing());
        let mut note = |boundary: usize, inside: u32, crowded: u32| match left_out
            .iter_mut()
            .find(|some| (some.volume, some.boundary) == (volume, boundary))
        {
            Some(some) => {
                some.inside += inside;
                some.crowded += crowded;
            }
            None => left_out.push(LeftOut { volume, boundary, inside, crowded }),
        };
        let is_outside = |point: &Vec3| match obstacles.place(*point) {
            Place::Inside(boundary) => {
                note(boundary, 1, 0);
                false
            }
            Place::Beside(..) | Place::Free => true,
        };
        let mut kept: Vec<Vec3> = points.iter().copied().filter(is_outside).collect();
        let is_cut = kept.len() < points.len();
        if is_cut || kept.iter().any(|point| obstacles.is_too_near(obstacles.place(*point))) {
            for piece in pieces(&kept, &volumes[volume], layer.spacing()) {
                let its: Vec<Vec3> = piece.iter().map(|&i| kept[i]).collect();
                let mut others = boxes.iter().enumerate().filter(|(other, _)| *other != volume);
                let is_alone = !others.any(|(_, other)| periodic.any() || other.meets(&its, 2.0 * layer.spacing()));
                let shift = if is_alone { obstacles.way_out(&its) } else { None };
                piece.iter().for_each(|&i| kept[i] += shift.unwrap_or_default());
            }
            kept.retain(|point| match obstacles.place(*point) {
                place @ (Place::Inside(boundary) | Place::Beside(boundary, ..)) => {
                    let leaves = is_cut || !matches!(place, Place::Beside(..)) || obstacles.is_too_near(place);
                    if leaves {
                        note(boundary, 0, 1);
                    }
                    !leaves
                }
                Place::Free => true,
            });
        }
        (*first, *count) = (all.len() as u32, kept.len() as u32);
        moving.extend(kept.iter().map(|_| volumes[volume].velocity));
        all.append(&mut kept);
    }
    (*positions, *velocities) = (all, moving);
    left_out
}

/// The box along the axes around points.
struct Bounds {
    low: Vec3,
    high: Vec3,
}

impl Bounds {
    fn of(points: &[Vec3]) -> Self {
        let mut bounds = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY };
        for &point in points {
            bounds.low = bounds.low.min(point);
            bounds.high = bounds.high.max(point);
        }
        bounds
    }

    /// Whether the box around points is nearer than `margin` along every axis.
    fn meets(&self, points: &[Vec3], margin: f32) -> bool {
        let other = Self::of(points);
        (self.low - margin).cmple(other.high).all() && (other.low - margin).cmple(self.high).all()
    }
}

/// Indices of points by connected piece of the lattice of their volume.
fn pieces(points: &[Vec3], volume: &Volume, spacing: f32) -> Vec<Vec<usize>> {
    let Some(&origin) = points.first() else { return Vec::new() };
    let back = volume.rotation.conjugate();
    let site = |point: &Vec3| (back * (*point - origin) / spacing).round().as_ivec3();
    let mut at: HashMap<IVec3, usize> = points.iter().enumerate().map(|(index, point)| (site(point), index)).collect();
    let mut all = Vec::new();
    for point in points {
        let Some(seed) = at.remove(&site(point)) else { continue };
        let mut piece = vec![seed];
        let mut asked = 0;
        while let Some(&index) = piece.get(asked) {
            asked += 1;
            for step in [IVec3::X, IVec3::Y, IVec3::Z, IVec3::NEG_X, IVec3::NEG_Y, IVec3::NEG_Z] {
                piece.extend(at.remove(&(site(&points[index]) + step)));
            }
        }
        all.push(piece);
    }
    all
}
