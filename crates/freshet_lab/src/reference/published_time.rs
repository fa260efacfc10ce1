//! Times that others published for their solvers.

/// What a step took somewhere else.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PublishedTime {
    /// The scene's particles.
    pub particles: u32,
    /// Wall time of a step, ms.
    pub milliseconds: f64,
    /// On what.
    pub hardware: &'static str,
    /// Where it stands, and what is in it.
    pub source: &'static str,
}

impl PublishedTime {
    /// Nanoseconds per particle and step.
    pub fn nanoseconds(&self) -> f64 {
        self.milliseconds * 1e6 / f64::from(self.particles)
    }
}
