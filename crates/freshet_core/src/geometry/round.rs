//! Bodies of revolution about the y axis.

use glam::{DVec2, DVec3};

/// Half of the section of a body of revolution: what turns about the y axis. x is the distance from the axis.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Profile {
    /// Corners of the outline, from one point of the axis to another, with the body on the left.
    outline: Vec<DVec2>,
    /// By how much it is thickened all round, m.
    rounding: f64,
}

impl Profile {
    /// Half height along the axis.
    pub fn cylinder(radius: f64, half_height: f64) -> Self {
        let at = DVec2::new;
        Self {
            outline: vec![
                at(0.0, -half_height),
                at(radius, -half_height),
                at(radius, half_height),
                at(0.0, half_height),
            ],
            rounding: 0.0,
        }
    }

    /// With its tip up.
    pub fn cone(radius: f64, half_height: f64) -> Self {
        let at = DVec2::new;
        Self { outline: vec![at(0.0, -half_height), at(radius, -half_height), at(0.0, half_height)], rounding: 0.0 }
    }

    /// Half the height of its straight part.
    pub fn capsule(radius: f64, half_height: f64) -> Self {
        Self { outline: vec![DVec2::new(0.0, -half_height), DVec2::new(0.0, half_height)], rounding: radius }
    }

    /// Radius and half height of the room in it.
    pub fn cup(radius: f64, half_height: f64, thickness: f64) -> Self {
        let (outer, bottom) = (radius + thickness, -half_height - thickness);
        let outline = [
            (0.0, bottom),
            (outer, bottom),
            (outer, half_height),
            (radius, half_height),
            (radius, -half_height),
            (0.0, -half_height),
        ];
        Self { outline: outline.map(DVec2::from).to_vec(), rounding: 0.0 }
    }

    /// What is half way between the two sides of [`cup`](Self::cup), as a sheet.
    pub fn cup_middle(radius: f64, half_height: f64, thickness: f64) -> Self {
        let (middle, bottom) = (radius + 0.5 * thickness, -half_height - 0.5 * thickness);
        // As far from the rim as from the sides, but for thick walls of flat cups.
        let rim = half_height - (0.5 * thickness).min(half_height);
        let outline = [(0.0, bottom), (middle, bottom), (middle, rim)];
        Self { outline: outline.map(DVec2::from).to_vec(), rounding: 0.0 }
    }

    /// Highest distances from the axis and from the plane across it, m.
    pub fn reach(&self) -> DVec2 {
        self.outline.iter().fold(DVec2::ZERO, |reach, corner| reach.max(corner.abs())) + self.rounding
    }

    /// Area of the surface, m2.
    pub fn area(&self) -> f64 {
        use std::f64::consts::PI;
        let bands: f64 = self
            .outline
            .windows(2)
            .map(|ends| 2.0 * PI * (0.5 * (ends[0].x + ends[1].x) + self.rounding) * ends[0].distance(ends[1]))
            .sum();
        bands + 4.0 * PI * self.rounding * self.rounding
    }

    /// The nearest point of the surface.
    pub fn nearest(&self, point: DVec3) -> DVec3 {
        let around = DVec2::new(point.x, point.z).normalize_or(DVec2::X);
        let flat = DVec2::new(point.x.hypot(point.z), point.y);
        let mut near = self.nearest_on_outline(flat);
        if self.rounding > 0.0 {
            near += (flat - near).normalize_or(DVec2::X) * self.rounding;
        }
        DVec3::new(around.x * near.x, near.y, around.y * near.x)
    }

    fn nearest_on_outline(&self, point: DVec2) -> DVec2 {
        self.outline
            .windows(2)
            .map(|ends| {
                let along = ends[1] - ends[0];
                ends[0] + along * ((point - ends[0]).dot(along) / along.length_squared()).clamp(0.0, 1.0)
            })
            .min_by(|a, b| a.distance_squared(point).total_cmp(&b.distance_squared(point)))
            .unwrap_or_default()
    }

    /// Whether a point is inside.
    pub fn encloses(&self, point: DVec3) -> bool {
        let flat = DVec2::new(point.x.hypot(point.z), point.y);
        if self.rounding > 0.0 {
            return self.nearest_on_outline(flat).distance(flat) < self.rounding;
        }
        // Edges that a ray outwards from the point crosses.
        let crosses = |ends: &&[DVec2]| {
            let (a, b) = (ends[0], ends[1]);
            (a.y > flat.y) != (b.y > flat.y) && flat.x < a.x + (b.x - a.x) * (flat.y - a.y) / (b.y - a.y)
        };
        self.outline.windows(2).filter(crosses).count() % 2 == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn nearest_points_and_insides() {
        let cylinder = Profile::cylinder(1.0, 2.0);
        assert!(cylinder.nearest(DVec3::new(0.6, 0.0, 0.0)).distance(DVec3::X) < 1e-12);
        assert!(cylinder.nearest(DVec3::new(0.0, 1.8, 0.1)).distance(DVec3::new(0.0, 2.0, 0.1)) < 1e-12);
        assert!(cylinder.nearest(DVec3::new(0.0, 3.0, -2.0)).distance(DVec3::new(0.0, 2.0, -1.0)) < 1e-12);
        assert!(cylinder.encloses(DVec3::new(0.7, 1.9, 0.7)) && !cylinder.encloses(DVec3::new(0.72, 0.0, 0.72)));
        let cone = Profile::cone(1.0, 1.0);
        assert!(cone.encloses(DVec3::new(0.49, 0.0, 0.0)) && !cone.encloses(DVec3::new(0.51, 0.0, 0.0)));
        assert!(cone.nearest(DVec3::Y * 4.0).distance(DVec3::Y) < 1e-12);
        let capsule = Profile::capsule(0.5, 1.0);
        assert!(capsule.encloses(DVec3::Y * 1.49) && !capsule.encloses(DVec3::Y * 1.51));
        assert!(capsule.nearest(DVec3::new(0.1, 0.0, 0.0)).distance(DVec3::X * 0.5) < 1e-12);
        let cup = Profile::cup(1.0, 1.0, 0.25);
        assert!(!cup.encloses(DVec3::ZERO) && !cup.encloses(DVec3::new(0.0, -1.3, 0.0)));
        assert!(cup.encloses(DVec3::new(0.0, -1.2, 0.0)) && cup.encloses(DVec3::new(0.0, 0.9, 1.2)));
        assert!(cup.nearest(DVec3::new(0.0, 0.0, -0.9)).distance(DVec3::NEG_Z) < 1e-12);
    }

    #[test]
    fn areas() {
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
        assert!(near(Profile::cylinder(1.0, 2.0).area(), 10.0 * PI));
        assert!(near(Profile::cone(3.0, 2.0).area(), PI * 9.0 + PI * 3.0 * 5.0));
        assert!(near(Profile::capsule(1.0, 1.5).area(), 4.0 * PI + 2.0 * PI * 3.0));
    }
}
