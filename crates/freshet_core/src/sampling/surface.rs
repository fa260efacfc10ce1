//! Layers on surfaces that have fluid on both sides.

use glam::{DVec3, Vec3};

use super::check_estimate;
use super::poisson::{DISTANCES, Samples};
use crate::error::InvalidInput;
use crate::geometry::TriangleMesh;

/// Distance between candidates over the spacing: none of a triangle's points is farther than 0.71 times it from one, which together
/// with the least distance between samples is 0.74.
const STEP: f64 = 0.1;

/// Samples the triangles themselves, no two nearer than two thirds of a spacing, no point of them farther than 0.75 from one.
///
/// # Errors
/// If there would be more than [`MAX_CURVED_SAMPLES`](super::MAX_CURVED_SAMPLES).
pub(super) fn sample_surface(mesh: &TriangleMesh, spacing: f64) -> Result<Vec<Vec3>, InvalidInput> {
    check_mesh(mesh, spacing)?;
    let mut samples = Samples::new(spacing);
    for distance in DISTANCES {
        for corners in mesh.corners() {
            visit_triangle(corners.map(|corner| corner.as_dvec3()), STEP * spacing, |point| {
                if samples.is_free(point, distance * spacing) {
                    samples.add(point);
                }
            });
        }
    }
    Ok(samples.into_positions())
}

/// Refuses a mesh that asks for too many samples: by its area, and by its length where it has none.
pub(super) fn check_mesh(mesh: &TriangleMesh, spacing: f64) -> Result<(), InvalidInput> {
    let count = |corners: [Vec3; 3]| {
        let [a, b, c] = corners.map(|corner| corner.as_dvec3());
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        0.5 * (b - a).cross(c - a).length() / (spacing * spacing) + 0.1 * longest / spacing
    };
    check_estimate(mesh.corners().map(count).sum(), spacing)
}

/// Calls `f` for points of a triangle: its corners, and rows along its longest edge, so that neighbours are at most `step` apart along
/// and across them.
pub(super) fn visit_triangle(corners: [DVec3; 3], step: f64, f: impl FnMut(DVec3)) {
    let rows = Rows::new(corners, step);
    rows.visit(&rows.tile(), 1, f);
}

/// Points of a triangle in rows along its longest edge.
#[derive(Clone, Copy)]
pub(super) struct Rows {
    /// Its corners, the longest edge first.
    corners: [DVec3; 3],
    step: f64,
    /// Steps from the longest edge to the third corner.
    count: u32,
}

/// Some of a triangle's rows, and a part of each that ends at the same distances from their common start.
#[derive(Clone, Copy)]
pub(super) struct Tile {
    rows: [u32; 2],
    along: [f64; 2],
}

impl Rows {
    /// Neighbours are at most `step` metres apart along and across the rows.
    pub fn new([a, b, c]: [DVec3; 3], step: f64) -> Self {
        let lengths = [a.distance_squared(b), b.distance_squared(c), c.distance_squared(a)];
        let longest = lengths[0].max(lengths[1]).max(lengths[2]);
        let corners = match lengths {
            [_, _, third] if third == longest => [c, a, b],
            [_, second, _] if second == longest => [b, c, a],
            _ => [a, b, c],
        };
        let [a, b, c] = corners;
        let along = (b - a).normalize_or_zero();
        let height = ((c - a) - along * (c - a).dot(along)).length();
        Self { corners, step, count: (height / step).ceil() as u32 }
    }

    /// Longest way between neighbours, m.
    pub fn step(&self) -> f64 {
        self.step
    }

    /// The whole triangle.
    pub fn tile(&self) -> Tile {
        Tile { rows: [0, self.count], along: [f64::NEG_INFINITY, f64::INFINITY] }
    }

