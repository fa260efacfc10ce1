//! Vertices of convex hulls.

use bevy::prelude::*;
use freshet_core::error::InvalidInput;
use freshet_core::geometry::{MAX_HULL_POINTS, convex_hull};

/// Directions in which the farthest points are looked for: their hull is within a hundredth of that of a ball.
const DIRECTIONS: u32 = 400;

/// What is nearer to a face than this share of the hull's size lies on it, as in the model.
const ON_FACE: f32 = 1e-6;

/// The points that are vertices of the convex hull of all. The model takes few thousand, a mesh may have millions: most are
/// deep within.
pub(super) fn hull_points(mut points: Vec<Vec3>) -> Result<Vec<Vec3>, InvalidInput> {
    if let Some((index, point)) = points.iter().enumerate().find(|(_, point)| !point.is_finite()) {
        return Err(InvalidInput::new(format_args!("vertices[{index}]"), point, "finite numbers"));
    }
    let key = |point: &Vec3| (*point + 0.0).to_array().map(f32::to_bits);
    points.sort_unstable_by_key(key);
    points.dedup_by_key(|point| key(point));
    if points.len() > MAX_HULL_POINTS {
        points = outermost(points)?;
    }
    Ok(convex_hull(&points)?.vertices().to_vec())
}

/// Points without those that are within the hull of the farthest ones.
fn outermost(points: Vec<Vec3>) -> Result<Vec<Vec3>, InvalidInput> {
    // Evenly over a sphere, on a spiral of the golden angle.
    let direction = |index: u32| {
        let (height, turn) = (1.0 - (2 * index + 1) as f32 / DIRECTIONS as f32, index as f32 * 2.399_963_3);
        let radius = (1.0 - height * height).max(0.0).sqrt();
        Vec3::new(radius * turn.cos(), height, radius * turn.sin())
    };
    let farthest =
        |direction: Vec3| points.iter().copied().max_by(|a, b| a.dot(direction).total_cmp(&b.dot(direction)));
    let mut few: Vec<Vec3> = (0..DIRECTIONS).filter_map(|index| farthest(direction(index))).collect();
    few.sort_unstable_by_key(|point| point.to_array().map(f32::to_bits));
    few.dedup();
    let inner = convex_hull(&few)?;
    let size = few.iter().map(|point| point.distance(few[0])).fold(0.0, f32::max);
    let corner = |index: u32| inner.vertices()[index as usize].as_dvec3();
    let faces: Vec<_> = inner
        .triangles()
        .iter()
        .map(|triangle| triangle.map(corner))
        .map(|[a, b, c]| (a, (b - a).cross(c - a).normalize_or_zero()))
        .collect();
    let is_within = |point: Vec3| {
        faces.iter().all(|(corner, normal)| (point.as_dvec3() - corner).dot(*normal) < -f64::from(ON_FACE * size))
    };
    Ok(points.into_iter().filter(|point| !is_within(*point)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random(count: usize) -> Vec<Vec3> {
        let mut state = 7u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / 16_777_216.0
        };
        (0..count).map(|_| Vec3::new(next(), next(), next())).collect()
    }

    #[test]
    fn a_hull_of_very_many_points_is_that_of_all() {
        // In a cube, with its corners: the hull has eight vertices whatever is within.
        let mut points = random(50_000);
        let corners =
            (0..8).map(|corner| Vec3::new((corner & 1) as f32, (corner >> 1 & 1) as f32, (corner >> 2) as f32));
        points.splice(20_000..20_000, corners.clone());
        let mut hull = hull_points(points).unwrap();
        hull.sort_unstable_by_key(|point| point.to_array().map(f32::to_bits));
        let mut corners: Vec<Vec3> = corners.collect();
        corners.sort_unstable_by_key(|point| point.to_array().map(f32::to_bits));
        assert_eq!(hull, corners);
        // In a ball: none of the points is outside of the hull of those that are left.
        let points: Vec<Vec3> =
            random(20_000).into_iter().map(|p| 2.0 * p - 1.0).filter(|p| p.length() < 1.0).collect();
        assert!(points.len() > 2 * MAX_HULL_POINTS);
        let hull = convex_hull(&hull_points(points.clone()).unwrap()).unwrap();
        for [a, b, c] in hull.triangles().iter().map(|triangle| triangle.map(|index| hull.vertices()[index as usize])) {
            let normal = (b - a).cross(c - a).normalize();
            assert!(points.iter().all(|point| (point - a).dot(normal) < 1e-5));
        }
    }

    #[test]
    fn what_has_no_hull_is_refused() {
        let flat: Vec<Vec3> = random(10_000).into_iter().map(|point| point * Vec3::new(1.0, 0.0, 1.0)).collect();
        assert!(hull_points(flat).unwrap_err().to_string().contains("plane"));
        assert!(hull_points(vec![Vec3::X; 9]).unwrap_err().to_string().starts_with("points: 1 of them"));
        let nowhere = vec![Vec3::X, Vec3::Y, Vec3::Z, Vec3::NAN];
        assert!(hull_points(nowhere).unwrap_err().to_string().starts_with("vertices[3]"));
        let ball: Vec<Vec3> = random(9_000).into_iter().map(|point| (2.0 * point - 1.0).normalize()).collect();
        assert!(hull_points(ball).unwrap_err().to_string().contains("4 to 4096"));
    }
}
