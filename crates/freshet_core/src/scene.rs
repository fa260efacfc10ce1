//! The scene: plain data that says what is simulated and how accurately. [`Plan::new`](crate::plan::Plan::new) turns
//! it into what is executed.

mod boundary;
mod friction;

use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};

pub(crate) use self::boundary::side_of;
pub use self::boundary::{Boundary, BoundaryShape, FluidSide};
pub use self::friction::Friction;

use crate::density_form::DensityForm;
use crate::emitter::Emitter;
use crate::equation_of_state::EquationOfState;
use crate::error::{InvalidInput, check_finite, check_range};
use crate::fidelity::FluidFidelity;
use crate::integrator::Integrator;
use crate::kernel::KernelKind;
use crate::material::Material;
use crate::periodic::Periodic;
use crate::plan::sample_boundary;
use crate::pressure_force::PressureForce;
use crate::pressure_solver::PressureSolver;
use crate::relaxation::Relaxation;
use crate::sampling::wall_layer::WallLayer;
use crate::solid::Solid;
use crate::variable_support;
use crate::viscosity::ViscosityModel;
use crate::wall_method::WallMethod;

/// A fluid, what holds it, what floats in it, and how it is to be simulated. SI units throughout.
///
/// ```
/// use freshet_core::prelude::*;
/// let scene = FluidScene {
///     volumes: vec![Volume::block(Vec3::splat(0.5), Vec3::splat(0.5))],
///     boundaries: vec![Boundary::open_box(Vec3::new(2.0, 1.5, 1.0), Vec3::new(1.0, 0.75, 0.5))],
///     ..FluidScene::with_spacing(0.1)
/// };
/// println!("{}", Plan::new(&scene)?);
/// # Ok::<(), SceneError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "FluidScene")]
pub struct FluidScene {
    /// Name, for reports.
    #[serde(default)]
    pub name: String,
    /// How fine the fluid is sampled.
    pub resolution: Resolution,
    /// Gravity, m/s2; each component within 10,000.
    #[serde(default = "standard_gravity")]
    pub gravity: Vec3,
    /// What the fluid is.
    #[serde(default = "Material::water")]
    pub material: Material,
    /// Where the fluid starts, at most [`MAX_OBJECTS`] volumes, which must not overlap. What of them is in a wall or a body is
    /// left out and counted: see [`solid`](crate::solid).
    #[serde(default)]
    pub volumes: Vec<Volume>,
    /// Where fluid flows in, at most [`MAX_OBJECTS`].
    #[serde(default)]
    pub emitters: Vec<Emitter>,
    /// What holds the fluid and does not move, at most [`MAX_OBJECTS`].
    #[serde(default)]
    pub boundaries: Vec<Boundary>,
    /// What the fluid pushes and is pushed by, at most [`MAX_OBJECTS`].
    #[serde(default)]
    pub bodies: Vec<Body>,
    /// Where the domain repeats itself; nowhere by default.
    #[serde(default)]
    pub periodic: Periodic,
    /// How it is simulated.
    #[serde(default)]
    pub settings: Settings,
}

fn standard_gravity() -> Vec3 {
    Vec3::new(0.0, -9.81, 0.0)
}

impl FluidScene {
    /// An empty scene of water under standard gravity with particles `spacing` metres apart.
    pub fn with_spacing(spacing: f32) -> Self {
        Self {
            name: String::new(),
            resolution: Resolution::Spacing(spacing),
            gravity: standard_gravity(),
            material: Material::water(),
            volumes: Vec::new(),
            emitters: Vec::new(),
            boundaries: Vec::new(),
            bodies: Vec::new(),
            periodic: Periodic::default(),
            settings: Settings::default(),
        }
    }
}

/// How fine the fluid is sampled (P §4.1.4).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Resolution {
    /// Distance of neighbouring particles at rest, m, 1e-4 to 100.
    Spacing(f32),
    /// About this many particles share the volumes, 1 to 64 Mi; the spacing follows.
    Particles(u32),
}

/// A solid shape about its own centre.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Shape {
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
}

