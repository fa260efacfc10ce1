//! What went wrong in the app: each is one line in the log, and the first of them is the program's end.

use std::sync::{Arc, Mutex, PoisonError};

use bevy::prelude::*;
use bevy_freshet::prelude::*;

/// What went wrong so far; shared, because the app is gone when it is asked for.
#[derive(Resource, Clone, Default)]
pub struct Trouble(Arc<Mutex<Vec<String>>>);

impl Trouble {
    /// Notes what has not been logged.
    pub fn note(&self, message: String) {
        error!("{message}");
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(message);
    }

    /// The first of it, in one line.
    pub fn result(&self) -> Result<(), String> {
        let messages = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match messages.as_slice() {
            [] => Ok(()),
            [only] => Err(only.clone()),
            [first, more @ ..] => Err(format!("{first} (and {} more, see above)", more.len())),
        }
    }
}

/// Notes what the fluid complains of, which it logs itself.
pub fn listen(mut problems: MessageReader<FluidProblem>, domains: Query<&FluidDomain>, trouble: Res<Trouble>) {
    for problem in problems.read() {
        // Whoever leaves the choice to the app has got one.
        let is_auto = domains.get(problem.entity).is_ok_and(|domain| domain.backend == FluidBackend::Auto);
        if !(is_auto && problem.message.starts_with("backend: ")) {
            trouble.0.lock().unwrap_or_else(PoisonError::into_inner).push(problem.to_string());
        }
    }
}
