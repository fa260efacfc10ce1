//! From scene to plan: a pure function that decides what is executed, and says why.

mod checks;
mod display;
mod error;
mod extent;
mod left_out;
mod parameters;
mod resolution;
mod sampling;
mod speeds;
mod stages;

use std::collections::HashMap;

use glam::{Mat3, Vec3};

pub use self::error::SceneError;
pub use self::left_out::LeftOut;
pub use self::parameters::Parameters;
pub use self::sampling::{PlannedBody, PlannedBoundary, sample_boundary, sample_volume};
pub use self::stages::{Stage, StageKind};

use self::checks::{
    check_belts, check_bounds, check_carried_density, check_driven, check_friction, check_moved_apart,
    check_particles_within, check_periods, check_precision, check_quasi_fluid, check_relaxation, check_wall_method,
    max_particles,
};
use self::extent::Extent;
use self::left_out::{Start, leave_out};
use self::resolution::{Kernels, spacing_of};
use self::sampling::{bear, plan_body, press, sample_boundaries, sample_volumes, stand};
use self::speeds::{equation_and_sound_speed, expected_speed};
use self::stages::stages;
use crate::emitter::Emitter;
use crate::equation_of_state::PressureLaw;
use crate::error::{InvalidInput, check_range};
use crate::field::Field;
use crate::grid::Grid;
use crate::position_based::PositionBased;
use crate::pressure_corrected::PressureCorrected;
use crate::pressure_poisson::PressurePoisson;
use crate::pressure_solver::{
    DivergenceFree, PressureSolver, largest_eigenvalue, lattice_diagonal, pressure_frequency,
};
use crate::relaxation::Relaxation;
use crate::scene::{FluidScene, MAX_SPACING, MIN_SPACING};
use crate::step::StepInput;
use crate::tensile_correction::POSITIVE;

/// What is executed, in order, with the reason of each stage.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The scene's name.
    pub name: String,
    /// All numbers.
    pub parameters: Parameters,
    /// Stages of one substep, in order.
    pub stages: Vec<Stage>,
    /// Fields that can be read.
    pub fields: Vec<Field>,
    /// The grid of all neighbour searches.
    pub grid: Grid,
    /// Where particles start, m, in the order of their ids.
    pub positions: Vec<Vec3>,
    /// Velocities they start with, m/s.
    pub velocities: Vec<Vec3>,
    /// `p / rho^2` that an incompressible fluid starts its first solve from, m5/(kg s2): that of water standing in each volume that
    /// is [hydrostatic](crate::scene::Volume::hydrostatic). Empty for other plans.
    pub pressures: Vec<f32>,
    /// `rho/rho0 - 1` that particles start with, no unit, likewise; empty for plans whose densities are not
    /// [carried](crate::density_form::DensityForm::is_carried).
    pub excesses: Vec<f32>,
    /// For each volume of the scene, its first id and its number of particles.
    pub volume_ids: Vec<(u32, u32)>,
    /// What the volumes have inside of walls, which is none of the above: for each pair of a volume and a boundary, in the order
    /// of the volumes. Empty if all is well; [`notes`](Self::notes) say the same in words.
    pub left_out: Vec<LeftOut>,
    /// Emitters, whose layers become commands of the ticks.
    pub emitters: Vec<Emitter>,
    /// Samples of boundaries.
    pub boundary: PlannedBoundary,
    /// Samples of bodies.
    pub bodies: Vec<PlannedBody>,
    /// Most particles there may ever be.
    pub max_particles: u32,
    /// Wall time a tick may take, ms.
    pub budget_milliseconds: Option<f32>,
    /// How particles settle before the start.
    pub relaxation: Option<Relaxation>,
    /// Whether particles can have a lifetime.
    pub lifetimes: bool,
    /// What the user should know: choices made for them, warnings.
    pub notes: Vec<String>,
}

/// Largest speed of sound, m/s, as of the equations of state.
const MAX_SOUND_SPEED: f32 = 1e4;

