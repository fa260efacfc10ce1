//! How the solver runs, apart from what it simulates.

use freshet_core::error::InvalidInput;

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
    /// For tests: replaces a piece of WGSL by another before compiling.
    #[doc(hidden)]
    pub patch: Option<(&'static str, &'static str)>,
}

impl Default for GpuOptions {
    fn default() -> Self {
        Self { workgroup_size: 64, time_stamps: false, patch: None }
    }
}

impl GpuOptions {
    pub(crate) fn validate(&self) -> Result<(), InvalidInput> {
        if [32, 64, 256].contains(&self.workgroup_size) {
            Ok(())
        } else {
            Err(InvalidInput::new("workgroup_size", self.workgroup_size, "32, 64 or 256"))
        }
    }
}
