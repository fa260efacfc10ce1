//! How the solver runs, apart from what it simulates.

use freshet_core::error::InvalidInput;

/// What holds the positions and velocities that passes read of every neighbour: most of what they read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NeighbourMemory {
    /// [`Textures`](Self::Textures) on adapters that are programs on the CPU, [`Buffers`](Self::Buffers) elsewhere.
    #[default]
    Auto,
    /// Storage buffers: contiguous, what the caches of graphics processors are made for.
    Buffers,
    /// Storage textures of four words a texel. Mesa's software driver loads buffers one lane after the other, texels of
    /// textures for all lanes of a vector at once. Its time stamps then are late: what the sort takes is counted for the
    /// density.
    Textures,
}

/// Settings of a [`GpuSolver`](crate::GpuSolver) that change its speed, not its results.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GpuOptions {
    /// Threads in a workgroup: 32, 64 or 256.
    ///
    /// 64 fills the wavefronts of every vendor (32 or 64 wide), and threads that differ in their number of neighbours
    /// hold up few others; the passes use no shared memory that would gain from larger groups.
    pub workgroup_size: u32,
    /// Measures each pass, where the device has `TIMESTAMP_QUERY`. Passes then are compute passes of their own, which
    /// costs a little; the first [`MEASURED_SUBSTEPS`](crate::MEASURED_SUBSTEPS) of a tick are measured.
    pub time_stamps: bool,
    /// What holds that which passes read of every neighbour.
    pub neighbours: NeighbourMemory,
    /// For tests: replaces a piece of WGSL by another before compiling.
    #[doc(hidden)]
    pub patch: Option<(&'static str, &'static str)>,
}

impl Default for GpuOptions {
    fn default() -> Self {
        Self { workgroup_size: 64, time_stamps: false, neighbours: NeighbourMemory::Auto, patch: None }
    }
}

impl GpuOptions {
    /// Decides what was left open.
    pub(crate) fn for_device(self, device: &wgpu::Device) -> Self {
        let neighbours = match self.neighbours {
            NeighbourMemory::Auto if device.adapter_info().device_type == wgpu::DeviceType::Cpu => {
                NeighbourMemory::Textures
            }
            NeighbourMemory::Auto => NeighbourMemory::Buffers,
            chosen => chosen,
        };
        Self { neighbours, ..self }
    }

    /// Whether textures hold what passes read of every neighbour.
    pub(crate) fn textures(&self) -> bool {
        self.neighbours == NeighbourMemory::Textures
    }

    pub(crate) fn validate(&self) -> Result<(), InvalidInput> {
        if [32, 64, 256].contains(&self.workgroup_size) {
            Ok(())
        } else {
            Err(InvalidInput::new("workgroup_size", self.workgroup_size, "32, 64 or 256"))
        }
    }
}
