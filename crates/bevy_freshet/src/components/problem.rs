//! What went wrong, for programs; the same stands in the log.

use bevy::prelude::*;

/// Something a user asked for cannot be done. The rest goes on.
///
/// Sent as an entity event to the entity concerned and as a message for those who watch all.
#[derive(EntityEvent, Message, Clone, Debug, PartialEq, Eq)]
pub struct FluidProblem {
    /// The entity concerned.
    #[event_target]
    pub entity: Entity,
    /// The component concerned.
    pub component: &'static str,
    /// Field, value and what is allowed, in one line.
    pub message: String,
}

impl std::fmt::Display for FluidProblem {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} of entity {}: {}", self.component, self.entity, self.message)
    }
}

/// Logs a problem and sends it both ways.
pub(crate) fn report(commands: &mut Commands, entity: Entity, component: &'static str, message: impl ToString) {
    let problem = FluidProblem { entity, component, message: message.to_string() };
    error!("{problem}");
    commands.queue(move |world: &mut World| {
        world.write_message(problem.clone());
        // The entity may be gone by now; then there is nobody to tell.
        if world.get_entity(problem.entity).is_ok() {
            world.trigger(problem);
        }
    });
}
