//! The solver as every solver is used: step, wait, read.

use std::time::Instant;

use freshet_core::field::{Field, FieldData};
use freshet_core::plan::Plan;
use freshet_core::snapshot::{Snapshot, carried_over};
use freshet_core::solver::{FluidSolver, Schedule, SolverError};
use freshet_core::step::{StepInput, StepReport};

use crate::prediction::substeps_to_encode;
use crate::report::Arrival;
use crate::solver::{GpuSolver, TickMemo};

/// Most iterations that are encoded in one go.
const MOST_ITERATIONS: u32 = 256;

impl FluidSolver for GpuSolver {
    fn plan(&self) -> &Plan {
        &self.plan
    }

    fn schedule(&self) -> &Schedule {
        &self.schedule
    }

    /// Encodes the predicted substeps, waits, and encodes more until the tick is covered.
    fn step(&mut self, input: &StepInput) -> Result<StepReport, SolverError> {
        // Ticks of the pipelined mode come first, those prepared and not encoded too.
        self.finish_ticks()?;
        let started = Instant::now();
        let queue = self.queue.clone();
        self.prepare(&queue, input)?;
        let Some(tick) = self.prepared.pop_front() else {
            return Err(SolverError::Device("the tick was not prepared".to_owned()));
        };
        self.submit(|solver, encoder| {
            solver.encode_tick(encoder, &tick)?;
            solver.encode_report(encoder, tick.about)
        })?;
        // Stamps of the first chunk and the substeps encoded in it: they stand for the whole tick.
        let mut first = None;
        let mut iterations = self.iterations_to_encode();
        loop {
            let Some((about, bytes)) = self.readback.finish(&self.device)?.pop() else {
                return Err(SolverError::Device("the tick's report did not arrive".to_owned()));
            };
            let arrival = Arrival::parse(&bytes, self.plan.bodies.len())?;
            let control = arrival.control;
            let (stamps, encoded) = first.get_or_insert((arrival.stamps, about.encoded));
            let elapsed = started.elapsed().as_secs_f32() * 1e3;
            let in_time = self.plan.budget_milliseconds.is_none_or(|budget| elapsed < budget);
            // A substep whose solves are still open is ended in any case.
            let open = control.solve_phase != 0;
            let more = if control.going != 0 && in_time {
                substeps_to_encode(&self.plan.parameters, control.remaining, control.smallest_substep)
            } else {
                u32::from(open)
            };
            if more == 0 {
                let mut report = self.account(&about, &bytes)?;
                let made = self.made(&report);
                self.known.milliseconds = elapsed / made.max(1) as f32;
                if let Some(timer) = &self.timer {
                    report.passes = timer.times(stamps, *encoded, made);
                }
                return Ok(report);
            }
            // They took all that were encoded: twice as many, until it is enough.
            iterations = if open { iterations.map(|count| (2 * count).min(MOST_ITERATIONS)) } else { iterations };
            self.submit(|solver, encoder| {
                solver.encode_substeps(encoder, more, iterations);
                solver.encode_report(encoder, TickMemo { encoded: more, ..about })
            })?;
        }
    }

    fn read(&mut self, field: Field) -> Result<FieldData, SolverError> {
        self.read_field(field)
    }

    fn snapshot(&mut self) -> Result<Snapshot, SolverError> {
        self.take_snapshot()
    }

    fn restore(&mut self, snapshot: &Snapshot) -> Result<(), SolverError> {
        self.load_snapshot(snapshot)
    }

    fn reconfigure(&mut self, plan: Plan) -> Result<(), SolverError> {
        let mut snapshot = self.take_snapshot()?;
        if plan.parameters.density.is_carried() && snapshot.excesses.is_empty() && self.start.is_none() {
            // Pressures go on, and what lacked neighbours lacks them no more.
            let (ids, densities) = (self.read_field(Field::Id)?, self.read_field(Field::Density)?);
            let densities = ids.integers().and_then(|ids| densities.sorted_by_id(&ids).scalars()).unwrap_or_default();
            let rest_density = plan.parameters.rest_density;
            snapshot.excesses = densities.iter().map(|density| (density / rest_density - 1.0).max(0.0)).collect();
        }
        if !plan.parameters.goes_on_from(&self.plan.parameters) {
            snapshot.last_substep = 0.0;
        }
        let before = plan.bodies_of(&self.plan);
        snapshot.exchanges = carried_over(&snapshot.exchanges, &before);
        snapshot.poses = plan.poses_from(&self.plan, &snapshot.poses);
        let mut next = Self::with_compiled(&self.device, &self.queue, plan, self.options, Some(&self.compiled))?;
        next.load_snapshot(&snapshot)?;
        next.generation = self.generation + 1;
        next.readback.add_waits(self.readback.waits());
        next.late = std::mem::take(&mut self.late);
        *self = next;
        Ok(())
    }
}
