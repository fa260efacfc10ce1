//! The GPU solver, shared by the main world, which gives it orders and waits for it in lockstep, and the render world,
//! which drives it without waiting ([`crate::gpu`]).

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use bevy::render::render_resource::Buffer;
use bevy::render::renderer::{RenderDevice, RenderQueue};
use freshet_core::field::{Field, FieldData};
use freshet_core::plan::Plan;
use freshet_core::snapshot::Snapshot;
use freshet_core::solver::{FluidSolver, SolverError};
use freshet_core::step::{StepInput, StepReport};
use freshet_gpu::{GpuOptions, GpuSolver};

use super::{Order, Outcome};

/// How long the main world waits for a frame that has been encoded and not submitted. A frame is far shorter; past this
/// the renderer has stopped.
const PATIENCE: Duration = Duration::from_secs(10);

/// How long the report of finished work may take to be called in by another thread.
const MOST_UNSAID: Duration = Duration::from_secs(1);

/// What particles are drawn from.
pub(crate) struct DrawBuffers {
    pub(crate) particles: Buffer,
    pub(crate) densities: Buffer,
    pub(crate) accelerations: Buffer,
    pub(crate) arguments: Buffer,
    pub(crate) arguments_offset: u64,
}

/// wgpu panics where a report is read that had arrived before its device was lost.
fn survive<T>(work: impl FnOnce() -> Result<T, SolverError>) -> Result<T, SolverError> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| Err(SolverError::Device("it was lost".to_owned())))
}

/// A solver with its orders and outcomes.
struct Slot {
    solver: GpuSolver,
    orders: VecDeque<Order>,
    outcomes: Vec<Outcome>,
    /// Ticks are in a command encoder of Bevy's that has not been submitted: nothing else may be until it is, or ticks
    /// would be executed out of order.
    encoded: bool,
    failed: bool,
}

/// A handle on the solver, for the render world.
#[derive(Clone)]
pub(crate) struct SharedGpu(Arc<Mutex<Slot>>);

/// The GPU solver of one domain.
pub(crate) struct GpuEngine {
    shared: SharedGpu,
    device: RenderDevice,
}

impl Slot {
    fn fail(&mut self, error: SolverError) {
        self.failed = true;
        self.orders.clear();
        self.outcomes.push(Outcome::Failed(error));
    }

    fn note(&mut self, result: Result<Vec<StepReport>, SolverError>) {
        match result {
            Ok(reports) => self.outcomes.extend(reports.into_iter().map(|report| {
                let milliseconds = report.passes.iter().map(|pass| pass.milliseconds).sum();
                Outcome::Report(report, milliseconds)
            })),
            Err(error) => self.fail(error),
        }
    }

    /// Takes what has arrived.
    fn collect(&mut self, device: &RenderDevice) {
        let result = survive(|| self.solver.collect(device.wgpu_device()));
        self.note(result);
    }

    /// Waits for what has been submitted, and takes it.
    fn finish(&mut self, device: &RenderDevice) {
        let mut waited_since = None;
        while self.solver.ticks_in_flight() > 0 && !self.failed {
            if let Err(error) = device.poll(wgpu::PollType::wait_indefinitely()) {
                return self.fail(SolverError::Device(error.to_string()));
            }
            self.collect(device);
            // All that was submitted is done. Another thread that polls may still be about to say so; a lost device never does.
            let waited = waited_since.get_or_insert_with(Instant::now).elapsed();
            if waited > MOST_UNSAID && self.solver.ticks_in_flight() > 0 {
                return self.fail(SolverError::Device("it does not say that a tick is done".to_owned()));
            }
        }
    }

    /// Carries out the oldest order and waits for it.
    fn carry_out_one(&mut self, device: &RenderDevice) {
        self.finish(device);
        match self.orders.pop_front() {
            Some(Order::Tick(input)) => self.step(&input),
            Some(Order::Reconfigure(plan)) => self.reconfigure(*plan),
            None => {}
        }
    }

    fn step(&mut self, input: &StepInput) {
        let begin = Instant::now();
        match survive(|| self.solver.step(input)) {
            Ok(report) => self.outcomes.push(Outcome::Report(report, begin.elapsed().as_secs_f32() * 1e3)),
            Err(error) => self.fail(error),
        }
    }

    fn reconfigure(&mut self, plan: Plan) {
        if let Err(error) = self.solver.reconfigure(plan) {
            self.fail(error);
        }
    }
}

