//! The faces that samples stand for.

use glam::Vec3;

use crate::sampling::wall_layer::WallLayer;
use crate::scene::{Boundary, BoundaryShape};

/// The face that a sample lies behind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Unit normal, to the fluid.
    pub normal: Vec3,
    /// How far behind the face the sample lies, m.
    pub depth: f32,
}

/// Most faces that hold a particle at once: as many as meet in the corner of a room.
pub const MOST_PLANES: usize = 3;

/// Cosine between the normals of two faces from which on they count as one.
const SAME: f32 = 0.5;

/// A face that holds a particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit normal, to the fluid.
    pub normal: Vec3,
    /// Distance of the particle from it, m, negative behind it.
    pub distance: f32,
    /// The sample it is of.
    pub sample: usize,
}

impl Plane {
    /// How near a particle has to be to a sample half a spacing behind its face, in spacings: from half a spacing before the face to more than one behind it.
    pub const REACH: f32 = 1.3;
    /// How far beside a sample, in spacings, its face reaches: no point of a wall's layer is farther than 0.75 from a sample.
    pub const LATERAL_REACH: f32 = 0.8;

    /// The planes of a particle: that of the nearest sample, then of the nearest of those whose normal is 60 degrees or more from it, and so on.
    /// A sample counts if the particle is within `reach`, m, of it and within `beside`, m, of its normal.
    ///
    /// `samples` are their numbers, with the way from each to the particle, m, and at least all within that reach.
    pub fn among(
        samples: &[(usize, Vec3)],
        face: impl Fn(usize) -> Face,
        [reach, beside]: [f32; 2],
    ) -> ([Self; MOST_PLANES], usize) {
        let none = Self { normal: Vec3::ZERO, distance: 0.0, sample: 0 };
        let (mut planes, mut count) = ([none; MOST_PLANES], 0);
        let [reach, beside] = [reach, beside].map(|reach| reach * reach);
        while count < MOST_PLANES {
            let mut nearest = reach;
            let mut found = None;
            for &(sample, x) in samples {
                let squared = x.length_squared();
                if squared >= nearest {
                    continue;
                }
                let Face { normal, depth } = face(sample);
                let height = x.dot(normal);
                let is_known = planes[..count].iter().any(|plane| plane.normal.dot(normal) > SAME);
                if !is_known && squared - height * height < beside {
                    nearest = squared;
                    found = Some(Self { normal, distance: height - depth, sample });
                }
            }
            let Some(plane) = found else { break };
            planes[count] = plane;
            count += 1;
        }
        (planes, count)
    }
}

