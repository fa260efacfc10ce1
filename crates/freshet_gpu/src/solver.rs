//! The solver: what it owns, how it is made, and the three calls of the pipelined mode.

use std::collections::VecDeque;

use freshet_core::misplaced::Misplaced;
use freshet_core::plan::Plan;
use freshet_core::pressure_solver::PressureSolver;
use freshet_core::relaxation::relax;
use freshet_core::solver::{Schedule, ScheduledBuffer, SolverError};
use freshet_core::step::{BodyInput, StepInput, StepReport};
use glam::Vec3;

use crate::buffers::{Buffers, INPUT_STRIDE, TICK_SLOTS};
use crate::commands::{Edits, LeftOut};
use crate::compiled::Compiled;
use crate::layout::{Binding, BodyInputRecord, ParticleRecord, StepControl, TickRecord};
use crate::memory::Memory;
use crate::options::GpuOptions;
use crate::passes::Arguments;
use crate::pool::initial_capacity;
use crate::prediction::{iterations_to_encode, substeps_to_encode};
use crate::readback::Readback;
use crate::report::Arrival;
use crate::timing::Timer;

/// A tick that was told to the solver and waits to be encoded.
#[derive(Debug)]
pub(crate) struct PreparedTick {
    pub about: TickMemo,
    pub slot: u32,
    pub edits: Edits,
}

/// What the CPU remembers of a tick until its report arrives.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TickMemo {
    pub tick: u64,
    /// Substeps encoded.
    pub encoded: u32,
    /// Particles it spawns.
    pub spawned: u32,
}

/// What a tick spawns.
#[derive(Clone, Debug, Default)]
pub(crate) struct Spawning {
    pub count: u32,
    pub left_out: LeftOut,
}

/// What the last report that arrived said.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Known {
    pub particles: u32,
    pub substep: f32,
    pub carry: f32,
    /// The GPU's clock when the solver's time was the one that follows from the reports.
    pub clock: u32,
    /// Wall time of one substep, ms; zero if it was never measured.
    pub milliseconds: f32,
    /// The most iterations of each of the two solves of a substep; zero if there was none.
    pub iterations: [u32; 2],
}

/// A [`Plan`] executed on a GPU.
///
/// Each tick is one `prepare`, one `encode`, one submit and one `collect`; several ticks may be prepared and encoded
/// before a submit, up to eight before a `collect`.
#[derive(Debug)]
pub struct GpuSolver {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) plan: Plan,
    pub(crate) options: GpuOptions,
    pub(crate) schedule: Schedule,
    pub(crate) memory: Memory,
    pub(crate) buffers: Buffers,
    pub(crate) compiled: Compiled,
    /// Bind groups of the passes that begin a tick, then of those of a substep.
    pub(crate) groups: Vec<wgpu::BindGroup>,
    pub(crate) timer: Option<Timer>,
    pub(crate) readback: Readback<TickMemo>,
    pub(crate) prepared: VecDeque<PreparedTick>,
    /// Reports that arrived while something else was waited for; the next `collect` gives them.
    pub(crate) late: Vec<StepReport>,
    /// Particles spawned by each tick whose report has not arrived.
    pub(crate) spawning: VecDeque<Spawning>,
    /// Particles left out that have not fallen out yet: a tick of no duration does not sort.
    pub(crate) falling: u32,
    /// Particles at the start; none once there was a tick.
    pub(crate) start: Option<Start>,
    pub(crate) known: Known,
    pub(crate) generation: u64,
    pub(crate) gravity: Vec3,
    pub(crate) time: f64,
    /// See [`Snapshot::emitted`](freshet_core::snapshot::Snapshot::emitted); of the ticks encoded.
    pub(crate) emitted: Option<f64>,
    pub(crate) ticks: u64,
    next_slot: u32,
}

/// The particles before the first tick, which are on the GPU by then: only that tick says where bodies are.
#[derive(Debug)]
pub(crate) struct Start {
    pub(crate) ids: Vec<u32>,
    pub(crate) positions: Vec<Vec3>,
}

impl Start {
    /// Those that start in or beside bodies, by id.
    fn inside(&self, plan: &Plan, bodies: &[BodyInput]) -> Vec<Misplaced> {
        let found = plan.started_inside(&self.positions, bodies).into_iter();
        found.map(|one| Misplaced { index: self.ids[one.index as usize], ..one }).collect()
    }
}

