//! Where the solver's buffers are made, and the count of their bytes.

use std::ops::Deref;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Bytes of the buffers that were made and not given back.
#[derive(Clone, Debug, Default)]
pub(crate) struct Memory {
    bytes: Arc<AtomicU64>,
}

impl Memory {
    /// Makes a buffer and counts it until it is dropped.
    pub fn allocate(&self, device: &wgpu::Device, about: &wgpu::BufferDescriptor<'_>) -> Held {
        let buffer = device.create_buffer(about);
        self.bytes.fetch_add(buffer.size(), Ordering::Relaxed);
        Held { buffer, memory: self.clone() }
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        self.bytes.load(Ordering::Relaxed)
    }
}

/// A buffer that is counted as long as it is held.
#[derive(Debug)]
pub(crate) struct Held {
    buffer: wgpu::Buffer,
    memory: Memory,
}

impl Deref for Held {
    type Target = wgpu::Buffer;

    fn deref(&self) -> &wgpu::Buffer {
        &self.buffer
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        self.memory.bytes.fetch_sub(self.buffer.size(), Ordering::Relaxed);
    }
}
