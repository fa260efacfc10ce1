//! From the plan's stages to the dispatches of a substep: which entry point, which buffers, how many groups.

use freshet_core::plan::{Plan, StageKind};
use freshet_core::solver::ScheduledPass;
use freshet_shaders::{ShaderFile, passes};

use crate::cells::WallDrag;
use crate::layout::{Access, Binding};

/// Indirect dispatches, by their place in the buffer of arguments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub(crate) enum Arguments {
    /// A thread for each particle.
    Particles,
    /// A group for each block of cells.
    Cells,
    /// A thread for each sample of a body.
    Samples,
    /// A group for each body.
    Bodies,
    /// A thread for each particle that is moved.
    Motion,
    /// A thread for each body that is moved.
    BodyMotion,
}

impl Arguments {
    /// Number of indirect dispatches; the arguments of drawing come after them.
    pub const COUNT: u32 = 6;

    /// Offset in bytes.
    pub fn offset(self) -> u64 {
        12 * self as u64
    }
}

/// How many groups a pass is dispatched with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Dispatch {
    /// As the GPU wrote it.
    Indirect(Arguments),
    /// One group.
    Single,
    /// As the encoding code knows.
    Direct,
}

/// One entry point and what it needs.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pass {
    /// Name of the pass and of the entry point.
    pub name: &'static str,
    /// The stage it belongs to; none for passes between ticks.
    pub stage: Option<StageKind>,
    /// Where it is.
    pub file: ShaderFile,
    /// Its buffers.
    pub uses: Vec<(Binding, Access)>,
    /// Its groups.
    pub dispatch: Dispatch,
}

impl Pass {
    /// As it stands in the schedule; none for passes between ticks.
    pub fn scheduled(&self) -> Option<ScheduledPass> {
        let bytes = |&(binding, _): &(Binding, Access)| binding.particle_bytes().unwrap_or(0);
        let bytes_per_particle = self.uses.iter().map(bytes).sum::<u64>() as u32;
        Some(ScheduledPass { stage: self.stage?, name: self.name, bytes_per_particle })
    }
}

/// Whether pairs need each other's velocities.
pub(crate) fn needs_velocities(plan: &Plan) -> bool {
    plan.parameters.artificial_viscosity > 0.0 || plan.parameters.dynamic_viscosity > 0.0
}

/// Whether fluid sticks to walls some of which move.
pub(crate) fn moving_walls(plan: &Plan) -> bool {
    !plan.boundary.velocities.is_empty() && WallDrag::of(plan) == WallDrag::Morris
}

/// The passes of one substep, in order.
pub(crate) fn substep_passes(plan: &Plan) -> Vec<Pass> {
    plan.stages.iter().flat_map(|stage| stage_passes(stage.kind, plan)).collect()
}

