//! The numbers of a plan.

use std::mem::discriminant;

use glam::{Mat3, Vec3};

use crate::density_form::DensityForm;
use crate::equation_of_state::PressureLaw;
use crate::error::InvalidInput;
use crate::integrator::Integrator;
use crate::kernel::{Kernel, KernelKind};
use crate::pressure_force::PressureForce;
use crate::pressure_solver::{DivergenceFree, PressureSolver};
use crate::sampling::wall_layer::WallLayer;
use crate::wall_method::WallMethod;

/// Every number the solvers use, derived once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Distance of neighbours at rest, d, m.
    pub spacing: f32,
    /// Support radius, H, m.
    pub support_radius: f32,
    /// Smoothing length h = H/2, m: in viscosity and step limits.
    pub smoothing_length: f32,
    /// Mass of a particle, `rest_density * spacing^3`, kg.
    pub particle_mass: f32,
    /// Density at rest, kg/m3.
    pub rest_density: f32,
    /// Kernel of densities, and of whatever else sums values.
    pub kernel: KernelKind,
    /// Kernel of pressure forces, and of what else goes with a gradient: artificial viscosity, friction, what walls take of a viscous fluid.
    pub pressure_kernel: KernelKind,
    /// Kernel of physical viscosity between particles.
    pub viscosity_kernel: KernelKind,
    /// S: the kernel sum on the rest lattice; densities are divided by it.
    pub density_calibration: f32,
    /// Factor on pair forces' divisor, so that a linear pressure on the rest lattice has its exact gradient.
    pub gradient_calibration: f32,
    /// Gamma of the boundary samples' volume weights, see [`WallLayer`](crate::sampling::wall_layer::WallLayer).
    pub boundary_gamma: f32,
    /// How far behind the visible surface samples that are in the sums lie, m, see [`WallLayer`](crate::sampling::wall_layer::WallLayer).
    pub boundary_depth: f32,
    /// How pressure is found.
    pub pressure_solver: PressureSolver,
    /// Share of a Jacobi step that a solver takes which has such, see [`PressureSolver`]; no unit.
    pub relaxation: f32,
    /// Least diagonal `K` of a [`DivergenceFree`] solver's system, kg s2/m5 over s2: see
    /// [`lattice_diagonal`](crate::pressure_solver::lattice_diagonal).
    pub least_diagonal: f32,
    /// What a position-based solver adds to `K`, likewise; zero for others.
    pub softness: f32,
    /// How far sound of a pressure-corrected fluid goes in a substep at most, m, see
    /// [`longest_sound`](crate::pressure_corrected::PressureCorrected::longest_sound); zero for others.
    pub longest_sound: f32,
    /// Frequency of particles under pressure, see [`pressure_frequency`](crate::pressure_solver::pressure_frequency); no unit.
    pub pressure_frequency: f32,
    /// How densities are found.
    pub density: DensityForm,
    /// Pressure as a function of density, if it is one.
    pub pressure_law: PressureLaw,
    /// How pressures become forces.
    pub pressure_force: PressureForce,
    /// Speed of sound at rest density, m/s.
    pub sound_speed: f32,
    /// Speed the flow is expected to reach, m/s.
    pub expected_speed: f32,
    /// Monaghan's alpha.
    pub artificial_viscosity: f32,
    /// k of the near pressure `k rho`, m2/s2; zero for none. See [`near_pressure`](crate::near_pressure).
    pub near_pressure: f32,
    /// Monaghan's epsilon against clumping; zero for none. See [`tensile_correction`](crate::tensile_correction).
    pub tensile_correction: f32,
    /// Epsilon of XSPH; zero for none. See [`xsph`](crate::xsph).
    pub xsph: f32,
    /// Widest support of a particle over the support radius; 1 where all have the same. See
    /// [`variable_support`](crate::variable_support).
    pub widest_support: f32,
    /// Dynamic viscosity of Morris' model, Pa s; zero without a model.
    pub dynamic_viscosity: f32,
    /// Divisor of Morris' pair forces, so that a parabolic velocity on the rest lattice has its exact force; where viscosity has a kernel of its own, on planes of that lattice
    /// that [slide past each other](Kernel::sheared_viscous_sum).
    pub viscous_calibration: f32,
    /// What viscosity with a kernel of its own gives next to a wall over what a layer of samples gives, see
    /// [`viscous_share`](crate::sampling::wall_layer::WallLayer::viscous_share); one for the kernel of pressure.
    pub viscous_share: f32,
    /// How walls act on the fluid.
    pub wall_method: WallMethod,
    /// How hard, see [`WallMethod::strength`].
    pub wall_strength: f32,
    /// How accelerations become velocities and positions.
    pub integrator: Integrator,
    /// Step factors: Courant, force, viscous.
    pub courant_factor: f32,
    /// See [`Settings::force_factor`](crate::scene::Settings::force_factor).
    pub force_factor: f32,
    /// See [`Settings::viscous_factor`](crate::scene::Settings::viscous_factor).
    pub viscous_factor: f32,
    /// See [`Settings::redo_substeps`](crate::scene::Settings::redo_substeps).
    pub redo_substeps: bool,
    /// See [`Settings::max_substeps`](crate::scene::Settings::max_substeps).
    pub max_substeps: u32,
    /// Gravity at the start, m/s2.
    pub gravity: Vec3,
    /// Lower corner of where particles may be, m.
    pub bounds_min: Vec3,
    /// Upper corner of where particles may be, m.
    pub bounds_max: Vec3,
}

