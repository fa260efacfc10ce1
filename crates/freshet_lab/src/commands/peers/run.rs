//! What every peer delivers.

use std::time::Duration;

use glam::Vec3;

/// Seconds between frames: three ticks of a sixtieth.
pub const FRAME_INTERVAL: f64 = 0.05;

/// What is asked of a peer.
#[derive(Clone, Copy, Debug)]
pub struct Task {
    /// Particles of the tank, a cube of a whole number.
    pub particles: u32,
    /// Spacing, m.
    pub spacing: f64,
    /// Simulated time, a whole number of frames, s.
    pub seconds: f64,
    /// Threads of CPU solvers.
    pub threads: usize,
}

impl Task {
    /// Number of frames.
    pub fn frames(&self) -> u32 {
        (self.seconds / FRAME_INTERVAL).round() as u32
    }
}

/// A moment of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Simulated time, s.
    pub time: f64,
    /// Positions, m; the corner of the water is the origin, y is up.
    pub positions: Vec<Vec3>,
}

/// What a system says of its own run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kept {
    /// Particles lost: removed or refused.
    pub lost: u64,
    /// Smallest time covered over time asked for of any tick.
    pub time_scale: f64,
}

/// A finished run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Finished {
    /// Wall time of the stepping alone.
    pub wall: Duration,
    /// Steps made.
    pub steps: u64,
    /// Every [`FRAME_INTERVAL`], without the start.
    pub frames: Vec<Frame>,
    /// What it says of itself; none of systems that say nothing.
    pub kept: Option<Kept>,
}
