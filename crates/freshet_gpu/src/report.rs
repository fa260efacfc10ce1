//! From what the GPU writes to a [`StepReport`].

use freshet_core::solver::SolverError;
use freshet_core::step::{Impulse, StepReport};

use crate::layout::{BodyRecord, StepControl};

/// What came back from the GPU at the end of a tick.
#[derive(Clone, Debug)]
pub(crate) struct Arrival {
    /// The GPU's own account.
    pub control: StepControl,
    /// Bodies.
    pub bodies: Vec<BodyRecord>,
    /// Time stamps, as bytes.
    pub stamps: Vec<u8>,
}

impl Arrival {
    /// Takes apart what was copied: the control, `bodies` bodies, then time stamps.
    pub fn parse(bytes: &[u8], bodies: usize) -> Result<Self, SolverError> {
        let short = || SolverError::Device("a report is too short".to_owned());
        let (control, rest) = bytes.split_at_checked(size_of::<StepControl>()).ok_or_else(short)?;
        let (body_bytes, stamps) = rest.split_at_checked(size_of::<BodyRecord>() * bodies).ok_or_else(short)?;
        Ok(Self {
            control: bytemuck::pod_read_unaligned(control),
            bodies: body_bytes.chunks_exact(size_of::<BodyRecord>()).map(bytemuck::pod_read_unaligned).collect(),
            stamps: stamps.to_vec(),
        })
    }

    /// Time the tick covered, s.
    fn simulated(&self) -> f32 {
        self.control.asked - self.control.remaining
    }

    /// The GPU's clock at the end of the tick, to which `begin_tick` sets it.
    pub fn clock(&self) -> u32 {
        self.control.clock.wrapping_add((self.simulated() * 16_777_216.0) as u32)
    }

    /// The report of tick `tick`, without times.
    pub fn report(&self, tick: u64) -> StepReport {
        let control = &self.control;
        let simulated = self.simulated();
        let ratio = f32::from_bits(control.max_ratio.0);
        StepReport {
            tick,
            particles: control.count,
            substeps: control.substeps,
            smallest_substep: control.smallest_substep,
            simulated: f64::from(simulated),
            time_scale: if control.asked > 0.0 { simulated / control.asked } else { 1.0 },
            mean_compression: control.mean_compression,
            max_compression: (ratio - 1.0).max(0.0),
            max_speed: control.fastest,
            divergence_iterations: control.divergence_iterations,
            density_iterations: control.density_iterations,
            residual: control.residual,
            unsolved: control.unsolved,
            redone: control.redone,
            removed: control.removed.0,
            not_finite: control.not_finite.0,
            retired: control.retired.0,
            refused: control.refused,
            // Only the CPU knows of those.
            inside_solids: 0,
            beside_solids: 0,
            bodies: self
                .bodies
                .iter()
                .map(|body| Impulse { linear: body.impulse_linear, angular: body.impulse_angular })
                .collect(),
            wetted: self.bodies.iter().map(|body| body.wetted).collect(),
            passes: Vec::new(),
        }
    }
}