impl Parameters {
    /// Whether a plan's fluid is found by the same method as another's, so that it can go on from the length of the other's last substep: what
    /// another method did in it means nothing. For solvers.
    pub fn goes_on_from(&self, earlier: &Self) -> bool {
        let (this, other) = (self.pressure_solver, earlier.pressure_solver);
        // Those that move particles apart leave the same: places and velocities without pressure.
        (discriminant(&this) == discriminant(&other) || this.moves_apart() && other.moves_apart())
            && self.density.is_carried() == earlier.density.is_carried()
    }

    /// The substep allowed by the Courant, force and viscous conditions for the given maxima (METHODS, Conventions):
    /// `0.4 h/(c+v)`, `0.25 sqrt(h/a)`, `0.125 h^2/nu` with `nu = alpha c h / 10` (Monaghan 2005, eq. 8.8)
    /// plus `mu / rho`.
    pub fn substep_limit(&self, max_speed: f32, max_acceleration: f32) -> f32 {
        let h = self.smoothing_length;
        let courant = self.courant_factor * h / (self.sound_speed + max_speed);
        let force = self.force_factor * (h / max_acceleration.max(1e-12)).sqrt();
        courant.min(force).min(self.steady_limit())
    }

    /// The substep of an incompressible fluid: its fastest particle, with the speed it is expected to leave the substep with, goes no
    /// farther than its [way](Self::longest_way), `C d`, nor does any fall farther from rest by gravity (`sqrt(C d/g)`); particles under the largest
    /// `p / rho`, m2/s2, stay in their places ([`DivergenceFree::PRESSURE_FACTOR`]); and that of viscosity.
    pub fn incompressible_limit(&self, max_speed: f32, gravity: f32, max_pressure: f32) -> f32 {
        let way = self.longest_way();
        let courant = way / max_speed.max(1e-12);
        let fall = (way / gravity.max(1e-12)).sqrt();
        let frequency = self.pressure_frequency * max_pressure.max(1e-12).sqrt() / self.spacing;
        let pressure = 2.0 * DivergenceFree::PRESSURE_FACTOR / frequency.max(1e-12);
        courant.min(fall).min(pressure).min(self.steady_limit())
    }

    /// The substep of a position-based fluid: as that of an incompressible one, without the part of pressure.
    pub fn position_based_limit(&self, max_speed: f32, gravity: f32) -> f32 {
        self.incompressible_limit(max_speed, gravity, 0.0)
    }

    /// How much longer than the limit of the state that it leaves a substep may be; no unit.
    pub const REDO_SLACK: f32 = 1.1;
    /// How often a substep is made again at most; the last is left as it is.
    pub const MOST_REDOS: u32 = 6;

    /// The substep with which one of `dt` seconds is made again, if it was too long; none if it was not.
    ///
    /// A substep is as long as the state allows that it starts from. What happens in it, an impact mostly, can leave particles so fast, or
    /// so hard pressed, that it should have been shorter: `limit` is what that state allows. More than a
    /// [tenth](Self::REDO_SLACK) longer is too long. Then it is made again with that limit, between an eighth and a half of what it was (P §2.3.5: "the
    /// time step is lowered to the maximum possible time step").
    pub fn redone(dt: f32, limit: f32) -> Option<f32> {
        let too_long = dt > Self::REDO_SLACK * limit || limit.is_nan();
        too_long.then(|| limit.max(0.125 * dt).min(0.5 * dt))
    }

    /// How far a particle of an incompressible fluid may go in a substep, m.
    pub fn longest_way(&self) -> f32 {
        self.courant_factor * self.spacing
    }

    /// Largest relative density too large that velocities of an incompressible fluid correct in a substep of `dt` seconds. A correction by `e` takes velocities
    /// of `e d/dt`: without a limit to the rate a single fast particle, for which substeps are short, would make all that is a little
    /// too dense fly apart, and what is much too dense each substep faster than the one before.
    pub fn most_by_velocity(&self, dt: f32) -> f32 {
        DivergenceFree::RATE_BY_VELOCITY * self.expected_speed / self.spacing * dt
    }

    /// The substep allowed by viscosity alone, s: shorter under integrators that bear [less of it](Integrator::drag_limit).
    pub fn viscous_limit(&self) -> f32 {
        let artificial = self.artificial_viscosity * self.sound_speed * self.smoothing_length / 10.0;
        let nu = artificial + self.dynamic_viscosity / self.rest_density;
        let share = self.integrator.drag_limit() / Integrator::default().drag_limit();
        share * self.viscous_factor * self.smoothing_length * self.smoothing_length / nu.max(1e-12)
    }

