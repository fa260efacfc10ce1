//! One run with one step length.

use freshet_core::density_form::DensityForm;
use freshet_core::equation_of_state::EquationOfState;
use freshet_core::field::Field;
use freshet_core::integrator::Integrator;
use freshet_core::kernel::KernelKind;
use freshet_core::plan::{Parameters, Plan, SceneError};
use freshet_core::scene::{Boundary, FluidScene, Support, Volume};
use freshet_core::step::StepReport;
use freshet_core::viscosity::ViscosityModel;
use glam::Vec3;

use crate::backend::Backend;
use crate::drive::Drive;
use crate::error::LabError;
use crate::measure::containment::escaped;
use crate::measure::spacing::nearest_distances;
use crate::method::Method;

/// What is asked of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Situation {
    /// A dam break against the far wall.
    Violent,
    /// A tall column at rest.
    Calm,
}

impl Situation {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Violent, Self::Calm];

    /// Name, as in files and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Violent => "dam break",
            Self::Calm => "column",
        }
    }

    /// Simulated time, s: the front is at the far wall after 0.4 s; waves cross the column a hundred times.
    fn seconds(self) -> f64 {
        match self {
            Self::Violent => 0.8,
            Self::Calm => 1.0,
        }
    }

    /// Inner size of the container, whose lowest corner is the origin, m.
    fn container(self) -> Vec3 {
        match self {
            Self::Violent => Vec3::new(1.2, 1.5, 0.5),
            Self::Calm => Vec3::new(0.15, 0.75, 0.15),
        }
    }

    fn scene(self) -> FluidScene {
        let (block, spacing) = match self {
            Self::Violent => (Vec3::splat(0.5), 0.05),
            Self::Calm => (Vec3::new(0.15, 0.5, 0.15), 0.025),
        };
        let container = self.container();
        FluidScene {
            name: self.name().to_owned(),
            volumes: vec![Volume::block(block / 2.0, block / 2.0)],
            boundaries: vec![Boundary::open_box(container, container / 2.0)],
            ..FluidScene::with_spacing(spacing)
        }
    }
}

/// What of a solver is not the plan's default.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolverOption {
    /// Nothing: Tait's equation, clamped, and Monaghan's artificial viscosity.
    Tait,
    /// A linear equation of state, clamped.
    Linear,
    /// Tait's with its tension.
    Tension,
    /// The same with a near pressure of 0.01 c2 rho against clumping.
    NearPressure,
    /// The same with Monaghan's correction in place of the near pressure ([`tensile_correction`](freshet_core::tensile_correction)), 0.2.
    TensileCorrection,
    /// Morris' viscosity in place of Monaghan's, as large as that acts: `nu = alpha c h / 10` (Monaghan 2005, eq. 8.8).
    Morris,
    /// Particles that move with half of the mean velocity around them ([`xsph`](freshet_core::xsph)).
    Xsph,
    /// Supports that widen to 1.5 times where the fluid is thin ([`variable_support`](freshet_core::variable_support)).
    VariableSupport,
    /// Densities that particles carry ([`density_form`](freshet_core::density_form)).
    Continuity,
    /// Particles moved apart, with the default number of iterations, tried on the CPU only. Its number is that of [`DivergenceFree`](Self::DivergenceFree), without a limit of pressure.
    PositionBased,
    /// Pressures corrected by what velocities compress ([`pressure_corrected`](freshet_core::pressure_corrected)), the same.
    PressureCorrected,
    /// Pressures by a Poisson equation ([`pressure_poisson`](freshet_core::pressure_poisson)), the same.
    Poisson,
    /// Divergence-free SPH with its default tolerances, tried on the CPU only. Its number is the way of the fastest particle in a
    /// step over the spacing, `v dt / d`; steps are limited by the pressure, too, as in every plan: in water at rest nothing goes any
    /// way.
    DivergenceFree,
}

impl SolverOption {
    /// All of them, the plan's default first. [`redo_substeps`](freshet_core::scene::Settings::redo_substeps) is none of them: it
    /// shortens the very step whose length is asked for.
    pub const ALL: [Self; 13] = [
        Self::Tait,
        Self::Linear,
        Self::Tension,
        Self::NearPressure,
        Self::TensileCorrection,
        Self::Morris,
        Self::Xsph,
        Self::VariableSupport,
        Self::Continuity,
        Self::PositionBased,
        Self::PressureCorrected,
        Self::Poisson,
        Self::DivergenceFree,
    ];

