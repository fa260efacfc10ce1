//! From scene to plan: a pure function that decides what is executed, and says why.

use std::collections::HashMap;
use std::fmt;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::emitter::Emitter;
use crate::equation_of_state::{EquationOfState, PressureLaw};
use crate::error::{InvalidInput, check_range};
use crate::field::Field;
use crate::grid::Grid;
use crate::kernel::{Kernel, KernelKind, support_radius_for_neighbours};
use crate::overlap::check_overlap;
use crate::sampling::lattice::{sample_box, sample_sphere};
use crate::sampling::wall_layer::WallLayer;
use crate::scene::{
    Body, Boundary, BoundaryShape, FluidScene, MAX_PARTICLES, MAX_SPACING, MIN_SPACING, Resolution, Settings, Shape,
    Support, Volume,
};

/// Why a scene cannot be planned or read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A value is not allowed.
    #[error(transparent)]
    Invalid(#[from] InvalidInput),
    /// Two volumes share space.
    #[error("volumes[{first}] and volumes[{second}] overlap near {place}; allowed: shapes that share no space")]
    Overlap {
        /// Index of one volume.
        first: usize,
        /// Index of the other.
        second: usize,
        /// Where, m.
        place: String,
    },
    /// The flow would be faster than a tenth of the speed of sound.
    #[error(
        "{field}: a speed of sound of {sound_speed} m/s is not allowed; allowed: at least {least} m/s, ten times the \
         expected speed, or set settings.allow_compressible"
    )]
    Compressible {
        /// The setting it comes from.
        field: &'static str,
        /// The given speed of sound.
        sound_speed: String,
        /// The least that is allowed.
        least: String,
    },
    /// A scene file does not parse.
    #[error("line {line}, column {column}: {message}")]
    Parse {
        /// Line, from one.
        line: usize,
        /// Column, from one.
        column: usize,
        /// What is wrong there.
        message: String,
    },
    /// A value in a scene file is not allowed.
    #[error("line {line}: {error}")]
    InFile {
        /// Line, from one.
        line: usize,
        /// What is wrong there.
        error: Box<SceneError>,
    },
    /// A scene file is too large to be one.
    #[error("the file has {bytes} bytes; allowed: up to {allowed}")]
    TooLarge {
        /// Its size.
        bytes: u64,
        /// The largest accepted.
        allowed: u64,
    },
}

/// What a substep consists of; a solver may make several passes of a stage or fuse stages.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum StageKind {
    /// Sorts particles by cell, and by id within a cell; those retired or removed fall out.
    Sort,
    /// Moves the bodies' samples to where the bodies are and sorts them by cell.
    BodySort,
    /// Density sum and pressure.
    Density,
    /// Acceleration by pressure, viscosity and gravity.
    Acceleration,
    /// Force and torque of the fluid on each body.
    BodyLoad,
    /// Chooses the substep.
    StepControl,
    /// Moves the bodies by the fluid's force over the substep.
    BodyMotion,
    /// Moves the particles.
    Integrate,
}

impl StageKind {
    /// Name, as in file names of both solvers.
    pub fn name(self) -> &'static str {
        match self {
            StageKind::Sort => "sort",
            StageKind::BodySort => "body_sort",
            StageKind::Density => "density",
            StageKind::Acceleration => "acceleration",
            StageKind::BodyLoad => "body_load",
            StageKind::StepControl => "step_control",
            StageKind::BodyMotion => "body_motion",
            StageKind::Integrate => "integrate",
        }
    }
}

