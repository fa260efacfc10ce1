//! How a fluid is simulated: the model's settings, as Bevy can reflect them.

use bevy::prelude::*;
use freshet_core::density_form::DensityForm;
use freshet_core::equation_of_state::EquationOfState;
use freshet_core::error::InvalidInput;
use freshet_core::fidelity;
use freshet_core::integrator::Integrator;
use freshet_core::kernel::KernelKind;
use freshet_core::position_based::PositionBased;
use freshet_core::pressure_corrected::{PressureCorrected, PressureGradient};
use freshet_core::pressure_force::PressureForce;
use freshet_core::pressure_poisson::PressurePoisson;
use freshet_core::pressure_solver::{DivergenceFree, PressureSolver};
use freshet_core::relaxation::Relaxation;
use freshet_core::scene::{Settings, Support};
use freshet_core::viscosity::ViscosityModel;

use super::wall_method::FluidWallMethod;

/// How a fluid is simulated. The defaults are those of every chart and benchmark of Freshet.
#[derive(Clone, Debug, PartialEq, Reflect)]
#[reflect(Default, Clone, Debug, PartialEq)]
pub struct FluidSettings {
    /// How accurate the fluid is to be; chooses the other settings that say how it is simulated, which then have to be at their defaults
    /// ([`expected_speed`](Self::expected_speed), [`viscosity_model`](Self::viscosity_model), [`relaxation`](Self::relaxation) and
    /// [`bounds`](Self::bounds) may be set). None: these settings as they are.
    pub fidelity: Option<FluidFidelity>,
    /// Smoothing kernel; not [`FluidKernel::Viscosity`], which has a Laplacian only.
    pub kernel: FluidKernel,
    /// Kernel of pressure forces; none takes [`kernel`](Self::kernel): see [`Settings::pressure_kernel`].
    pub pressure_kernel: Option<FluidKernel>,
    /// Kernel of physical viscosity, [`FluidKernel::Viscosity`] among them; none takes that of pressure forces: see [`Settings::viscosity_kernel`].
    pub viscosity_kernel: Option<FluidKernel>,
    /// Reach of the kernel over the spacing, 1.5 to 4.
    pub support_ratio: f32,
    /// How pressure is found.
    pub pressure_solver: FluidPressureSolver,
    /// Pressure as a function of density; none takes Tait's with the sound speed.
    pub equation_of_state: Option<FluidEquationOfState>,
    /// How densities are found; another way than the default for weakly compressible fluids only.
    pub density: FluidDensityForm,
    /// How pressures become forces; another way than the default for weakly compressible fluids only.
    pub pressure_force: FluidPressureForce,
    /// Whether negative pressures are set to zero, so that fluid does not pull at itself.
    pub clamp_negative_pressure: bool,
    /// Speed of sound, m/s, 1e-3 to 1e5; none takes ten times the expected speed.
    pub sound_speed: Option<f32>,
    /// Largest speed the flow is expected to reach, m/s, 1e-4 to 1e4; none derives it from heights and velocities.
    pub expected_speed: Option<f32>,
    /// Allows a sound speed below ten times the expected speed; [`FluidStats::notes`](super::stats::FluidStats) says so.
    pub allow_compressible: bool,
    /// Monaghan's artificial viscosity alpha, 0 to 1.
    pub artificial_viscosity: f32,
    /// Near pressure over the square of the speed of sound, 0 to 0.1: see [`Settings::near_pressure`].
    pub near_pressure: f32,
    /// Monaghan's epsilon against clumping under tension, 0 to 1: see [`Settings::tensile_correction`].
    pub tensile_correction: f32,
    /// XSPH's epsilon, 0 to 1: see [`Settings::xsph`].
    pub xsph: f32,
    /// Widest support of a particle over the reach of the kernel, 1 to 3; 1 gives all the same: see [`Settings::widest_support`].
    pub widest_support: f32,
    /// Lets particles settle before the start; not with bodies. See [`Settings::relaxation`].
    pub relaxation: Option<FluidRelaxation>,
    /// How the fluid's [`dynamic_viscosity`](super::material::Fluid::dynamic_viscosity) acts, beside the artificial one; none leaves it out.
    pub viscosity_model: Option<FluidViscosityModel>,
    /// How walls act on the fluid; another method than the default for weakly compressible fluids only.
    pub wall_method: FluidWallMethod,
    /// How accelerations become velocities and positions; another way than the default for weakly compressible fluids only, and
    /// [`FluidIntegrator::ForwardEuler`] and [`FluidIntegrator::PositionCorrectedBeeman`] are refused.
    pub integrator: FluidIntegrator,
    /// Substep over `h / (c + v)`, of an incompressible fluid over `d / v`, 0.01 to 1; `h` is half the reach of the kernel.
    pub courant_factor: f32,
    /// Substep over `sqrt(h / a)`, 0.01 to 1; an incompressible fluid does not need it.
    pub force_factor: f32,
    /// Substep over `h^2 / nu`, 0.01 to 1.
    pub viscous_factor: f32,
    /// Whether a substep that turns out too long is made again in shorter ones: see [`Settings::redo_substeps`].
    pub redo_substeps: bool,
    /// Where particles may be, lower and upper corner in the domain's frame, m; those that leave are removed, and volumes must
    /// lie inside. None: four times the size of fluid and walls around them.
    pub bounds: Option<(Vec3, Vec3)>,
}

