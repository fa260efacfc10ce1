//! The only place where the solver polls the device, maps buffers or waits.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use std::time::{Duration, Instant};

use freshet_core::solver::SolverError;

use crate::errors::guarded;
use crate::memory::{Held, Memory};

/// Ticks that may be in flight before [`GpuSolver::collect`](crate::GpuSolver::collect) waits.
pub const TICKS_IN_FLIGHT: usize = 3;

/// How long a report of finished work may take to be called in by another thread; also what a report costs that is waited
/// for and was never submitted.
const MOST_UNSAID: Duration = Duration::from_millis(100);

const PENDING: u8 = 0;
const READY: u8 = 1;
const FAILED: u8 = 2;

/// A report on its way from the GPU.
#[derive(Debug)]
struct Ticket<T> {
    about: T,
    staging: Held<wgpu::Buffer>,
    state: Arc<AtomicU8>,
}

/// A ring of staging buffers; `T` is what is remembered of each report.
#[derive(Debug)]
pub(crate) struct Readback<T> {
    free: Vec<Held<wgpu::Buffer>>,
    pending: VecDeque<Ticket<T>>,
    waits: u64,
    bytes: u64,
    memory: Memory,
}

impl<T> Readback<T> {
    /// A ring of `count` buffers of `bytes` each.
    pub fn new(device: &wgpu::Device, count: usize, bytes: u64, memory: &Memory) -> Result<Self, SolverError> {
        let free = guarded(device, "allocating staging buffers", || {
            (0..count).map(|_| staging(device, bytes, memory)).collect::<Vec<_>>()
        })?;
        let (pending, memory) = (VecDeque::new(), memory.clone());
        Ok(Self { free, pending, waits: 0, bytes: bytes * count as u64, memory })
    }

    /// Bytes of all staging buffers together.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// How often the CPU waited for the GPU.
    pub fn waits(&self) -> u64 {
        self.waits
    }

    /// Counts on from another ring's waits.
    pub fn add_waits(&mut self, waits: u64) {
        self.waits += waits;
    }

    /// Reports that are not collected yet.
    pub fn in_flight(&self) -> usize {
        self.pending.len()
    }

    /// Encodes copies of whole buffers, one behind the other, that can be read once the encoder's commands are done.
    pub fn copy(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        sources: &[&wgpu::Buffer],
        about: T,
    ) -> Result<(), SolverError> {
        let Some(staging) = self.free.pop() else {
            return Err(SolverError::Device(format!(
                "{} ticks were encoded and none collected: call collect after each submit",
                self.pending.len()
            )));
        };
        let mut offset = 0;
        for source in sources {
            encoder.copy_buffer_to_buffer(source, 0, &staging, offset, source.size());
            offset += source.size();
        }
        let state = Arc::new(AtomicU8::new(PENDING));
        let signal = Arc::clone(&state);
        encoder.map_buffer_on_submit(&staging, wgpu::MapMode::Read, .., move |result| {
            signal.store(if result.is_ok() { READY } else { FAILED }, Ordering::Release);
        });
        self.pending.push_back(Ticket { about, staging, state });
        Ok(())
    }

    /// Reports that have arrived, in order; waits only while more than [`TICKS_IN_FLIGHT`] are on their way.
    pub fn collect(&mut self, device: &wgpu::Device) -> Result<Vec<(T, Vec<u8>)>, SolverError> {
        poll(device, wgpu::PollType::Poll)?;
        let mut arrived = self.take_arrived()?;
        if self.pending.len() > TICKS_IN_FLIGHT {
            self.wait_for_pending(device)?;
            arrived.extend(self.take_arrived()?);
        }
        Ok(arrived)
    }

    /// Waits for everything that was submitted; gives all reports.
    pub fn finish(&mut self, device: &wgpu::Device) -> Result<Vec<(T, Vec<u8>)>, SolverError> {
        if !self.pending.is_empty() {
            self.wait_for_pending(device)?;
        }
        self.take_arrived()
    }

    /// Waits, then reads a part of a buffer that has `COPY_SRC`.
    pub fn download(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        buffer: &wgpu::Buffer,
        bytes: u64,
    ) -> Result<Vec<u8>, SolverError> {
        if bytes == 0 {
            return Ok(Vec::new());
        }
        let state = Arc::new(AtomicU8::new(PENDING));
        let signal = Arc::clone(&state);
        let staging = guarded(device, "reading a buffer", || {
            let staging = staging(device, bytes, &self.memory);
            let about = wgpu::CommandEncoderDescriptor { label: Some("freshet:encoder:download") };
            let mut encoder = device.create_command_encoder(&about);
            encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, bytes);
            encoder.map_buffer_on_submit(&staging, wgpu::MapMode::Read, .., move |result| {
                signal.store(if result.is_ok() { READY } else { FAILED }, Ordering::Release);
            });
            queue.submit([encoder.finish()]);
            staging
        })?;
        self.wait(device, &[Arc::clone(&state)])?;
        if state.load(Ordering::Acquire) != READY {
            return Err(SolverError::Device("a buffer could not be read".to_owned()));
        }
        let data = staging.slice(..).get_mapped_range().to_vec();
        staging.unmap();
        Ok(data)
    }

    fn wait_for_pending(&mut self, device: &wgpu::Device) -> Result<(), SolverError> {
        let states: Vec<_> = self.pending.iter().map(|ticket| Arc::clone(&ticket.state)).collect();
        self.wait(device, &states)
    }

    /// Waits for all that was submitted. Another thread that polls the device may then still be about to say so.
    fn wait(&mut self, device: &wgpu::Device, states: &[Arc<AtomicU8>]) -> Result<(), SolverError> {
        self.waits += 1;
        poll(device, wgpu::PollType::wait_indefinitely())?;
        let begin = Instant::now();
        let is_unsaid = || states.iter().any(|state| state.load(Ordering::Acquire) == PENDING);
        while is_unsaid() && begin.elapsed() < MOST_UNSAID {
            std::thread::sleep(Duration::from_micros(50));
        }
        Ok(())
    }

    fn take_arrived(&mut self) -> Result<Vec<(T, Vec<u8>)>, SolverError> {
        let mut arrived = Vec::new();
        while let Some(ticket) = self.pending.pop_front() {
            match ticket.state.load(Ordering::Acquire) {
                PENDING => {
                    self.pending.push_front(ticket);
                    break;
                }
                READY => {
                    let data = ticket.staging.slice(..).get_mapped_range().to_vec();
                    ticket.staging.unmap();
                    self.free.push(ticket.staging);
                    arrived.push((ticket.about, data));
                }
                _ => {
                    self.free.push(ticket.staging);
                    return Err(SolverError::Device("a report could not be read".to_owned()));
                }
            }
        }
        Ok(arrived)
    }
}

fn staging(device: &wgpu::Device, bytes: u64, memory: &Memory) -> Held<wgpu::Buffer> {
    let about = wgpu::BufferDescriptor {
        label: Some("freshet:buffer:staging"),
        size: bytes,
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    };
    memory.allocate(device, &about)
}

fn poll(device: &wgpu::Device, how: wgpu::PollType) -> Result<(), SolverError> {
    device.poll(how).map(|_| ()).map_err(|error| SolverError::Device(error.to_string()))
}
