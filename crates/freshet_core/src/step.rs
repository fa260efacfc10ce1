//! What goes into a tick and what comes out of it: plain data, so that it can be recorded, replayed and sent.

use glam::{Mat3, Quat, Vec3};
use serde::{Deserialize, Serialize};

use crate::error::{InvalidInput, check_finite, check_range};
use crate::scene::check_gravity;

/// Everything a solver is told about one tick.
///
/// A [`Snapshot`](crate::snapshot::Snapshot) plus the stream of these is a full record of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StepInput {
    /// Number of the tick, 0 to [`MAX_TICK`](Self::MAX_TICK): one more than the last, whether that was made here or is in
    /// the snapshot restored.
    ///
    /// The fluid does not depend on it, and solvers do not check that numbers follow each other. Bodies do: what the fluid
    /// gave them is remembered by its tick's number, for four ticks ([`BodyInput::corrected_before`]). After a gap a
    /// solver takes the ticks left out for made: what is remembered displaces a free body for that much longer, and is
    /// forgotten when a tick whose number differs by a multiple of four takes its place. A number used again, or a
    /// smaller one, hears nothing of the ticks from there on.
    pub tick: u64,
    /// Time to cover, s, 0 to 1. The solver chooses the substeps.
    pub duration: f32,
    /// State of each body of the plan, in the plan's order.
    #[serde(default)]
    pub bodies: Vec<BodyInput>,
    /// Changes to carry out before the first substep, in order.
    #[serde(default)]
    pub commands: Vec<Command>,
}

impl StepInput {
    /// Longest duration of one tick, s; a longer hitch is several ticks.
    pub const MAX_DURATION: f32 = 1.0;

    /// Largest number of a tick, 2^63 - 1, so that the next one's can always be told.
    pub const MAX_TICK: u64 = (1 << 63) - 1;

    /// Checks every number; `bodies` is the plan's number of bodies. Solvers ask [`Plan::check_input`](crate::plan::Plan::check_input), which asks
    /// more.
    pub fn validate(&self, bodies: usize) -> Result<(), InvalidInput> {
        if self.tick > Self::MAX_TICK {
            return Err(InvalidInput::new("tick", self.tick, "0 to 2^63 - 1"));
        }
        check_range("duration", self.duration, 0.0, Self::MAX_DURATION, "s")?;
        if self.bodies.len() != bodies {
            return Err(InvalidInput::new(
                "bodies",
                self.bodies.len(),
                format_args!("{bodies}, one for each of the plan"),
            ));
        }
        for (index, body) in self.bodies.iter().enumerate() {
            body.validate().map_err(|error| error.inside(format_args!("bodies[{index}]")))?;
        }
        for (index, command) in self.commands.iter().enumerate() {
            command.validate().map_err(|error| error.inside(format_args!("commands[{index}]")))?;
        }
        Ok(())
    }
}

/// A change to the fluid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Command {
    /// Adds particles; they get the next free ids in the order given. Those [inside a wall or a body](crate::solid), and
    /// those that have no room beside one, are taken out again before the first substep; until then they take room.
    Spawn(NewParticles),
    /// Removes the particles whose id is in `first .. first + count`.
    RemoveIds {
        /// First id.
        first: u32,
        /// How many ids.
        count: u32,
    },
    /// Removes the particles in an axis-aligned box.
    RemoveInBox {
        /// Lower corner, m.
        min: Vec3,
        /// Upper corner, m.
        max: Vec3,
    },
    /// Sets the gravity from here on, m/s2.
    SetGravity(Vec3),
}

impl Command {
    fn validate(&self) -> Result<(), InvalidInput> {
        match self {
            Command::Spawn(particles) => particles.validate(),
            Command::RemoveIds { .. } => Ok(()),
            Command::RemoveInBox { min, max } => check_finite("min", *min).and(check_finite("max", *max)),
            Command::SetGravity(gravity) => check_gravity(*gravity),
        }
    }
}