impl Shape {
    /// Whether a point relative to the centre, in the shape's own axes, is more than `tolerance` metres below the surface.
    pub(crate) fn contains(&self, local: Vec3, tolerance: f32) -> bool {
        match *self {
            Shape::Box { half_extents } => local.abs().cmplt(half_extents - tolerance).all(),
            Shape::Sphere { radius } => local.length() < radius - tolerance,
        }
    }

    /// Distance of such a point from the surface, m, negative inside, and the direction away from it.
    pub(crate) fn distance(&self, local: Vec3) -> (f32, Vec3) {
        match *self {
            Shape::Box { half_extents } => {
                let beyond = local.abs() - half_extents;
                let outside = beyond.max(Vec3::ZERO);
                let normal =
                    if outside == Vec3::ZERO { Vec3::AXES[beyond.max_position()] } else { outside.normalize() };
                (outside.length() + beyond.max_element().min(0.0), normal * local.signum())
            }
            Shape::Sphere { radius } => (local.length() - radius, local.normalize_or(Vec3::Y)),
        }
    }

    pub(crate) fn validate(&self) -> Result<(), InvalidInput> {
        match *self {
            Shape::Box { half_extents } => check_half_extents(half_extents).map_err(|error| error.inside("shape")),
            Shape::Sphere { radius } => check_range("shape.radius", radius, 1e-5, REACH, "m"),
        }
    }
}

/// Fluid at the start, on a cubic lattice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Volume {
    /// Its shape.
    pub shape: Shape,
    /// Centre of the shape, m.
    pub center: Vec3,
    /// Orientation of shape and lattice.
    #[serde(default)]
    pub rotation: Quat,
    /// Velocity at the start, m/s.
    #[serde(default)]
    pub velocity: Vec3,
    /// Whether its particles start as dense as water standing in it would be: closer together with depth, by 0.1 % and less.
    /// Without, a column starts with a bounce that rings for seconds.
    /// An incompressible fluid starts under the pressure of standing water instead.
    #[serde(default = "yes")]
    pub hydrostatic: bool,
}

fn yes() -> bool {
    true
}

impl Volume {
    /// A block of fluid at rest.
    pub fn block(half_extents: Vec3, center: Vec3) -> Self {
        let shape = Shape::Box { half_extents };
        Self { shape, center, rotation: Quat::IDENTITY, velocity: Vec3::ZERO, hydrostatic: true }
    }

    /// A ball of fluid at rest.
    pub fn ball(radius: f32, center: Vec3) -> Self {
        let shape = Shape::Sphere { radius };
        Self { shape, center, rotation: Quat::IDENTITY, velocity: Vec3::ZERO, hydrostatic: true }
    }

    /// m3.
    pub fn size(&self) -> f32 {
        match self.shape {
            Shape::Box { half_extents } => 8.0 * half_extents.x * half_extents.y * half_extents.z,
            Shape::Sphere { radius } => 4.0 / 3.0 * std::f32::consts::PI * radius.powi(3),
        }
    }
}

/// A rigid body as the fluid sees it: samples of its surface that move with it.
///
/// `freshet_rapier` makes these from rapier's shapes. Mass and inertia come with each tick's
/// [`BodyInput`](crate::step::BodyInput), so that they may change.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// Name, for reports.
    #[serde(default)]
    pub name: String,
    /// Surface samples relative to the centre of mass, m, at the depth of the scene's
    /// [`WallLayer`](crate::sampling::wall_layer::WallLayer) inside the visible surface.
    pub samples: Vec<Vec3>,
    /// The closed shapes it consists of, relative to the centre of mass, at most [`MAX_OBJECTS`]: particles that would start with
    /// their centre inside are left out and counted ([`StepReport::inside_solids`](crate::step::StepReport::inside_solids)).
    /// Without, samples do not tell inside from outside, and what starts there is simulated.
    #[serde(default)]
    pub solids: Vec<Solid>,
    /// Whether it is wholly there at once, wherever it comes, as a wall that moves is, and throws off what it finds. Others
    /// [swell](crate::swelling) and push it out.
    #[serde(default)]
    pub at_once: bool,
    /// What its samples are.
    #[serde(default)]
    pub sampling: BodySampling,
    /// Coulomb's friction, on all of its surface, none by default; of a body that the fluid does not move: see
    /// [`Plan::check_input`](crate::plan::Plan::check_input).
    #[serde(default)]
    pub friction: Friction,
}