/// A stage, and why the scene needs it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stage {
    /// Which.
    pub kind: StageKind,
    /// Why it is there.
    pub reason: String,
}

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
    /// Kernel.
    pub kernel: KernelKind,
    /// S: the kernel sum on the rest lattice; densities are divided by it.
    pub density_calibration: f32,
    /// Factor on pair forces' divisor, so that a linear pressure on the rest lattice has its exact gradient.
    pub gradient_calibration: f32,
    /// Gamma of the boundary samples' volume weights, see [`WallLayer`].
    pub boundary_gamma: f32,
    /// How far behind the visible surface boundary samples lie, m, see [`WallLayer`].
    pub boundary_depth: f32,
    /// Pressure as a function of density.
    pub pressure_law: PressureLaw,
    /// Speed of sound at rest density, m/s.
    pub sound_speed: f32,
    /// Speed the flow is expected to reach, m/s.
    pub expected_speed: f32,
    /// Monaghan's alpha.
    pub artificial_viscosity: f32,
    /// Step factors: Courant, force, viscous.
    pub courant_factor: f32,
    /// See [`Settings::force_factor`].
    pub force_factor: f32,
    /// See [`Settings::viscous_factor`].
    pub viscous_factor: f32,
    /// See [`Settings::max_substeps`].
    pub max_substeps: u32,
    /// Gravity at the start, m/s2.
    pub gravity: Vec3,
    /// Lower corner of where particles may be, m.
    pub bounds_min: Vec3,
    /// Upper corner of where particles may be, m.
    pub bounds_max: Vec3,
}

impl Parameters {
    /// The substep allowed by the Courant, force and viscous conditions for the given maxima (METHODS, Conventions):
    /// `0.4 h/(c+v)`, `0.25 sqrt(h/a)`, `0.125 h^2/nu` with `nu = alpha c h / 10` (Monaghan 2005, eq. 8.8).
    pub fn substep_limit(&self, max_speed: f32, max_acceleration: f32) -> f32 {
        let h = self.smoothing_length;
        let courant = self.courant_factor * h / (self.sound_speed + max_speed);
        let force = self.force_factor * (h / max_acceleration.max(1e-12)).sqrt();
        courant.min(force).min(self.viscous_limit())
    }

    /// The substep allowed by viscosity alone, s.
    pub fn viscous_limit(&self) -> f32 {
        let nu = self.artificial_viscosity * self.sound_speed * self.smoothing_length / 10.0;
        self.viscous_factor * self.smoothing_length * self.smoothing_length / nu.max(1e-12)
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

    /// The kernel on the support radius.
    pub fn kernel(&self) -> Result<Kernel, InvalidInput> {
        Kernel::new(self.kernel, self.support_radius)
    }
}

/// Samples of all boundaries that do not move.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlannedBoundary {
    /// Positions, m.
    pub positions: Vec<Vec3>,
    /// Volume weights, m3.
    pub volumes: Vec<f32>,
    /// Whether the fluid's artificial viscosity acts between it and the sample.
    pub viscous: Vec<bool>,
}

/// A body with the weights of its samples.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlannedBody {
    /// Name, for reports.
    pub name: String,
    /// Samples relative to the centre of mass, m.
    pub samples: Vec<Vec3>,
    /// Volume weights, m3.
    pub volumes: Vec<f32>,
}

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
    /// For each volume of the scene, its first id and its number of particles.
    pub volume_ids: Vec<(u32, u32)>,
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
    /// Whether particles can have a lifetime.
    pub lifetimes: bool,
    /// What the user should know: choices made for them, warnings.
    pub notes: Vec<String>,
}

/// Largest speed of sound, m/s, as of the equations of state.
const MAX_SOUND_SPEED: f32 = 1e4;