    /// Name, as in files and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tait => "Tait",
            Self::Linear => "linear",
            Self::Tension => "unclamped",
            Self::NearPressure => "near pressure",
            Self::TensileCorrection => "tensile correction",
            Self::Morris => "Morris viscosity",
            Self::Xsph => "XSPH",
            Self::VariableSupport => "variable support",
            Self::Continuity => "continuity",
            Self::PositionBased => "position-based",
            Self::PressureCorrected => "pressure-corrected",
            Self::Poisson => "poisson",
            Self::DivergenceFree => "DFSPH",
        }
    }

    /// Name on the command line.
    pub fn argument(self) -> String {
        self.name().replace(' ', "-").to_lowercase()
    }

    /// Whether a speed of sound plays any part.
    pub fn has_sound(self) -> bool {
        !matches!(self, Self::DivergenceFree | Self::PositionBased | Self::PressureCorrected | Self::Poisson)
    }
}

/// What is tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Configuration {
    /// Where.
    pub backend: Backend,
    /// Equation of state.
    pub option: SolverOption,
    /// Kernel.
    pub kernel: KernelKind,
    /// Mean number of neighbours.
    pub neighbours: f32,
    /// Speed of sound over the largest speed expected; [`SOUND`](Self::SOUND) where it plays no part.
    pub sound: f32,
    /// Scene.
    pub situation: Situation,
}

impl Configuration {
    /// The plan's own speed of sound over the largest speed expected.
    pub const SOUND: f32 = 10.0;

    /// What the plan takes when nothing is said: Tait's equation, Wendland's kernel, H = 2 d (32 to 33 neighbours), c = 10 v.
    pub fn of_defaults(backend: Backend, situation: Situation) -> Self {
        let (option, kernel) = (SolverOption::Tait, KernelKind::WendlandC2);
        Self { backend, option, kernel, neighbours: 32.0, sound: Self::SOUND, situation }
    }

    /// Whether it is one of these, by either way to find pressures.
    pub fn is_default(&self) -> bool {
        let tait = Self::of_defaults(self.backend, self.situation);
        *self == tait || *self == Self { option: SolverOption::DivergenceFree, ..tait }
    }

    /// Its place among all.
    pub fn place(&self) -> (bool, usize, u32, usize, bool, u32) {
        let kernel = KernelKind::WITH_GRADIENT.iter().position(|kernel| *kernel == self.kernel);
        let option = SolverOption::ALL.iter().position(|option| *option == self.option);
        let calm = self.situation == Situation::Calm;
        (
            self.backend == Backend::Gpu,
            kernel.unwrap_or_default(),
            self.neighbours as u32,
            option.unwrap_or_default(),
            calm,
            self.sound as u32,
        )
    }

    fn plan(&self, integrator: Integrator) -> Result<Plan, SceneError> {
        let mut scene = self.situation.scene();
        scene.settings.integrator = integrator;
        let speed = Plan::new(&scene)?.parameters.expected_speed;
        scene.settings.kernel = self.kernel;
        scene.settings.support = Support::Neighbours(self.neighbours);
        scene.settings.expected_speed = Some(speed);
        scene.settings.allow_compressible = self.sound < 10.0;
        let sound_speed = self.sound * speed;
        match self.option {
            SolverOption::Linear => scene.settings.equation_of_state = Some(EquationOfState::Linear { sound_speed }),
            _ => scene.settings.sound_speed = Some(sound_speed),
        }
        scene.settings.clamp_negative_pressure = !matches!(
            self.option,
            SolverOption::Tension | SolverOption::NearPressure | SolverOption::TensileCorrection
        );
        match self.option {
            SolverOption::NearPressure => scene.settings.near_pressure = 0.01,
            SolverOption::TensileCorrection => scene.settings.tensile_correction = 0.2,
            SolverOption::Xsph => scene.settings.xsph = 0.5,
            SolverOption::Continuity => scene.settings.density = DensityForm::Continuity,
            SolverOption::VariableSupport => scene.settings.widest_support = 1.5,
            _ => {}
        }
        match self.option {
            SolverOption::DivergenceFree => scene = Method::DivergenceFree.on(scene),
            SolverOption::PositionBased => scene = Method::PositionBased.on(scene),
            SolverOption::PressureCorrected => scene = Method::PressureCorrected.on(scene),
            SolverOption::Poisson => scene = Method::Poisson.on(scene),
            _ => {}
        }
        if self.option == SolverOption::Morris {
            let Parameters { artificial_viscosity, smoothing_length, rest_density, .. } = Plan::new(&scene)?.parameters;
            scene.material.dynamic_viscosity =
                rest_density * artificial_viscosity * sound_speed * smoothing_length / 10.0;
            scene.settings.artificial_viscosity = 0.0;
            scene.settings.viscosity_model = Some(ViscosityModel::Morris1997);
        }
        Plan::new(&scene)
    }
}

impl std::fmt::Display for Configuration {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { backend, option, kernel, neighbours, sound, situation } = self;
        write!(f, "{}, {}, {}, {neighbours} neighbours, ", situation.name(), option.name(), kernel.name())?;
        if option.has_sound() {
            write!(f, "c = {sound} v, ")?;
        }
        write!(f, "{backend}")
    }
}

