//! The shapes, as collider and as mesh.

use std::f32::consts::{FRAC_PI_2, PI};

use bevy::prelude::*;
use bevy_rapier3d::prelude::Collider;

/// Half the thickness of a cross's bars over its size.
const CROSS_BAR: f32 = 0.22;

/// A shape that can be dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// As wide as it is large.
    Ball,
    /// Its edges are as long as it is large.
    Cube,
    /// Lower than wide.
    Cylinder,
    /// Longer than thick.
    Capsule,
    /// As high as wide.
    Cone,
    /// Three bars through each other.
    Cross,
    /// Five boards around a hollow: it floats if it is denser than water.
    Boat,
}

impl Shape {
    /// Every shape.
    pub const ALL: [Self; 7] =
        [Self::Ball, Self::Cube, Self::Cylinder, Self::Capsule, Self::Cone, Self::Cross, Self::Boat];

    /// In panels and figures.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ball => "ball",
            Self::Cube => "cube",
            Self::Cylinder => "cylinder",
            Self::Capsule => "capsule",
            Self::Cone => "cone",
            Self::Cross => "cross",
            Self::Boat => "boat",
        }
    }

    /// Rapier's shape, `size` metres large; nothing of it is thinner than `spacing`.
    pub fn collider(self, size: f32, spacing: f32) -> Collider {
        match self {
            Self::Ball => Collider::ball(size / 2.0),
            Self::Cube => Collider::cuboid(size / 2.0, size / 2.0, size / 2.0),
            Self::Cylinder => Collider::cylinder(0.35 * size, 0.55 * size),
            Self::Capsule => Collider::capsule_y(0.4 * size, 0.3 * size),
            Self::Cone => Collider::cone(0.5 * size, 0.55 * size),
            Self::Cross | Self::Boat => {
                let part =
                    |(center, half): (Vec3, Vec3)| (center, Quat::IDENTITY, Collider::cuboid(half.x, half.y, half.z));
                Collider::compound(self.parts(size, spacing).into_iter().map(part).collect())
            }
        }
    }

    /// What is drawn: meshes, and where they are in the body.
    pub fn meshes(self, size: f32, spacing: f32) -> Vec<(Mesh, Transform)> {
        let whole = |mesh: Mesh| vec![(mesh, Transform::IDENTITY)];
        match self {
            Self::Ball => whole(Sphere::new(size / 2.0).mesh().uv(64, 32)),
            Self::Cube => whole(Cuboid::from_length(size).into()),
            Self::Cylinder => whole(Cylinder::new(0.55 * size, 0.7 * size).mesh().resolution(64).build()),
            Self::Capsule => whole(Capsule3d::new(0.3 * size, 0.8 * size).mesh().longitudes(48).latitudes(24).build()),
            Self::Cone => whole(Cone::new(0.55 * size, size).mesh().resolution(64).build()),
            Self::Cross | Self::Boat => {
                let parts = self.parts(size, spacing).into_iter();
                parts.map(|(center, half)| (Cuboid::from_size(2.0 * half).into(), at(center))).collect()
            }
        }
    }

    /// Volume of what it is made of, m3. (Rapier would count what several parts of it cover several times.)
    pub fn volume(self, size: f32, spacing: f32) -> f32 {
        let box_volume = |(_, half): (Vec3, Vec3)| (2.0 * half).element_product();
        match self {
            Self::Ball => PI / 6.0 * size.powi(3),
            Self::Cube => size.powi(3),
            Self::Cylinder => PI * (0.55 * size).powi(2) * 0.7 * size,
            Self::Capsule => PI * (0.3 * size).powi(2) * (0.8 + 4.0 / 3.0 * 0.3) * size,
            Self::Cone => PI / 3.0 * (0.55 * size).powi(2) * size,
            Self::Cross => {
                let parts = self.parts(size, spacing).into_iter().map(box_volume);
                parts.sum::<f32>() - 2.0 * (2.0 * CROSS_BAR * size).powi(3)
            }
            Self::Boat => self.parts(size, spacing).into_iter().map(box_volume).sum(),
        }
    }

    /// How it is dropped: what is long lies.
    pub fn attitude(self) -> Quat {
        if self == Self::Capsule { Quat::from_rotation_z(FRAC_PI_2) } else { Quat::IDENTITY }
    }

    /// Whether it keeps water out of a hollow, so that it floats higher than its density says.
    pub fn is_hollow(self) -> bool {
        self == Self::Boat
    }

    /// Boxes it is made of: centres and half edges.
    fn parts(self, size: f32, spacing: f32) -> Vec<(Vec3, Vec3)> {
        if self == Self::Cross {
            let half = |long: usize| {
                let mut half = Vec3::splat(CROSS_BAR * size);
                half[long] = 0.6 * size;
                (Vec3::ZERO, half)
            };
            return (0..3).map(half).collect();
        }
        let (outer, board) = (size * Vec3::new(0.9, 0.4, 0.55), (0.07 * size).max(spacing / 2.0));
        let side = outer.y - board;
        let mut parts = vec![(Vec3::Y * (board - outer.y), Vec3::new(outer.x, board, outer.z))];
        for sign in [-1.0, 1.0] {
            parts.push((Vec3::new(sign * (outer.x - board), board, 0.0), Vec3::new(board, side, outer.z)));
            let across = Vec3::new(outer.x - 2.0 * board, side, board);
            parts.push((Vec3::new(0.0, board, sign * (outer.z - board)), across));
        }
        parts
    }
}

fn at(center: Vec3) -> Transform {
    Transform::from_translation(center)
}
