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
        Ok(WallLayer::new(&kernel_of(&sampled, spacing)?, spacing))
    }
}

/// The kernel on its support radius.
pub(super) fn kernel_of(scene: &FluidScene, spacing: f32) -> Result<Kernel, SceneError> {
    let settings = &scene.settings;
    if settings.kernel == KernelKind::Viscosity {
        let allowed = KernelKind::WITH_GRADIENT.map(KernelKind::name).join(", ");
        return Err(InvalidInput::new("settings.kernel", "viscosity (a Laplacian only)", allowed).into());
    }
    let support_radius = match settings.support {
        Support::Ratio(ratio) => ratio * spacing,
        Support::Neighbours(count) => {
            support_radius_for_neighbours(spacing, count).map_err(|error| error.inside("settings"))?
        }
    };
    Ok(Kernel::new(settings.kernel, support_radius)?)
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
