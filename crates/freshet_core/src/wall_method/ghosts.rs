//! Mirror images of the fluid behind plane faces (Randles & Libersky 1996; Pirovano 2011, section 3.5.4, where they were not finished).
//!
//! Behind a face stands the mirror image `R b` of each particle, with its density and pressure: what particle and images are together is a fluid that is
//! its own mirror image, under a gravity that is, too, and so is what becomes of it. So energy is kept, and water comes to rest. Where faces meet at right angles there are images of images.
//!
//! None of them is stored: as `|x_a - R x_b| = |R x_a - x_b|`, a particle near a face sums over what is around its own image:
//!
//! `rho_a = (m/S) sum_b (W_ab + sum_R W(R x_a - x_b))`, `a_a = ... - (m/G) sum_R sum_b (P_a + P_b + Pi) F(R x_a - x_b) (x_a - R x_b)`.
//!
//! `R v_b` is the velocity of an image behind a face that fluid slips along, `-v_b` behind a viscous one, so that velocities at the face are none. (The mirror image of gravity is what makes pressures
//! have no slope at the face; one that goes on with `rho g` into the wall is that of no fluid: with it nothing would be kept.)
//!
//! The faces are those of the nearest samples, which lie on them, as of [springs](super::SpringDamper). A particle without neighbours has no pressure, and would go through: what comes nearer to
//! a face than [`CONTACT`] is put back, and loses the speed with which it came.

use glam::Vec3;

use super::{MOST_PLANES, Plane};

/// How near to a face particles get, spacings.
pub const CONTACT: f32 = 0.1;

/// How far beside a sample its face reaches, spacings: in a corner samples on the edges may be of the other faces.
pub const LATERAL_REACH: f32 = 1.5;

/// Cosine between two normals up to which faces are at right angles.
pub const RIGHT: f32 = 0.01;

/// An image: mirrored at each of up to three planes that are at right angles to each other.
#[derive(Clone, Copy, Debug, Default)]
pub struct Image {
    /// Normals of the planes, zero for those that are not.
    normals: [Vec3; MOST_PLANES],
    /// From the particle to its image, m.
    pub way: Vec3,
    /// Which of them are of viscous faces.
    sticks: [bool; MOST_PLANES],
}

/// The images behind planes, `sticks` of which are viscous, that are nearer to the fluid than `reach`, m.
pub fn images<'a>(planes: &'a [Plane], sticks: &'a [bool], reach: f32) -> impl Iterator<Item = Image> + 'a {
    let count = planes.len().min(MOST_PLANES);
    (1..1usize << count).filter_map(move |mask| {
        let mut image = Image::default();
        let mut squared = 0.0;
        for (index, plane) in planes.iter().enumerate().filter(|(index, _)| mask >> index & 1 == 1) {
            if image.normals.iter().any(|normal| normal.dot(plane.normal).abs() > RIGHT) {
                return None;
            }
            image.normals[index] = plane.normal;
            image.sticks[index] = sticks[index];
            image.way -= 2.0 * plane.distance * plane.normal;
            squared += plane.distance * plane.distance;
        }
        (squared < reach * reach).then_some(image)
    })
}

impl Image {
    /// A vector, mirrored.
    #[inline(always)]
    pub fn mirrored(&self, vector: Vec3) -> Vec3 {
        self.normals.iter().fold(vector, |vector, normal| vector - 2.0 * vector.dot(*normal) * *normal)
    }

    /// The velocity of an image of a particle.
    #[inline(always)]
    pub fn velocity(&self, velocity: Vec3) -> Vec3 {
        self.normals.iter().zip(self.sticks).fold(velocity, |velocity, (normal, sticks)| match sticks {
            true => -velocity,
            false => velocity - 2.0 * velocity.dot(*normal) * *normal,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_corner_has_seven_images_and_a_slanted_edge_two() {
        let plane = |normal: Vec3, distance| Plane { normal, distance, sample: 0 };
        let corner = [plane(Vec3::X, 0.1), plane(Vec3::Y, 0.2), plane(Vec3::Z, 0.3)];
        let found: Vec<Image> = images(&corner, &[false, true, true], 1.0).collect();
        assert_eq!(found.len(), 7);
        let all = &found[6];
        assert!(all.way.distance(-2.0 * Vec3::new(0.1, 0.2, 0.3)) < 1e-6);
        let v = Vec3::new(1.0, 2.0, 3.0);
        assert_eq!((all.mirrored(v), all.velocity(v)), (-v, Vec3::new(-1.0, 2.0, 3.0)));
        assert_eq!((found[1].mirrored(v), found[1].velocity(v)), (Vec3::new(1.0, -2.0, 3.0), -v));
        let slanted = [plane(Vec3::X, 0.1), plane(Vec3::new(0.6, 0.8, 0.0), 0.2)];
        assert_eq!(images(&slanted, &[false; 2], 1.0).count(), 2);
        assert_eq!(images(&corner, &[false; 3], 0.25).count(), 3);
    }
}
