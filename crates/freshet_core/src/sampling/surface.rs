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
pub(super) fn visit_triangle(corners: [DVec3; 3], step: f64, mut f: impl FnMut(DVec3)) {
    let [a, b, c] = corners;
    let edges = [(a, b, c), (b, c, a), (c, a, b)];
    let longest = |x: &&(DVec3, DVec3, DVec3), y: &&(DVec3, DVec3, DVec3)| {
        x.0.distance_squared(x.1).total_cmp(&y.0.distance_squared(y.1))
    };
    let &(a, b, c) = edges.iter().max_by(longest).unwrap_or(&edges[0]);
    let along = (b - a).normalize_or_zero();
    let height = ((c - a) - along * (c - a).dot(along)).length();
    let rows = (height / step).ceil() as u32;
    for row in 0..=rows {
        let share = if rows == 0 { 0.0 } else { f64::from(row) / f64::from(rows) };
        let (first, last) = (a.lerp(c, share), b.lerp(c, share));
        let parts = (first.distance(last) / step).ceil() as u32;
        for part in 0..=parts {
            f(if parts == 0 { first } else { first.lerp(last, f64::from(part) / f64::from(parts)) });
        }
    }
}
