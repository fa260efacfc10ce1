//! The CPU solver on a thread of its own. Lockstep is the same thread, waited for.

use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use freshet_core::field::{Field, FieldData};
use freshet_core::plan::Plan;
use freshet_core::snapshot::Snapshot;
use freshet_core::solver::{FluidSolver, SolverError};
use freshet_cpu::{CpuOptions, CpuSolver};

use super::frame::ParticleFrame;
use super::{Order, Outcome};

/// What the thread is told: orders, and questions that are answered on a channel of their own.
enum Message {
    Order(Order),
    Snapshot(Sender<Result<Snapshot, SolverError>>),
    Read(Field, Sender<Result<FieldData, SolverError>>),
}

/// The latest particles to draw, shared by the thread and its owner.
type Drawing = Mutex<Option<Arc<ParticleFrame>>>;

/// A thread with a CPU solver. It ends when this is dropped.
pub(crate) struct CpuWorker {
    messages: Sender<Message>,
    // A receiver alone is not `Sync`, which a component must be.
    outcomes: Mutex<Receiver<Outcome>>,
    drawing: Arc<Drawing>,
}

impl CpuWorker {
    /// Starts the thread. `wants_frames`: particles are read for drawing after each tick.
    pub(crate) fn start(plan: Plan, snapshot: Option<&Snapshot>, wants_frames: bool) -> Result<Self, SolverError> {
        let mut solver = CpuSolver::new(plan, CpuOptions::default())?;
        if let Some(snapshot) = snapshot {
            solver.restore(snapshot)?;
        }
        let (messages, inbox) = channel();
        let (outbox, outcomes) = channel();
        let drawing = Arc::<Drawing>::default();
        let shared = wants_frames.then(|| drawing.clone());
        std::thread::Builder::new()
            .name("freshet:solver:cpu".to_owned())
            .spawn(move || work(solver, &inbox, &outbox, shared.as_deref()))
            .map_err(|error| SolverError::Device(format!("no thread for the CPU solver: {error}")))?;
        Ok(Self { messages, outcomes: Mutex::new(outcomes), drawing })
    }

    pub(crate) fn send(&mut self, order: Order) {
        // If the thread is gone, `outcomes` says so.
        let _ = self.messages.send(Message::Order(order));
    }

    pub(crate) fn outcomes(&mut self) -> Vec<Outcome> {
        self.outcomes.get_mut().unwrap_or_else(PoisonError::into_inner).try_iter().collect()
    }

    pub(crate) fn wait(&mut self) -> Vec<Outcome> {
        let outcomes = self.outcomes.get_mut().unwrap_or_else(PoisonError::into_inner);
        match outcomes.recv() {
            Ok(first) => std::iter::once(first).chain(outcomes.try_iter()).collect(),
            Err(_) => vec![Outcome::Failed(gone())],
        }
    }

    pub(crate) fn snapshot(&mut self) -> Result<Snapshot, SolverError> {
        self.ask(Message::Snapshot)
    }

    pub(crate) fn read(&mut self, field: Field) -> Result<FieldData, SolverError> {
        self.ask(|reply| Message::Read(field, reply))
    }

    pub(crate) fn frame(&self) -> Option<Arc<ParticleFrame>> {
        self.drawing.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn ask<T>(&self, question: impl FnOnce(Sender<Result<T, SolverError>>) -> Message) -> Result<T, SolverError> {
        let (reply, answer) = channel();
        self.messages.send(question(reply)).map_err(|_| gone())?;
        answer.recv().map_err(|_| gone())?
    }
}

fn gone() -> SolverError {
    SolverError::Device("the thread of the CPU solver has ended".to_owned())
}

fn work(mut solver: CpuSolver, inbox: &Receiver<Message>, outbox: &Sender<Outcome>, drawing: Option<&Drawing>) {
    let mut version = 0;
    publish(&mut solver, &mut version, drawing);
    while let Ok(message) = inbox.recv() {
        let outcome = match message {
            Message::Order(Order::Tick(input)) => {
                let begin = Instant::now();
                let report = solver.step(&input);
                let milliseconds = begin.elapsed().as_secs_f32() * 1e3;
                // Before the report, so that whoever waits for the tick draws this tick.
                publish(&mut solver, &mut version, drawing);
                Some(report.map_or_else(Outcome::Failed, |report| Outcome::Report(report, milliseconds)))
            }
            Message::Order(Order::Reconfigure(plan)) => solver.reconfigure(*plan).err().map(Outcome::Failed),
            Message::Snapshot(reply) => {
                let _ = reply.send(solver.snapshot());
                None
            }
            Message::Read(field, reply) => {
                let _ = reply.send(solver.read(field));
                None
            }
        };
        if let Some(outcome) = outcome
            && outbox.send(outcome).is_err()
        {
            return; // Nobody listens any more.
        }
    }
}

fn publish(solver: &mut CpuSolver, version: &mut u64, drawing: Option<&Drawing>) {
    if let Some(drawing) = drawing {
        *version += 1;
        let frame = Arc::new(ParticleFrame::read(solver, *version));
        *drawing.lock().unwrap_or_else(PoisonError::into_inner) = Some(frame);
    }
}