impl Default for FluidSettings {
    fn default() -> Self {
        Self::from_settings(&Settings::default(), 2.0)
    }
}

impl FluidSettings {
    /// The model's settings, with the reach of the kernel over the spacing, which may have been given otherwise.
    pub(crate) fn from_settings(settings: &Settings, support_ratio: f32) -> Self {
        Self {
            fidelity: settings.fidelity.map(Into::into),
            kernel: settings.kernel.into(),
            pressure_kernel: settings.pressure_kernel.map(Into::into),
            viscosity_kernel: settings.viscosity_kernel.map(Into::into),
            support_ratio,
            pressure_solver: settings.pressure_solver.into(),
            equation_of_state: settings.equation_of_state.map(Into::into),
            density: settings.density.into(),
            pressure_force: settings.pressure_force.into(),
            clamp_negative_pressure: settings.clamp_negative_pressure,
            sound_speed: settings.sound_speed,
            expected_speed: settings.expected_speed,
            allow_compressible: settings.allow_compressible,
            artificial_viscosity: settings.artificial_viscosity,
            near_pressure: settings.near_pressure,
            tensile_correction: settings.tensile_correction,
            xsph: settings.xsph,
            widest_support: settings.widest_support,
            relaxation: settings.relaxation.map(Into::into),
            viscosity_model: settings.viscosity_model.map(Into::into),
            wall_method: settings.wall_method.into(),
            integrator: settings.integrator.into(),
            courant_factor: settings.courant_factor,
            force_factor: settings.force_factor,
            viscous_factor: settings.viscous_factor,
            redo_substeps: settings.redo_substeps,
            bounds: settings.bounds,
        }
    }

    /// The same as the model knows it.
    pub(crate) fn to_settings(&self) -> Settings {
        Settings {
            fidelity: self.fidelity.map(Into::into),
            kernel: self.kernel.into(),
            pressure_kernel: self.pressure_kernel.map(Into::into),
            viscosity_kernel: self.viscosity_kernel.map(Into::into),
            support: Support::Ratio(self.support_ratio),
            pressure_solver: self.pressure_solver.into(),
            equation_of_state: self.equation_of_state.map(Into::into),
            density: self.density.into(),
            pressure_force: self.pressure_force.into(),
            clamp_negative_pressure: self.clamp_negative_pressure,
            sound_speed: self.sound_speed,
            expected_speed: self.expected_speed,
            allow_compressible: self.allow_compressible,
            artificial_viscosity: self.artificial_viscosity,
            near_pressure: self.near_pressure,
            tensile_correction: self.tensile_correction,
            xsph: self.xsph,
            widest_support: self.widest_support,
            relaxation: self.relaxation.map(Into::into),
            viscosity_model: self.viscosity_model.map(Into::into),
            wall_method: self.wall_method.into(),
            integrator: self.integrator.into(),
            courant_factor: self.courant_factor,
            force_factor: self.force_factor,
            viscous_factor: self.viscous_factor,
            redo_substeps: self.redo_substeps,
            bounds: self.bounds,
            ..Settings::default()
        }
    }
}

