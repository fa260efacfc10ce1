//! Where no fluid may start: the insides of walls and bodies.
//!
//! A particle that starts there would be thrown out by all samples around it at once, or be caught. Whether a centre is inside is
//! asked of closed shapes and not of samples, when particles come into being and never again: a plan leaves out those of its
//! volumes that start in a wall ([`Plan::left_out`](crate::plan::Plan::left_out)); bodies have a place from the first tick on, so
//! solvers ask then, and for what commands spawn ([`StepReport::inside_solids`](crate::step::StepReport::inside_solids)).

use glam::{DVec3, Mat3, Quat, Vec3};
use serde::{Deserialize, Serialize};

use crate::error::{InvalidInput, check_range};
use crate::geometry::round::Profile;
use crate::geometry::{HeightField, TriangleMesh, convex_hull};
use crate::sampling::wall_layer::WallLayer;
use crate::scene::{Boundary, BoundaryShape, FluidSide, REACH, Shape, check_pose, side_of};

/// A closed shape about its own centre; sizes from 1e-5 to 1e6 m. What turns about an axis turns about the local y axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum SolidShape {
    /// A box.
    Box {
        /// Half its edge lengths, m.
        half_extents: Vec3,
    },
    /// A sphere.
    Sphere {
        /// Radius, m.
        radius: f32,
    },
    /// All below the plane of the local x and z axes.
    HalfSpace,
    /// A cylinder.
    Cylinder {
        /// Radius, m.
        radius: f32,
        /// Half its height, m.
        half_height: f32,
    },
    /// A cylinder that ends in half spheres.
    Capsule {
        /// Radius, m.
        radius: f32,
        /// Half the height of the cylinder between them, m.
        half_height: f32,
    },
    /// A cone with its tip up, its centre half way up.
    Cone {
        /// Radius of the base, m.
        radius: f32,
        /// Half its height, m.
        half_height: f32,
    },
    /// Wall and bottom of a cylindrical vessel.
    Cup {
        /// Radius of the room in it, m.
        radius: f32,
        /// Half the height of the room in it, about the centre, m.
        half_height: f32,
        /// How thick wall and bottom are, m.
        thickness: f32,
    },
    /// What a mesh encloses: see [`TriangleMesh::is_inside`].
    Mesh {
        /// Its surface.
        mesh: TriangleMesh,
    },
    /// Ground.
    Ground {
        /// Its surface.
        field: HeightField,
        /// How deep it goes below its lowest place, m.
        thickness: f32,
    },
    /// A convex shape, thickened all round.
    Rounded {
        /// The shape.
        core: Box<SolidShape>,
        /// By how much, m.
        rounding: f32,
    },
    /// The wall around a room.
    Around {
        /// The room.
        room: Box<SolidShape>,
        /// How thick the wall is, m.
        thickness: f32,
    },
    /// What is near the surface of a shape, on either side.
    Skin {
        /// The shape.
        shape: Box<SolidShape>,
        /// How near, m.
        reach: f32,
    },
}

impl From<Shape> for SolidShape {
    fn from(shape: Shape) -> Self {
        match shape {
            Shape::Box { half_extents } => Self::Box { half_extents },
            Shape::Sphere { radius } => Self::Sphere { radius },
        }
    }
}

impl SolidShape {
    /// Distance of a point relative to the centre, in the shape's own axes, from the surface, m, negative inside, and the direction
    /// away from it.
    pub fn distance(&self, local: Vec3) -> (f32, Vec3) {
        let double = f64::from;
        match self {
            &Self::Box { half_extents } => Shape::Box { half_extents }.distance(local),
            &Self::Sphere { radius } => Shape::Sphere { radius }.distance(local),
            Self::HalfSpace => (local.y, Vec3::Y),
            &Self::Cylinder { radius, half_height } => {
                distance_of(&Profile::cylinder(double(radius), double(half_height)), local)
            }
            &Self::Capsule { radius, half_height } => {
                distance_of(&Profile::capsule(double(radius), double(half_height)), local)
            }
            &Self::Cone { radius, half_height } => {
                distance_of(&Profile::cone(double(radius), double(half_height)), local)
            }
            &Self::Cup { radius, half_height, thickness } => {
                distance_of(&Profile::cup(double(radius), double(half_height), double(thickness)), local)
            }
            Self::Mesh { mesh } => {
                let point = local.as_dvec3();
                let (low, high) = mesh.bounds();
                let is_inside = local.cmpge(low).all() && local.cmple(high).all() && mesh.encloses(point);
                signed(point, mesh.nearest(point, f64::INFINITY).unwrap_or(point), is_inside)
            }
            Self::Ground { field, thickness } => ground_distance(field, *thickness, local),
            Self::Rounded { core, rounding } => {
                let (distance, normal) = core.distance(local);
                (distance - rounding, normal)
            }
            Self::Around { room, thickness } => {
                let (distance, normal) = room.distance(local);
                // Nearer to the room or to what is behind the wall.
                if distance < 0.5 * thickness { (-distance, -normal) } else { (distance - thickness, normal) }
            }
            Self::Skin { shape, reach } => {
                let (distance, normal) = shape.distance(local);
                (distance.abs() - reach, if distance < 0.0 { -normal } else { normal })
            }
        }
    }