/// What the samples of a body are to the fluid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum BodySampling {
    /// One layer that stands for all of the body, with weights for that (Akinci et al. 2012); see
    /// [`WallLayer`](crate::sampling::wall_layer::WallLayer).
    #[default]
    SingleLayer,
    /// Three layers, each of the fluid's own spacing and volume, with densities and pressures of their own; see
    /// [`quasi_fluid`](crate::sampling::quasi_fluid) and [`Body::quasi_fluid`]. Weakly compressible fluids of one width of support only, without
    /// a viscosity model.
    QuasiFluid {
        /// How many of the samples are in the first, second and third layer, in their order.
        layers: [u32; 3],
    },
}

impl BodySampling {
    /// Name, as in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::SingleLayer => "single layer",
            Self::QuasiFluid { .. } => "quasi-fluid",
        }
    }
}

/// How wide the kernels reach (P §4.1.4, eq. 4.1).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Support {
    /// Support radius over spacing, 1.5 to 4.
    Ratio(f32),
    /// Mean number of neighbours, 14 to 270; the radius follows.
    Neighbours(f32),
}

/// How the scene is simulated. The defaults are the ones every chart and benchmark uses.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// How accurate the fluid is to be; chooses the other settings that say how it is simulated, which then have to be at their defaults. None: these
    /// settings as they are.
    pub fidelity: Option<FluidFidelity>,
    /// Smoothing kernel: of densities, and of every term that has none of its own.
    pub kernel: KernelKind,
    /// Kernel of pressure forces, on the same support (Mueller, Charypar & Gross 2003; P §4.2.3); none takes [`kernel`](Self::kernel). Artificial viscosity, friction and
    /// what walls and bodies take of a viscous fluid go with it. Weakly compressible fluids with a summed density, walls of volume weights and one width of support.
    /// Forces and densities then do not follow from one energy: a fluid may gain or lose some where one kernel would keep it.
    pub pressure_kernel: Option<KernelKind>,
    /// Kernel of [physical viscosity](Self::viscosity_model) between particles, likewise; [`KernelKind::Viscosity`] is made for it. None takes that of pressure.
    /// Any solver; not with ghost particles, nor with supports of more than one width.
    pub viscosity_kernel: Option<KernelKind>,
    /// Reach of the kernel.
    pub support: Support,
    /// How pressure is found.
    pub pressure_solver: PressureSolver,
    /// Pressure as a function of density, with its own speed of sound; none takes Tait's with [`sound_speed`](Self::sound_speed).
    pub equation_of_state: Option<EquationOfState>,
    /// How densities are found; of weakly compressible fluids. See [`density_form`](crate::density_form).
    pub density: DensityForm,
    /// How pressures become forces; of weakly compressible fluids. See [`pressure_force`](crate::pressure_force).
    pub pressure_force: PressureForce,
    /// Whether negative pressures are set to zero (E eq. 9), so that fluid does not pull at itself.
    pub clamp_negative_pressure: bool,
    /// Speed of sound, m/s, 1e-3 to 1e4; none takes ten times the expected speed. Not together with an equation of state.
    pub sound_speed: Option<f32>,
    /// Largest speed the flow is expected to reach, m/s, 1e-4 to 1e4; none derives it from heights, velocities and emitters.
    pub expected_speed: Option<f32>,
    /// Allows a sound speed below ten times the expected speed; plan and statistics then say so.
    pub allow_compressible: bool,
    /// Monaghan's artificial viscosity alpha, 0 to 1; zero takes it out of the plan.
    pub artificial_viscosity: f32,
    /// Near pressure over the square of the speed of sound, 0 to 0.1; zero takes it out of the plan. It keeps particles of a fluid
    /// under tension, of negative pressures that are not [clamped](Self::clamp_negative_pressure), from clumping: 0.01 does, more
    /// than that loosens the fluid. See [`near_pressure`](crate::near_pressure).
    pub near_pressure: f32,
    /// Monaghan's epsilon against clumping under tension, 0 to 1; zero takes it out of the plan, his own is 0.2. Weakly compressible fluids of one width of support. See
    /// [`tensile_correction`](crate::tensile_correction).
    pub tensile_correction: f32,
    /// XSPH's epsilon, 0 to 1; zero takes it out of the plan. Particles move with a share of the mean velocity around them, which keeps
    /// streams that meet from passing through each other; velocities stay as they are. See [`xsph`](crate::xsph).
    pub xsph: f32,
    /// The widest support that a particle may have over the support radius, 1 to 3; 1 gives all the same and takes it out of the plan.
    /// With more a particle's support grows with `(rho0/rho)^(1/3)`, so that a fluid that thins out, to an eighth with 2, keeps its
    /// neighbours. It takes the more time the wider it may be. Weakly compressible fluids only. See
    /// [`variable_support`](crate::variable_support).
    pub widest_support: f32,
    /// Lets particles settle before the start; none starts as volumes are sampled. Not with bodies, whose places are not known then, nor with
    /// solvers that move particles apart (position-based, pressure-corrected, pressure Poisson) or walls that are not in the sums.
    pub relaxation: Option<Relaxation>,
    /// How the material's dynamic viscosity acts; none leaves it out of the plan.
    pub viscosity_model: Option<ViscosityModel>,
    /// How walls act on the fluid; another method than the default for weakly compressible fluids only. See [`wall_method`](crate::wall_method).
    pub wall_method: WallMethod,
    /// How accelerations become velocities and positions. Weakly compressible fluids choose; all others have a way of their own, and take the default only. Forward Euler and
    /// the position-corrected Beeman are refused: under them every oscillation grows, as `freshet_lab integrators` shows.
    pub integrator: Integrator,
    /// Substep over `h / (c + v)`, or, of an incompressible fluid, over `d / v`: 0.01 to 1.
    pub courant_factor: f32,
    /// Substep over `sqrt(h / a)`, 0.01 to 1; an incompressible fluid does not need it.
    pub force_factor: f32,
    /// Substep over `h^2 / nu`, 0.01 to 1.
    pub viscous_factor: f32,
    /// Whether a substep that turns out too long is taken back and made again in shorter ones (Pirovano 2011, §2.3.5): see
    /// [`Parameters::redone`](crate::plan::Parameters::redone).
    pub redo_substeps: bool,
    /// Most substeps in one tick, 1 to 100,000; what is left of the tick is carried to the next.
    pub max_substeps: u32,
    /// Wall time a tick may take, ms; past it simulated time slows down. None: no limit.
    pub budget_milliseconds: Option<f32>,
    /// Most particles there may ever be, 1 to 64 Mi; none: the start's, plus what the emitters can have alive.
    pub max_particles: Option<u32>,
    /// Where particles may be: lower and upper corner, m; those that leave are removed, and none may start outside. None: four
    /// times the scene's size around it.
    pub bounds: Option<(Vec3, Vec3)>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            fidelity: None,
            kernel: KernelKind::WendlandC2,
            pressure_kernel: None,
            viscosity_kernel: None,
            support: Support::Ratio(2.0),
            pressure_solver: PressureSolver::WeaklyCompressible,
            equation_of_state: None,
            density: DensityForm::default(),
            pressure_force: PressureForce::default(),
            clamp_negative_pressure: true,
            sound_speed: None,
            expected_speed: None,
            allow_compressible: false,
            artificial_viscosity: 0.03,
            near_pressure: 0.0,
            tensile_correction: 0.0,
            xsph: 0.0,
            widest_support: 1.0,
            relaxation: None,
            viscosity_model: None,
            wall_method: WallMethod::default(),
            integrator: Integrator::default(),
            courant_factor: 0.4,
            force_factor: 0.25,
            viscous_factor: 0.125,
            redo_substeps: false,
            max_substeps: 10_000,
            budget_milliseconds: None,
            max_particles: None,
            bounds: None,
        }
    }
}