/// How accurate a fluid is to be. What each chooses was measured: `docs/methods.md` has the chart, and
/// [`FluidStats::notes`](super::stats::FluidStats) say what it is and why.
#[derive(Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Default, Clone, Debug, PartialEq)]
pub enum FluidFidelity {
    /// The cheapest whose error is at most a tenth.
    Fast,
    /// Between both: the smallest product of cost and error.
    #[default]
    Balanced,
    /// The smallest error.
    Accurate,
    /// The cheapest whose error is at most this, a share: 0.05 for 5 %. See [`within`](Self::within).
    Within(f32),
}

impl FluidFidelity {
    /// The cheapest whose error is at most `error`, a share: 0.05 for 5 %.
    ///
    /// # Errors
    /// If no configuration reaches it.
    pub fn within(error: f32) -> Result<Self, InvalidInput> {
        fidelity::FluidFidelity::within(error).map(Into::into)
    }
}

impl From<FluidFidelity> for fidelity::FluidFidelity {
    fn from(fidelity: FluidFidelity) -> Self {
        match fidelity {
            FluidFidelity::Fast => Self::Fast,
            FluidFidelity::Balanced => Self::Balanced,
            FluidFidelity::Accurate => Self::Accurate,
            FluidFidelity::Within(error) => Self::Within(error),
        }
    }
}

impl From<fidelity::FluidFidelity> for FluidFidelity {
    fn from(of: fidelity::FluidFidelity) -> Self {
        match of {
            fidelity::FluidFidelity::Fast => Self::Fast,
            fidelity::FluidFidelity::Balanced => Self::Balanced,
            fidelity::FluidFidelity::Accurate => Self::Accurate,
            fidelity::FluidFidelity::Within(error) => Self::Within(error),
        }
    }
}

/// When particles have settled; what happens stands at [`relaxation`](freshet_core::relaxation).
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Default, Clone, Debug, PartialEq)]
pub struct FluidRelaxation {
    /// They have when the fastest is slower than this share of the expected speed, 1e-6 to 1.
    pub calm: f32,
    /// Most substeps, 1 to 1,000,000.
    pub max_substeps: u32,
    /// Whether they settle under gravity.
    pub under_gravity: bool,
}

impl Default for FluidRelaxation {
    fn default() -> Self {
        Relaxation::default().into()
    }
}

impl From<FluidRelaxation> for Relaxation {
    fn from(FluidRelaxation { calm, max_substeps, under_gravity }: FluidRelaxation) -> Self {
        Self { calm, max_substeps, under_gravity }
    }
}

impl From<Relaxation> for FluidRelaxation {
    fn from(Relaxation { calm, max_substeps, under_gravity }: Relaxation) -> Self {
        Self { calm, max_substeps, under_gravity }
    }
}

/// How a fluid's dynamic viscosity acts; formulas and sources stand at [`ViscosityModel`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Clone, Debug, PartialEq)]
pub enum FluidViscosityModel {
    /// Morris, Fox & Zhu 1997. Fluid sticks to viscous faces of walls.
    Morris1997,
}

impl From<FluidViscosityModel> for ViscosityModel {
    fn from(model: FluidViscosityModel) -> Self {
        match model {
            FluidViscosityModel::Morris1997 => Self::Morris1997,
        }
    }
}

impl From<ViscosityModel> for FluidViscosityModel {
    fn from(model: ViscosityModel) -> Self {
        match model {
            ViscosityModel::Morris1997 => Self::Morris1997,
        }
    }
}

/// How accelerations become velocities and positions; formulas, orders and limits stand at [`Integrator`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Default, Clone, Debug, PartialEq)]
pub enum FluidIntegrator {
    /// Forward Euler, refused: every oscillation grows.
    ForwardEuler,
    /// Semi-implicit Euler.
    #[default]
    SemiImplicitEuler,
    /// Verlet.
    Verlet,
    /// Velocity Verlet.
    VelocityVerlet,
    /// Modified velocity Verlet.
    ModifiedVelocityVerlet,
    /// Leapfrog.
    Leapfrog,
    /// Prediction and relaxation after Clavet, which takes energy.
    Clavet,
    /// Beeman.
    Beeman,
    /// Beeman with corrected velocities.
    VelocityCorrectedBeeman,
    /// Beeman with corrected positions, refused: every oscillation grows.
    PositionCorrectedBeeman,
}