    /// Lowest and highest corner of the box around it, m.
    fn bounds(&self) -> (Vec3, Vec3) {
        let double = f64::from;
        let around = |profile: Profile| {
            let reach = profile.reach().as_vec2();
            let high = Vec3::new(reach.x, reach.y, reach.x);
            (-high, high)
        };
        match self {
            &Self::Box { half_extents } => (-half_extents, half_extents),
            &Self::Sphere { radius } => (Vec3::splat(-radius), Vec3::splat(radius)),
            Self::HalfSpace => (Vec3::NEG_INFINITY, Vec3::INFINITY),
            &Self::Cylinder { radius, half_height } => around(Profile::cylinder(double(radius), double(half_height))),
            &Self::Capsule { radius, half_height } => around(Profile::capsule(double(radius), double(half_height))),
            &Self::Cone { radius, half_height } => around(Profile::cone(double(radius), double(half_height))),
            &Self::Cup { radius, half_height, thickness } => {
                around(Profile::cup(double(radius), double(half_height), double(thickness)))
            }
            Self::Mesh { mesh } => mesh.bounds(),
            Self::Ground { field, thickness } => {
                let (low, high) = field.surface().bounds();
                (low - Vec3::Y * *thickness, high)
            }
            Self::Around { room: shape, thickness: reach }
            | Self::Skin { shape, reach }
            | Self::Rounded { core: shape, rounding: reach } => {
                let (low, high) = shape.bounds();
                (low - *reach, high + *reach)
            }
        }
    }

    fn validate(&self) -> Result<(), InvalidInput> {
        let size = |field: &str, value: f32| check_range(field, value, 1e-5, REACH, "m");
        match self {
            &Self::Box { half_extents } => return Shape::Box { half_extents }.validate(),
            &Self::Sphere { radius } => return Shape::Sphere { radius }.validate(),
            Self::HalfSpace => Ok(()),
            &Self::Cylinder { radius, half_height }
            | &Self::Capsule { radius, half_height }
            | &Self::Cone { radius, half_height } => {
                size("radius", radius).and_then(|()| size("half_height", half_height))
            }
            &Self::Cup { radius, half_height, thickness } => size("radius", radius)
                .and_then(|()| size("half_height", half_height))
                .and_then(|()| size("thickness", thickness)),
            Self::Mesh { mesh } => mesh.validate().map_err(|error| error.inside("mesh")),
            Self::Ground { field, thickness } => {
                size("thickness", *thickness).and_then(|()| field.validate().map_err(|error| error.inside("field")))
            }
            Self::Rounded { core, rounding } => {
                size("rounding", *rounding).and_then(|()| core.validate().map_err(renamed("core")))
            }
            Self::Around { room, thickness } => {
                size("thickness", *thickness).and_then(|()| room.validate().map_err(renamed("room")))
            }
            Self::Skin { shape, reach } => {
                size("reach", *reach).and_then(|()| shape.validate().map_err(renamed("shape")))
            }
        }
        .map_err(|error| error.inside("shape"))
    }
}

/// The path of a shape's error, seen from the field the shape is in.
fn renamed(field: &'static str) -> impl Fn(InvalidInput) -> InvalidInput {
    move |error| {
        let path = error.field.strip_prefix("shape").unwrap_or(&error.field).to_owned();
        InvalidInput { field: format!("{field}{path}"), ..error }
    }
}

