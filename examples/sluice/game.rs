//! The rules: what counts, and how a level ends.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_freshet::prelude::*;

use crate::crates;
use crate::gates::Gate;
use crate::level::{Action, Level};
use crate::paint::Paints;
use crate::site::{self, Method, OnSite};
use crate::wheel::Turning;

/// All levels.
#[derive(Resource)]
pub struct Levels(pub Vec<Level>);

/// How the level being played stands.
#[derive(Resource, Clone, Debug, Default)]
pub struct Game {
    /// Its number; 0 is the first.
    pub level: usize,
    /// Where in it the player is.
    pub phase: Phase,
    /// Time played, s.
    pub time: f32,
    /// Water in the basin, l.
    pub litres: f32,
    /// Water that there is, l.
    pub there: f32,
    /// Turns of the wheel.
    pub turns: f32,
    /// Crates that may still be placed.
    pub crates: u32,
    /// Moves of the level's file made so far.
    moves_made: usize,
}

/// Where the player is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Phase {
    /// The hint is shown.
    #[default]
    Waiting,
    /// The time runs.
    Playing,
    /// The goal is reached.
    Won,
    /// The time is over.
    TimeIsOver,
    /// What water there is, or will come, is less than the goal.
    WaterIsLost,
}

impl Phase {
    /// In summaries.
    pub fn name(self) -> &'static str {
        match self {
            Self::Waiting => "waiting",
            Self::Playing => "playing",
            Self::Won => "won",
            Self::TimeIsOver => "time is over",
            Self::WaterIsLost => "water is lost",
        }
    }
}

impl Game {
    /// A level from its start.
    pub fn new(level: usize, levels: &Levels) -> Self {
        let crates = levels.0[level].crates.count;
        Self { level, crates, ..default() }
    }

    /// Points: for the time that is left, what is in the basin beyond the goal, and crates that were not needed.
    pub fn score(&self, level: &Level) -> u32 {
        if self.phase != Phase::Won {
            return 0;
        }
        let left = (level.goal.seconds - self.time).max(0.0);
        let more = (self.litres - level.goal.litres).max(0.0);
        (1000.0 + 20.0 * left + 2.0 * more + 100.0 * self.crates as f32) as u32
    }
}

/// Acts for the player.
#[derive(SystemParam)]
pub struct Hands<'w, 's> {
    commands: Commands<'w, 's>,
    meshes: ResMut<'w, Assets<Mesh>>,
    paints: Res<'w, Paints>,
    levels: Res<'w, Levels>,
    game: ResMut<'w, Game>,
    gates: Query<'w, 's, &'static mut Gate>,
    domains: Query<'w, 's, Entity, With<FluidDomain>>,
}

impl Hands<'_, '_> {
    /// Makes a move, if it is allowed now.
    pub fn act(&mut self, action: Action) {
        if self.game.phase != Phase::Playing {
            return;
        }
        match action {
            Action::Gate(number) => {
                for mut gate in self.gates.iter_mut().filter(|gate| gate.number == number) {
                    gate.is_open = !gate.is_open;
                }
            }
            Action::Crate(at) => {
                let (Ok(domain), true) = (self.domains.single(), self.game.crates > 0) else { return };
                self.game.crates -= 1;
                let crates = &self.levels.0[self.game.level].crates;
                crates::spawn(&mut self.commands, &mut self.meshes, &self.paints, domain, (crates, at));
            }
        }
    }
}

/// Makes the moves of the level's file whose time has come; in fixed ticks.
pub fn autoplay(mut hands: Hands) {
    let due = |hands: &Hands| {
        let next = hands.levels.0[hands.game.level].moves.get(hands.game.moves_made)?;
        (hands.game.phase == Phase::Playing && next.at <= hands.game.time).then_some(next.what)
    };
    while let Some(action) = due(&hands) {
        hands.game.moves_made += 1;
        hands.act(action);
    }
}

/// Builds a level, and takes away the one before.
#[derive(SystemParam)]
pub struct Builder<'w, 's> {
    commands: Commands<'w, 's>,
    meshes: ResMut<'w, Assets<Mesh>>,
    paints: Res<'w, Paints>,
    method: Res<'w, Method>,
    levels: Res<'w, Levels>,
    game: ResMut<'w, Game>,
    old: Query<'w, 's, Entity, With<OnSite>>,
}

impl Builder<'_, '_> {
    /// Builds a level; it waits to be begun.
    pub fn build(&mut self, level: usize) {
        for entity in &self.old {
            self.commands.entity(entity).despawn();
        }
        *self.game = Game::new(level, &self.levels);
        site::spawn(&mut self.commands, &mut self.meshes, &self.paints, &self.method, &self.levels.0[level]);
    }

    /// Builds the level that the game is in.
    pub fn rebuild(&mut self) {
        self.build(self.game.level);
    }

    /// Builds the next level, after the last one the first.
    pub fn build_next(&mut self) {
        self.build((self.game.level + 1) % self.levels.0.len());
    }

    /// The time runs.
    pub fn begin(&mut self) {
        self.game.phase = Phase::Playing;
    }
}

/// Counts the water in the basin.
pub fn note_water(
    read: On<FluidReadbackComplete>,
    domains: Query<&FluidDomain>,
    levels: Res<Levels>,
    mut game: ResMut<Game>,
) {
    let positions = read.get(FluidField::Position).cloned().and_then(|positions| positions.vectors());
    let (Some(positions), Ok(domain)) = (positions, domains.get(read.entity)) else { return };
    let basin = levels.0[game.level].basin;
    let of_one = 1000.0 * domain.spacing.powi(3);
    let inside = positions.iter().filter(|position| basin.contains(position.truncate())).count();
    game.litres = inside as f32 * of_one;
    game.there = positions.len() as f32 * of_one;
}

/// Decides how the level stands; in fixed ticks.
pub fn judge(time: Res<Time>, levels: Res<Levels>, wheels: Query<&Turning>, mut game: ResMut<Game>) {
    if game.phase != Phase::Playing {
        return;
    }
    let level = &levels.0[game.level];
    game.time += time.delta_secs();
    game.turns = wheels.iter().map(|wheel| wheel.turns).sum();
    let to_come = 1000.0 * level.flow() * (level.goal.seconds - game.time).max(0.0);
    if game.litres >= level.goal.litres && game.turns >= level.goal.turns {
        game.phase = Phase::Won;
    } else if game.time >= level.goal.seconds {
        game.phase = Phase::TimeIsOver;
    } else if game.there > 0.0 && game.there + to_come < level.goal.litres {
        game.phase = Phase::WaterIsLost;
    }
}

/// What both ways of playing have in common.
pub fn furnish(app: &mut App, levels: Vec<Level>, level: usize, method: Method) {
    let levels = Levels(levels);
    app.insert_resource(Game::new(level, &levels))
        .insert_resource(levels)
        .insert_resource(method)
        .add_systems(PreStartup, make_paints)
        .add_systems(
            FixedUpdate,
            (
                crate::gates::slide.before(bevy_rapier3d::prelude::PhysicsSet::SyncBackend),
                (crate::wheel::count, judge).chain().after(FreshetSystems::Complete),
            ),
        )
        .add_observer(note_water);
}

fn make_paints(mut commands: Commands, mut materials: ResMut<Assets<StandardMaterial>>) {
    commands.insert_resource(Paints::new(&mut materials));
}