impl From<FluidIntegrator> for Integrator {
    fn from(integrator: FluidIntegrator) -> Self {
        match integrator {
            FluidIntegrator::ForwardEuler => Self::ForwardEuler,
            FluidIntegrator::SemiImplicitEuler => Self::SemiImplicitEuler,
            FluidIntegrator::Verlet => Self::Verlet,
            FluidIntegrator::VelocityVerlet => Self::VelocityVerlet,
            FluidIntegrator::ModifiedVelocityVerlet => Self::ModifiedVelocityVerlet,
            FluidIntegrator::Leapfrog => Self::Leapfrog,
            FluidIntegrator::Clavet => Self::Clavet,
            FluidIntegrator::Beeman => Self::Beeman,
            FluidIntegrator::VelocityCorrectedBeeman => Self::VelocityCorrectedBeeman,
            FluidIntegrator::PositionCorrectedBeeman => Self::PositionCorrectedBeeman,
        }
    }
}

impl From<Integrator> for FluidIntegrator {
    fn from(integrator: Integrator) -> Self {
        match integrator {
            Integrator::ForwardEuler => Self::ForwardEuler,
            Integrator::SemiImplicitEuler => Self::SemiImplicitEuler,
            Integrator::Verlet => Self::Verlet,
            Integrator::VelocityVerlet => Self::VelocityVerlet,
            Integrator::ModifiedVelocityVerlet => Self::ModifiedVelocityVerlet,
            Integrator::Leapfrog => Self::Leapfrog,
            Integrator::Clavet => Self::Clavet,
            Integrator::Beeman => Self::Beeman,
            Integrator::VelocityCorrectedBeeman => Self::VelocityCorrectedBeeman,
            Integrator::PositionCorrectedBeeman => Self::PositionCorrectedBeeman,
        }
    }
}

/// How densities are found; formulas stand at [`density_form`](freshet_core::density_form).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Default, Clone, Debug, PartialEq)]
pub enum FluidDensityForm {
    /// As sums over neighbours.
    #[default]
    Summation,
    /// From the number density: the same, as all particles have one mass.
    Adapted,
    /// Carried by particles and changed by the flow; see [`DensityForm::Continuity`] for what it goes with.
    Continuity,
    /// From a number density that is carried: the same as [`Continuity`](Self::Continuity).
    AdaptedContinuity,
}

impl From<FluidDensityForm> for DensityForm {
    fn from(form: FluidDensityForm) -> Self {
        match form {
            FluidDensityForm::Summation => Self::Summation,
            FluidDensityForm::Adapted => Self::Adapted,
            FluidDensityForm::Continuity => Self::Continuity,
            FluidDensityForm::AdaptedContinuity => Self::AdaptedContinuity,
        }
    }
}

impl From<DensityForm> for FluidDensityForm {
    fn from(form: DensityForm) -> Self {
        match form {
            DensityForm::Summation => Self::Summation,
            DensityForm::Adapted => Self::Adapted,
            DensityForm::Continuity => Self::Continuity,
            DensityForm::AdaptedContinuity => Self::AdaptedContinuity,
        }
    }
}

/// How pressures become forces; formulas stand at [`PressureForce`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Default, Clone, Debug, PartialEq)]
pub enum FluidPressureForce {
    /// Monaghan's.
    #[default]
    Monaghan,
    /// Mueller's; not with supports of different width.
    Mueller,
}

impl From<FluidPressureForce> for PressureForce {
    fn from(force: FluidPressureForce) -> Self {
        match force {
            FluidPressureForce::Monaghan => Self::Monaghan,
            FluidPressureForce::Mueller => Self::Mueller,
        }
    }
}

impl From<PressureForce> for FluidPressureForce {
    fn from(force: PressureForce) -> Self {
        match force {
            PressureForce::Monaghan => Self::Monaghan,
            PressureForce::Mueller => Self::Mueller,
        }
    }
}

/// How a pressure-corrected fluid finds the gradient of its pressures; formulas stand at [`PressureGradient`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Default, Clone, Debug, PartialEq)]
pub enum FluidPressureGradient {
    /// From sums of pairs' pressures.
    #[default]
    Sum,
    /// From their differences.
    Difference,
}

