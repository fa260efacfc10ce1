//! wgpu's errors as ours: creation happens inside error scopes, so that nothing reaches the device's panic handler.

use std::future::Future;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

use freshet_core::solver::SolverError;

/// Runs a future of wgpu to its end. On native backends they are ready at once.
pub(crate) fn block_on<T>(future: impl Future<Output = T>) -> T {
    let mut future = pin!(future);
    let mut context = Context::from_waker(Waker::noop());
    loop {
        match future.as_mut().poll(&mut context) {
            Poll::Ready(value) => return value,
            Poll::Pending => std::thread::yield_now(),
        }
    }
}

/// Makes objects of the device; errors of any kind become [`SolverError::Device`], with `what` in front.
pub(crate) fn guarded<T>(device: &wgpu::Device, what: &str, make: impl FnOnce() -> T) -> Result<T, SolverError> {
    let internal = device.push_error_scope(wgpu::ErrorFilter::Internal);
    let memory = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let validation = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let value = make();
    let errors = [block_on(validation.pop()), block_on(memory.pop()), block_on(internal.pop())];
    match errors.into_iter().flatten().next() {
        Some(error) => Err(SolverError::Device(format!("{what}: {error}"))),
        None => Ok(value),
    }
}
