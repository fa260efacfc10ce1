//! Scenes of the model, such as those in files, as entities.

use bevy::prelude::*;
use freshet_core::error::InvalidInput;
use freshet_core::kernel::support_radius_for_neighbours;
use freshet_core::scene::{BoundaryShape, FluidScene, Resolution, Shape, Support, Volume};

use super::boundary::{FluidBoundary, FluidBoundaryShape};
use super::container::FluidContainer;
use super::domain::FluidDomain;
use super::emitter::FluidEmitter;
use super::material::Fluid;
use super::membership::FluidInDomain;
use super::settings::FluidSettings;
use super::volume::{FluidShape, FluidVolume};

/// Spawns whole scenes.
pub trait FluidSceneCommands {
    /// Spawns a domain and what belongs to it (as its children, so that despawning the domain despawns all); returns the
    /// domain. `change` is called with the domain before it is spawned, to choose backend and mode.
    ///
    /// # Errors
    /// A value out of range, or bodies: those of a scene are samples without mass; spawn rapier bodies with
    /// [`FluidBody`](super::body::FluidBody) instead. What components do not have: periods.
    fn spawn_fluid_scene(
        &mut self,
        scene: &FluidScene,
        change: impl FnOnce(&mut FluidDomain),
    ) -> Result<Entity, InvalidInput>;
}

impl FluidSceneCommands for Commands<'_, '_> {
    fn spawn_fluid_scene(
        &mut self,
        scene: &FluidScene,
        change: impl FnOnce(&mut FluidDomain),
    ) -> Result<Entity, InvalidInput> {
        scene.validate()?;
        if !scene.bodies.is_empty() {
            return Err(InvalidInput::new("bodies", scene.bodies.len(), "none; spawn rapier bodies with FluidBody"));
        }
        check_components(scene)?;
        let spacing = match scene.resolution {
            Resolution::Spacing(spacing) => spacing,
            Resolution::Particles(count) => (scene.volumes.iter().map(Volume::size).sum::<f32>() / count as f32).cbrt(),
        };
        let support_ratio = match scene.settings.support {
            Support::Ratio(ratio) => ratio,
            Support::Neighbours(count) => support_radius_for_neighbours(spacing, count)? / spacing,
        };
        let mut domain = FluidDomain {
            gravity: Some(scene.gravity),
            max_particles: scene.settings.max_particles,
            budget_milliseconds: scene.settings.budget_milliseconds,
            max_substeps: scene.settings.max_substeps,
            settings: FluidSettings::from_settings(&scene.settings, support_ratio),
            ..FluidDomain::with_spacing(spacing)
        };
        change(&mut domain);
        let domain = self.spawn((domain, Name::new(format!("fluid {}", scene.name)))).id();
        let member = || (ChildOf(domain), FluidInDomain(domain));
        let fluid = Fluid::from(scene.material.clone());
        for volume in &scene.volumes {
            let shape = match volume.shape {
                Shape::Box { half_extents } => FluidShape::Cuboid { half_size: half_extents },
                Shape::Sphere { radius } => FluidShape::Sphere { radius },
            };
            let pose = Transform::from_translation(volume.center).with_rotation(volume.rotation);
            self.spawn((
                FluidVolume { shape, velocity: volume.velocity, hydrostatic: volume.hydrostatic },
                fluid.clone(),
                pose,
                member(),
            ));
        }
        for emitter in &scene.emitters {
            let pose = Transform::from_translation(emitter.center)
                .with_rotation(Quat::from_rotation_arc(Vec3::NEG_Z, emitter.direction.normalize()));
            let emitter = FluidEmitter::disc(emitter.radius, emitter.speed, emitter.lifetime);
            self.spawn((emitter, fluid.clone(), pose, member()));
        }
        for boundary in &scene.boundaries {
            let pose = Transform::from_translation(boundary.center).with_rotation(boundary.rotation);
            let (viscous_faces, friction) = (boundary.viscous_faces, boundary.friction.into());
            let velocity = boundary.rotation.inverse() * boundary.velocity;
            let mut entity = self.spawn((pose, member()));
            if let BoundaryShape::Container { half_extents, open } = boundary.shape {
                let Vec3 { x, y, z } = 2.0 * half_extents;
                let container = FluidContainer::closed_box(x, y, z);
                entity.insert(FluidContainer { open, viscous_faces, friction, velocity, ..container });
            } else if let Some(shape) = FluidBoundaryShape::from_model(&boundary.shape) {
                entity.insert(FluidBoundary { viscous_faces, friction, velocity, ..FluidBoundary::new(shape) });
            }
        }
        Ok(domain)
    }
}

/// Refuses what no component has, so that none of a scene is lost without a word.
fn check_components(scene: &FluidScene) -> Result<(), InvalidInput> {
    if scene.periodic.any() {
        return Err(InvalidInput::new("periodic", format_args!("{:?}", scene.periodic), "none, in an app"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use freshet_core::periodic::Periodic;
    use freshet_core::scene::{Boundary, Friction};

    use super::*;

    #[test]
    fn what_no_component_has_is_refused_by_name() {
        let wall = Boundary::open_box(Vec3::ONE, Vec3::ZERO).with_friction(Friction::coulomb(0.5));
        let plain = FluidScene { boundaries: vec![wall], ..FluidScene::with_spacing(0.1) };
        assert!(check_components(&plain).is_ok());
        let endless = FluidScene { periodic: Periodic { x: Some((0.0, 1.0)), ..Periodic::default() }, ..plain };
        let error = check_components(&endless).map_err(|error| error.to_string());
        assert!(error.as_ref().is_err_and(|text| text.contains("periodic")), "{error:?}");
    }
}