impl GpuSolver {
    /// Lowers a plan to passes and buffers, compiles and allocates them, and uploads the start. Waits for the GPU if particles are to
    /// [settle](freshet_core::relaxation) first.
    ///
    /// # Errors
    /// [`SolverError::WeakAdapter`] if a buffer would be larger than the device allows, [`SolverError::Unsupported`],
    /// or [`SolverError::Device`].
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        plan: Plan,
        options: GpuOptions,
    ) -> Result<Self, SolverError> {
        let mut solver = Self::with_compiled(device, queue, plan, options, None)?;
        relax(&mut solver)?;
        Ok(solver)
    }

    /// As [`new`](Self::new), with the pipelines of an earlier plan where they are the same.
    pub(crate) fn with_compiled(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        plan: Plan,
        options: GpuOptions,
        earlier: Option<&Compiled>,
    ) -> Result<Self, SolverError> {
        options.validate()?;
        let options = options.for_device(device);
        let compiled = Compiled::new(device, &plan, options, earlier)?;
        let memory = Memory::default();
        let start = plan.positions.len() as u32;
        let buffers =
            Buffers::new(device, queue, &plan, initial_capacity(start, plan.max_particles), &options, &memory)?;
        let names = compiled.entries().map(|entry| entry.name).collect();
        let timer = if options.time_stamps { Timer::new(device, queue, names, &memory)? } else { None };
        let mut solver = Self {
            device: device.clone(),
            queue: queue.clone(),
            schedule: Schedule { backend: "gpu", passes: Vec::new(), buffers: Vec::new(), capacity: 0 },
            readback: Readback::new(device, TICK_SLOTS, report_bytes(&buffers, timer.as_ref()), &memory)?,
            gravity: plan.parameters.gravity,
            plan,
            options,
            memory,
            buffers,
            compiled,
            groups: Vec::new(),
            timer,
            prepared: VecDeque::new(),
            late: Vec::new(),
            spawning: VecDeque::new(),
            falling: 0,
            start: None,
            known: Known::default(),
            generation: 0,
            time: 0.0,
            emitted: None,
            ticks: 0,
            next_slot: 0,
        };
        solver.rebind()?;
        solver.upload_start();
        Ok(solver)
    }

    /// Tells the solver of a tick. Uploads take effect at the next submit.
    ///
    /// The number of substeps to encode follows from the last report. A plan's budget limits it once the cost of a substep
    /// is known: from time stamps ([`GpuOptions::time_stamps`]), or from ticks made in lockstep.
    ///
    /// # Errors
    /// An input out of range, or eight ticks that were not collected.
    pub fn prepare(&mut self, queue: &wgpu::Queue, input: &StepInput) -> Result<(), SolverError> {
        self.plan.check_input(input)?;
        if self.prepared.len() + self.readback.in_flight() >= TICK_SLOTS {
            return Err(SolverError::Device(format!("{TICK_SLOTS} ticks are prepared and none collected")));
        }
        let slot = self.next_slot;
        self.next_slot = (slot + 1) % TICK_SLOTS as u32;
        let is_first = self.start.is_some();
        let started = self.start.take().map(|start| start.inside(&self.plan, &input.bodies)).unwrap_or_default();
        let left_out = LeftOut { started, spawned: self.plan.spawned_inside(input) };
        let edits = Edits::of(&input.commands, left_out, &mut self.gravity, (self.time, self.known.clock));
        let bodies = self.plan.bodies.len() as u32;
        let record = TickRecord {
            gravity: self.gravity,
            duration: input.duration,
            tick: halves(input.tick),
            tick_plus_one: halves(input.tick + 1),
            first_body: slot * bodies,
            ..Default::default()
        };
        self.buffers.write_at(queue, Binding::Input, INPUT_STRIDE * u64::from(slot), &[record]);
        let known = self.plan.bodies.iter().zip(&input.bodies);
        let given: Vec<BodyInputRecord> = known
            .map(|(body, given)| BodyInputRecord { is_whole: u32::from(is_first || body.at_once), ..given.into() })
            .collect();
        let offset = u64::from(slot * bodies) * size_of::<BodyInputRecord>() as u64;
        self.buffers.write_at(queue, Binding::BodyInputs, offset, &given);

        let about = TickMemo {
            tick: input.tick,
            encoded: self.substeps_within_budget(input.duration + self.known.carry),
            spawned: edits.spawned(),
        };
        self.prepared.push_back(PreparedTick { about, slot, edits });
        Ok(())
    }

    /// Reports of ticks that are done, in order. Call it after each submit; it waits only while more than
    /// [`TICKS_IN_FLIGHT`](crate::TICKS_IN_FLIGHT) ticks are on their way.
    ///
    /// # Errors
    /// If the device failed.
    pub fn collect(&mut self, device: &wgpu::Device) -> Result<Vec<StepReport>, SolverError> {
        let mut reports = std::mem::take(&mut self.late);
        for (about, bytes) in self.readback.collect(device)? {
            reports.push(self.account(&about, &bytes)?);
        }
        Ok(reports)
    }

    /// How often the CPU waited for the GPU: never, in the pipelined mode, unless more than
    /// [`TICKS_IN_FLIGHT`](crate::TICKS_IN_FLIGHT) ticks were on their way. Steps, snapshots, reads and changes of the plan wait.
    pub fn waits(&self) -> u64 {
        self.readback.waits()
    }

    /// Ticks that were encoded and whose reports have not arrived.
    pub fn ticks_in_flight(&self) -> usize {
        self.readback.in_flight()
    }

    /// Takes a report into account: time, particles, the next prediction.
    pub(crate) fn account(&mut self, about: &TickMemo, bytes: &[u8]) -> Result<StepReport, SolverError> {
        let arrival = Arrival::parse(bytes, self.plan.bodies.len())?;
        let mut report = arrival.report(about.tick);
        if let Some(timer) = &self.timer {
            let made = self.made(&report);
            report.passes = timer.times(&arrival.stamps, about.encoded, made);
            let total: f32 = report.passes.iter().map(|pass| pass.milliseconds).sum();
            self.known.milliseconds = total / made.max(1) as f32;
        }
        self.known.particles = report.particles;
        self.known.carry = arrival.control.remaining.min(StepInput::MAX_DURATION);
        self.known.clock = arrival.clock();
        if report.substeps > 0 {
            self.known.iterations = [arrival.control.most_divergence, arrival.control.most_density];
        }
        if report.smallest_substep > 0.0 {
            self.known.substep = report.smallest_substep;
        }
        if let Some(Spawning { count, left_out }) = self.spawning.pop_front() {
            [report.inside_solids, report.beside_solids] = left_out.count(count, report.refused);
            self.falling += report.inside_solids + report.beside_solids;
            let fallen = self.falling.min(report.retired);
            report.retired -= fallen;
            self.falling -= fallen;
        }
        self.time += report.simulated;
        self.ticks = about.tick + 1;
        Ok(report)
    }

    /// The substeps that a tick made of those encoded: its own, those taken back, and the one in which the last of its own was judged.
    pub(crate) fn made(&self, report: &StepReport) -> u32 {
        report.substeps + report.redone + u32::from(self.plan.parameters.redo_substeps)
    }

    /// The substeps to encode for `asked` seconds, no more than the plan's budget allows where their cost is known.
    pub(crate) fn substeps_within_budget(&self, asked: f32) -> u32 {
        let predicted = substeps_to_encode(&self.plan.parameters, asked, self.known.substep);
        match self.plan.budget_milliseconds {
            Some(budget) if self.known.milliseconds > 0.0 => {
                predicted.min((budget / self.known.milliseconds).max(1.0) as u32)
            }
            _ => predicted,
        }
    }

    /// The iterations to encode for each of the two solves of a substep: those that need more take those of the next.
    pub(crate) fn iterations_to_encode(&self) -> [u32; 2] {
        match self.plan.parameters.pressure_solver {
            PressureSolver::DivergenceFree(solver) => {
                iterations_to_encode(self.known.iterations).map(|count| count.min(solver.max_iterations))
            }
            _ => [0; 2],
        }
    }

    /// Makes the bind groups and the schedule anew, after buffers were replaced.
    pub(crate) fn rebind(&mut self) -> Result<(), SolverError> {
        let pipelines = self.compiled.in_order();
        self.groups = crate::errors::guarded(&self.device, "making bind groups", || {
            pipelines.map(|pipeline| pipeline.bind(&self.device, &self.buffers, &[])).collect()
        })?;
        self.generation += 1;
        let mut buffers = self.buffers.scheduled();
        let mut other = |name, bytes| buffers.push(ScheduledBuffer { name, bytes, per_particle: false });
        other("report_staging", self.readback.bytes());
        if let Some(timer) = &self.timer {
            other("time_stamps", timer.buffer().size());
        }
        self.schedule = Schedule {
            backend: "gpu",
            passes: self.compiled.entries().collect(),
            buffers,
            capacity: self.buffers.capacity,
        };
        Ok(())
    }

    fn upload_start(&mut self) {
        let start = self.plan.positions.iter().zip(&self.plan.velocities).enumerate();
        let particles: Vec<ParticleRecord> = start
            .map(|(id, (&position, &velocity))| ParticleRecord {
                position,
                id: id as u32,
                velocity,
                remaining_life: f32::INFINITY,
            })
            .collect();
        self.start = Some(Start { ids: (0..particles.len() as u32).collect(), positions: self.plan.positions.clone() });
        let control = StepControl { next_id: particles.len() as u32, ..Default::default() };
        self.upload_state(&particles, control);
        self.buffers.write(&self.queue, Binding::Solves, &self.plan.pressures);
        self.upload_kept(particles.len(), &[], &self.plan.excesses);
    }

    /// Writes particles and control; `control` need not hold the number of particles.
    pub(crate) fn upload_state(&mut self, particles: &[ParticleRecord], control: StepControl) {
        let count = particles.len() as u32;
        self.buffers.write(&self.queue, Binding::Particles, particles);
        let control = StepControl { count, live: count, gravity: self.gravity, ..control };
        self.buffers.write(&self.queue, Binding::Control, &[control]);
        let draw = [4, count, 0, 0];
        self.buffers.write_at(&self.queue, Binding::Arguments, 12 * u64::from(Arguments::COUNT), &draw);
        self.known = Known { particles: count, ..Default::default() };
    }
}

fn report_bytes(buffers: &Buffers, timer: Option<&Timer>) -> u64 {
    let size = |binding| buffers.get(binding).map_or(0, wgpu::Buffer::size);
    size(Binding::Control) + size(Binding::Bodies) + timer.map_or(0, |timer| timer.buffer().size())
}

/// A 64-bit number as shaders hold it.
pub(crate) fn halves(number: u64) -> [u32; 2] {
    [number as u32, (number >> 32) as u32]
}