/// Smallest distance of neighbouring particles, m.
pub const MIN_SPACING: f32 = 1e-4;
/// Largest distance of neighbouring particles, m.
pub const MAX_SPACING: f32 = 100.0;
/// Most particles or samples of one scene.
pub const MAX_PARTICLES: u32 = 64 << 20;
/// Most volumes of one scene, and most emitters, boundaries and bodies: of each kind this many.
pub const MAX_OBJECTS: usize = 10_000;

impl Settings {
    /// Refuses what needs pressures that follow from densities where they do not.
    fn check_pressure_solver(&self) -> Result<(), InvalidInput> {
        match &self.pressure_solver {
            PressureSolver::WeaklyCompressible => return Ok(()),
            PressureSolver::DivergenceFree(solver) => solver.validate(),
            PressureSolver::PositionBased(solver) => solver.validate(),
            PressureSolver::PressureCorrected(solver) => solver.validate(),
            PressureSolver::PressurePoisson(solver) => solver.validate(),
        }
        .map_err(|error| error.inside("pressure_solver"))?;
        if self.pressure_solver.moves_apart() {
            let with = format!("with the {} settings.pressure_solver", self.pressure_solver.name());
            if self.redo_substeps {
                return Err(InvalidInput::new("redo_substeps", true, format_args!("false, {with}")));
            }
            if self.xsph > 0.0 {
                return Err(InvalidInput::new("xsph", self.xsph, format_args!("0, {with}")));
            }
            if self.relaxation.is_some() {
                return Err(InvalidInput::new("relaxation", "Some", format_args!("none, {with}")));
            }
        }
        let allowed = "with the weakly compressible settings.pressure_solver only";
        if let Some(equation) = &self.equation_of_state {
            return Err(InvalidInput::new("equation_of_state", equation.name(), allowed));
        }
        if !self.clamp_negative_pressure {
            return Err(InvalidInput::new("clamp_negative_pressure", false, allowed));
        }
        if self.near_pressure > 0.0 {
            return Err(InvalidInput::new("near_pressure", self.near_pressure, allowed));
        }
        if self.tensile_correction > 0.0 {
            return Err(InvalidInput::new("tensile_correction", self.tensile_correction, allowed));
        }
        if self.widest_support != 1.0 {
            return Err(InvalidInput::new("widest_support", self.widest_support, allowed));
        }
        if self.integrator != Integrator::default() {
            return Err(InvalidInput::new("integrator", self.integrator.name(), allowed));
        }
        if self.pressure_force != PressureForce::default() {
            return Err(InvalidInput::new("pressure_force", self.pressure_force.name(), allowed));
        }
        if self.density.is_carried() {
            return Err(InvalidInput::new("density", self.density.name(), allowed));
        }
        if let Some(kernel) = self.pressure_kernel {
            return Err(InvalidInput::new("pressure_kernel", kernel.name(), allowed));
        }
        if self.wall_method != WallMethod::VolumeWeights {
            return Err(InvalidInput::new("wall_method", self.wall_method.name(), allowed));
        }
        Ok(())
    }

