//! What is run repeatedly.

use super::BenchScene;
use crate::backend::Backend;

/// A scene at a size on a solver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Configuration {
    /// What flows.
    pub scene: BenchScene,
    /// Where.
    pub backend: Backend,
    /// Threads of the CPU solver, none on the GPU.
    pub threads: Option<usize>,
    /// Particles asked for; Krog's scene has up to 2 % more or less.
    pub particles: u32,
}

impl Configuration {
    /// The solver alone, as charts name it.
    pub fn solver(&self) -> String {
        match (self.backend, self.threads) {
            (Backend::Gpu, _) => "GPU".to_owned(),
            (Backend::Cpu, Some(1)) => "CPU, 1 thread".to_owned(),
            (Backend::Cpu, threads) => format!("CPU, {} threads", threads.unwrap_or(0)),
        }
    }
}

impl std::fmt::Display for Configuration {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}, {} particles, {}", self.scene.name(), self.particles, self.backend)?;
        match self.threads {
            Some(1) => write!(f, ", 1 thread"),
            Some(threads) => write!(f, ", {threads} threads"),
            None => Ok(()),
        }
    }
}
