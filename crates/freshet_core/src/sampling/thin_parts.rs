//! Layers in the middle of parts that are too thin for one at its depth: centres of balls that touch the surface on both sides
//! (Ma et al. 2012).
//!
//! The surface is looked at in patches up to three spacings long, so that a large triangle with a thin part costs what the part
//! costs.

use glam::DVec3;

use super::level_set::{Level, Surface};
use super::poisson::{DISTANCES, LEAST, Samples};
use super::surface::{Rows, Tile};
use crate::geometry::mesh_tree::Near;
use crate::geometry::{TriangleMesh, nearest_on_triangle};

/// Distance between points of triangles, over the spacing.
const STEP: f64 = 0.1;

/// Steps of a patch across and along its rows: flat, so that a row of samples is there before the next one is looked for.
const PATCH: [u32; 2] = [4, 30];

/// A look at each third point of each third row is enough where the whole layer is behind a patch.
const STRIDE: u32 = 3;

/// How far behind a point a sample of a whole layer is from where it would be with no other near, at most, over the spacing.
const PLAIN: f64 = 0.7;

/// How far a sample may be from a point, over the spacing, to serve it if it is in line with it, and how far off that line.
const SERVES: [f64; 2] = [1.3, 0.5];

/// Most triangles of a patch's list: without one, sides are asked at every point, of which a patch has a hundred.
const LONGEST: usize = 256;

/// A part of a triangle.
#[derive(Clone, Copy)]
struct Patch {
    corners: [DVec3; 3],
    /// Of unit length, or zero if the triangle has no area.
    normal: DVec3,
    rows: Rows,
    tile: Tile,
    /// A point of it, m.
    middle: DVec3,
    /// How far from it others are, m.
    radius: f64,
    /// What is behind all of it, once it was asked; none inside if it is not the same everywhere.
    behind: Option<Option<Behind>>,
}

impl Patch {
    /// None if no point of the triangle is in it.
    fn new(corners: [DVec3; 3], rows: Rows, tile: Tile) -> Option<Self> {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
        let (mut sum, mut count) = (DVec3::ZERO, 0.0);
        rows.visit(&tile, STRIDE, |point| (sum, count) = (sum + point, count + 1.0));
        if count == 0.0 {
            return None;
        }
        let (middle, mut radius) = (sum / count, 0.0f64);
        rows.visit(&tile, STRIDE, |point| radius = radius.max(point.distance(middle)));
        let radius = radius + f64::from(STRIDE) * rows.step();
        Some(Self { corners, normal, rows, tile, middle, radius, behind: None })
    }
}

/// What is behind a point of a triangle with a normal.
#[derive(Clone, Copy, PartialEq)]
enum Behind {
    /// The side of the layer, this way.
    Layer(DVec3),
    /// It on both sides: between two parts of the inside there is no wall to be kept.
    Nothing,
    /// It on neither: a flap, which holds fluid as what it is.
    Flap,
}

impl Behind {
    /// Of whether the side of the layer is in front of a triangle and behind it.
    fn new(normal: DVec3, front: bool, back: bool) -> Self {
        match [front, back] {
            [true, false] => Self::Layer(normal),
            [false, true] => Self::Layer(-normal),
            [true, true] => Self::Nothing,
            [false, false] => Self::Flap,
        }
    }
}

/// What was found out about a patch.
struct Surroundings<'a> {
    mesh: &'a TriangleMesh,
    patch: &'a mut Patch,
    /// Triangles as near as those that balls behind the patch may touch, unless they are too many.
    list: Option<Vec<Near>>,
}

