//! Problems are said once, when they begin.

use bevy::prelude::*;

use crate::components::problem::report;

/// Something that is wrong as long as nobody changes it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Problem {
    pub(crate) entity: Entity,
    pub(crate) component: &'static str,
    pub(crate) message: String,
}

impl Problem {
    pub(crate) fn new(entity: Entity, component: &'static str, message: impl ToString) -> Self {
        Self { entity, component, message: message.to_string() }
    }
}

/// What is wrong at the moment.
#[derive(Resource, Default)]
pub(crate) struct Problems(Vec<Problem>);

impl Problems {
    /// What is wrong at the moment.
    #[cfg(test)]
    pub(crate) fn current(&self) -> &[Problem] {
        &self.0
    }

    /// Says those that were not there in the last tick.
    pub(crate) fn update(&mut self, current: Vec<Problem>, commands: &mut Commands) {
        for problem in &current {
            if !self.0.contains(problem) {
                report(commands, problem.entity, problem.component, &problem.message);
            }
        }
        self.0 = current;
    }
}