/// Particles to add.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NewParticles {
    /// Positions, m.
    pub positions: Vec<Vec3>,
    /// Velocities, m/s, one for each position.
    pub velocities: Vec<Vec3>,
    /// Time after which each is retired, s; infinite means never. It counts from [`at`](Self::at).
    #[serde(default = "forever")]
    pub lifetime: f32,
    /// Simulated time at which they are at `positions`, s; none means the start of the tick.
    ///
    /// The solver moves them along their velocities to where they are at the start of the tick, which it alone knows when
    /// earlier ticks are still in flight and may not cover what they were asked to. A solver that starts anew is at 0, one that
    /// restores a snapshot at [`Snapshot::time`](crate::snapshot::Snapshot::time).
    #[serde(default)]
    pub at: Option<f64>,
}

fn forever() -> f32 {
    f32::INFINITY
}

impl NewParticles {
    fn validate(&self) -> Result<(), InvalidInput> {
        if self.velocities.len() != self.positions.len() {
            return Err(InvalidInput::new(
                "velocities",
                self.velocities.len(),
                format_args!("{}, one for each position", self.positions.len()),
            ));
        }
        if self.lifetime.is_nan() || self.lifetime <= 0.0 {
            return Err(InvalidInput::new("lifetime", self.lifetime, "more than 0 s, infinite for ever"));
        }
        for (field, values) in [("positions", &self.positions), ("velocities", &self.velocities)] {
            if let Some(index) = values.iter().position(|value| !value.is_finite()) {
                return Err(InvalidInput::new(format_args!("{field}[{index}]"), values[index], "finite numbers"));
            }
        }
        if let Some(at) = self.at
            && !at.is_finite()
        {
            return Err(InvalidInput::new("at", at, "a finite number of seconds, or none"));
        }
        Ok(())
    }
}

/// Momentum and angular momentum about the body's centre of mass, both in world axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Impulse {
    /// N s.
    pub linear: Vec3,
    /// N m s.
    pub angular: Vec3,
}

impl std::ops::Add for Impulse {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { linear: self.linear + other.linear, angular: self.angular + other.angular }
    }
}

impl std::ops::Sub for Impulse {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self { linear: self.linear - other.linear, angular: self.angular - other.angular }
    }
}

/// A body at the start of a tick, as its engine knows it.
///
/// An engine that hears of the fluid's impulses late gives what it forecast ([`forecast`](Self::forecast)) and up to
/// where it has been corrected ([`corrected_before`](Self::corrected_before)); the solver adds the difference for the
/// ticks in between, which it remembers, so that the fluid always meets the body where it really is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodyInput {
    /// Centre of mass, m, world.
    pub position: Vec3,
    /// Orientation of the frame in which the plan's samples are given.
    pub rotation: Quat,
    /// Velocity of the centre of mass, m/s.
    pub linear_velocity: Vec3,
    /// Angular velocity, rad/s, world axes.
    pub angular_velocity: Vec3,
    /// 1/mass, 1/kg; zero for a body the fluid cannot move.
    pub inverse_mass: f32,
    /// Inverse inertia tensor in world axes, 1/(kg m2); zero for a body the fluid cannot turn.
    pub inverse_inertia: Mat3,
    /// Acceleration from everything but the fluid (gravity, mostly), m/s2.
    pub acceleration: Vec3,
    /// Impulse the engine applies to the body in this tick on the fluid's behalf.
    pub forecast: Impulse,
    /// The engine has heard the true impulses of all ticks before this one and has been corrected for them.
    pub corrected_before: u64,
    /// Whether displacements are corrected too (a body without contact or joint).
    pub free: bool,
    /// Whether it has been put at its place since the last tick: the tick starts from there. Otherwise it starts from where the last tick
    /// left the body, if that is near, and the body drifts to its place, pushing fluid.
    #[serde(default)]
    pub placed: bool,
}

impl Default for BodyInput {
    fn default() -> Self {
        Self {
            position: Vec3::ZERO,
            rotation: Quat::IDENTITY,
            linear_velocity: Vec3::ZERO,
            angular_velocity: Vec3::ZERO,
            inverse_mass: 0.0,
            inverse_inertia: Mat3::ZERO,
            acceleration: Vec3::ZERO,
            forecast: Impulse::default(),
            corrected_before: u64::MAX,
            free: true,
            placed: false,
        }
    }
}

