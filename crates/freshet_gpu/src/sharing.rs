//! What others may see of the solver: its buffers, for drawing, and its shaders.

use freshet_core::solver::SolverError;

use crate::layout::Binding;
#[cfg(doc)]
use crate::layout::StepControl;
use crate::passes::Arguments;
use crate::shader::{compose, text};
use crate::solver::GpuSolver;

/// The solver's buffers, for those who draw or read them on the GPU. They have `STORAGE` and `COPY_SRC`.
#[derive(Clone, Copy, Debug)]
pub struct FluidBuffers<'a> {
    /// `array<ParticleRecord>`, 32 bytes each: `position: vec3<f32>` (m), `id: u32`, `velocity: vec3<f32>` (m/s),
    /// `remaining_life: f32` (s).
    pub particles: &'a wgpu::Buffer,
    /// `array<vec2<f32>>`: density (kg/m3) and pressure over its square.
    pub densities: &'a wgpu::Buffer,
    /// `array<AccelerationRecord>`, 16 bytes each: `acceleration: vec3<f32>` (m/s2), then scratch.
    pub accelerations: &'a wgpu::Buffer,
    /// [`StepControl`]; the number of particles is its member `count`.
    pub control: &'a wgpu::Buffer,
    /// Has `INDIRECT`. At [`draw_offset`](Self::draw_offset): `DrawIndirectArgs` of four vertices and an instance for
    /// each particle, for `draw_indirect` with a triangle strip.
    pub arguments: &'a wgpu::Buffer,
    /// Offset of the arguments of drawing in bytes.
    pub draw_offset: u64,
    /// Changes whenever buffers were replaced by larger or smaller ones, so that bind groups must be made anew.
    pub generation: u64,
}

impl GpuSolver {
    /// What renderers and user shaders may read.
    ///
    /// # Errors
    /// Never for a solver that was made; the type says so because nothing here panics.
    pub fn buffers(&self) -> Result<FluidBuffers<'_>, SolverError> {
        let get = |binding: Binding| {
            self.buffers.get(binding).ok_or_else(|| SolverError::Device(format!("no buffer {}", binding.name())))
        };
        Ok(FluidBuffers {
            particles: get(Binding::Particles)?,
            densities: get(Binding::Densities)?,
            accelerations: get(Binding::Accelerations)?,
            control: get(Binding::Control)?,
            arguments: get(Binding::Arguments)?,
            draw_offset: 12 * u64::from(Arguments::COUNT),
            generation: self.generation,
        })
    }

    /// Bytes of all buffers the solver holds, counted where buffers are made and dropped, apart from the schedule.
    ///
    /// A tick's commands travel in buffers of that tick, and downloads through one of their own: these are neither here nor in
    /// the schedule, and the device frees them when it has done with them.
    pub fn allocated_bytes(&self) -> u64 {
        self.memory.bytes()
    }

    /// The WGSL of a pass as the plan selected it, without what it does not use; none if the plan does not have it.
    pub fn shader(&self, pass: &str) -> Option<String> {
        let pipeline = self.compiled.in_order().find(|pipeline| pipeline.pass.name == pass)?;
        text(compose(&pipeline.pass, self.compiled.definitions(), &self.options).ok()?)
    }
}