fn stage_passes(stage: StageKind, plan: &Plan) -> Vec<Pass> {
    use Access::{Read, Write};
    use Binding as B;

    let bodies = !plan.bodies.is_empty();
    let samples = bodies || !plan.boundary.positions.is_empty();
    let viscous = needs_velocities(plan);
    let pass = |name, file, dispatch, uses: &[(Binding, Access)]| {
        let mut uses = uses.to_vec();
        uses.push((B::Parameters, Read));
        Pass { name, stage: Some(stage), file, uses, dispatch: Dispatch::Indirect(dispatch) }
    };
    let with = |condition: bool, mut uses: Vec<(Binding, Access)>, more: &[(Binding, Access)]| {
        if condition {
            uses.extend_from_slice(more);
        }
        uses
    };
    let state = (B::Particles, Read);
    let neighbours = [(B::SortedPositions, Read), (B::CellStarts, Read), (B::Control, Write)];
    match stage {
        StageKind::Sort => vec![
            pass(
                "sort_count",
                passes::SORT,
                Arguments::Particles,
                &[state, (B::CellCounts, Write), (B::Control, Write)],
            ),
            pass("sort_scan_blocks", passes::SORT, Arguments::Cells, &[(B::CellCounts, Read), (B::CellStarts, Write)]),
            pass("sort_scan_cells", passes::SORT, Arguments::Cells, &[(B::CellCounts, Read), (B::CellStarts, Write)]),
            pass(
                "sort_scatter",
                passes::SORT,
                Arguments::Particles,
                &[state, (B::CellCounts, Write), (B::CellStarts, Read), (B::Slots, Write), (B::Control, Read)],
            ),
            pass(
                "sort_reorder",
                passes::SORT,
                Arguments::Particles,
                &[
                    state,
                    (B::CellStarts, Read),
                    (B::Slots, Read),
                    (B::SortedPositions, Write),
                    (B::Accelerations, Write),
                    (B::SortedLives, Write),
                    (B::Control, Write),
                ],
            ),
        ],
        StageKind::BodySort => {
            let sources = [(B::Bodies, Read), (B::BodySamples, Read)];
            let scan = [(B::CellCounts, Read), (B::CellStarts, Write)];
            vec![
                pass(
                    "body_sort_count",
                    passes::BODY_SORT,
                    Arguments::Samples,
                    &[sources[0], sources[1], (B::CellCounts, Write)],
                ),
                pass("body_sort_scan_blocks", passes::BODY_SORT, Arguments::Cells, &scan),
                pass("body_sort_scan_cells", passes::BODY_SORT, Arguments::Cells, &scan),
                pass(
                    "body_sort_scatter",
                    passes::BODY_SORT,
                    Arguments::Samples,
                    &[sources[0], sources[1], (B::CellCounts, Write), (B::CellStarts, Read), (B::BodySlots, Write)],
                ),
                pass(
                    "body_sort_reorder",
                    passes::BODY_SORT,
                    Arguments::Samples,
                    &[sources[0], sources[1], (B::CellStarts, Read), (B::BodySlots, Read), (B::Samples, Write)],
                ),
            ]
        }
        StageKind::Density => {
            let uses = with(samples, neighbours.to_vec(), &[(B::Samples, Read)]);
            let written =
                [B::SortedVelocities, B::Densities, B::Hits, B::Accelerations].map(|binding| (binding, Write));
            let uses = with(true, uses, &written);
            vec![pass("density", passes::DENSITY, Arguments::Particles, &uses)]
        }
        StageKind::Acceleration => {
            let uses = with(samples, neighbours.to_vec(), &[(B::Samples, Read)]);
            let uses = with(true, uses, &[(if viscous { B::SortedVelocities } else { B::Densities }, Read)]);
            let uses = with(moving_walls(plan), uses, &[(B::WallVelocities, Read)]);
            let uses = with(true, uses, &[(B::Accelerations, Write), (B::Hits, Read)]);
            vec![pass("acceleration", passes::ACCELERATION, Arguments::Particles, &uses)]
        }
        StageKind::BodyLoad => vec![
            pass(
                "body_load",
                passes::BODY_LOAD,
                Arguments::Samples,
                &[
                    (B::Bodies, Read),
                    (B::BodySamples, Read),
                    (B::SortedPositions, Read),
                    (B::CellStarts, Read),
                    (B::Densities, Read),
                    (B::SampleLoads, Write),
                ],
            ),
            pass("body_sum", passes::BODY_LOAD, Arguments::Bodies, &[(B::Bodies, Write), (B::SampleLoads, Read)]),
        ],
        StageKind::StepControl => {
            let uses = with(bodies, vec![(B::Control, Write), (B::Arguments, Write)], &[(B::Bodies, Read)]);
            // Dispatched in any case: past the tick's end it switches the motion off.
            let pass = pass("step_control", passes::STEP_CONTROL, Arguments::Particles, &uses);
            vec![Pass { dispatch: Dispatch::Single, ..pass }]
        }
        // Plans with these are refused by `shader::definitions`.
        StageKind::DivergenceSolve | StageKind::DensitySolve => Vec::new(),
        StageKind::Friction => vec![pass(
            "friction",
            passes::FRICTION,
            Arguments::Motion,
            &[
                (B::SortedPositions, Read),
                (B::SortedVelocities, Read),
                (B::CellStarts, Read),
                (B::Samples, Read),
                (B::WallFrictions, Read),
                (B::Control, Read),
                (B::Accelerations, Write),
            ],
        )],
        StageKind::Xsph => vec![pass(
            "xsph",
            passes::XSPH,
            Arguments::Motion,
            &[
                (B::SortedPositions, Read),
                (B::SortedVelocities, Read),
                (B::CellStarts, Read),
                (B::Hits, Read),
                (B::Accelerations, Read),
                (B::Control, Read),
                (B::Drifts, Write),
            ],
        )],
        StageKind::BodyMotion => vec![pass(
            "body_motion",
            passes::BODY_MOTION,
            Arguments::BodyMotion,
            &[(B::Bodies, Write), (B::Control, Write)],
        )],
        StageKind::Integrate => {
            let moved = [
                (B::SortedPositions, Read),
                (B::SortedVelocities, Read),
                (B::SortedLives, Read),
                (B::Accelerations, Read),
                (B::Control, Read),
                (B::Particles, Write),
            ];
            let uses = with(plan.has(StageKind::Xsph), moved.to_vec(), &[(B::Drifts, Read)]);
            vec![pass("integrate", passes::INTEGRATE, Arguments::Motion, &uses)]
        }
    }
}

/// Starts a tick.
pub(crate) fn begin_tick() -> Pass {
    between(
        "begin_tick",
        passes::STEP_CONTROL,
        Dispatch::Single,
        &[(Binding::Input, Access::Read), (Binding::Control, Access::Write), (Binding::Arguments, Access::Write)],
    )
}

/// Starts a tick's bodies.
pub(crate) fn begin_bodies() -> Pass {
    between(
        "begin_bodies",
        passes::BODY_MOTION,
        Dispatch::Direct,
        &[
            (Binding::Input, Access::Read),
            (Binding::Control, Access::Read),
            (Binding::Bodies, Access::Write),
            (Binding::BodyInputs, Access::Read),
        ],
    )
}

/// The passes of commands: `spawn`, `finish_spawn`, `remove_ids`, `remove_in_box`.
pub(crate) fn command_passes() -> [Pass; 4] {
    use Access::{Read, Write};
    use Binding as B;
    let state = [(B::Particles, Write), (B::Control, Write), (B::Command, Read)];
    let spawn: Vec<_> =
        state.into_iter().chain([(B::Spawned, Read), (B::Densities, Write), (B::Accelerations, Write)]).collect();
    [
        between("spawn", passes::COMMANDS, Dispatch::Direct, &spawn),
        between(
            "finish_spawn",
            passes::COMMANDS,
            Dispatch::Single,
            &[(B::Command, Read), (B::Control, Write), (B::Arguments, Write)],
        ),
        between("remove_ids", passes::COMMANDS, Dispatch::Direct, &state),
        between("remove_in_box", passes::COMMANDS, Dispatch::Direct, &state),
    ]
}

fn between(name: &'static str, file: ShaderFile, dispatch: Dispatch, uses: &[(Binding, Access)]) -> Pass {
    let mut uses = uses.to_vec();
    uses.push((Binding::Parameters, Access::Read));
    Pass { name, stage: None, file, uses, dispatch }
}
