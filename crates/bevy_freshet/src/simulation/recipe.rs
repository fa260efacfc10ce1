//! What the components ask for, in a form that can be compared: planning is expensive, and done when this changes.

use bevy::prelude::*;
use freshet_core::emitter::Emitter;
use freshet_core::material::Material;
use freshet_core::scene::{Boundary, FluidScene, Settings, Volume};

use super::movers::Mover;
use crate::components::domain::FluidDomain;

/// Change of a pose, m or radians, up to which walls count as unmoved: a domain that moves with its walls as children
/// would otherwise be planned anew each tick for rounding errors. A tenth of the finest spacing allowed.
const SAME_PLACE: f32 = 1e-5;

/// A boundary and where it came from.
#[derive(Clone, Debug)]
pub(crate) struct Wall {
    pub(crate) entity: Entity,
    pub(crate) component: &'static str,
    pub(crate) boundary: Boundary,
}

impl Wall {
    /// Whether it is not where another is, by more than rounding.
    pub(crate) fn is_moved_from(&self, other: &Self) -> bool {
        is_moved(other.pose(), self.pose())
    }

    /// Where it is, in the domain's frame.
    pub(crate) fn pose(&self) -> Isometry3d {
        Isometry3d::new(self.boundary.center, self.boundary.rotation)
    }
}

/// Whether two poses differ by more than rounding.
pub(crate) fn is_moved(before: Isometry3d, now: Isometry3d) -> bool {
    let away = before.translation.distance(now.translation);
    let is_there = away <= SAME_PLACE && angle_between(before.rotation, now.rotation) <= SAME_PLACE;
    !is_there
}

/// A volume that has not been poured.
#[derive(Clone, Debug)]
pub(crate) struct FreshVolume {
    pub(crate) entity: Entity,
    pub(crate) volume: Volume,
}

/// An emitter and where it is now.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    pub(crate) entity: Entity,
    pub(crate) emitter: Emitter,
}

/// What the components of one domain ask for.
#[derive(Clone, Debug)]
pub(crate) struct Recipe {
    pub(crate) spacing: f32,
    pub(crate) settings: Settings,
    pub(crate) material: Material,
    /// In the domain's frame, m/s2.
    pub(crate) gravity: Vec3,
    pub(crate) walls: Vec<Wall>,
    /// Walls that move. Where they are does not matter to a plan.
    pub(crate) movers: Vec<Mover>,
    pub(crate) sources: Vec<Source>,
    /// Bodies and the versions of their samples.
    pub(crate) bodies: Vec<(Entity, u64)>,
    /// Volumes to pour.
    pub(crate) fresh: Vec<FreshVolume>,
    /// Walls that are not there yet, in order; it is not planned as long as there are any.
    pub(crate) waits_for: Vec<Entity>,
}

impl Recipe {
    /// The model's settings of a domain.
    pub(crate) fn settings(domain: &FluidDomain) -> Settings {
        Settings {
            max_substeps: domain.max_substeps,
            budget_milliseconds: domain.budget_milliseconds,
            max_particles: domain.max_particles,
            ..domain.settings.to_settings()
        }
    }

    /// Whether a plan made from `other` serves this too. Gravity may turn and change by a tenth: the solver is told, and
    /// only the expected speed depends on it. Emitters may move.
    pub(crate) fn is_served_by(&self, other: &Self) -> bool {
        let (strength, planned) = (self.gravity.length(), other.gravity.length());
        self.spacing == other.spacing
            && self.settings == other.settings
            && self.material == other.material
            && (strength - planned).abs() <= 0.1 * planned
            && self.bodies == other.bodies
            && self.fresh.iter().map(|fresh| fresh.entity).eq(other.fresh.iter().map(|fresh| fresh.entity))
            && same(&self.walls, &other.walls, |a, b| {
                a.entity == b.entity
                    && a.boundary.shape == b.boundary.shape
                    && a.boundary.viscous_faces == b.boundary.viscous_faces
                    && a.boundary.friction == b.boundary.friction
                    && is_same_velocity(a.boundary.velocity, b.boundary.velocity)
                    && !a.is_moved_from(b)
            })
            && self.has_movers_of(other)
            && same(&self.sources, &other.sources, |a, b| {
                let (a, b) = ((a.entity, &a.emitter), (b.entity, &b.emitter));
                a.0 == b.0
                    && (a.1.radius, a.1.speed, a.1.lifetime) == (b.1.radius, b.1.speed, b.1.lifetime)
                    // One that moves out of range is refused, until it is back.
                    && a.1.validate().is_ok() == b.1.validate().is_ok()
            })
    }