impl BodyInput {
    fn validate(&self) -> Result<(), InvalidInput> {
        check_finite("position", self.position)?;
        check_finite("linear_velocity", self.linear_velocity)?;
        check_finite("angular_velocity", self.angular_velocity)?;
        check_finite("acceleration", self.acceleration)?;
        check_finite("forecast.linear", self.forecast.linear)?;
        check_finite("forecast.angular", self.forecast.angular)?;
        if !self.rotation.is_finite() || !self.rotation.is_normalized() {
            return Err(InvalidInput::new("rotation", self.rotation, "a unit quaternion"));
        }
        if !self.inverse_inertia.is_finite() {
            return Err(InvalidInput::new("inverse_inertia", self.inverse_inertia, "finite numbers"));
        }
        check_range("inverse_mass", self.inverse_mass, 0.0, f32::MAX, "1/kg")
    }
}

/// What one pass cost in one tick.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PassTime {
    /// Name of the pass, the same as in the schedule.
    pub pass: String,
    /// Sum over the tick's substeps, ms.
    pub milliseconds: f32,
}

/// What a solver says of one finished tick.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StepReport {
    /// Number of the tick.
    pub tick: u64,
    /// Live particles after the tick.
    pub particles: u32,
    /// Substeps made.
    pub substeps: u32,
    /// Smallest substep, s; zero if none was made.
    pub smallest_substep: f32,
    /// Time covered, s. Less than asked for if the budget ran out.
    pub simulated: f64,
    /// Time covered over time asked for, including what earlier ticks left over; 1 when real time is kept.
    pub time_scale: f32,
    /// Mean over particles of `max(density / rest_density - 1, 0)`; the largest of the tick's substeps.
    pub mean_compression: f32,
    /// Largest `max(density / rest_density - 1, 0)` of any particle in the tick.
    pub max_compression: f32,
    /// Largest speed in the last substep, m/s; of an incompressible fluid that which particles were expected to leave it with.
    pub max_speed: f32,
    /// Iterations of [divergence solves](crate::pressure_solver::DivergenceFree) in this tick, over all substeps; zero for a plan
    /// without.
    #[serde(default)]
    pub divergence_iterations: u32,
    /// Iterations of density solves likewise, and of [Poisson solves](crate::pressure_poisson).
    #[serde(default)]
    pub density_iterations: u32,
    /// What [Poisson solves](crate::pressure_poisson) of this tick left at most of what they began with, no unit; zero for plans without.
    #[serde(default)]
    pub residual: f32,
    /// Solves that ended at their most iterations before they were as exact as asked for.
    #[serde(default)]
    pub unsolved: u32,
    /// Substeps taken back because they turned out too long, and made again in shorter ones: see
    /// [`Settings::redo_substeps`](crate::scene::Settings::redo_substeps). They are in no other number but those of iterations.
    #[serde(default)]
    pub redone: u32,
    /// Particles removed in this tick because they left the bounds or were not finite.
    pub removed: u32,
    /// Those of the [`removed`](Self::removed) of which a coordinate or a component of the velocity was infinite or not a number,
    /// wherever they were. The others have left the bounds.
    #[serde(default)]
    pub not_finite: u32,
    /// Particles retired in this tick because their lifetime was over or a command said so.
    pub retired: u32,
    /// Particles not spawned in this tick because the capacity was reached.
    pub refused: u32,
    /// Particles left out in this tick because their centre was [inside a wall or a body](crate::solid): of those spawned, and
    /// on a solver's first tick of those of the start that are in a body. They have ids and are never simulated; they are not
    /// among the [`retired`](Self::retired). Those that start in a wall are left out by the plan:
    /// [`Plan::left_out`](crate::plan::Plan::left_out).
    #[serde(default)]
    pub inside_solids: u32,
    /// Particles left out likewise because a body was nearer to their centre than half a spacing, or a wall than a fifth: it would have blown
    /// them off. Those that flow in ([`NewParticles::at`]) may be as near.
    #[serde(default)]
    pub beside_solids: u32,
    /// Impulse of the fluid on each body over the tick, in the plan's order.
    pub bodies: Vec<Impulse>,
    /// Of each body, in the plan's order, the samples that the fluid reaches: those with the centre of a particle within the
    /// [support radius](crate::plan::Parameters::support_radius), on the CPU in the tick's first substep, or, while a body
    /// [swells](crate::swelling), in its last; on the GPU in its last.
    #[serde(default)]
    pub wetted: Vec<u32>,
    /// Cost of each pass, where it was measured.
    pub passes: Vec<PassTime>,
}
