//! What the components ask for, in a form that can be compared: planning is expensive, and done when this changes.

use bevy::prelude::*;
use freshet_core::emitter::Emitter;
use freshet_core::material::Material;
use freshet_core::scene::{Boundary, FluidScene, Settings, Volume};

use crate::components::domain::FluidDomain;

/// Change of a pose, m or radians, below which walls count as unmoved: a domain that moves with its walls as children
/// would otherwise be planned anew each tick for rounding errors. A thousandth of the finest spacing in use.
const SAME_PLACE: f32 = 1e-5;

/// A boundary and where it came from.
#[derive(Clone, Debug)]
pub(crate) struct Wall {
    pub(crate) entity: Entity,
    pub(crate) component: &'static str,
    pub(crate) boundary: Boundary,
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
    pub(crate) sources: Vec<Source>,
    /// Bodies and the versions of their samples.
    pub(crate) bodies: Vec<(Entity, u64)>,
    /// Volumes to pour.
    pub(crate) fresh: Vec<FreshVolume>,
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
                    && a.boundary.center.abs_diff_eq(b.boundary.center, SAME_PLACE)
                    && a.boundary.rotation.angle_between(b.boundary.rotation) <= SAME_PLACE.sqrt()
            })
            && same(&self.sources, &other.sources, |a, b| {
                let (a, b) = ((a.entity, &a.emitter), (b.entity, &b.emitter));
                a.0 == b.0 && (a.1.radius, a.1.speed, a.1.lifetime) == (b.1.radius, b.1.speed, b.1.lifetime)
            })
    }

    /// The scene, without bodies, whose samples the caller adds.
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

fn same<T>(a: &[T], b: &[T], equal: impl Fn(&T, &T) -> bool) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| equal(a, b))
}