impl Plan {
    /// Plans a scene. Particles of its volumes that would start inside a wall are left out: see [`left_out`](Self::left_out).
    ///
    /// # Errors
    /// Any value out of range, volumes that overlap or reach out of the bounds, a spacing larger than a volume, too many
    /// particles, or a speed of sound below ten times the expected speed without [`Settings::allow_compressible`](crate::scene::Settings::allow_compressible).
    pub fn new(scene: &FluidScene) -> Result<Self, SceneError> {
        scene.validate()?;
        if let Some(plan) = scene.plan_of_fidelity()? {
            return Ok(plan);
        }
        let settings = &scene.settings;
        let mut notes = Vec::new();
        let spacing = spacing_of(scene);
        check_range("resolution", spacing, MIN_SPACING, MAX_SPACING, "m between particles")?;
        let kernels = Kernels::of(scene, spacing)?;
        let kernel = kernels.density;
        let support_radius = kernel.support_radius();
        let periodic = scene.periodic;
        let reach = support_radius * settings.widest_support;
        check_periods(&periodic, reach)?;
        check_driven(scene)?;
        check_quasi_fluid(scene)?;
        check_carried_density(scene)?;
        check_moved_apart(scene)?;
        check_relaxation(scene)?;
        check_friction(scene)?;
        check_wall_method(scene, support_radius)?;
        check_belts(scene)?;

        for (index, emitter) in scene.emitters.iter().enumerate() {
            emitter.check_flow(spacing).map_err(|error| error.inside(format_args!("emitters[{index}]")))?;
        }
        let (mut positions, mut velocities, mut volume_ids) = sample_volumes(&scene.volumes, spacing)?;
        check_particles_within(&periodic, &positions, spacing)?;
        let layer = kernels.wall_layer(spacing)?;
        let boundary = sample_boundaries(&scene.boundaries, settings.wall_method, &periodic, &layer)?;
        let asked = volume_ids.clone();
        let start = Start { positions: &mut positions, velocities: &mut velocities, ids: &mut volume_ids };
        let left_out = leave_out(start, &scene.volumes, &scene.boundaries, &periodic, &layer);
        notes.extend(left_out.iter().map(|&LeftOut { volume, boundary, inside, crowded }| {
            let (count, all) = (inside + crowded, asked[volume].1);
            format!(
                "volumes[{volume}]: {count} of {all} particles are left out: {inside} have their centre inside \
                 boundaries[{boundary}], {crowded} are nearer to it than half a spacing"
            )
        }));
        let plan_body = |(index, body)| {
            plan_body(body, &periodic, &layer, reach).map_err(|error| error.inside(format_args!("bodies[{index}]")))
        };
        let bodies = scene.bodies.iter().enumerate().map(plan_body).collect::<Result<Vec<PlannedBody>, _>>()?;

        let extent = Extent::of(positions.iter().chain(&boundary.positions), scene, reach);
        check_precision(extent.min.abs().max(extent.max.abs()), spacing)?;
        let (expected_speed, speed_reason) = expected_speed(scene, &positions, &boundary.positions, &layer);
        let rest_density = scene.material.rest_density;
        let (equation, sound_speed) = equation_and_sound_speed(settings, rest_density, expected_speed);
        if sound_speed > MAX_SOUND_SPEED {
            let allowed = format!("up to {MAX_SOUND_SPEED} m/s; it is ten times the expected speed: {speed_reason}");
            return Err(InvalidInput::new("settings.sound_speed", sound_speed, allowed).into());
        }
        let least = 10.0 * expected_speed;
        if sound_speed < least * 0.999 {
            if !settings.allow_compressible {
                return Err(SceneError::Compressible {
                    field: match settings.equation_of_state {
                        Some(_) => "settings.equation_of_state",
                        None => "settings.sound_speed",
                    },
                    sound_speed: sound_speed.to_string(),
                    least: least.to_string(),
                });
            }
            notes.push(format!(
                "compressible by request: sound speed {sound_speed} m/s is below ten times the expected speed, {least} m/s"
            ));
        }
        if settings.tensile_correction > 0.0 && settings.clamp_negative_pressure {
            notes.push(format!(
                "settings.tensile_correction is {}, but settings.clamp_negative_pressure leaves no tension to correct: what acts is \
                 {POSITIVE} (P_a + P_b) alone",
                settings.tensile_correction
            ));
        }
        notes.push(format!("expected speed {expected_speed:.3} m/s: {speed_reason}"));

        let incompressible = matches!(settings.pressure_solver, PressureSolver::DivergenceFree(_));
        let mut pressures = vec![0.0; if incompressible { positions.len() } else { 0 }];
        let by_positions = settings.pressure_solver.moves_apart();
        let poisson = matches!(settings.pressure_solver, PressureSolver::PressurePoisson(_));
        let carried = settings.density.is_carried();
        let mut excesses = vec![0.0; if carried { positions.len() } else { 0 }];
        for (volume, &(first, count)) in scene.volumes.iter().zip(&volume_ids) {
            if volume.hydrostatic {
                let range = first as usize..(first + count) as usize;
                let down = periodic.across(scene.gravity);
                if incompressible {
                    bear(&mut pressures[range.clone()], &positions[range], down, rest_density, spacing);
                } else if !by_positions {
                    if carried {
                        press(&mut excesses[range.clone()], &positions[range.clone()], down, sound_speed, spacing);
                    }
                    stand(&mut positions[range], down, sound_speed, spacing);
                }
            }
        }
        // Lattice sums that no other plan needs.
        let (eigenvalue, pressure_frequency, diagonal) = match incompressible || by_positions {
            true => (
                largest_eigenvalue(&kernel, spacing) as f32,
                pressure_frequency(&kernel, spacing) as f32,
                lattice_diagonal(&kernel, spacing) * f64::from(rest_density)
                    / (kernel.lattice_sum(spacing) * kernel.lattice_gradient_sum(spacing)),
            ),
            false => (1.0, 0.0, 0.0),
        };
        for position in &mut positions {
            *position = periodic.wrap(*position);
        }
        let max_particles = max_particles(scene, positions.len(), spacing)?;
        let (bounds_min, bounds_max) = match settings.bounds {
            Some(bounds) => check_bounds(bounds, &positions, &periodic)?,
            None => extent.grown(4.0),
        };
        let parameters = Parameters {
            spacing,
            support_radius,
            smoothing_length: support_radius / 2.0,
            particle_mass: rest_density * spacing * spacing * spacing,
            rest_density,
            kernel: settings.kernel,
            pressure_kernel: settings.of_pressure(),
            viscosity_kernel: settings.of_viscosity(),
            density_calibration: kernel.lattice_sum(spacing) as f32,
            gradient_calibration: kernels.pressure.lattice_gradient_sum(spacing) as f32,
            boundary_gamma: layer.gamma,
            boundary_depth: layer.depth,
            pressure_solver: settings.pressure_solver,
            relaxation: match by_positions {
                true if poisson => PressurePoisson::RELAXATION,
                true => PositionBased::RELAXATION / eigenvalue,
                false => DivergenceFree::RELAXATION / eigenvalue,
            },
            least_diagonal: DivergenceFree::LEAST_DIAGONAL * diagonal as f32,
            softness: match settings.pressure_solver {
                PressureSolver::PositionBased(solver) => solver.softness * diagonal as f32,
                _ => 0.0,
            },
            longest_sound: match settings.pressure_solver {
                PressureSolver::PressureCorrected(_) => PressureCorrected::longest_sound(&kernel, spacing),
                _ => 0.0,
            },
            pressure_frequency,
            density: settings.density,
            pressure_law: PressureLaw { equation, clamp_negative: settings.clamp_negative_pressure },
            pressure_force: settings.pressure_force,
            sound_speed,
            expected_speed,
            artificial_viscosity: settings.artificial_viscosity,
            near_pressure: settings.near_pressure * sound_speed * sound_speed,
            tensile_correction: settings.tensile_correction,
            xsph: settings.xsph,
            widest_support: settings.widest_support,
            dynamic_viscosity: scene.physical_viscosity().map_or(0.0, |_| scene.material.dynamic_viscosity),
            viscous_calibration: kernels.viscous_calibration(spacing) as f32,
            viscous_share: match kernels.viscosity == kernels.pressure {
                true => 1.0,
                false => layer.viscous_share(&kernels.viscosity) as f32,
            },
            wall_method: settings.wall_method,
            wall_strength: settings.wall_method.strength(expected_speed, sound_speed, spacing),
            integrator: settings.integrator,
            courant_factor: settings.courant_factor,
            force_factor: settings.force_factor,
            viscous_factor: settings.viscous_factor,
            redo_substeps: settings.redo_substeps,
            max_substeps: settings.max_substeps,
            gravity: scene.gravity,
            bounds_min,
            bounds_max,
        };
        let lifetimes = scene.emitters.iter().any(|emitter| emitter.lifetime.is_finite());
        let mut fields = vec![Field::Id, Field::Position, Field::Velocity, Field::Density, Field::Pressure];
        fields.extend([Field::Acceleration, Field::Speed, Field::RemainingLife]);
        Ok(Self {
            name: scene.name.clone(),
            parameters,
            stages: stages(scene, !boundary.positions.is_empty(), &bodies),
            fields,
            grid: Grid { support_radius, ..Grid::repeating(reach, extent.max - extent.min, periodic, max_particles) },
            positions,
            velocities,
            pressures,
            excesses,
            volume_ids,
            left_out,
            emitters: scene.emitters.clone(),
            boundary,
            bodies,
            max_particles,
            budget_milliseconds: settings.budget_milliseconds,
            relaxation: settings.relaxation,
            lifetimes,
            notes,
        })
    }