impl Plan {
    /// Plans a scene.
    ///
    /// # Errors
    /// Any value out of range, volumes that overlap or reach out of the bounds, a spacing larger than a volume, too many
    /// particles, or a speed of sound below ten times the expected speed without [`Settings::allow_compressible`].
    pub fn new(scene: &FluidScene) -> Result<Self, SceneError> {
        scene.validate()?;
        let settings = &scene.settings;
        let mut notes = Vec::new();
        let spacing = spacing_of(scene);
        check_range("resolution", spacing, MIN_SPACING, MAX_SPACING, "m between particles")?;
        let kernel = kernel_of(scene, spacing)?;
        let support_radius = kernel.support_radius();

        for (index, emitter) in scene.emitters.iter().enumerate() {
            emitter.check_flow(spacing).map_err(|error| error.inside(format_args!("emitters[{index}]")))?;
        }
        let (mut positions, velocities, volume_ids) = sample_volumes(&scene.volumes, spacing)?;
        let layer = WallLayer::new(&kernel, spacing);
        let boundary = sample_boundaries(&scene.boundaries, &layer)?;
        let plan_body = |(index, body)| {
            plan_body(body, &layer, support_radius).map_err(|error| error.inside(format_args!("bodies[{index}]")))
        };
        let bodies = scene.bodies.iter().enumerate().map(plan_body).collect::<Result<Vec<PlannedBody>, _>>()?;

        let extent = Extent::of(positions.iter().chain(&boundary.positions), scene, support_radius);
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
        notes.push(format!("expected speed {expected_speed:.3} m/s: {speed_reason}"));

        for (volume, &(first, count)) in scene.volumes.iter().zip(&volume_ids) {
            if volume.hydrostatic {
                let range = first as usize..(first + count) as usize;
                stand(&mut positions[range], scene.gravity, sound_speed, spacing);
            }
        }
        let max_particles = max_particles(scene, positions.len(), spacing)?;
        let (bounds_min, bounds_max) = match settings.bounds {
            Some(bounds) => check_bounds(bounds, &positions)?,
            None => extent.grown(4.0),
        };
        let parameters = Parameters {
            spacing,
            support_radius,
            smoothing_length: support_radius / 2.0,
            particle_mass: rest_density * spacing * spacing * spacing,
            rest_density,
            kernel: settings.kernel,
            density_calibration: kernel.lattice_sum(spacing) as f32,
            gradient_calibration: kernel.lattice_gradient_sum(spacing) as f32,
            boundary_gamma: layer.gamma,
            boundary_depth: layer.depth,
            pressure_law: PressureLaw { equation, clamp_negative: settings.clamp_negative_pressure },
            sound_speed,
            expected_speed,
            artificial_viscosity: settings.artificial_viscosity,
            courant_factor: settings.courant_factor,
            force_factor: settings.force_factor,
            viscous_factor: settings.viscous_factor,
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
            stages: stages(settings, !boundary.positions.is_empty(), &bodies),
            fields,
            grid: Grid::fitting(support_radius, extent.max - extent.min, max_particles),
            positions,
            velocities,
            volume_ids,
            emitters: scene.emitters.clone(),
            boundary,
            bodies,
            max_particles,
            budget_milliseconds: settings.budget_milliseconds,
            lifetimes,
            notes,
        })
    }

    /// Whether the plan has a stage.
    pub fn has(&self, kind: StageKind) -> bool {
        self.stages.iter().any(|stage| stage.kind == kind)
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

fn stages(settings: &Settings, walls: bool, bodies: &[PlannedBody]) -> Vec<Stage> {
    let mut stages = Vec::new();
    let mut add = |kind, reason: &str| stages.push(Stage { kind, reason: reason.to_owned() });
    add(StageKind::Sort, "particles have neighbours, which are searched in cells of the support radius");
    if !bodies.is_empty() {
        add(StageKind::BodySort, "the scene has bodies, which move");
    }
    add(
        StageKind::Density,
        match (walls, bodies.is_empty()) {
            (false, true) => "pressure follows from density (weakly compressible); fluid only",
            (true, true) => "pressure follows from density (weakly compressible); fluid and walls",
            (false, false) => "pressure follows from density (weakly compressible); fluid and bodies",
            (true, false) => "pressure follows from density (weakly compressible); fluid, walls and bodies",
        },
    );
    add(
        StageKind::Acceleration,
        if settings.artificial_viscosity > 0.0 {
            "pressure, artificial viscosity and gravity"
        } else {
            "pressure and gravity; settings.artificial_viscosity is 0"
        },
    );
    if !bodies.is_empty() {
        add(StageKind::BodyLoad, "the scene has bodies, which the fluid pushes");
    }
    add(StageKind::StepControl, "substeps adapt to the fastest particle and the largest acceleration");
    if !bodies.is_empty() {
        add(StageKind::BodyMotion, "bodies answer within the tick");
    }
    add(StageKind::Integrate, "semi-implicit Euler: one force evaluation a substep, energy error bounded");
    stages
}

impl FluidScene {
    /// Where samples of walls and bodies have to lie in this scene, and what they weigh.
    ///
    /// # Errors
    /// If the resolution, the support or the kernel is not allowed.
    pub fn wall_layer(&self) -> Result<WallLayer, SceneError> {
        self.validate()?;
        let spacing = spacing_of(self);
        Ok(WallLayer::new(&kernel_of(self, spacing)?, spacing))
    }
}

fn kernel_of(scene: &FluidScene, spacing: f32) -> Result<Kernel, SceneError> {
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

fn spacing_of(scene: &FluidScene) -> f32 {
    match scene.resolution {
        Resolution::Spacing(spacing) => spacing,
        Resolution::Particles(count) => {
            let volume: f32 = scene.volumes.iter().map(Volume::size).sum();
            (volume / count as f32).cbrt()
        }
    }
}

fn sample_volumes(volumes: &[Volume], spacing: f32) -> Result<(Vec<Vec3>, Vec<Vec3>, Vec<(u32, u32)>), SceneError> {
    let too_many = |count: f64| {
        let allowed =
            format!("up to {MAX_PARTICLES} particles in all; this one makes {count:.3e}: choose a larger spacing");
        InvalidInput::new("resolution", format_args!("spacing {spacing} m"), allowed)
    };
    // Before anything is allocated; exact counts follow.
    let expected = volumes.iter().map(|volume| f64::from(volume.size())).sum::<f64>() / f64::from(spacing).powi(3);
    if expected > 2.0 * f64::from(MAX_PARTICLES) {
        return Err(too_many(expected).into());
    }
    let (mut positions, mut velocities, mut ids) = (Vec::new(), Vec::new(), Vec::new());
    for (index, volume) in volumes.iter().enumerate() {
        let sampled =
            sample_volume(volume, spacing).map_err(|error| located(error, format_args!("volumes[{index}]")))?;
        ids.push((positions.len() as u32, sampled.len() as u32));
        velocities.extend(std::iter::repeat_n(volume.velocity, sampled.len()));
        positions.extend(sampled);
        if positions.len() > MAX_PARTICLES as usize {
            return Err(too_many(positions.len() as f64).into());
        }
    }
    check_precision(positions.iter().fold(Vec3::ZERO, |reach, point| reach.max(point.abs())), spacing)?;
    check_overlap(volumes, &positions, &ids, spacing)?;
    Ok((positions, velocities, ids))
}

/// Particles of one volume, in world coordinates.
pub fn sample_volume(volume: &Volume, spacing: f32) -> Result<Vec<Vec3>, InvalidInput> {
    let local = match volume.shape {
        Shape::Box { half_extents } => sample_box(half_extents, spacing),
        Shape::Sphere { radius } => sample_sphere(radius, spacing),
    }
    .map_err(|error| error.inside("shape"))?;
    Ok(local.into_iter().map(|point| volume.rotation * point + volume.center).collect())
}

fn sample_boundaries(boundaries: &[Boundary], layer: &WallLayer) -> Result<PlannedBoundary, SceneError> {
    let spacing = layer.spacing();
    let too_many = |count: f64| {
        let allowed =
            format!("up to {MAX_PARTICLES} wall samples in all; this one makes {count:.3e}: choose a larger spacing");
        InvalidInput::new("resolution", format_args!("spacing {spacing} m"), allowed)
    };
    let expected = boundaries.iter().map(boundary_area).sum::<f64>() / f64::from(spacing).powi(2);
    if expected > 2.0 * f64::from(MAX_PARTICLES) {
        return Err(too_many(expected).into());
    }
    let mut planned = PlannedBoundary::default();
    for (index, boundary) in boundaries.iter().enumerate() {
        let samples =
            sample_boundary(boundary, layer).map_err(|error| located(error, format_args!("boundaries[{index}]")))?;
        planned.viscous.extend(samples.iter().map(|&sample| is_viscous(boundary, layer, sample)));
        if planned.positions.len() + samples.len() > MAX_PARTICLES as usize {
            return Err(too_many((planned.positions.len() + samples.len()) as f64).into());
        }
        planned.volumes.extend(layer.volumes(&samples));
        planned.positions.extend(samples);
    }
    Ok(planned)
}

fn boundary_area(boundary: &Boundary) -> f64 {
    let (half_extents, open) = match boundary.shape {
        BoundaryShape::Container { half_extents, open } => (half_extents.as_dvec3(), open),
        BoundaryShape::Box { half_extents } => (half_extents.as_dvec3(), [false; 6]),
        BoundaryShape::Plane { half_extents: [x, z] } => return 4.0 * f64::from(x) * f64::from(z),
    };
    let face = |axis: usize| 4.0 * half_extents[(axis + 1) % 3] * half_extents[(axis + 2) % 3];
    (0..6).filter(|&index| !open[index]).map(|index| face(index / 2)).sum()
}

/// Moves particles down until each is as dense as the water above it makes it: `rho/rho0 - 1 = g z / c^2` at depth z.
///
/// The lowest stay where they are; at height s of a volume D high the way is `g / c^2 (D s - s^2 / 2)`.
fn stand(positions: &mut [Vec3], gravity: Vec3, sound_speed: f32, spacing: f32) {
    let (g, up) = (gravity.length(), -gravity.normalize_or_zero());
    let low = positions.iter().map(|position| position.dot(up)).fold(f32::INFINITY, f32::min) - 0.5 * spacing;
    let high = positions.iter().map(|position| position.dot(up)).fold(f32::NEG_INFINITY, f32::max) + 0.5 * spacing;
    for position in positions {
        let height = position.dot(up) - low;
        let way = g / (sound_speed * sound_speed) * height * (high - low - 0.5 * height);
        *position -= way.min(0.25 * height) * up;
    }
}

/// Samples of one boundary at the depth of `layer`, in world coordinates.
pub fn sample_boundary(boundary: &Boundary, layer: &WallLayer) -> Result<Vec<Vec3>, InvalidInput> {
    let local = match boundary.shape {
        BoundaryShape::Container { half_extents, open } => layer.container(half_extents, open),
        BoundaryShape::Box { half_extents } => layer.box_surface(half_extents),
        BoundaryShape::Plane { half_extents } => {
            layer.plane(Vec3::Y, half_extents[0], half_extents[1]).map_err(|error| match error.field.as_str() {
                "half_extent_u" => InvalidInput { field: "half_extents[0]".to_owned(), ..error },
                "half_extent_v" => InvalidInput { field: "half_extents[1]".to_owned(), ..error },
                _ => error,
            })
        }
    }
    .map_err(|error| error.inside("shape"))?;
    Ok(local.into_iter().map(|point| boundary.rotation * point + boundary.center).collect())
}

/// Whether a sample lies behind a viscous face.
fn is_viscous(boundary: &Boundary, layer: &WallLayer, sample: Vec3) -> bool {
    let local = boundary.rotation.conjugate() * (sample - boundary.center);
    // From the centre to where samples of a face lie, less half a spacing for rounding.
    let reach = match boundary.shape {
        BoundaryShape::Container { half_extents, .. } => half_extents + layer.depth,
        BoundaryShape::Box { half_extents } => half_extents - layer.depth,
        BoundaryShape::Plane { .. } => return boundary.viscous_faces[3],
    } - 0.5 * layer.spacing();
    (0..3).any(|axis| {
        let [below, above] = [boundary.viscous_faces[2 * axis], boundary.viscous_faces[2 * axis + 1]];
        (below && local[axis] < -reach[axis]) || (above && local[axis] > reach[axis])
    })
}

/// An error of a sampler, seen from the scene: what it calls the spacing is the scene's resolution.
fn located(error: InvalidInput, parent: fmt::Arguments<'_>) -> InvalidInput {
    if error.field == "shape.spacing" {
        let allowed = format!("{}, in {parent}", error.allowed);
        return InvalidInput::new("resolution", format_args!("spacing {} m", error.value), allowed);
    }
    error.inside(parent)
}

/// Refuses particles so far from the origin that `f32` cannot tell a sixty-fourth of their spacing.
fn check_precision(corner: Vec3, spacing: f32) -> Result<(), InvalidInput> {
    let reach = corner.max_element();
    let least = reach / (1 << 17) as f32;
    if spacing < least {
        let allowed =
            format!("at least {least} m where positions are up to {reach} m from the origin, as f32 rounds them");
        return Err(InvalidInput::new("resolution", format_args!("spacing {spacing} m"), allowed));
    }
    Ok(())
}

/// Refuses bounds that leave out particles of the start: they would be gone after the first substep.
fn check_bounds((min, max): (Vec3, Vec3), positions: &[Vec3]) -> Result<(Vec3, Vec3), InvalidInput> {
    let low = positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    if !(min.cmple(low).all() && max.cmpge(high).all()) {
        let allowed = format!("corners up to {low} and from {high} on, around all particles of the start");
        return Err(InvalidInput::new("settings.bounds", format_args!("{min} {max}"), allowed));
    }
    Ok((min, max))
}

fn plan_body(body: &Body, layer: &WallLayer, support_radius: f32) -> Result<PlannedBody, InvalidInput> {
    check_crowding(&body.samples, support_radius)?;
    let volumes = layer.volumes(&body.samples);
    Ok(PlannedBody { name: body.name.clone(), samples: body.samples.clone(), volumes })
}

/// Most samples of a body in a cube of the support radius: a layer a spacing apart has about ten there. All that share a place
/// are each other's neighbours, so the work grows with the square of this.
const MAX_CROWD: usize = 1000;

fn check_crowding(samples: &[Vec3], support_radius: f32) -> Result<(), InvalidInput> {
    let cell = |sample: &Vec3| (*sample / support_radius).floor().as_i64vec3().to_array();
    let mut cells: Vec<[i64; 3]> = samples.iter().map(cell).collect();
    cells.sort_unstable();
    let Some(crowd) = cells.chunk_by(|a, b| a == b).find(|crowd| crowd.len() > MAX_CROWD) else { return Ok(()) };
    let near = Vec3::from(crowd[0].map(|index| index as f32)) * support_radius;
    let value = format!("{} in a cube of {support_radius} m near {near}", crowd.len());
    Err(InvalidInput::new("samples", value, format_args!("up to {MAX_CROWD} there; they should lie a spacing apart")))
}

struct Extent {
    min: Vec3,
    max: Vec3,
}

impl Extent {
    fn of<'a>(points: impl Iterator<Item = &'a Vec3>, scene: &FluidScene, margin: f32) -> Self {
        let mut extent = Self { min: Vec3::splat(f32::INFINITY), max: Vec3::splat(f32::NEG_INFINITY) };
        for &point in points {
            extent.min = extent.min.min(point);
            extent.max = extent.max.max(point);
        }
        for emitter in &scene.emitters {
            extent.min = extent.min.min(emitter.center - emitter.radius);
            extent.max = extent.max.max(emitter.center + emitter.radius);
        }
        if extent.min.x > extent.max.x {
            extent = Self { min: Vec3::splat(-1.0), max: Vec3::splat(1.0) };
        }
        Self { min: extent.min - margin, max: extent.max + margin }
    }

    fn grown(&self, factor: f32) -> (Vec3, Vec3) {
        let reach = (self.max - self.min).length() * factor;
        (self.min - reach, self.max + reach)
    }
}

/// The speed the flow is expected to reach, and why (METHODS, Pressure: twice `sqrt(g D)` for a dam break).
fn expected_speed(scene: &FluidScene, positions: &[Vec3], walls: &[Vec3], layer: &WallLayer) -> (f32, String) {
    if let Some(speed) = scene.settings.expected_speed {
        return (speed, "given by settings.expected_speed".to_owned());
    }
    let gravity = scene.gravity.length();
    let up = if gravity > 0.0 { -scene.gravity / gravity } else { Vec3::Y };
    let heights = |points: &[Vec3]| {
        points
            .iter()
            .map(|point| point.dot(up))
            .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), height| (low.min(height), high.max(height)))
    };
    let mut best = (1e-2, "nothing moves it; 0.01 m/s".to_owned());
    let mut consider = |speed: f32, reason: String| {
        if speed > best.0 {
            best = (speed, reason);
        }
    };
    let (fluid_low, fluid_high) = heights(positions);
    // Faces lie in front of their samples.
    let wall_low = heights(walls).0 + layer.depth;
    if !positions.is_empty() {
        let depth = fluid_high - fluid_low + spacing_of(scene);
        consider(2.0 * (gravity * depth).sqrt(), format!("2 sqrt(g D) of a column D = {depth:.4} m deep"));
    }
    for (index, volume) in scene.volumes.iter().enumerate() {
        let initial = volume.velocity.length();
        let fall = if wall_low.is_finite() { (fluid_high - wall_low).max(0.0) } else { 0.0 };
        let speed = (initial * initial + 2.0 * gravity * fall).sqrt();
        consider(speed, format!("volumes[{index}] at {initial} m/s falling {fall:.4} m"));
    }
    for (index, emitter) in scene.emitters.iter().enumerate() {
        let low = wall_low.min(fluid_low);
        let fall = if low.is_finite() { (emitter.center.dot(up) - low).max(0.0) } else { 0.0 };
        let speed = (emitter.speed * emitter.speed + 2.0 * gravity * fall).sqrt();
        consider(speed, format!("emitters[{index}] at {} m/s falling {fall:.4} m", emitter.speed));
    }
    best
}