/// How a run failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// A number that is not finite, of a particle that the solver removed for it or of a report.
    NotFinite,
    /// A particle lost: it went through a wall.
    Lost,
    /// Kinetic energy and energy of height above 1.05 of the start.
    Energy,
    /// Mean compression above 5 % in a substep.
    Compression,
    /// One particle in a hundred has another nearer than 0.3 d.
    Crowded,
}

impl Failure {
    /// All of them, in the order of the map's legend.
    pub const ALL: [Self; 5] = [Self::NotFinite, Self::Lost, Self::Energy, Self::Compression, Self::Crowded];

    /// Letter in the map.
    pub fn letter(self) -> &'static str {
        match self {
            Self::NotFinite => "N",
            Self::Lost => "L",
            Self::Energy => "E",
            Self::Compression => "C",
            Self::Crowded => "P",
        }
    }

    /// What the letter stands for.
    pub fn name(self) -> &'static str {
        match self {
            Self::NotFinite => "not finite",
            Self::Lost => "particle lost",
            Self::Energy => "energy",
            Self::Compression => "compression",
            Self::Crowded => "pairs too near",
        }
    }
}

/// Duration of a tick, s. Its substeps are of equal length, shorter than the limit by up to one part in their number: long, so
/// that this is a hundredth.
const TICK: f64 = 0.1;

/// Simulates with steps of `number` times `h / (c + v)` and no other limit (of [`SolverOption::DivergenceFree`]: see there); says how
/// it failed if it did.
pub fn survives(configuration: &Configuration, number: f64) -> Result<Option<Failure>, LabError> {
    survives_by(Integrator::default(), configuration, number)
}

/// The same with another integrator.
pub fn survives_by(
    integrator: Integrator,
    configuration: &Configuration,
    number: f64,
) -> Result<Option<Failure>, LabError> {
    let mut plan = configuration.plan(integrator)?;
    let parameters = &mut plan.parameters;
    parameters.courant_factor = number as f32;
    parameters.force_factor = 1e6;
    parameters.viscous_factor = 1e6;
    let (gravity, spacing) = (f64::from(-parameters.gravity.y), parameters.spacing);
    let particles = plan.positions.len();
    let start = energy(gravity, &plan.positions, &plan.velocities);
    let mut drive = Drive::open(configuration.backend, plan, Some(1), Vec::new())?;
    let ticks = (configuration.situation.seconds() / TICK).round() as u32;
    for _ in 0..ticks {
        let report = drive.tick(TICK)?;
        if let Some(failure) = failure(&report, particles) {
            return Ok(Some(failure));
        }
        let (positions, velocities) = (drive.positions()?, drive.vectors(Field::Velocity)?);
        // Not-a-number is not at most anything.
        let now = energy(gravity, &positions, &velocities);
        if !now.is_finite() {
            return Ok(Some(Failure::NotFinite));
        }
        if now > 1.05 * start {
            return Ok(Some(Failure::Energy));
        }
        if escaped(&positions, Vec3::ZERO, configuration.situation.container()) > 0 {
            return Ok(Some(Failure::Lost));
        }
        let near = nearest_distances(&positions, spacing).into_iter().filter(|&nearest| nearest < 0.3 * spacing);
        if near.count() * 100 > particles {
            return Ok(Some(Failure::Crowded));
        }
    }
    Ok(None)
}

fn failure(report: &StepReport, particles: usize) -> Option<Failure> {
    if report.not_finite > 0 || !report.max_speed.is_finite() || !report.mean_compression.is_finite() {
        Some(Failure::NotFinite)
    } else if report.removed > 0 || report.particles as usize != particles {
        Some(Failure::Lost)
    } else if report.mean_compression > 0.05 {
        Some(Failure::Compression)
    } else {
        None
    }
}

/// Kinetic energy and energy of height above y = 0, over the mass of a particle, m2/s2.
fn energy(gravity: f64, positions: &[Vec3], velocities: &[Vec3]) -> f64 {
    positions
        .iter()
        .zip(velocities)
        .map(|(position, velocity)| 0.5 * velocity.as_dvec3().length_squared() + gravity * f64::from(position.y))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_finite_is_told_from_what_is_lost() {
        let report = StepReport { particles: 98, removed: 2, ..StepReport::default() };
        assert_eq!(failure(&report, 100), Some(Failure::Lost));
        assert_eq!(failure(&StepReport { not_finite: 1, ..report.clone() }, 100), Some(Failure::NotFinite));
        assert_eq!(failure(&StepReport { max_speed: f32::NAN, ..report.clone() }, 100), Some(Failure::NotFinite));
        assert_eq!(failure(&StepReport { removed: 0, ..report }, 98), None);
    }
}