    /// Kernel of pressure forces.
    pub fn of_pressure(&self) -> KernelKind {
        self.pressure_kernel.unwrap_or(self.kernel)
    }

    /// Kernel of physical viscosity.
    pub fn of_viscosity(&self) -> KernelKind {
        self.viscosity_kernel.unwrap_or(self.of_pressure())
    }

    /// Refuses kernels of terms with what sums both by one kernel.
    fn check_kernels(&self) -> Result<(), InvalidInput> {
        let alone = |field: &str, kernel: KernelKind, with: &str| {
            Err(InvalidInput::new(field, kernel.name(), format_args!("none, with {with}")))
        };
        let wide = "a settings.widest_support above 1";
        if let Some(kernel) = self.pressure_kernel {
            if self.density.is_carried() {
                return alone(
                    "pressure_kernel",
                    kernel,
                    "a settings.density that is carried: its rates are sums of gradients",
                );
            }
            if self.wall_method != WallMethod::VolumeWeights {
                let with = format!("a settings.wall_method of {}", self.wall_method.name());
                return alone("pressure_kernel", kernel, &with);
            }
            if self.widest_support != 1.0 {
                return alone("pressure_kernel", kernel, wide);
            }
        }
        if let Some(kernel) = self.viscosity_kernel {
            if self.viscosity_model.is_none() {
                return alone("viscosity_kernel", kernel, "no settings.viscosity_model, whose kernel it is");
            }
            if self.wall_method == WallMethod::Ghosts {
                return alone("viscosity_kernel", kernel, "a settings.wall_method of ghost particles");
            }
            if self.widest_support != 1.0 {
                return alone("viscosity_kernel", kernel, wide);
            }
        }
        Ok(())
    }

