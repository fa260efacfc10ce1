//! What the plugin remembers of a domain.

use std::collections::{HashMap, HashSet, VecDeque};

use bevy::prelude::*;
use freshet_core::emitter::EmitterFlow;
use freshet_core::leaks::LeakWatch;
use freshet_core::plan::Plan;
use freshet_core::run::SimulatedClock;
use freshet_core::sampling::wall_layer::WallLayer;
use freshet_core::scene::{Body, Boundary};
use freshet_core::step::{BodyInput, Command, Impulse};

use super::movers::{MoverBodies, MovingWall};
use super::pours::Pours;
use super::problems::Problem;
use super::recipe::Recipe;
use crate::components::domain::{FluidBackend, FluidMode};
use crate::engine::Engine;

/// Gravity of domains that do not give their own, m/s2; the coupling keeps it at rapier's.
#[derive(Resource, Clone, Copy)]
pub(crate) struct DefaultGravity(pub(crate) Vec3);

impl Default for DefaultGravity {
    fn default() -> Self {
        Self(Vec3::new(0.0, -9.81, 0.0))
    }
}

/// A body as the fluid sees it, made by the coupling; without it a [`FluidBody`](crate::prelude::FluidBody) is not
/// simulated.
#[derive(Component)]
pub(crate) struct BodySamples {
    /// Samples relative to the centre of mass.
    pub(crate) body: Body,
    /// Differs whenever `body` does.
    pub(crate) version: u64,
}

/// A tick that has been sent.
pub(crate) struct SentTick {
    pub(crate) tick: u64,
    /// Bodies of the plan at that time, in its order.
    pub(crate) bodies: Vec<Entity>,
}

/// What the fluid did to bodies in one tick.
pub(crate) struct Pushes {
    pub(crate) tick: u64,
    /// Time covered, s.
    pub(crate) simulated: f32,
    pub(crate) bodies: Vec<Push>,
}

/// What the fluid did to a body.
pub(crate) struct Push {
    pub(crate) body: Entity,
    /// In the domain's axes.
    pub(crate) impulse: Impulse,
    /// Samples that the fluid reaches.
    pub(crate) wetted: u32,
}

/// What the plugin remembers of a domain.
#[derive(Component, Default)]
pub(crate) struct DomainState {
    /// Executes the ticks, once there is fluid.
    pub(crate) engine: Option<Engine>,
    /// What was asked to execute them; the CPU may have stepped in.
    pub(crate) backend: Option<FluidBackend>,
    /// Whether ticks are waited for.
    pub(crate) mode: FluidMode,
    /// The plan being executed, without its particles.
    pub(crate) plan: Option<Plan>,
    /// What that plan was made from.
    pub(crate) recipe: Option<Recipe>,
    /// What was wrong with the recipe.
    pub(crate) problems: Vec<Problem>,
    /// There are problems that came up outside of planning, which is what says them.
    pub(crate) has_unsaid_problems: bool,
    /// Why the engine stopped; it is made anew when the recipe changes.
    pub(crate) stopped: bool,
    /// A wall is not there yet: no ticks until it is.
    pub(crate) waits: bool,
    /// Which particles are whose.
    pub(crate) pours: Pours,
    /// Gravity as the solver was last told, m/s2.
    pub(crate) gravity: Vec3,
    /// Simulated time, as far as it is known.
    pub(crate) clock: SimulatedClock,
    /// Emitters of the plan; those that were refused are only in the recipe.
    pub(crate) emitters: Vec<Entity>,
    /// What each emitter has sent.
    pub(crate) flows: HashMap<Entity, EmitterFlow>,
    /// From the domain's frame to the world.
    pub(crate) frame: Isometry3d,
    /// For the coming tick, in order.
    pub(crate) commands: Vec<Command>,
    /// Bodies of the plan, in its order.
    pub(crate) body_entities: Vec<Entity>,
    /// Their states at the coming tick, in the domain's frame; made by the coupling.
    pub(crate) body_inputs: Vec<BodyInput>,
    /// Walls that move, which are the last of the plan's bodies, in its order.
    pub(crate) movers: Vec<MovingWall>,
    /// Their samples.
    pub(crate) mover_bodies: MoverBodies,
    /// Walls that have been moved, and count as moving from there on.
    pub(crate) moved: HashSet<Entity>,
    /// Walls of the plan's that were put elsewhere while time stood still: they have not been moved.
    pub(crate) placed: HashSet<Entity>,
    /// All walls of the plan, and then those that move, where they were when it was made.
    pub(crate) boundaries: Vec<Boundary>,
    /// Where samples of walls lie.
    pub(crate) layer: Option<WallLayer>,
    /// Looks for leaks, where they are counted.
    pub(crate) watch: Option<LeakWatch>,
    /// A wall's scale has changed, which only planning can deal with.
    pub(crate) asks_for_planning: bool,
    /// Number of the coming tick.
    pub(crate) tick: u64,
    /// Ticks sent and not known.
    pub(crate) sent: VecDeque<SentTick>,
    /// Taken by the coupling.
    pub(crate) pushes: Vec<Pushes>,
}

impl DomainState {
    /// Whether ticks are sent.
    pub(crate) fn runs(&self) -> bool {
        self.engine.is_some() && !self.stopped && !self.waits
    }

    /// Notes a problem that came up while running; it is said in the next tick.
    pub(crate) fn complain(&mut self, problem: Problem) {
        if !self.problems.contains(&problem) {
            self.problems.push(problem);
            self.has_unsaid_problems = true;
        }
    }
}