    /// Checks every number of a tick's input, and that the bodies with friction are such that the fluid does not move: one that answers would get, in
    /// one substep, what every particle that sticks to it gives it of the same difference of velocities.
    ///
    /// # Errors
    /// The first number that is out of range.
    pub fn check_input(&self, input: &StepInput) -> Result<(), InvalidInput> {
        input.validate(self.bodies.len())?;
        for (index, (body, given)) in self.bodies.iter().zip(&input.bodies).enumerate() {
            let moves = given.inverse_mass > 0.0 || given.inverse_inertia != Mat3::ZERO;
            if moves && body.friction.is_some() {
                let field = format!("bodies[{index}].inverse_mass");
                let allowed = "0, with an inverse inertia of 0, of a body with friction";
                return Err(InvalidInput::new(field, given.inverse_mass, allowed));
            }
        }
        Ok(())
    }

    /// Whether the plan has a stage.
    pub fn has(&self, kind: StageKind) -> bool {
        self.stages.iter().any(|stage| stage.kind == kind)
    }

    /// Whether walls are in the sums of the fluid.
    pub fn sums_walls(&self) -> bool {
        self.parameters.wall_method.is_in_sums() && !self.boundary.positions.is_empty()
    }

    /// For each body, its index among the bodies of an earlier plan: the one of the same name, or of several with the same
    /// name the one as far along. None for a body that is new.
    pub fn bodies_of(&self, earlier: &Plan) -> Vec<Option<usize>> {
        let mut namesakes: HashMap<&str, Vec<usize>> = HashMap::new();
        for (index, body) in earlier.bodies.iter().enumerate() {
            namesakes.entry(&body.name).or_default().push(index);
        }
        let mut ranks: HashMap<&str, usize> = HashMap::new();
        self.bodies
            .iter()
            .map(|body| {
                let rank = ranks.entry(&body.name).or_default();
                *rank += 1;
                namesakes.get(body.name.as_str())?.get(*rank - 1).copied()
            })
            .collect()
    }

    /// Samples of all bodies together.
    pub fn body_samples(&self) -> usize {
        self.bodies.iter().map(|body| body.samples.len()).sum()
    }
}