fn signed(point: DVec3, nearest: DVec3, is_inside: bool) -> (f32, Vec3) {
    let way = point - nearest;
    let distance = way.length() as f32;
    let normal = way.as_vec3().normalize_or(Vec3::Y);
    if is_inside { (-distance, -normal) } else { (distance, normal) }
}

fn distance_of(profile: &Profile, local: Vec3) -> (f32, Vec3) {
    let point = local.as_dvec3();
    signed(point, profile.nearest(point), profile.encloses(point))
}

/// Sides and bottom of ground are no faces that fluid touches: of points inside, the surface alone counts, and what is below or
/// beside it is outside.
fn ground_distance(field: &HeightField, thickness: f32, local: Vec3) -> (f32, Vec3) {
    let point = local.as_dvec3();
    let bottom = field.surface().bounds().0.y - thickness;
    let nearest = field.surface().nearest(point, f64::INFINITY).unwrap_or(point);
    if local.y < bottom {
        return (bottom - local.y, Vec3::NEG_Y);
    }
    let is_inside = field.covers(local.x, local.z, 0.0) && local.y < field.height(local.x, local.z);
    signed(point, nearest, is_inside)
}

/// A closed shape with no fluid in it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Solid {
    /// Its shape.
    pub shape: SolidShape,
    /// Centre of the shape, m, within 1e6 m of the origin.
    pub center: Vec3,
    /// Orientation of the shape, a unit quaternion.
    #[serde(default)]
    pub rotation: Quat,
}

impl Solid {
    /// A box of half its edge lengths, m, that is not turned.
    pub fn block(half_extents: Vec3, center: Vec3) -> Self {
        Self { shape: SolidShape::Box { half_extents }, center, rotation: Quat::IDENTITY }
    }

    /// A ball of a radius in m.
    pub fn ball(radius: f32, center: Vec3) -> Self {
        Self { shape: SolidShape::Sphere { radius }, center, rotation: Quat::IDENTITY }
    }

    /// The same, moved and turned with the frame it is given in.
    #[must_use]
    pub fn placed(&self, position: Vec3, rotation: Quat) -> Self {
        Self { center: position + rotation * self.center, rotation: rotation * self.rotation, ..self.clone() }
    }

    /// Whether a point is more than `tolerance` metres (0 or more) below the surface. A point on the surface is outside.
    pub fn contains(&self, point: Vec3, tolerance: f32) -> bool {
        self.distance(point - self.center).0 < -tolerance
    }

    /// Distance from the surface of a point relative to the centre, m, negative inside, and the direction away from it.
    pub(crate) fn distance(&self, offset: Vec3) -> (f32, Vec3) {
        let (distance, normal) = self.shape.distance(self.rotation.conjugate() * offset);
        (distance, self.rotation * normal)
    }

    /// Distance from the surface of a point, m, negative inside, and the direction away from it.
    pub(crate) fn distance_from(&self, point: Vec3) -> (f32, Vec3) {
        self.distance(point - self.center)
    }

    /// Distance of a point from the box along the axes that is around it, m; zero inside.
    pub(crate) fn distance_of_bounds(&self, point: Vec3) -> f32 {
        let (middle, reach) = self.reach();
        ((point - self.center - middle).abs() - reach).max(Vec3::ZERO).length()
    }

    /// Middle, relative to the centre, and half the edges of the box along the axes that is around it, m.
    pub(crate) fn reach(&self) -> (Vec3, Vec3) {
        let (low, high) = self.shape.bounds();
        if !high.is_finite() {
            return (Vec3::ZERO, Vec3::INFINITY);
        }
        let axes = Mat3::from_quat(self.rotation) * Mat3::from_diagonal(0.5 * (high - low));
        (self.rotation * (0.5 * (low + high)), axes.x_axis.abs() + axes.y_axis.abs() + axes.z_axis.abs())
    }

    pub(crate) fn validate(&self) -> Result<(), InvalidInput> {
        self.shape.validate()?;
        check_pose(self.center, self.rotation)
    }
}