impl Surroundings<'_> {
    /// Whether no other triangle crosses the patch, stands on it or covers a part of it, but at its corners at most.
    fn is_uniform(&self, tolerance: f64) -> bool {
        let Some(list) = &self.list else { return false };
        let (tree, [a, b, c]) = (self.mesh.tree(), self.patch.corners);
        let reach = self.patch.radius + tolerance;
        // From the middle to the nearest edge, where neighbours begin.
        let clear = [[a, b], [b, c], [c, a]].map(|[p, q]| nearest_on_triangle(self.patch.middle, [p, q, q]));
        let clear = 0.99 * clear.map(|near| near.distance(self.patch.middle)).into_iter().fold(f64::INFINITY, f64::min);
        let mut flat = 0;
        for near in list.iter().take_while(|near| near.distance() <= reach) {
            let corners = tree.corners_of(*near);
            let heights = corners.map(|corner| (corner - self.patch.middle).dot(self.patch.normal));
            if heights.iter().any(|height| *height > tolerance) && heights.iter().any(|height| *height < -tolerance) {
                return false;
            }
            let mut on_it = corners.into_iter().zip(heights).filter(|(_, height)| height.abs() <= tolerance);
            let (first, second, third) = (on_it.next(), on_it.next(), on_it.next());
            let touches = match (first, second) {
                // The triangle that the patch is of is one such.
                _ if third.is_some() => {
                    flat += u32::from(near.distance() < clear);
                    flat > 1
                }
                (Some((p, _)), Some((q, _))) => {
                    nearest_on_triangle(self.patch.middle, [p, q, q]).distance(self.patch.middle) < clear
                }
                (Some((p, _)), None) => p.distance(self.patch.middle) < clear,
                _ => false,
            };
            if touches {
                return false;
            }
        }
        true
    }
}