impl From<FluidPressureGradient> for PressureGradient {
    fn from(gradient: FluidPressureGradient) -> Self {
        match gradient {
            FluidPressureGradient::Sum => Self::Sum,
            FluidPressureGradient::Difference => Self::Difference,
        }
    }
}

impl From<PressureGradient> for FluidPressureGradient {
    fn from(gradient: PressureGradient) -> Self {
        match gradient {
            PressureGradient::Sum => Self::Sum,
            PressureGradient::Difference => Self::Difference,
        }
    }
}

/// How pressure is found; methods and sources stand at [`PressureSolver`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Default, Clone, Debug, PartialEq)]
pub enum FluidPressureSolver {
    /// From the density, by an equation of state, in many cheap substeps.
    #[default]
    WeaklyCompressible,
    /// Such that the fluid is not compressed, in few substeps of some iterations: several times as fast, and calmer; with bodies on the CPU
    /// backend only.
    DivergenceFree {
        /// Mean compression with which positions are left as they are, 1e-6 to 0.1.
        compression: f32,
        /// Mean change of density in a substep at which iterations end, 1e-6 to 0.1.
        divergence: f32,
        /// Most iterations of a solve, 2 to 10,000.
        max_iterations: u32,
    },
    /// None: particles are moved apart a fixed number of times in each of few substeps. Without bodies.
    PositionBased {
        /// Iterations of a substep, 1 to 1000: the more, the less the fluid gives in.
        iterations: u32,
        /// See [`PositionBased::softness`], 0 to 10.
        softness: f32,
    },
    /// From what is too dense where particles would be without pressure, a fixed number of times in each of few substeps: as soft as its iterations. Without bodies.
    PressureCorrected {
        /// Iterations of a substep, 1 to 1000.
        iterations: u32,
        /// By which gradient particles are moved.
        gradient: FluidPressureGradient,
    },
    /// From the same by a Poisson equation (MPS), in as many iterations as it takes. Without bodies.
    PressurePoisson {
        /// What iterations leave of what they begin with, 1e-4 to 0.5.
        tolerance: f32,
        /// Most iterations of a substep, 2 to 1000.
        max_iterations: u32,
    },
}

impl FluidPressureSolver {
    /// Divergence-free SPH with the tolerances of Freshet's charts.
    pub fn divergence_free() -> Self {
        PressureSolver::DivergenceFree(DivergenceFree::default()).into()
    }
}

impl From<FluidPressureSolver> for PressureSolver {
    fn from(solver: FluidPressureSolver) -> Self {
        match solver {
            FluidPressureSolver::WeaklyCompressible => Self::WeaklyCompressible,
            FluidPressureSolver::DivergenceFree { compression, divergence, max_iterations } => {
                Self::DivergenceFree(DivergenceFree { compression, divergence, max_iterations })
            }
            FluidPressureSolver::PositionBased { iterations, softness } => {
                Self::PositionBased(PositionBased { iterations, softness })
            }
            FluidPressureSolver::PressurePoisson { tolerance, max_iterations } => {
                Self::PressurePoisson(PressurePoisson { tolerance, max_iterations })
            }
            FluidPressureSolver::PressureCorrected { iterations, gradient } => {
                Self::PressureCorrected(PressureCorrected { iterations, gradient: gradient.into() })
            }
        }
    }
}

impl From<PressureSolver> for FluidPressureSolver {
    fn from(solver: PressureSolver) -> Self {
        match solver {
            PressureSolver::WeaklyCompressible => Self::WeaklyCompressible,
            PressureSolver::DivergenceFree(DivergenceFree { compression, divergence, max_iterations }) => {
                Self::DivergenceFree { compression, divergence, max_iterations }
            }
            PressureSolver::PositionBased(PositionBased { iterations, softness }) => {
                Self::PositionBased { iterations, softness }
            }
            PressureSolver::PressurePoisson(PressurePoisson { tolerance, max_iterations }) => {
                Self::PressurePoisson { tolerance, max_iterations }
            }
            PressureSolver::PressureCorrected(PressureCorrected { iterations, gradient }) => {
                Self::PressureCorrected { iterations, gradient: gradient.into() }
            }
        }
    }
}