    /// Whether the same walls move.
    pub(crate) fn has_movers_of(&self, other: &Self) -> bool {
        same(&self.movers, &other.movers, |a, b| a.entity == b.entity && a.shape == b.shape && a.friction == b.friction)
    }

    /// The scene, without bodies and walls that move, whose samples the caller adds.
    pub(crate) fn scene(&self) -> FluidScene {
        FluidScene {
            gravity: self.gravity,
            material: self.material.clone(),
            volumes: self.fresh.iter().map(|fresh| fresh.volume.clone()).collect(),
            emitters: self.sources.iter().map(|source| source.emitter.clone()).collect(),
            boundaries: self.walls.iter().map(|wall| wall.boundary.clone()).collect(),
            settings: self.settings.clone(),
            ..FluidScene::with_spacing(self.spacing)
        }
    }
}

/// Angle between rotations, radians. `Quat::angle_between` takes an arc cosine near one, where rounding alone makes 1e-3.
fn angle_between(a: Quat, b: Quat) -> f32 {
    let (a, b) = (Vec4::from(a), Vec4::from(b));
    // Opposite quaternions are the same rotation; unit ones at an angle t are 2 sin(t / 4) apart.
    4.0 * (a.distance(b).min(a.distance(-b)) / 2.0).min(1.0).asin()
}

/// Whether velocities differ by no more than rounding makes of them where the domain turns with the wall.
fn is_same_velocity(a: Vec3, b: Vec3) -> bool {
    a.distance(b) <= SAME_PLACE * (1.0 + b.length())
}

fn same<T>(a: &[T], b: &[T], equal: impl Fn(&T, &T) -> bool) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| equal(a, b))
}

#[cfg(test)]
mod tests {
    use freshet_core::scene::{BoundaryShape, Friction};

    use super::*;

    fn recipe(boundary: Boundary) -> Recipe {
        let wall = Wall { entity: Entity::PLACEHOLDER, component: "FluidContainer", boundary };
        Recipe {
            spacing: 0.1,
            settings: Settings::default(),
            material: Material::water(),
            gravity: Vec3::NEG_Y,
            walls: vec![wall],
            movers: Vec::new(),
            sources: Vec::new(),
            bodies: Vec::new(),
            fresh: Vec::new(),
            waits_for: Vec::new(),
        }
    }

    #[test]
    fn angles_are_right_from_rounding_to_half_a_turn() {
        let axis = Vec3::new(1.0, -2.0, 0.5).normalize();
        let start = Quat::from_euler(EulerRot::YXZ, 0.7, -0.3, 2.0);
        for angle in [0.0f32, 1e-5, 1e-3, 0.5, 3.0] {
            let turned = start * Quat::from_axis_angle(axis, angle);
            for turned in [turned, -turned] {
                // Rounding of the components, 6e-8 each.
                let wrong = (angle_between(start, turned) - angle).abs();
                assert!(wrong < 1e-6 + 1e-5 * angle, "{angle}: {wrong}");
            }
        }
    }

    #[test]
    fn walls_that_turn_move_or_become_slippery_are_planned_anew() {
        let half_extents = Vec3::ONE;
        let wall = Boundary::new(BoundaryShape::Box { half_extents }, Vec3::ZERO);
        let planned = recipe(wall.clone());
        let turned = |angle| Boundary { rotation: Quat::from_rotation_y(angle), ..wall.clone() };
        let moved = |x| Boundary { center: Vec3::X * x, ..wall.clone() };
        for unmoved in [wall.clone(), turned(0.5 * SAME_PLACE), moved(0.5 * SAME_PLACE)] {
            assert!(recipe(unmoved).is_served_by(&planned));
        }
        let slippery = wall.clone().with_viscous_faces([true, true, false, true, true, true]);
        let rough = wall.clone().with_friction(Friction::coulomb(0.1));
        let belt = wall.clone().with_velocity(Vec3::X * 0.1);
        for changed in [turned(2.0 * SAME_PLACE), turned(1e-3), moved(2.0 * SAME_PLACE), slippery, rough, belt] {
            assert!(!recipe(changed.clone()).is_served_by(&planned), "{changed:?}");
        }
    }
}
