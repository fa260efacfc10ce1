//! Which particles came from which volume, so that they go when it goes.
//!
//! A solver numbers particles as they are made, and those refused for want of room get no number. So the ids of a spawn
//! are known when its tick is; until then a removal waits.

use std::collections::VecDeque;

use bevy::prelude::*;
use freshet_core::step::{Command, StepReport};

use super::state::DomainState;
use crate::components::domain::FluidDomain;
use crate::components::volume::FluidVolume;

/// On a volume: it has been poured into this domain, or refused there.
#[derive(Component, Clone, PartialEq)]
pub(crate) struct Poured {
    pub(crate) domain: Entity,
    /// The values that were refused; pouring is tried again when they change.
    pub(crate) refused: Option<FluidVolume>,
}

/// Particles made in one tick; the owner is a volume, an emitter has none.
struct Spawned {
    tick: u64,
    owner: Option<Entity>,
    count: u32,
}

/// The particles of one volume.
struct Pour {
    owner: Entity,
    /// As asked for.
    count: u32,
    /// First id and count, once known.
    ids: Option<(u32, u32)>,
    /// The volume has gone.
    orphaned: bool,
}

/// Which particles are whose.
#[derive(Default)]
pub(crate) struct Pours {
    next_id: u32,
    pours: Vec<Pour>,
    spawned: VecDeque<Spawned>,
}

impl Pours {
    /// Notes particles that are there from the start, in the order of their ids.
    pub(crate) fn start(&mut self, owner: Entity, count: u32) {
        self.pours.push(Pour { owner, count, ids: Some((self.next_id, count)), orphaned: false });
        self.next_id += count;
    }

    /// Notes particles spawned in a tick.
    pub(crate) fn spawn(&mut self, tick: u64, owner: Option<Entity>, count: u32) {
        self.spawned.push_back(Spawned { tick, owner, count });
        if let Some(owner) = owner {
            self.pours.push(Pour { owner, count, ids: None, orphaned: false });
        }
    }

    /// Particles of all volumes that are there, as asked for.
    pub(crate) fn claimed(&self) -> u64 {
        self.pours.iter().map(|pour| u64::from(pour.count)).sum()
    }

    /// Particles spawned in ticks that are not known.
    pub(crate) fn unknown(&self) -> u64 {
        self.spawned.iter().map(|spawned| u64::from(spawned.count)).sum()
    }

    /// Whether a tick that is not known has particles of volumes: those of the start, or poured into the fluid.
    pub(crate) fn made_by(&self, tick: u64) -> bool {
        let mut spawned = self.spawned.iter().take_while(|spawned| spawned.tick <= tick);
        tick == 0 || spawned.any(|spawned| spawned.owner.is_some())
    }

    /// Learns the ids of a tick's particles; returns what removes those whose volume has gone meanwhile.
    pub(crate) fn learn(&mut self, report: &StepReport) -> Vec<Command> {
        let of_tick = self.spawned.iter().take_while(|spawned| spawned.tick <= report.tick).count();
        let made: Vec<Spawned> = self.spawned.drain(..of_tick).collect();
        let asked: u64 = made.iter().map(|spawned| u64::from(spawned.count)).sum();
        // Within a tick room only shrinks, so it is the last ones that were refused.
        let mut room = asked.saturating_sub(u64::from(report.refused));
        let mut removals = Vec::new();
        for Spawned { owner, count, .. } in made {
            let count = u64::from(count).min(room) as u32;
            room -= u64::from(count);
            let ids = (self.next_id, count);
            self.next_id = self.next_id.wrapping_add(count);
            let pour = self.pours.iter_mut().find(|pour| Some(pour.owner) == owner && pour.ids.is_none());
            if let Some(pour) = pour {
                pour.ids = Some(ids);
                if pour.orphaned {
                    removals.push(Command::RemoveIds { first: ids.0, count: ids.1 });
                }
            }
        }
        self.pours.retain(|pour| !(pour.orphaned && pour.ids.is_some()));
        removals
    }

    /// The volume has gone; returns what removes its particles, if their ids are known.
    fn release(&mut self, owner: Entity) -> Option<Command> {
        let index = self.pours.iter().position(|pour| pour.owner == owner && !pour.orphaned)?;
        match self.pours[index].ids {
            Some((first, count)) => {
                self.pours.swap_remove(index);
                Some(Command::RemoveIds { first, count })
            }
            None => {
                self.pours[index].orphaned = true;
                None
            }
        }
    }
}

/// Despawning a volume removes its particles.
pub(crate) fn remove_particles(
    removed: On<Remove, FluidVolume>,
    poured: Query<&Poured>,
    mut domains: Query<&mut DomainState>,
    mut commands: Commands,
) {
    let Ok(Poured { domain, .. }) = poured.get(removed.entity) else { return };
    if let Ok(mut state) = domains.get_mut(*domain) {
        let removal = state.pours.release(removed.entity);
        state.commands.extend(removal);
    }
    // Only the component may have gone, and another one may come.
    commands.entity(removed.entity).try_remove::<Poured>();
}

/// A domain takes its particles with it; the next one starts from all volumes.
pub(crate) fn forget_domain(
    removed: On<Remove, FluidDomain>,
    poured: Query<(Entity, &Poured)>,
    mut commands: Commands,
) {
    for (entity, _) in poured.iter().filter(|(_, poured)| poured.domain == removed.entity) {
        commands.entity(entity).try_remove::<Poured>();
    }
    commands.entity(removed.entity).try_remove::<DomainState>();
}