/// The face of a sample of a boundary; that of a surface with fluid on both sides says nothing.
pub(crate) fn face_of(boundary: &Boundary, layer: &WallLayer, sample: Vec3) -> Face {
    let local = boundary.rotation.conjugate() * (sample - boundary.center);
    let across = |axis: usize, side: f32, depth: f32| {
        let mut normal = Vec3::ZERO;
        normal[axis] = side;
        Face { normal: boundary.rotation * normal, depth }
    };
    match boundary.shape {
        BoundaryShape::Plane { .. } | BoundaryShape::HalfSpace { .. } => across(1, 1.0, -local.y),
        BoundaryShape::Box { half_extents } => {
            let beyond = local.abs() - half_extents;
            let axis = beyond.max_position();
            across(axis, local[axis].signum(), -beyond[axis])
        }
        BoundaryShape::Container { half_extents, open } => {
            // Faces that are missing hold nothing.
            let is_closed = |axis: usize| !open[2 * axis + usize::from(local[axis] > 0.0)];
            let beyond = |axis: usize| local[axis].abs() - half_extents[axis];
            let closed = (0..3).filter(|&axis| is_closed(axis));
            let axis = closed.max_by(|&a, &b| beyond(a).total_cmp(&beyond(b))).unwrap_or(1);
            across(axis, -local[axis].signum(), beyond(axis))
        }
        _ => {
            let nearest = |solid: &crate::solid::Solid| solid.distance_from(sample);
            let (distance, normal) = boundary.solids(layer).iter().map(nearest).next().unwrap_or((0.0, Vec3::Y));
            Face { normal, depth: -distance }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Quat;

    use super::*;
    use crate::plan::sample_boundary;
    use crate::scene::{FluidScene, FluidSide};
    use crate::wall_method::{SpringDamper, WallMethod};

    const D: f32 = 0.1;

    fn faces(boundary: &Boundary) -> Result<Vec<(Vec3, Face)>, Box<dyn std::error::Error>> {
        let layer = FluidScene::with_spacing(D).wall_layer()?;
        let samples = sample_boundary(boundary, &layer.of_method(WallMethod::SpringDamper(SpringDamper::DEFAULT)))?;
        Ok(samples.into_iter().map(|sample| (sample, face_of(boundary, &layer, sample))).collect())
    }

    #[test]
    fn samples_know_their_faces() -> Result<(), Box<dyn std::error::Error>> {
        let turned = Quat::from_rotation_z(0.3);
        let room = BoundaryShape::Sphere { radius: 1.0, fluid: FluidSide::Inside };
        let ball = BoundaryShape::Sphere { radius: 1.0, fluid: FluidSide::Outside };
        let open = [false, false, false, true, false, false];
        let half_extents = Vec3::new(0.5, 0.6, 0.7);
        for (shape, to_fluid) in [
            (BoundaryShape::Plane { half_extents: [0.5, 0.5] }, Vec3::Y),
            (BoundaryShape::Container { half_extents, open }, Vec3::ZERO),
            (BoundaryShape::Box { half_extents }, Vec3::ZERO),
            (room, Vec3::ZERO),
            (ball, Vec3::ZERO),
        ] {
            let boundary = Boundary { rotation: turned, ..Boundary::new(shape, Vec3::new(0.2, 0.1, 0.0)) };
            for (sample, face) in faces(&boundary)? {
                assert!((face.depth - 0.5 * D).abs() < 1e-4, "{:?}: {face:?}", boundary.shape);
                assert!((face.normal.length() - 1.0).abs() < 1e-5);
                // What the face stands for is on the wall's surface: just before it is fluid, just behind it is not.
                let on_face = sample + face.depth * face.normal;
                let layer = FluidScene::with_spacing(D).wall_layer()?;
                let inside = |point: Vec3| boundary.solids(&layer).iter().any(|solid| solid.contains(point, 0.0));
                assert!(inside(on_face - 0.01 * D * face.normal), "{:?} at {sample}: {face:?}", boundary.shape);
                if to_fluid != Vec3::ZERO {
                    assert!(face.normal.distance(turned * to_fluid) < 1e-5);
                }
            }
        }
        Ok(())
    }

    #[test]
    fn a_corner_holds_by_three_planes_and_a_face_by_one() -> Result<(), Box<dyn std::error::Error>> {
        let all = faces(&Boundary::open_box(Vec3::ONE, Vec3::splat(0.5)))?;
        let planes = |at: Vec3| {
            let samples: Vec<_> = all.iter().enumerate().map(|(k, (sample, _))| (k, at - *sample)).collect();
            Plane::among(&samples, |k| all[k].1, [Plane::REACH * D, Plane::LATERAL_REACH * D])
        };
        let (found, count) = planes(Vec3::splat(0.04));
        assert_eq!(count, 3);
        assert!(found.iter().all(|plane| (plane.distance - 0.04).abs() < 1e-5), "{found:?}");
        let (found, count) = planes(Vec3::new(0.5, -0.02, 0.53));
        assert!(count == 1 && found[0].normal == Vec3::Y && (found[0].distance + 0.02).abs() < 1e-6, "{found:?}");
        assert_eq!(planes(Vec3::splat(0.5)).1, 0);
        Ok(())
    }
}