impl Boundary {
    /// What of it is solid, in world coordinates.
    ///
    /// A [box](BoundaryShape::Box) is, all of it. A [plane](BoundaryShape::Plane) and the faces of a
    /// [container](BoundaryShape::Container) are walls twice as thick as their samples lie deep, for the samples push to both
    /// sides alike: what is farther behind is not in the wall but beyond it, where another tank may stand. So is the wall around any
    /// other room, and a surface with fluid on both sides, which is in the middle of its wall.
    pub fn solids(&self, layer: &WallLayer) -> Vec<Solid> {
        let thickness = 2.0 * layer.depth;
        let place = |solid: Solid| solid.placed(self.center, self.rotation);
        let shaped = |shape: SolidShape| place(Solid { shape, center: Vec3::ZERO, rotation: Quat::IDENTITY });
        let sided = |shape: SolidShape, fluid: FluidSide| {
            vec![shaped(match fluid {
                FluidSide::Outside => shape,
                FluidSide::Inside => SolidShape::Around { room: Box::new(shape), thickness },
                FluidSide::Both => SolidShape::Skin { shape: Box::new(shape), reach: layer.depth },
            })]
        };
        match &self.shape {
            &BoundaryShape::HalfSpace { .. } => vec![shaped(SolidShape::HalfSpace)],
            &BoundaryShape::Sphere { radius, fluid } => sided(SolidShape::Sphere { radius }, fluid),
            &BoundaryShape::Cylinder { radius, half_height, fluid } => {
                sided(SolidShape::Cylinder { radius, half_height }, fluid)
            }
            &BoundaryShape::Capsule { radius, half_height, fluid } => {
                sided(SolidShape::Capsule { radius, half_height }, fluid)
            }
            &BoundaryShape::Cone { radius, half_height, fluid } => {
                sided(SolidShape::Cone { radius, half_height }, fluid)
            }
            &BoundaryShape::Cup { radius, half_height, thickness } => {
                vec![shaped(SolidShape::Cup { radius, half_height, thickness })]
            }
            BoundaryShape::ConvexHull { points } => {
                convex_hull(points).map(|mesh| shaped(SolidShape::Mesh { mesh })).into_iter().collect()
            }
            BoundaryShape::Mesh { mesh, fluid } => {
                sided(SolidShape::Mesh { mesh: mesh.clone() }, side_of(mesh, *fluid))
            }
            BoundaryShape::HeightField { field } => {
                vec![shaped(SolidShape::Ground { field: field.clone(), thickness })]
            }
            &BoundaryShape::Box { half_extents } => vec![place(Solid::block(half_extents, Vec3::ZERO))],
            &BoundaryShape::Plane { half_extents: [x, z] } => {
                vec![place(Solid::block(Vec3::new(x, layer.depth, z), Vec3::NEG_Y * layer.depth))]
            }
            &BoundaryShape::Container { half_extents, open } => {
                // Corners are closed where both faces are.
                let beyond = |face: usize| if open[face] { 0.0 } else { thickness };
                let low = -half_extents - Vec3::from([0, 2, 4].map(beyond));
                let high = half_extents + Vec3::from([1, 3, 5].map(beyond));
                let slab = |face: usize| {
                    let (mut low, mut high) = (low, high);
                    if face.is_multiple_of(2) {
                        high[face / 2] = -half_extents[face / 2];
                    } else {
                        low[face / 2] = half_extents[face / 2];
                    }
                    place(Solid::block(0.5 * (high - low), 0.5 * (high + low)))
                };
                (0..6).filter(|&face| !open[face]).map(slab).collect()
            }
        }
    }
}

