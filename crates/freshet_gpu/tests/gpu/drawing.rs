//! What a renderer finds in the buffers.

use freshet_core::prelude::*;
use freshet_gpu::GpuSolver;
use freshet_gpu::layout::{ParticleRecord, StepControl};

use crate::common::{dam_break, device, solver, tick, tick_with};

fn read(buffer: &wgpu::Buffer) -> Vec<u8> {
    let opened = device();
    let staging = opened.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: buffer.size(),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = opened.device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, buffer.size());
    opened.queue.submit([encoder.finish()]);
    staging.map_async(wgpu::MapMode::Read, .., |result| result.unwrap());
    opened.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    staging.slice(..).get_mapped_range().to_vec()
}

fn drawn(solver: &GpuSolver) -> [u32; 4] {
    let buffers = solver.buffers().unwrap();
    let bytes = read(buffers.arguments);
    let at = buffers.draw_offset as usize;
    bytemuck::pod_read_unaligned(&bytes[at..at + 16])
}

#[test]
fn the_draw_call_has_an_instance_for_each_particle() {
    let mut solver = solver(&dam_break(0.05));
    assert_eq!(drawn(&solver), [4, 1000, 0, 0], "before the first tick");
    solver.step(&tick(0, 0.01)).unwrap();
    assert_eq!(drawn(&solver), [4, 1000, 0, 0]);
    solver.step(&tick_with(1, 0.01, vec![Command::RemoveIds { first: 0, count: 400 }])).unwrap();
    assert_eq!(drawn(&solver), [4, 600, 0, 0]);

    let control: StepControl =
        bytemuck::pod_read_unaligned(&read(solver.buffers().unwrap().control)[..size_of::<StepControl>()]);
    assert_eq!(control.count, 600);
    let particles: Vec<ParticleRecord> =
        read(solver.buffers().unwrap().particles).chunks_exact(32).map(bytemuck::pod_read_unaligned).collect();
    let positions = solver.read(Field::Position).unwrap().vectors().unwrap();
    assert!(particles[..600].iter().map(|particle| particle.position).eq(positions));
}
