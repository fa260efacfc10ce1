//! Distance and solid angle of one triangle.

use glam::DVec3;

/// The point of a triangle that is nearest to `point` (Ericson 2005, Real-Time Collision Detection, 5.1.5).
///
/// Triangles without an area are what is left of them, a segment or a point.
#[inline]
pub(crate) fn nearest_on_triangle(point: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = point - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let cp = point - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    let area = va + vb + vc;
    // A needle's area is the difference of numbers that are nearly equal: its edges are asked instead.
    if area > 1e-12 * ab.length_squared() * ac.length_squared() {
        if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
            return a + ab * (d1 / (d1 - d3));
        }
        if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
            return a + ac * (d2 / (d2 - d6));
        }
        if va <= 0.0 && d4 >= d3 && d5 >= d6 {
            return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
        }
        if va > 0.0 && vb > 0.0 && vc > 0.0 {
            return a + (ab * vb + ac * vc) / area;
        }
    }
    [[a, b], [b, c], [c, a]]
        .map(|edge| nearest_on_segment(point, edge))
        .into_iter()
        .min_by(|p, q| point.distance_squared(*p).total_cmp(&point.distance_squared(*q)))
        .unwrap_or(a)
}

fn nearest_on_segment(point: DVec3, [a, b]: [DVec3; 2]) -> DVec3 {
    let along = b - a;
    let length = along.length_squared();
    if length > 0.0 { a + along * ((point - a).dot(along) / length).clamp(0.0, 1.0) } else { a }
}

/// The solid angle that a triangle covers as seen from `point`, positive from behind it (van Oosterom & Strackee 1983, eq. 8).
pub(super) fn solid_angle(point: DVec3, triangle: [DVec3; 3]) -> f64 {
    let [a, b, c] = triangle.map(|corner| corner - point);
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let across = a.dot(b.cross(c));
    let along = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    if across == 0.0 { 0.0 } else { 2.0 * across.atan2(along) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn the_nearest_point_is_that_of_a_dense_search() {
        let mut state = 7u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / 16_777_216.0
        };
        let mut point = || DVec3::new(random(), random(), random());
        for round in 0..400 {
            let [a, mut b, mut c, p] = [point(), point(), point(), 2.0 * point() - 0.5];
            match round % 5 {
                1 => c = a + (b - a) * 0.3,
                2 => c = a + (b - a) * 0.3 + (c - a) * 1e-7,
                3 => (b, c) = (a, a),
                _ => {}
            }
            let found = nearest_on_triangle(p, [a, b, c]).distance(p);
            let searched = (0..=60)
                .flat_map(|i| (0..=60 - i).map(move |j| (f64::from(i) / 60.0, f64::from(j) / 60.0)))
                .map(|(u, v)| (a + (b - a) * u + (c - a) * v).distance(p))
                .fold(f64::INFINITY, f64::min);
            assert!(found <= searched + 1e-9 && found > searched - 0.03, "{round}: {found} {searched}");
        }
    }

    #[test]
    fn an_octant_is_an_eighth_of_the_sphere() {
        let octant = [DVec3::X, DVec3::Y, DVec3::Z];
        assert!((solid_angle(DVec3::ZERO, octant) - PI / 2.0).abs() < 1e-12);
        assert!(solid_angle(DVec3::ONE, octant) < 0.0, "seen from its front");
        assert_eq!(solid_angle(DVec3::ONE, [DVec3::X, DVec3::X, DVec3::Z]), 0.0);
    }
}