impl Boundary {
    /// Whether a point is where no fluid may ever be, by more than `tolerance` metres (0 or more): in a solid, however deep, or
    /// outside of a room that has no opening, however far.
    ///
    /// For tests of whether walls hold, which ask it of every particle. Where there is no telling, as what is there may have come by
    /// another way, the answer is no: behind a plane, outside of an open container, on either side of a surface with fluid on both.
    pub fn is_on_wrong_side(&self, point: Vec3, tolerance: f32) -> bool {
        let local = self.rotation.conjugate() * (point - self.center);
        let depth_in = |shape: SolidShape| -shape.distance(local).0;
        let depth = |shape: SolidShape, fluid: FluidSide| match fluid {
            FluidSide::Outside => depth_in(shape),
            FluidSide::Inside => -depth_in(shape),
            FluidSide::Both => f32::NEG_INFINITY,
        };
        let found = match &self.shape {
            &BoundaryShape::Container { half_extents, open } if open == [false; 6] => {
                -depth_in(SolidShape::Box { half_extents })
            }
            BoundaryShape::Container { .. } | BoundaryShape::Plane { .. } => f32::NEG_INFINITY,
            &BoundaryShape::Box { half_extents } => depth_in(SolidShape::Box { half_extents }),
            &BoundaryShape::HalfSpace { half_extents: [x, z] } => {
                if local.x.abs() <= x && local.z.abs() <= z {
                    -local.y
                } else {
                    f32::NEG_INFINITY
                }
            }
            &BoundaryShape::Sphere { radius, fluid } => depth(SolidShape::Sphere { radius }, fluid),
            &BoundaryShape::Cylinder { radius, half_height, fluid } => {
                depth(SolidShape::Cylinder { radius, half_height }, fluid)
            }
            &BoundaryShape::Capsule { radius, half_height, fluid } => {
                depth(SolidShape::Capsule { radius, half_height }, fluid)
            }
            &BoundaryShape::Cone { radius, half_height, fluid } => {
                depth(SolidShape::Cone { radius, half_height }, fluid)
            }
            &BoundaryShape::Cup { radius, half_height, thickness } => {
                depth_in(SolidShape::Cup { radius, half_height, thickness })
            }
            BoundaryShape::ConvexHull { points } => {
                convex_hull(points).map_or(f32::NEG_INFINITY, |mesh| depth_in(SolidShape::Mesh { mesh }))
            }
            BoundaryShape::Mesh { mesh, fluid } => {
                depth(SolidShape::Mesh { mesh: mesh.clone() }, side_of(mesh, *fluid))
            }
            // However deep: what is below it went through.
            BoundaryShape::HeightField { field } => {
                depth_in(SolidShape::Ground { field: field.clone(), thickness: REACH })
            }
        };
        found > tolerance
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::FluidScene;
    use std::f32::consts::FRAC_PI_4;

    const H: f32 = 1e-4;

    /// Whether any is around a point, by more than rounding.
    fn any(solids: &[Solid], point: Vec3) -> bool {
        solids.iter().any(|solid| solid.contains(point, 1e-6))
    }

    fn layer() -> WallLayer {
        FluidScene::with_spacing(0.1).wall_layer().unwrap()
    }

    #[test]
    fn a_point_on_the_face_is_outside() {
        let block = Solid::block(Vec3::new(1.0, 2.0, 3.0), Vec3::X);
        assert!(!block.contains(Vec3::new(2.0, 0.0, 0.0), 0.0) && !block.contains(Vec3::new(1.0, -2.0, 0.0), 0.0));
        assert!(
            block.contains(Vec3::new(2.0 - H, 0.0, 0.0), 0.0) && !block.contains(Vec3::new(2.0 + H, 0.0, 0.0), 0.0)
        );
        assert!(!block.contains(Vec3::new(2.0 - H, 0.0, 0.0), 2.0 * H), "less deep than the tolerance");
        let ball = Solid::ball(0.5, Vec3::Y);
        assert!(!ball.contains(Vec3::new(0.5, 1.0, 0.0), 0.0));
        assert!(ball.contains(Vec3::new(0.5 - H, 1.0, 0.0), 0.0) && !ball.contains(Vec3::new(0.5 + H, 1.0, 0.0), 0.0));
    }

    #[test]
    fn a_turned_box_is_turned_about_its_centre() {
        let turned = Solid { rotation: Quat::from_rotation_y(FRAC_PI_4), ..Solid::block(Vec3::ONE, Vec3::X * 5.0) };
        let corner = 2.0f32.sqrt();
        assert!(turned.contains(Vec3::new(5.0 + corner - 1e-3, 0.0, 0.0), 0.0));
        assert!(!turned.contains(Vec3::new(5.0 + corner + 1e-3, 0.0, 0.0), 0.0));
        assert!(!turned.contains(Vec3::new(5.9, 0.0, 0.9), 0.0), "in the box that is not turned");
        // Its frame turns it back and moves it.
        let back = turned.placed(Vec3::Y, Quat::from_rotation_y(-FRAC_PI_4));
        let center = Vec3::Y + Quat::from_rotation_y(-FRAC_PI_4) * (Vec3::X * 5.0);
        assert!(back.contains(center + 0.99, 0.0) && !back.contains(center + Vec3::X * 1.01, 0.0));
    }

    #[test]
    fn a_plane_is_solid_on_the_side_its_normal_points_away_from() {
        let plane = Boundary::new(BoundaryShape::Plane { half_extents: [1.0, 2.0] }, Vec3::Y);
        let thickness = 2.0 * layer().depth;
        let solids = plane.solids(&layer());
        assert!(!any(&solids, Vec3::Y) && !any(&solids, Vec3::Y * (1.0 + H)) && any(&solids, Vec3::Y * (1.0 - H)));
        assert!(any(&solids, Vec3::Y * (1.0 - thickness + H)) && !any(&solids, Vec3::Y * (1.0 - thickness - H)));
        assert!(any(&solids, Vec3::new(0.99, 0.95, 1.99)) && !any(&solids, Vec3::new(1.01, 0.95, 0.0)));
        // Its normal is x.
        let upright = Boundary { rotation: Quat::from_rotation_z(-2.0 * FRAC_PI_4), ..plane };
        let solids = upright.solids(&layer());
        assert!(any(&solids, Vec3::new(-0.05, 1.5, 0.0)) && !any(&solids, Vec3::new(0.05, 1.5, 0.0)));
    }

    #[test]
    fn a_container_is_solid_behind_its_faces_and_closed_at_its_corners() {
        let tank = Boundary::open_box(Vec3::new(2.0, 2.0, 2.0), Vec3::ZERO);
        let solids = tank.solids(&layer());
        assert_eq!(solids.len(), 5);
        for inside in [Vec3::ZERO, Vec3::X, Vec3::NEG_Y, Vec3::ONE, Vec3::splat(-0.999)] {
            assert!(!any(&solids, inside), "{inside} is fluid");
        }
        for wall in [Vec3::X * 1.1, Vec3::NEG_Y * 1.1, Vec3::new(1.1, -1.1, 1.1), Vec3::new(0.0, 0.99, -1.01)] {
            assert!(any(&solids, wall), "{wall} is wall");
        }
        for outside in [Vec3::Y * 1.1, Vec3::new(1.1, 1.01, 0.0), Vec3::X * (1.0 + 2.0 * layer().depth + H)] {
            assert!(!any(&solids, outside), "{outside} is beyond the wall, or above the rim");
        }
    }

    #[test]
    fn a_rounded_box_is_round_at_its_corners() {
        let core = Box::new(SolidShape::Box { half_extents: Vec3::ONE });
        let rounded =
            Solid { shape: SolidShape::Rounded { core, rounding: 0.5 }, center: Vec3::X, rotation: Quat::IDENTITY };
        assert!(
            rounded.contains(Vec3::new(1.0, 1.5 - H, 0.0), 0.0) && !rounded.contains(Vec3::new(1.0, 1.5 + H, 0.0), 0.0)
        );
        let corner = Vec3::X + 1.0 + 0.5 / 3.0f32.sqrt();
        assert!(rounded.contains(corner - H, 0.0) && !rounded.contains(corner + H, 0.0));
        assert_eq!(rounded.reach(), (Vec3::ZERO, Vec3::splat(1.5)));
        let thin = SolidShape::Rounded { core: Box::new(SolidShape::Sphere { radius: 0.0 }), rounding: 0.5 };
        assert!(thin.validate().unwrap_err().to_string().starts_with("shape.core.radius: 0 is not allowed"));
    }

    #[test]
    fn distances_point_away_from_the_surface() {
        let block = Shape::Box { half_extents: Vec3::new(1.0, 2.0, 3.0) };
        assert_eq!(block.distance(Vec3::new(-1.5, 0.0, 0.0)), (0.5, Vec3::NEG_X));
        assert_eq!(block.distance(Vec3::new(0.0, 1.75, 0.0)), (-0.25, Vec3::Y));
        let (distance, normal) = block.distance(Vec3::new(4.0, -6.0, 0.0));
        assert!((distance - 5.0).abs() < 1e-6 && normal.distance(Vec3::new(0.6, -0.8, 0.0)) < 1e-6, "{normal}");
        assert_eq!(Shape::Sphere { radius: 2.0 }.distance(Vec3::Z * 3.0), (1.0, Vec3::Z));
        let (distance, normal) = Shape::Sphere { radius: 2.0 }.distance(Vec3::ZERO);
        assert!(distance == -2.0 && normal.is_normalized());
        let turned = Solid { rotation: Quat::from_rotation_z(2.0 * FRAC_PI_4), ..Solid::block(Vec3::ONE, Vec3::X) };
        let (distance, normal) = turned.distance(Vec3::NEG_X * 3.0);
        assert!((distance - 2.0).abs() < 1e-6 && normal.distance(Vec3::NEG_X) < 1e-6, "{normal}");
    }
}
