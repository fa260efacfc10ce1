//! How fine a scene is, and how far its kernels reach.

use super::SceneError;
use crate::error::InvalidInput;
use crate::kernel::{Kernel, KernelKind, support_radius_for_neighbours};
use crate::sampling::wall_layer::WallLayer;
use crate::scene::{FluidScene, Resolution, Support, Volume};

impl FluidScene {
    /// Where samples of walls and bodies have to lie in this scene, and what they weigh.
    ///
    /// # Errors
    /// If the resolution, the support or the kernel is not allowed.
    pub fn wall_layer(&self) -> Result<WallLayer, SceneError> {
        self.validate()?;
        let spacing = spacing_of(self);
        let sampled = self.as_sampled()?;
        Kernels::of(&sampled, spacing)?.wall_layer(spacing)
    }
}

/// The kernels of a scene's terms, all on one support radius.
pub(super) struct Kernels {
    /// Densities, and whatever else sums values.
    pub density: Kernel,
    /// Pressure forces.
    pub pressure: Kernel,
    /// Viscous forces.
    pub viscosity: Kernel,
}

impl Kernels {
    pub(super) fn of(scene: &FluidScene, spacing: f32) -> Result<Self, SceneError> {
        let settings = &scene.settings;
        let terms = [("settings.kernel", settings.kernel), ("settings.pressure_kernel", settings.of_pressure())];
        if let Some((field, _)) = terms.into_iter().find(|(_, kind)| *kind == KernelKind::Viscosity) {
            let allowed = KernelKind::WITH_GRADIENT.map(KernelKind::name).join(", ");
            return Err(InvalidInput::new(field, "viscosity (a Laplacian only)", allowed).into());
        }
        let support_radius = support_radius_of(scene, spacing)?;
        let on_support = |kind| Kernel::new(kind, support_radius);
        Ok(Self {
            density: on_support(settings.kernel)?,
            pressure: on_support(settings.of_pressure())?,
            viscosity: on_support(settings.of_viscosity())?,
        })
    }

    /// What viscous forces are divided by: of a kernel made for viscosity what it sums in a fluid that is sheared, as that is where it counts.
    pub(super) fn viscous_calibration(&self, spacing: f32) -> f64 {
        match self.viscosity == self.pressure {
            true => self.viscosity.lattice_viscous_sum(spacing),
            false => self.viscosity.sheared_viscous_sum(spacing),
        }
    }

    /// The layer of samples that stands for a wall.
    pub(super) fn wall_layer(&self, spacing: f32) -> Result<WallLayer, SceneError> {
        let layer = WallLayer::of_terms(&self.density, &self.pressure, spacing);
        if self.pressure != self.density && layer.gamma > WallLayer::MOST_GAMMA {
            let allowed = format!(
                "one that falls no faster towards the end of its support than the settings.kernel {}: no layer of samples has both a wall's \
                 density and its push then",
                self.density.kind().name()
            );
            return Err(InvalidInput::new("settings.pressure_kernel", self.pressure.kind().name(), allowed).into());
        }
        Ok(layer)
    }
}

fn support_radius_of(scene: &FluidScene, spacing: f32) -> Result<f32, InvalidInput> {
    let settings = &scene.settings;
    Ok(match settings.support {
        Support::Ratio(ratio) => ratio * spacing,
        Support::Neighbours(count) => {
            support_radius_for_neighbours(spacing, count).map_err(|error| error.inside("settings"))?
        }
    })
}

/// Distance of particles, m.
pub(super) fn spacing_of(scene: &FluidScene) -> f32 {
    match scene.resolution {
        Resolution::Spacing(spacing) => spacing,
        Resolution::Particles(count) => {
            let volume: f32 = scene.volumes.iter().map(Volume::size).sum();
            (volume / count as f32).cbrt()
        }
    }
}