    /// Refuses a density that is carried with what moves particles, or changes their neighbours, by more than their velocities.
    fn check_density(&self) -> Result<(), InvalidInput> {
        let reason = if self.widest_support != 1.0 {
            "a settings.widest_support above 1: supports that change are no part of the rate".to_owned()
        } else if self.xsph > 0.0 {
            "settings.xsph: particles move with more than the velocities that the rate is of".to_owned()
        } else if self.integrator != Integrator::default() {
            let name = self.integrator.name();
            format!("{name} as settings.integrator: rates are those of particles that move with their velocities")
        } else if self.relaxation.is_some() {
            "settings.relaxation: particles settle by the sums of densities".to_owned()
        } else if matches!(self.wall_method, WallMethod::Penalty(_)) {
            "walls by penalty as settings.wall_method: they put particles elsewhere without any velocity".to_owned()
        } else if matches!(self.wall_method, WallMethod::QuasiFluid(_)) {
            "quasi-fluid walls as settings.wall_method: their densities are sums".to_owned()
        } else if self.wall_method == WallMethod::Ghosts {
            "ghost particles as settings.wall_method: they are in sums".to_owned()
        } else {
            return Ok(());
        };
        match self.density.is_carried() {
            true => Err(InvalidInput::new("density", self.density.name(), format_args!("a summed one, with {reason}"))),
            false => Ok(()),
        }
    }

    fn validate(&self) -> Result<(), InvalidInput> {
        self.check_fidelity()?;
        match self.support {
            Support::Ratio(ratio) => check_range("support", ratio, 1.5, 4.0, "spacings")?,
            Support::Neighbours(count) => check_range("support", count, 14.0, 270.0, "neighbours")?,
        }
        self.check_pressure_solver()?;
        if self.integrator.in_solvers().is_none() {
            let others = Integrator::ALL.into_iter().filter(|other| other.in_solvers().is_some());
            let names: Vec<&str> = others.map(Integrator::name).collect();
            let allowed = format!("{}; under the others every oscillation grows", names.join(", "));
            return Err(InvalidInput::new("integrator", self.integrator.name(), allowed));
        }
        if let Some(equation) = &self.equation_of_state {
            equation.validate().map_err(|error| error.inside("equation_of_state"))?;
        }
        if let Some(speed) = self.sound_speed {
            check_range("sound_speed", speed, 1e-3, 1e4, "m/s")?;
            if self.equation_of_state.is_some() {
                return Err(InvalidInput::new("sound_speed", speed, "none, as settings.equation_of_state has its own"));
            }
        }
        if let Some(speed) = self.expected_speed {
            check_range("expected_speed", speed, 1e-4, 1e4, "m/s")?;
        }
        check_range("artificial_viscosity", self.artificial_viscosity, 0.0, 1.0, "")?;
        check_range("near_pressure", self.near_pressure, 0.0, 0.1, "")?;
        check_range("tensile_correction", self.tensile_correction, 0.0, 1.0, "")?;
        check_range("xsph", self.xsph, 0.0, 1.0, "")?;
        check_range("widest_support", self.widest_support, 1.0, variable_support::MOST, "times the support radius")?;
        if self.widest_support != 1.0 && self.tensile_correction > 0.0 {
            let allowed = "0, with a settings.widest_support above 1";
            return Err(InvalidInput::new("tensile_correction", self.tensile_correction, allowed));
        }
        if self.widest_support != 1.0 && self.pressure_force != PressureForce::Monaghan {
            let allowed = "Monaghan, with a settings.widest_support above 1";
            return Err(InvalidInput::new("pressure_force", self.pressure_force.name(), allowed));
        }
        self.check_density()?;
        self.check_kernels()?;
        self.wall_method.validate().map_err(|error| error.inside("wall_method"))?;
        if let Some(relaxation) = &self.relaxation {
            relaxation.validate().map_err(|error| error.inside("relaxation"))?;
        }
        check_range("courant_factor", self.courant_factor, 0.01, 1.0, "")?;
        check_range("force_factor", self.force_factor, 0.01, 1.0, "")?;
        check_range("viscous_factor", self.viscous_factor, 0.01, 1.0, "")?;
        if !(1..=100_000).contains(&self.max_substeps) {
            return Err(InvalidInput::new("max_substeps", self.max_substeps, "1 to 100000"));
        }
        if let Some(budget) = self.budget_milliseconds {
            check_range("budget_milliseconds", budget, 0.01, 1e6, "ms")?;
        }
        if let Some(count) = self.max_particles
            && !(1..=MAX_PARTICLES).contains(&count)
        {
            return Err(InvalidInput::new("max_particles", count, format_args!("1 to {MAX_PARTICLES}")));
        }
        if let Some((min, max)) = self.bounds {
            check_finite("bounds", min)?;
            check_finite("bounds", max)?;
            if !min.cmplt(max).all() {
                return Err(InvalidInput::new(
                    "bounds",
                    format_args!("{min} {max}"),
                    "the first corner below the second",
                ));
            }
        }
        Ok(())
    }
}