    /// The substep allowed whatever the state of the fluid: by viscosity and by the springs of walls, s.
    pub fn steady_limit(&self) -> f32 {
        self.viscous_limit().min(self.wall_method.substep_limit(self.wall_strength))
    }

    /// The substep allowed by how fluid drags a body of so many samples that reach so far, m: what a light body gets from the fluid that
    /// sticks to it must not make it faster than that. Infinite without a viscosity model, and for what nothing moves.
    ///
    /// For each sample there is about a particle half a spacing off the surface, which gives the body `mu d` of the difference of their
    /// velocities over that half spacing, `2 mu d` in all: `sum_k 2 mu d (1/M + r_k^2/I) dt` must stay below 2. The turning part is
    /// taken as that of samples all as far off as the farthest; the larger of both parts counts, as a body turns about its axis by
    /// what does not push it along.
    pub fn drag_limit(&self, samples: usize, reach: f32, inverse_mass: f32, inverse_inertia: Mat3) -> f32 {
        let turning =
            [inverse_inertia.x_axis, inverse_inertia.y_axis, inverse_inertia.z_axis].map(Vec3::length_squared);
        let turning = reach * reach * turning.into_iter().fold(0.0, f32::max).sqrt();
        let drag = 2.0 * self.dynamic_viscosity * self.spacing * samples as f32;
        1.0 / (drag * inverse_mass.max(turning))
    }

    /// The substep that covers what remains of a tick in equal parts no longer than `limit`.
    pub fn equal_substep(remaining: f32, limit: f32) -> f32 {
        remaining / (remaining / limit - 1e-3).ceil().max(1.0)
    }

    /// How far a body may be from where the last tick left it and still drift there instead of jumping, m: twice what lies
    /// within reach of a sample.
    pub fn body_reach(&self) -> f32 {
        4.0 * self.support_radius
    }

    /// How far behind its face the samples of a wall lie that fluid sticks to, m, and the viscosity between them and the fluid, Pa s. A single layer
    /// stands for twice the gradient of the fluid that it replaces, see [`wall_layer`](crate::sampling::wall_layer); one of three that weighs what fluid does for once.
    pub fn sticking(&self) -> (f32, f32) {
        match self.wall_method {
            WallMethod::QuasiFluid(walls) => {
                let viscosity = self.dynamic_viscosity * self.viscous_unit() as f32;
                (0.5 * self.spacing, 2.0 * viscosity / walls.relative_density())
            }
            _ => (self.boundary_depth, self.sticking_to_bodies()),
        }
    }

    /// The viscosity between samples of bodies and the fluid, Pa s: those of a single layer, see [`sticking`](Self::sticking).
    pub fn sticking_to_bodies(&self) -> f32 {
        self.dynamic_viscosity * (f64::from(self.viscous_share) * self.viscous_unit()) as f32
    }

    /// `2 mu G / G'`, Pa s: viscosity between particles, as forces are divided by G, and multiplied with the constant of the pressure's kernel.
    pub fn pair_viscosity(&self) -> f32 {
        let calibration = f64::from(self.gradient_calibration) / f64::from(self.viscous_calibration);
        let constants = self.viscosity_kernel.normalisation() / self.pressure_kernel.normalisation();
        (2.0 * f64::from(self.dynamic_viscosity) * calibration * constants) as f32
    }

    /// What sums of a viscosity kernel's slopes are worth that are taken as those of the pressure's; one where it is the same.
    fn viscous_unit(&self) -> f64 {
        match self.has_own_viscosity_kernel() {
            true => 0.5 * f64::from(self.pair_viscosity() / self.dynamic_viscosity),
            false => 1.0,
        }
    }

    /// Whether viscosity between particles has a kernel that pressure has not.
    pub fn has_own_viscosity_kernel(&self) -> bool {
        self.dynamic_viscosity > 0.0 && self.viscosity_kernel != self.pressure_kernel
    }

    /// Where samples of walls and bodies lie, and what they weigh.
    ///
    /// # Errors
    /// If the support radius is out of range.
    pub fn wall_layer(&self) -> Result<WallLayer, InvalidInput> {
        Ok(WallLayer::of_terms(&self.kernel()?, &self.pressure_kernel()?, self.spacing))
    }

    /// The kernel of pressure forces on the support radius.
    ///
    /// # Errors
    /// If the support radius is out of range.
    pub fn pressure_kernel(&self) -> Result<Kernel, InvalidInput> {
        Kernel::new(self.pressure_kernel, self.support_radius)
    }

    /// The kernel of physical viscosity on the support radius.
    ///
    /// # Errors
    /// If the support radius is out of range.
    pub fn viscosity_kernel(&self) -> Result<Kernel, InvalidInput> {
        Kernel::new(self.viscosity_kernel, self.support_radius)
    }

    /// The kernel of densities on the support radius.
    ///
    /// # Errors
    /// If the support radius is out of range.
    pub fn kernel(&self) -> Result<Kernel, InvalidInput> {
        Kernel::new(self.kernel, self.support_radius)
    }
}
