//! The domain: one fluid, one solver.

use bevy::prelude::*;

use super::settings::{FluidFidelity, FluidSettings};
use super::stats::FluidStats;

/// A fluid and the space it lives in; owns one solver.
///
/// Its [`Transform`] is the frame in which positions are kept (`f32`, so place it near the fluid); it may move and turn,
/// and the fluid moves with it. A scale other than 1 is an error. Every field may change at run time.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component, Clone, Debug, PartialEq)]
#[require(Transform, Visibility, FluidStats)]
pub struct FluidDomain {
    /// Distance of neighbouring particles at rest, m, 1e-4 to 100. Half of it costs sixteen times as much.
    pub spacing: f32,
    /// What simulates.
    pub backend: FluidBackend,
    /// Whether the app waits for the fluid.
    pub mode: FluidMode,
    /// Gravity in world axes, m/s2, each component within 10,000; none takes rapier's, or 9.81 downwards without rapier.
    pub gravity: Option<Vec3>,
    /// Most particles there may ever be, 1 to 64 Mi; none: what the volumes and emitters of the moment need. Particles
    /// beyond are refused and counted in [`FluidStats::refused`].
    pub max_particles: Option<u32>,
    /// Wall time one tick may take, ms, 0.01 to 1e6; past it the fluid slows down ([`FluidStats::time_scale`]). None: no
    /// limit.
    pub budget_milliseconds: Option<f32>,
    /// Most substeps of one tick, 1 to 100,000; what is left of the tick is carried to the next.
    pub max_substeps: u32,
    /// Whether [`FluidStats::leaks`] counts what goes through walls. Each tick then waits for the fluid and reads all particles,
    /// so it is for tests and for finding out which wall is too thin.
    pub count_leaks: bool,
    /// How the fluid is simulated.
    pub settings: FluidSettings,
}

impl FluidDomain {
    /// A domain whose particles are `spacing` metres apart, with every other setting at its default.
    pub fn with_spacing(spacing: f32) -> Self {
        Self {
            spacing,
            backend: FluidBackend::default(),
            mode: FluidMode::default(),
            gravity: None,
            max_particles: None,
            budget_milliseconds: None,
            max_substeps: 10_000,
            count_leaks: false,
            settings: FluidSettings::default(),
        }
    }

    /// The same domain on a backend.
    #[must_use]
    pub fn on(mut self, backend: FluidBackend) -> Self {
        self.backend = backend;
        self
    }

    /// The same domain simulated as accurately as that. Settings that it chooses have to be at their defaults; a full configuration instead of it goes into
    /// [`settings`](Self::settings).
    #[must_use]
    pub fn with_fidelity(mut self, fidelity: FluidFidelity) -> Self {
        self.settings.fidelity = Some(fidelity);
        self
    }

    /// The same domain in a mode.
    #[must_use]
    pub fn in_mode(mut self, mode: FluidMode) -> Self {
        self.mode = mode;
        self
    }
}

/// What simulates a fluid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Default, Clone, Debug, PartialEq)]
pub enum FluidBackend {
    /// The GPU where there is a hardware adapter, otherwise the CPU.
    #[default]
    Auto,
    /// The GPU, even one imitated in software. If it lacks what is needed: the CPU, with a warning that says what.
    Gpu,
    /// All cores of the CPU.
    Cpu,
}

/// Whether the app waits for the fluid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Default, Clone, Debug, PartialEq)]
pub enum FluidMode {
    /// The fluid is computed beside the app, at most three ticks behind; bodies get a forecast, corrected later.
    #[default]
    Pipelined,
    /// Each fixed tick waits for the fluid: results are of the same tick. For servers, tests and lockstep games.
    Lockstep,
}