/// Smoothing kernels; sources and formulas stand at [`KernelKind`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Default, Clone, Debug, PartialEq)]
pub enum FluidKernel {
    /// Cut and shifted Gaussian.
    Gaussian,
    /// Cubic B-spline.
    CubicSpline,
    /// Quintic B-spline.
    QuinticSpline,
    /// Quadratic.
    Quadratic,
    /// Quartic.
    Quartic,
    /// Wendland C2.
    #[default]
    WendlandC2,
    /// Wendland C6 without the wavelength of a lattice, for a support of 2.3 spacings.
    WendlandNotch,
    /// Poly6.
    Poly6,
    /// Spiky.
    Spiky,
    /// Viscosity kernel.
    Viscosity,
}

impl From<FluidKernel> for KernelKind {
    fn from(kernel: FluidKernel) -> Self {
        match kernel {
            FluidKernel::Gaussian => Self::Gaussian,
            FluidKernel::CubicSpline => Self::CubicSpline,
            FluidKernel::QuinticSpline => Self::QuinticSpline,
            FluidKernel::Quadratic => Self::Quadratic,
            FluidKernel::Quartic => Self::Quartic,
            FluidKernel::WendlandC2 => Self::WendlandC2,
            FluidKernel::WendlandNotch => Self::WendlandNotch,
            FluidKernel::Poly6 => Self::Poly6,
            FluidKernel::Spiky => Self::Spiky,
            FluidKernel::Viscosity => Self::Viscosity,
        }
    }
}

impl From<KernelKind> for FluidKernel {
    fn from(kernel: KernelKind) -> Self {
        match kernel {
            KernelKind::Gaussian => Self::Gaussian,
            KernelKind::CubicSpline => Self::CubicSpline,
            KernelKind::QuinticSpline => Self::QuinticSpline,
            KernelKind::Quadratic => Self::Quadratic,
            KernelKind::Quartic => Self::Quartic,
            KernelKind::WendlandC2 => Self::WendlandC2,
            KernelKind::WendlandNotch => Self::WendlandNotch,
            KernelKind::Poly6 => Self::Poly6,
            KernelKind::Spiky => Self::Spiky,
            KernelKind::Viscosity => Self::Viscosity,
        }
    }
}

/// Pressure as a function of density; formulas and ranges stand at [`EquationOfState`].
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Clone, Debug, PartialEq)]
pub enum FluidEquationOfState {
    /// Ideal gas.
    IdealGas {
        /// m2/s2.
        stiffness: f32,
    },
    /// Desbrun and Gascuel.
    Desbrun {
        /// m2/s2.
        stiffness: f32,
    },
    /// Harada.
    Harada {
        /// Pa.
        reference_pressure: f32,
        /// m2/s2.
        stiffness: f32,
    },
    /// Tait.
    Tait {
        /// m/s.
        sound_speed: f32,
        /// No unit.
        exponent: f32,
    },
    /// Linear.
    Linear {
        /// m/s.
        sound_speed: f32,
    },
}

impl From<FluidEquationOfState> for EquationOfState {
    fn from(equation: FluidEquationOfState) -> Self {
        match equation {
            FluidEquationOfState::IdealGas { stiffness } => Self::IdealGas { stiffness },
            FluidEquationOfState::Desbrun { stiffness } => Self::Desbrun { stiffness },
            FluidEquationOfState::Harada { reference_pressure, stiffness } => {
                Self::Harada { reference_pressure, stiffness }
            }
            FluidEquationOfState::Tait { sound_speed, exponent } => Self::Tait { sound_speed, exponent },
            FluidEquationOfState::Linear { sound_speed } => Self::Linear { sound_speed },
        }
    }
}

impl From<EquationOfState> for FluidEquationOfState {
    fn from(equation: EquationOfState) -> Self {
        match equation {
            EquationOfState::IdealGas { stiffness } => Self::IdealGas { stiffness },
            EquationOfState::Desbrun { stiffness } => Self::Desbrun { stiffness },
            EquationOfState::Harada { reference_pressure, stiffness } => Self::Harada { reference_pressure, stiffness },
            EquationOfState::Tait { sound_speed, exponent } => Self::Tait { sound_speed, exponent },
            EquationOfState::Linear { sound_speed } => Self::Linear { sound_speed },
        }
    }
}