impl Level<'_> {
    /// Adds samples where the surface has none behind it because there is no room for the depth.
    pub(super) fn sample_thin_parts(&self, mesh: &TriangleMesh, samples: &mut Samples) {
        let mut left_over = Vec::new();
        // Most triangles have the whole layer behind them, then as now.
        let mut rest = Vec::new();
        for corners in mesh.corners() {
            let corners = corners.map(|corner| corner.as_dvec3());
            let rows = Rows::new(corners, STEP * self.spacing);
            rows.tiles(PATCH, |tile| {
                if let Some(mut patch) = Patch::new(corners, rows, tile)
                    && !self.sample_patch(mesh, &mut patch, DISTANCES[0], samples, &mut left_over)
                {
                    rest.push(patch);
                }
            });
        }
        for distance in &DISTANCES[1..] {
            for patch in &mut rest {
                self.sample_patch(mesh, patch, *distance, samples, &mut left_over);
            }
        }
        // Then tips and slivers, what all else has left out. A whole layer leaves nothing as far as this, but behind edges sharper
        // than those of a box.
        for (point, sample) in left_over {
            if samples.is_free(point, self.tips()) && samples.is_free(sample, 0.55 * self.spacing) {
                samples.add(sample);
            }
        }
    }

    /// The diagonal of a cube of the depth, and as far as the next sample may be: the corner of a box needs none. In m.
    fn tips(&self) -> f64 {
        3.0f64.sqrt() * self.depth + 0.75 * self.spacing
    }

    /// Adds samples behind a patch, and says whether it has the whole layer behind it, so that it needs none.
    fn sample_patch(
        &self,
        mesh: &TriangleMesh,
        patch: &mut Patch,
        distance: f64,
        samples: &mut Samples,
        left_over: &mut Vec<(DVec3, DVec3)>,
    ) -> bool {
        let d = self.spacing;
        let Patch { middle, radius, normal, rows, tile, .. } = *patch;
        let behind = normal * if self.inside { -self.depth } else { self.depth };
        let mut near = Vec::new();
        samples.near(middle + behind, PLAIN * d + radius, &mut near);
        let is_plain =
            |point: DVec3| near.iter().any(|sample| sample.distance_squared(point + behind) < (PLAIN * d).powi(2));
        let mut is_whole = normal != DVec3::ZERO;
        rows.visit(&tile, STRIDE, |point| is_whole = is_whole && is_plain(point));
        if is_whole {
            return true;
        }
        let mut around = Vec::new();
        samples.near(middle, SERVES[0] * d + radius, &mut around);
        let mut found = Surroundings { mesh, patch, list: None };
        let mut list = Vec::new();
        if mesh.tree().list_near(middle, radius + 2.0 * self.depth, LONGEST, &mut list) {
            found.list = Some(list);
        }
        rows.visit(&tile, 1, |point| {
            if normal != DVec3::ZERO && is_plain(point) {
                return;
            }
            // Behind a plate's face: in line with it, whatever is beside.
            let is_in_line = |sample: &DVec3| {
                let way = *sample - point;
                way.length_squared() < (SERVES[0] * d).powi(2)
                    && (way - normal * way.dot(normal)).length_squared() < (SERVES[1] * d).powi(2)
            };
            if normal != DVec3::ZERO && around.iter().any(is_in_line) {
                return;
            }
            match self.middle_behind(point, &mut found, &around, distance * d) {
                Some((sample, true)) if samples.is_free(sample, distance * d) => {
                    samples.add(sample);
                    around.push(sample);
                }
                Some((sample, false)) if distance == LEAST && samples.is_free(point, self.tips()) => {
                    left_over.push((point, sample));
                }
                _ => {}
            }
        });
        false
    }

    /// Centre of the largest ball up to the depth behind a point of the surface, that touches it there, and whether the ball is as
    /// large as that or wedged between two sides. None where it is known before that it is nearer than `distance` to a sample.
    fn middle_behind(
        &self,
        point: DVec3,
        found: &mut Surroundings<'_>,
        samples: &[DVec3],
        distance: f64,
    ) -> Option<(DVec3, bool)> {
        let step = 1e-3 * self.spacing;
        let way = match self.behind(point, found) {
            Behind::Layer(way) => way,
            Behind::Nothing => return None,
            Behind::Flap => return Some((point, false)),
        };
        // All centres lie between these two.
        let far = point + way * self.depth;
        let is_near = |sample: &DVec3, end: DVec3| sample.distance_squared(end) < distance * distance;
        if samples.iter().any(|sample| is_near(sample, point) && is_near(sample, far)) {
            return None;
        }
        let mut radius = self.depth;
        let mut touched = point;
        for _ in 0..30 {
            let center = point + way * radius;
            let listed = found.list.as_deref().and_then(|list| {
                let off = center.distance(found.patch.middle);
                found.mesh.tree().nearest_of(list, off, center)
            });
            let foot = listed.unwrap_or_else(|| self.surface.nearest(center, 1.001 * radius));
            // None is nearer, or only what it touches already.
            if foot.distance(center) >= radius * (1.0 - 1e-6) {
                break;
            }
            let chord = foot - point;
            let along = 2.0 * chord.dot(way);
            if along <= 0.0 {
                break;
            }
            (radius, touched) = (chord.length_squared() / along, foot);
        }
        let center = point + way * radius;
        if let Surface::Ground(field) = self.surface
            && !field.covers(center.x as f32, center.z as f32, 0.0)
        {
            return None;
        }
        // On an edge the ball has no size, and touches nothing in particular.
        let is_wedged =
            radius > step && (point - center).normalize_or_zero().dot((touched - center).normalize_or_zero()) < -0.3;
        Some((center, is_wedged || touched == point))
    }

    /// What is behind a point of a patch: of most it is asked in the middle, once for all.
    fn behind(&self, point: DVec3, found: &mut Surroundings<'_>) -> Behind {
        let normal = found.patch.normal;
        if normal == DVec3::ZERO {
            return Behind::Flap;
        }
        // Triangles of ground miss its bilinear surface by more than a step aside, but all face up.
        if matches!(self.surface, Surface::Ground(_)) {
            return Behind::Layer(-normal);
        }
        let tolerance = 1e-6 * self.spacing;
        let for_all = match found.patch.behind {
            Some(known) => known,
            None => found.is_uniform(tolerance).then(|| {
                // One triangle is here: the surface goes round once more behind it than in front of it.
                let front = found.mesh.tree().winding_number(found.patch.middle + normal * (1e-3 * self.spacing));
                let is_layer = |winding: f64| (winding.abs() > 0.5) == self.inside;
                Behind::new(normal, is_layer(front), is_layer(front + 1.0))
            }),
        };
        found.patch.behind = Some(for_all);
        for_all.unwrap_or_else(|| self.side_of(point, normal))
    }

    fn side_of(&self, point: DVec3, normal: DVec3) -> Behind {
        let (step, margin) = (1e-3 * self.spacing, 0.05 * self.spacing);
        let is_layer = |way: DVec3| self.surface.has_layer_at(point + way * step, self.inside, margin);
        Behind::new(normal, is_layer(normal), is_layer(-normal))
    }
}
