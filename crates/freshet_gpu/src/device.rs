//! Opens a device for those who have none: tests, the lab, servers. Inside Bevy its own device is used.

use freshet_core::solver::SolverError;

use crate::errors::block_on;
use crate::layout::TEXTURE_WIDTH;

/// What a device should be able to do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DeviceRequest {
    /// Asks for time stamps, where the adapter has them.
    pub time_stamps: bool,
    /// Asks for the largest buffers the adapter offers instead of WebGPU's defaults (128 MiB a binding: 8 Mi particles).
    pub large_buffers: bool,
}

/// An open device.
#[derive(Clone, Debug)]
pub struct FluidDevice {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// What the adapter says of itself.
    pub adapter: wgpu::AdapterInfo,
}

impl FluidDevice {
    /// Whether the adapter is a program that runs on the CPU, such as llvmpipe.
    pub fn is_software(&self) -> bool {
        self.adapter.device_type == wgpu::DeviceType::Cpu
    }
}

/// Opens the fastest adapter with exactly `wgpu::Limits::default()` and no features, except for what is requested.
///
/// The validation of indirect arguments is off: wgpu makes it with one more dispatch each, and only the solver's own
/// passes write these arguments.
///
/// # Errors
/// [`SolverError::Device`] if there is no adapter, with what to install; [`SolverError::WeakAdapter`] if it cannot do
/// WebGPU's defaults.
pub fn open_device(request: DeviceRequest) -> Result<FluidDevice, SolverError> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    descriptor.flags.remove(wgpu::InstanceFlags::VALIDATION_INDIRECT_CALL);
    let instance = wgpu::Instance::new(descriptor);
    let options =
        wgpu::RequestAdapterOptions { power_preference: wgpu::PowerPreference::HighPerformance, ..Default::default() };
    let adapter = block_on(instance.request_adapter(&options)).map_err(|error| {
        SolverError::Device(format!(
            "no Vulkan, Metal or Direct3D 12 adapter ({error}); on Linux install one, in software if need be: apt-get \
             install -y mesa-vulkan-drivers libvulkan1"
        ))
    })?;
    let info = adapter.get_info();
    let offered = adapter.limits();
    let mut limits = wgpu::Limits::default();
    check_limits(&limits, &offered, &info.name)?;
    if request.large_buffers {
        limits.max_buffer_size = offered.max_buffer_size;
        limits.max_storage_buffer_binding_size = offered.max_storage_buffer_binding_size;
    }
    let features = if request.time_stamps {
        adapter.features() & wgpu::Features::TIMESTAMP_QUERY
    } else {
        wgpu::Features::empty()
    };
    let (device, queue) = block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        label: Some("freshet:device:solver"),
        required_features: features,
        required_limits: limits,
        ..Default::default()
    }))
    .map_err(|error| SolverError::Device(format!("{}: {error}", info.name)))?;
    Ok(FluidDevice { device, queue, adapter: info })
}

/// Names the first limit that `offered` does not reach.
fn check_limits(needed: &wgpu::Limits, offered: &wgpu::Limits, adapter: &str) -> Result<(), SolverError> {
    let mut weak = None;
    needed.check_limits_with_fail_fn(offered, true, |limit, needed, offered| {
        weak = Some(SolverError::WeakAdapter { adapter: adapter.to_owned(), limit: limit.to_owned(), offered, needed });
    });
    weak.map_or(Ok(()), Err)
}

/// Checks that a device can run the solver with buffers of at most `largest` bytes.
pub(crate) fn check_device(device: &wgpu::Device, largest: u64) -> Result<(), SolverError> {
    let limits = device.limits();
    let needs = [
        ("max_storage_buffer_binding_size", limits.max_storage_buffer_binding_size, largest),
        ("max_buffer_size", limits.max_buffer_size, largest),
        ("max_storage_buffers_per_shader_stage", u64::from(limits.max_storage_buffers_per_shader_stage), 8),
        ("max_compute_invocations_per_workgroup", u64::from(limits.max_compute_invocations_per_workgroup), 256),
        ("max_compute_workgroup_storage_size", u64::from(limits.max_compute_workgroup_storage_size), 16384),
    ];
    first_missing(device, &needs)
}

/// Checks that a device can hold `texels` texels in a texture.
pub(crate) fn check_textures(device: &wgpu::Device, texels: u64) -> Result<(), SolverError> {
    let limits = device.limits();
    let rows = texels.div_ceil(u64::from(TEXTURE_WIDTH));
    let needs = [
        ("max_texture_dimension_2d", u64::from(limits.max_texture_dimension_2d), rows),
        ("max_storage_textures_per_shader_stage", u64::from(limits.max_storage_textures_per_shader_stage), 3),
    ];
    first_missing(device, &needs)
}

fn first_missing(device: &wgpu::Device, needs: &[(&str, u64, u64)]) -> Result<(), SolverError> {
    match needs.iter().find(|(_, offered, needed)| offered < needed) {
        Some(&(limit, offered, needed)) => Err(SolverError::WeakAdapter {
            adapter: device.adapter_info().name,
            limit: limit.to_owned(),
            offered,
            needed,
        }),
        None => Ok(()),
    }
}
