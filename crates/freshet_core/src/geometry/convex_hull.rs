//! Convex hulls.

use glam::{DVec3, Vec3};

use super::triangle_mesh::TriangleMesh;
use crate::error::InvalidInput;
use crate::scene::check_position;

/// Most points of a convex hull.
pub const MAX_HULL_POINTS: usize = 4096;

/// The convex hull of points, m, as a closed mesh that faces outwards; points within and repeated ones are no vertices of it.
///
/// Points are added one by one, and faces that see a new one are replaced (Kallay 1981). What is nearer to a face than a millionth of
/// the hull's size counts as lying on it.
///
/// # Errors
/// Fewer than 4 or more than [`MAX_HULL_POINTS`]; one that is not within 1e6 m of the origin; points that all lie in a plane.
pub fn convex_hull(points: &[Vec3]) -> Result<TriangleMesh, InvalidInput> {
    if !(4..=MAX_HULL_POINTS).contains(&points.len()) {
        let allowed = format!("4 to {MAX_HULL_POINTS}");
        return Err(InvalidInput::new("points", format_args!("{} of them", points.len()), allowed));
    }
    for (index, &point) in points.iter().enumerate() {
        check_position("point", point).map_err(|error| InvalidInput { field: format!("points[{index}]"), ..error })?;
    }
    let exact: Vec<DVec3> = points.iter().map(|point| point.as_dvec3()).collect();
    let flat = || InvalidInput::new("points", "points of one plane", "four of them that span a volume");
    let farthest = |far: &dyn Fn(DVec3) -> f64| {
        (0..exact.len()).max_by(|&a, &b| far(exact[a]).total_cmp(&far(exact[b]))).unwrap_or_default()
    };
    // A first tetrahedron as large as can be found in four looks.
    let a = farthest(&|point| point.x);
    let b = farthest(&|point| point.distance_squared(exact[a]));
    let along = (exact[b] - exact[a]).normalize_or_zero();
    let c = farthest(&|point| (point - exact[a]).cross(along).length_squared());
    let normal = (exact[b] - exact[a]).cross(exact[c] - exact[a]).normalize_or_zero();
    let d = farthest(&|point| (point - exact[a]).dot(normal).abs());
    let tolerance = 1e-6 * exact[a].distance(exact[b]);
    let height = (exact[d] - exact[a]).dot(normal);
    if height.abs() <= tolerance {
        return Err(flat());
    }
    let [a, b, c, d] = [a, b, c, d].map(|index| index as u32);
    let (b, c) = if height > 0.0 { (c, b) } else { (b, c) };
    let mut faces: Vec<Face> =
        [[a, b, c], [a, d, b], [b, d, c], [c, d, a]].map(|corners| Face::new(corners, &exact)).to_vec();
    for (index, &point) in exact.iter().enumerate() {
        let sees = |face: &Face| face.normal.dot(point) - face.offset > tolerance;
        let (seen, kept): (Vec<Face>, Vec<Face>) = faces.iter().cloned().partition(sees);
        if seen.is_empty() {
            continue;
        }
        let edges = |face: &Face| {
            let [a, b, c] = face.corners;
            [(a, b), (b, c), (c, a)]
        };
        let mut inner: Vec<(u32, u32)> = seen.iter().flat_map(edges).collect();
        inner.sort_unstable();
        // The rim of what is seen: edges whose other side is not.
        let rim = seen.iter().flat_map(edges).filter(|&(a, b)| inner.binary_search(&(b, a)).is_err());
        faces = kept;
        faces.extend(rim.map(|(a, b)| Face::new([a, b, index as u32], &exact)));
    }
    let mut used: Vec<u32> = faces.iter().flat_map(|face| face.corners).collect();
    used.sort_unstable();
    used.dedup();
    let vertices = used.iter().map(|&index| points[index as usize]).collect();
    let renumbered = |corner: u32| used.binary_search(&corner).unwrap_or_default() as u32;
    TriangleMesh::new(vertices, faces.iter().map(|face| face.corners.map(renumbered)).collect())
}

/// A triangle of the hull with the plane it lies in.
#[derive(Clone)]
struct Face {
    corners: [u32; 3],
    normal: DVec3,
    offset: f64,
}

impl Face {
    fn new(corners: [u32; 3], points: &[DVec3]) -> Self {
        let [a, b, c] = corners.map(|index| points[index as usize]);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        Self { corners, normal, offset: normal.dot(a) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hull_of_a_box_with_points_in_it_is_the_box() {
        let mut points = Vec::new();
        for i in 0..5i8 {
            for j in 0..5i8 {
                points.extend((0..5i8).map(|k| Vec3::from([i, j, k].map(|index| f32::from(index) / 2.0 - 1.0))));
            }
        }
        let hull = convex_hull(&points).unwrap();
        assert!(hull.is_closed() && (hull.area() - 24.0).abs() < 1e-4, "{}", hull.area());
        for point in &points {
            let inner = 0.999 * *point;
            assert!(hull.is_inside(inner) && !hull.is_inside(1.001 * *point) || point.abs().max_element() < 0.999);
        }
    }

    #[test]
    fn all_points_are_in_the_hull_of_a_cloud() {
        let mut state = 11u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / 16_777_216.0 - 0.5
        };
        for round in 0..20 {
            // Some clouds are flat, most have points in one place.
            let thin = if round % 4 == 0 { 1e-3 } else { 1.0 };
            let mut points: Vec<Vec3> = (0..200).map(|_| Vec3::new(random(), thin * random(), random())).collect();
            points.extend_from_within(0..20);
            let hull = convex_hull(&points).unwrap();
            assert!(hull.is_closed(), "{round}");
            for [a, b, c] in hull.corners() {
                let normal = (b - a).cross(c - a).normalize();
                assert!(points.iter().all(|point| (*point - a).dot(normal) < 1e-4), "{round}");
            }
        }
    }

    #[test]
    fn bad_points_are_refused() {
        let refused = |points: &[Vec3]| convex_hull(points).unwrap_err().to_string();
        assert!(refused(&[Vec3::ZERO; 3]).starts_with("points: 3 of them"));
        assert!(refused(&[Vec3::ZERO; 9]).starts_with("points: points of one plane"));
        assert!(refused(&[Vec3::ZERO, Vec3::X, Vec3::Z, Vec3::X + Vec3::Z]).starts_with("points: points of one plane"));
        assert!(refused(&[Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::NAN]).starts_with("points[3]: [NaN"));
    }
}