    /// Parts of the triangle up to as many steps wide across and along the rows, in rows.
    pub fn tiles(&self, [steps, along]: [u32; 2], mut f: impl FnMut(Tile)) {
        let [a, b, _] = self.corners;
        let wide = f64::from(along) * self.step;
        let columns = (a.distance(b) / wide).ceil().max(1.0) as u32;
        for first in (0..=self.count).step_by(steps as usize) {
            let rows = [first, (first + steps - 1).min(self.count)];
            // No row begins before the longest edge, nor ends after it.
            let [begin, end] = rows
                .map(|row| self.row(row))
                .map(|[p, q]| [self.along(p), self.along(q)])
                .into_iter()
                .fold([f64::INFINITY, f64::NEG_INFINITY], |range, row| [range[0].min(row[0]), range[1].max(row[1])]);
            for column in 0..columns {
                let from = f64::from(column) * wide;
                let to = if column + 1 == columns { f64::INFINITY } else { from + wide };
                if from <= end && to >= begin {
                    f(Tile { rows, along: [if column == 0 { f64::NEG_INFINITY } else { from }, to] });
                }
            }
        }
    }

    /// Calls `f` for the points of a tile; for each `stride`th of each `stride`th row only, and the last ones.
    pub fn visit(&self, tile: &Tile, stride: u32, mut f: impl FnMut(DVec3)) {
        let [first_row, last_row] = tile.rows;
        let mut row = first_row;
        loop {
            let [first, last] = self.row(row);
            let length = first.distance(last);
            let parts = (length / self.step).ceil() as u32;
            let (from, to) = (tile.along[0] - self.along(first), tile.along[1] - self.along(first));
            // Points from here, up to but without there.
            let part_of = |way: f64| ((way / length * f64::from(parts)).ceil().max(0.0) as u32).min(parts + 1);
            let (start, end) =
                if parts == 0 { (u32::from(from > 0.0), u32::from(to > 0.0)) } else { (part_of(from), part_of(to)) };
            let mut part = start;
            while part < end {
                f(if parts == 0 { first } else { first.lerp(last, f64::from(part) / f64::from(parts)) });
                part = if part + 1 == end { end } else { (part + stride).min(end - 1) };
            }
            if row == last_row {
                break;
            }
            row = (row + stride).min(last_row);
        }
    }

    fn row(&self, row: u32) -> [DVec3; 2] {
        let share = if self.count == 0 { 0.0 } else { f64::from(row) / f64::from(self.count) };
        let [a, b, c] = self.corners;
        [a.lerp(c, share), b.lerp(c, share)]
    }

    /// How far along the longest edge, m.
    fn along(&self, point: DVec3) -> f64 {
        let [a, b, _] = self.corners;
        (point - a).dot((b - a).normalize_or_zero())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_have_each_point_of_a_triangle_once() {
        let corners = [DVec3::new(0.3, 0.0, 2.0), DVec3::new(4.0, 1.0, -3.0), DVec3::new(-1.0, 2.5, 0.5)];
        let needle = [DVec3::ZERO, DVec3::X * 5.0, DVec3::X * 2.0];
        for corners in [corners, [corners[1], corners[2], corners[0]], needle, [DVec3::ONE; 3]] {
            let key = |point: DVec3| point.to_array().map(f64::to_bits);
            let mut whole = Vec::new();
            visit_triangle(corners, 0.1, |point| whole.push(key(point)));
            let rows = Rows::new(corners, 0.1);
            let (mut parts, mut tiles) = (Vec::new(), 0);
            rows.tiles([4, 30], |tile| {
                tiles += 1;
                let (first, mut low, mut high) = (parts.len(), DVec3::INFINITY, DVec3::NEG_INFINITY);
                rows.visit(&tile, 1, |point| {
                    parts.push(key(point));
                    (low, high) = (low.min(point), high.max(point));
                });
                // 4 steps across, 30 along.
                assert!(parts.len() == first || low.distance(high) < 3.3);
                rows.visit(&tile, 3, |point| assert!(parts[first..].contains(&key(point))));
            });
            whole.sort_unstable();
            parts.sort_unstable();
            assert_eq!(whole, parts);
            assert!(tiles <= 10 + whole.len() / 40, "{tiles} tiles, {} points", whole.len());
        }
    }
}