fn equation_and_sound_speed(settings: &Settings, rest_density: f32, expected: f32) -> (EquationOfState, f32) {
    let sound_speed = settings.sound_speed.unwrap_or(10.0 * expected);
    let equation = settings.equation_of_state.unwrap_or(EquationOfState::Tait { sound_speed, exponent: 7.0 });
    (equation, equation.sound_speed(f64::from(rest_density)) as f32)
}

fn max_particles(scene: &FluidScene, start: usize, spacing: f32) -> Result<u32, SceneError> {
    if let Some(most) = scene.settings.max_particles {
        if (most as usize) < start {
            let allowed = format!("at least {start}, the particles of the start");
            return Err(InvalidInput::new("settings.max_particles", most, allowed).into());
        }
        return Ok(most);
    }
    let mut most = start as u64;
    for (index, emitter) in scene.emitters.iter().enumerate() {
        let Some(count) = emitter.steady_count(spacing) else {
            return Err(InvalidInput::new(
                "settings.max_particles",
                "none",
                format_args!("a number, as emitters[{index}] flows for ever"),
            )
            .into());
        };
        most = most.saturating_add(count);
    }
    if most > u64::from(MAX_PARTICLES) {
        return Err(InvalidInput::new("settings.max_particles", most, format_args!("1 to {MAX_PARTICLES}")).into());
    }
    Ok((most as u32).max(1))
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let p = &self.parameters;
        writeln!(f, "plan{}{}", if self.name.is_empty() { "" } else { " of " }, self.name)?;
        writeln!(
            f,
            "  {} particles of {:.4e} kg at the start, at most {}; spacing {} m, {} kernel of support {} m",
            self.positions.len(),
            p.particle_mass,
            self.max_particles,
            p.spacing,
            p.kernel.name(),
            p.support_radius
        )?;
        writeln!(
            f,
            "  density calibration {:.4}, gradient calibration {:.4}, walls {:.3} spacings behind their face with gamma {:.3}; {} wall samples, {} bodies with {} samples",
            p.density_calibration,
            p.gradient_calibration,
            p.boundary_depth / p.spacing,
            p.boundary_gamma,
            self.boundary.positions.len(),
            self.bodies.len(),
            self.body_samples()
        )?;
        writeln!(
            f,
            "  {} with sound speed {:.3} m/s{}; alpha {}; step factors {} {} {}; first limit {:.3e} s",
            p.pressure_law.equation.name(),
            p.sound_speed,
            if p.pressure_law.clamp_negative { ", clamped at zero" } else { "" },
            p.artificial_viscosity,
            p.courant_factor,
            p.force_factor,
            p.viscous_factor,
            p.substep_limit(0.0, p.gravity.length())
        )?;
        let cells = self.grid.dimensions();
        writeln!(f, "  wrapped grid of {} x {} x {} cells", cells.x, cells.y, cells.z)?;
        for stage in &self.stages {
            writeln!(f, "  stage {:<13} {}", stage.kind.name(), stage.reason)?;
        }
        for note in &self.notes {
            writeln!(f, "  note  {note}")?;
        }
        Ok(())
    }
}
