//! Takes what the engines have finished.

use bevy::prelude::*;

use super::problems::Problem;
use super::state::{DomainState, Push, Pushes};
use crate::components::stats::{FluidPassTime, FluidStats};
use crate::engine::{MOST_IN_FLIGHT, Outcome};
use freshet_core::step::StepReport;

/// Takes what is known, and waits where the next tick would be one too many.
pub(crate) fn collect_known(mut domains: Query<(Entity, &mut DomainState, &mut FluidStats)>) {
    for (entity, mut state, mut stats) in &mut domains {
        if state.engine.is_none() {
            continue;
        }
        let known = state.engine.as_mut().map(|engine| engine.outcomes()).unwrap_or_default();
        absorb(entity, &mut state, &mut stats, known);
        while state.sent.len() as u64 >= MOST_IN_FLIGHT {
            wait_for_one(entity, &mut state, &mut stats);
        }
    }
}

/// Waits until nothing is in flight.
pub(crate) fn wait_for_all(domain: Entity, state: &mut DomainState, stats: &mut FluidStats) {
    while !state.sent.is_empty() {
        wait_for_one(domain, state, stats);
    }
}

fn wait_for_one(domain: Entity, state: &mut DomainState, stats: &mut FluidStats) {
    match &mut state.engine {
        Some(engine) => {
            let known = engine.wait();
            absorb(domain, state, stats, known);
        }
        None => state.sent.clear(),
    }
}

fn absorb(domain: Entity, state: &mut DomainState, stats: &mut FluidStats, outcomes: Vec<Outcome>) {
    for outcome in outcomes {
        match outcome {
            Outcome::Report(report, milliseconds) => take_report(domain, state, stats, &report, milliseconds),
            Outcome::Failed(error) => {
                state.complain(Problem::new(domain, "FluidDomain", format!("the fluid stopped: {error}")));
                state.stopped = true;
                stats.stopped = Some(error.to_string());
                state.sent.clear();
            }
        }
    }
}

fn take_report(
    domain: Entity,
    state: &mut DomainState,
    stats: &mut FluidStats,
    report: &StepReport,
    milliseconds: f32,
) {
    state.clock.hear(report);
    let poured = state.pours.made_by(report.tick);
    let (inside, beside) = (report.inside_solids, report.beside_solids);
    if poured && inside + beside > 0 {
        let message = format!(
            "{} particles of its volumes are left out: {inside} have their centre inside a wall or a body, {beside} are nearer \
             to one than half a spacing",
            inside + beside
        );
        state.complain(Problem::new(domain, "FluidDomain", message));
    }
    let removals = state.pours.learn(report);
    state.commands.extend(removals);
    while let Some(sent) = state.sent.pop_front() {
        if sent.tick == report.tick {
            let given = report.bodies.iter().zip(&report.wetted);
            let push = |(body, (&impulse, &wetted))| Push { body, impulse, wetted };
            let bodies = sent.bodies.into_iter().zip(given).map(push).collect();
            state.pushes.push(Pushes { tick: report.tick, simulated: report.simulated as f32, bodies });
            break;
        }
    }
    stats.ticks = report.tick + 1;
    stats.ticks_in_flight = state.sent.len() as u64;
    stats.time += report.simulated;
    stats.particles = report.particles;
    stats.substeps = report.substeps;
    stats.time_scale = report.time_scale;
    stats.mean_compression = report.mean_compression;
    stats.max_compression = report.max_compression;
    stats.max_speed = report.max_speed;
    stats.iterations = [report.divergence_iterations, report.density_iterations];
    stats.residual = report.residual;
    stats.unsolved += u64::from(report.unsolved);
    stats.redone += u64::from(report.redone);
    stats.removed += u64::from(report.removed);
    stats.not_finite += u64::from(report.not_finite);
    stats.retired += u64::from(report.retired);
    stats.refused += u64::from(report.refused);
    stats.inside_solids += u64::from(report.inside_solids);
    stats.beside_solids += u64::from(report.beside_solids);
    stats.milliseconds = milliseconds;
    stats.passes = report
        .passes
        .iter()
        .map(|pass| FluidPassTime { pass: pass.pass.clone(), milliseconds: pass.milliseconds })
        .collect();
}