/// Distance from the origin up to which positions are accepted, m.
pub(crate) const REACH: f32 = 1e6;

/// Checks that a position is finite and not absurdly far away.
pub(crate) fn check_position(field: &str, position: Vec3) -> Result<(), InvalidInput> {
    if !position.is_finite() || position.abs().max_element() > REACH {
        return Err(InvalidInput::new(field, position, format_args!("within {REACH} m of the origin")));
    }
    Ok(())
}

pub(crate) fn check_gravity(gravity: Vec3) -> Result<(), InvalidInput> {
    for value in gravity.to_array() {
        check_range("gravity", value, -1e4, 1e4, "m/s2")?;
    }
    Ok(())
}

pub(crate) fn check_pose(center: Vec3, rotation: Quat) -> Result<(), InvalidInput> {
    check_position("center", center)?;
    if !rotation.is_finite() || !rotation.is_normalized() {
        return Err(InvalidInput::new("rotation", rotation, "a unit quaternion"));
    }
    Ok(())
}

pub(crate) fn check_half_extents(half_extents: Vec3) -> Result<(), InvalidInput> {
    for value in half_extents.to_array() {
        check_range("half_extents", value, 1e-5, REACH, "m")?;
    }
    Ok(())
}

impl FluidScene {
    /// Checks every number on its own. What needs sampling (overlap, spacing against volume) is checked by the plan.
    pub fn validate(&self) -> Result<(), InvalidInput> {
        for (field, count) in [
            ("volumes", self.volumes.len()),
            ("emitters", self.emitters.len()),
            ("boundaries", self.boundaries.len()),
            ("bodies", self.bodies.len()),
        ] {
            if count > MAX_OBJECTS {
                return Err(InvalidInput::new(
                    field,
                    format_args!("{count} of them"),
                    format_args!("up to {MAX_OBJECTS}"),
                ));
            }
        }
        match self.resolution {
            Resolution::Spacing(spacing) => check_range("resolution", spacing, MIN_SPACING, MAX_SPACING, "m")?,
            Resolution::Particles(count) if (1..=MAX_PARTICLES).contains(&count) => {
                if self.volumes.is_empty() {
                    return Err(InvalidInput::new(
                        "resolution",
                        format_args!("{count} particles"),
                        "a spacing, as there is no volume to share",
                    ));
                }
            }
            Resolution::Particles(count) => {
                return Err(InvalidInput::new("resolution", count, format_args!("1 to {MAX_PARTICLES} particles")));
            }
        }
        check_gravity(self.gravity)?;
        self.material.validate().map_err(|error| error.inside("material"))?;
        for (index, volume) in self.volumes.iter().enumerate() {
            volume.validate().map_err(|error| error.inside(format_args!("volumes[{index}]")))?;
        }
        for (index, emitter) in self.emitters.iter().enumerate() {
            emitter.validate().map_err(|error| error.inside(format_args!("emitters[{index}]")))?;
        }
        for (index, boundary) in self.boundaries.iter().enumerate() {
            boundary
                .validate()
                .and_then(|()| boundary.check_velocity(self.settings.viscosity_model))
                .map_err(|error| error.inside(format_args!("boundaries[{index}]")))?;
        }
        for (index, body) in self.bodies.iter().enumerate() {
            body.validate().map_err(|error| error.inside(format_args!("bodies[{index}]")))?;
        }
        self.periodic.validate().map_err(|error| error.inside("periodic"))?;
        self.settings.validate().map_err(|error| error.inside("settings"))
    }
}

