//! Where the solver's buffers and textures are made, and the count of their bytes.

use std::ops::Deref;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::layout::TEXTURE_WIDTH;

/// What the textures hold in a texel: four words.
pub(crate) const TEXEL_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;

/// Bytes of a texel.
pub(crate) const TEXEL_BYTES: u64 = 16;

/// Bytes of the buffers and textures that were made and not given back.
#[derive(Clone, Debug, Default)]
pub(crate) struct Memory {
    bytes: Arc<AtomicU64>,
}

impl Memory {
    /// Makes a buffer and counts it until it is dropped.
    pub fn allocate(&self, device: &wgpu::Device, about: &wgpu::BufferDescriptor<'_>) -> Held<wgpu::Buffer> {
        let buffer = device.create_buffer(about);
        let bytes = buffer.size();
        self.hold(buffer, bytes)
    }

    /// Makes a texture of whole rows of texels, no fewer than `texels`, and counts it until it is dropped.
    pub fn allocate_texels(&self, device: &wgpu::Device, label: &str, texels: u64) -> Held<wgpu::Texture> {
        let height = texels.div_ceil(u64::from(TEXTURE_WIDTH)).max(1) as u32;
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width: TEXTURE_WIDTH, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: TEXEL_FORMAT,
            usage: wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        self.hold(texture, TEXEL_BYTES * u64::from(TEXTURE_WIDTH) * u64::from(height))
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        self.bytes.load(Ordering::Relaxed)
    }

    fn hold<T>(&self, what: T, bytes: u64) -> Held<T> {
        self.bytes.fetch_add(bytes, Ordering::Relaxed);
        Held { what, bytes, memory: self.clone() }
    }
}

/// Writes the first texels of a texture before the next submit; what is left of the last row becomes zero.
pub(crate) fn write_texels(queue: &wgpu::Queue, texture: &wgpu::Texture, values: &[[f32; 4]]) {
    let mut rows = values.to_vec();
    rows.resize(values.len().next_multiple_of(TEXTURE_WIDTH as usize), [0.0; 4]);
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(TEXTURE_WIDTH * TEXEL_BYTES as u32),
        rows_per_image: None,
    };
    let size =
        wgpu::Extent3d { width: TEXTURE_WIDTH, height: rows.len() as u32 / TEXTURE_WIDTH, depth_or_array_layers: 1 };
    queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(&rows), layout, size);
}

/// A buffer or texture that is counted as long as it is held.
#[derive(Debug)]
pub(crate) struct Held<T> {
    what: T,
    bytes: u64,
    memory: Memory,
}

impl<T> Held<T> {
    /// Its size.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }
}

impl<T> Deref for Held<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.what
    }
}

impl<T> Drop for Held<T> {
    fn drop(&mut self) {
        self.memory.bytes.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}