impl SharedGpu {
    fn lock(&self) -> MutexGuard<'_, Slot> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Encodes the ticks that were ordered.
    pub(crate) fn encode(&self, encoder: &mut wgpu::CommandEncoder, device: &RenderDevice, queue: &RenderQueue) {
        let mut slot = self.lock();
        let slot = &mut *slot;
        let mut is_prepared = false;
        while let Some(order) = slot.orders.pop_front() {
            match order {
                Order::Tick(input) => match slot.solver.prepare(queue, &input) {
                    Ok(()) => is_prepared = true,
                    Err(error) => return slot.fail(error),
                },
                Order::Reconfigure(plan) => {
                    // The state is taken over on the CPU, so the ticks before must be done.
                    if is_prepared {
                        let mut own = device.create_command_encoder(&wgpu::CommandEncoderDescriptor {
                            label: Some("freshet:encoder:before_reconfiguration"),
                        });
                        if let Err(error) = slot.solver.encode(&mut own) {
                            return slot.fail(error);
                        }
                        queue.submit([own.finish()]);
                        is_prepared = false;
                    }
                    slot.finish(device);
                    slot.reconfigure(*plan);
                }
            }
        }
        if is_prepared {
            slot.encoded = true;
            if let Err(error) = slot.solver.encode(encoder) {
                slot.fail(error);
            }
        }
    }

    /// After the submit: takes what has arrived.
    pub(crate) fn collect(&self, device: &RenderDevice) {
        let mut slot = self.lock();
        slot.encoded = false;
        slot.collect(device);
    }

    /// The buffers as they are now; none of a solver that has failed, whose device may be lost.
    pub(crate) fn draw_buffers(&self) -> Option<DrawBuffers> {
        let slot = self.lock();
        if slot.failed {
            return None;
        }
        let buffers = slot.solver.buffers().ok()?;
        Some(DrawBuffers {
            particles: buffers.particles.clone().into(),
            densities: buffers.densities.clone().into(),
            accelerations: buffers.accelerations.clone().into(),
            arguments: buffers.arguments.clone().into(),
            arguments_offset: buffers.draw_offset,
        })
    }
}

impl GpuEngine {
    pub(crate) fn start(
        device: &RenderDevice,
        queue: &RenderQueue,
        plan: Plan,
        snapshot: Option<&Snapshot>,
    ) -> Result<Self, SolverError> {
        // Without the feature the solver does without.
        let options = GpuOptions { time_stamps: true, ..GpuOptions::default() };
        let mut solver = GpuSolver::new(device.wgpu_device(), queue, plan, options)?;
        if let Some(snapshot) = snapshot {
            solver.restore(snapshot)?;
        }
        let slot = Slot { solver, orders: VecDeque::new(), outcomes: Vec::new(), encoded: false, failed: false };
        let shared = SharedGpu(Arc::new(Mutex::new(slot)));
        Ok(Self { shared, device: device.clone() })
    }

    pub(crate) fn shared(&self) -> SharedGpu {
        self.shared.clone()
    }

    pub(crate) fn send(&mut self, order: Order) {
        let mut slot = self.shared.lock();
        if !slot.failed {
            slot.orders.push_back(order);
        }
    }

    pub(crate) fn outcomes(&mut self) -> Vec<Outcome> {
        std::mem::take(&mut self.shared.lock().outcomes)
    }

    pub(crate) fn wait(&mut self) -> Vec<Outcome> {
        match self.settled() {
            Ok(mut slot) => {
                if slot.outcomes.is_empty() {
                    slot.finish(&self.device);
                }
                while slot.outcomes.is_empty() && !slot.orders.is_empty() {
                    slot.carry_out_one(&self.device);
                }
                if slot.outcomes.is_empty() {
                    slot.fail(SolverError::Device("a tick that was sent has got lost".to_owned()));
                }
                std::mem::take(&mut slot.outcomes)
            }
            Err(error) => vec![Outcome::Failed(error)],
        }
    }

    pub(crate) fn snapshot(&mut self) -> Result<Snapshot, SolverError> {
        self.all_done()?.solver.snapshot()
    }

    pub(crate) fn read(&mut self, field: Field) -> Result<FieldData, SolverError> {
        self.all_done()?.solver.read(field)
    }

    /// The slot with all orders carried out.
    fn all_done(&self) -> Result<MutexGuard<'_, Slot>, SolverError> {
        let mut slot = self.settled()?;
        slot.finish(&self.device);
        while !slot.orders.is_empty() {
            slot.carry_out_one(&self.device);
        }
        Ok(slot)
    }

    /// The slot with nothing in an encoder that is not submitted. With pipelined rendering the frame before is still
    /// being recorded on another thread.
    fn settled(&self) -> Result<MutexGuard<'_, Slot>, SolverError> {
        let begin = Instant::now();
        loop {
            let slot = self.shared.lock();
            if !slot.encoded {
                return Ok(slot);
            }
            drop(slot);
            if begin.elapsed() > PATIENCE {
                return Err(SolverError::Device("the renderer has stopped before submitting a tick".to_owned()));
            }
            std::thread::sleep(Duration::from_micros(200));
        }
    }
}