impl Volume {
    fn validate(&self) -> Result<(), InvalidInput> {
        self.shape.validate()?;
        check_pose(self.center, self.rotation)?;
        for value in self.velocity.to_array() {
            check_range("velocity", value, -1e4, 1e4, "m/s")?;
        }
        Ok(())
    }
}

impl Body {
    /// A body of the shape of a boundary, about the shape's own centre: for walls that move.
    ///
    /// Samples lie where those of a [`Boundary`] of this shape do. Give it, in each tick, an inverse mass of zero and the velocity it moves
    /// with ([`BodyInput`](crate::step::BodyInput)). It pushes fluid, and drags it along by
    /// [`friction`](Self::friction) if it has that.
    ///
    /// ```
    /// use freshet_core::prelude::*;
    /// let scene = FluidScene::with_spacing(0.05);
    /// let cup = BoundaryShape::Cup { radius: 0.4, half_height: 0.35, thickness: 0.05 };
    /// let body = Body::of_shape("cup", cup, &scene.wall_layer()?)?;
    /// assert!(body.samples.len() > 100);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// A size out of range, or too small for the spacing, as of a [`Boundary`].
    pub fn of_shape(name: &str, shape: BoundaryShape, layer: &WallLayer) -> Result<Self, InvalidInput> {
        let boundary = Boundary::new(shape, Vec3::ZERO);
        boundary.validate()?;
        let samples = sample_boundary(&boundary, layer)?;
        Ok(Self { name: name.to_owned(), samples, solids: boundary.solids(layer), ..Self::default() })
    }

    fn validate(&self) -> Result<(), InvalidInput> {
        if self.samples.is_empty() {
            return Err(InvalidInput::new("samples", "none", "at least one"));
        }
        for (index, &sample) in self.samples.iter().enumerate() {
            check_position("sample", sample)
                .map_err(|error| InvalidInput { field: format!("samples[{index}]"), ..error })?;
        }
        if let BodySampling::QuasiFluid { layers } = self.sampling {
            let (sum, count) = (layers.iter().map(|&count| u64::from(count)).sum::<u64>(), self.samples.len());
            if sum != count as u64 {
                let allowed = format!("layers that are {count} together, as there are so many samples");
                return Err(InvalidInput::new("sampling.layers", format_args!("{layers:?}"), allowed));
            }
        }
        self.friction.validate().map_err(|error| error.inside("friction"))?;
        if self.solids.len() > MAX_OBJECTS {
            let value = format!("{} of them", self.solids.len());
            return Err(InvalidInput::new("solids", value, format_args!("up to {MAX_OBJECTS}")));
        }
        for (index, solid) in self.solids.iter().enumerate() {
            solid.validate().map_err(|error| error.inside(format_args!("solids[{index}]")))?;
        }
        Ok(())
    }
}
