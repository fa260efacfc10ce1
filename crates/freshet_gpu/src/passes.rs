//! From the plan's stages to the dispatches of a substep: which entry point, which buffers, how many groups.

use freshet_core::plan::{Plan, StageKind};
use freshet_core::pressure_corrected::{PressureCorrected, PressureGradient};
use freshet_core::pressure_force::PressureForce;
use freshet_core::pressure_solver::PressureSolver;
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
    /// A thread for each particle in the first pass of a divergence solve.
    First,
    /// A thread for each particle in an iteration of a solve.
    Iterations,
    /// A thread for each particle in the first pass of a density solve.
    Density,
    /// A thread for each sample of a body in an iteration of a divergence solve.
    Pushes,
    /// A group for each body in an iteration of a divergence solve.
    Answers,
    /// A thread for each sample of a wall.
    WallSamples,
    /// A thread for each sample of a body, of which some have friction, that is moved.
    FrictionLoads,
    /// A group for each body, likewise.
    FrictionSums,
    /// A thread for each particle and each body whose state is kept, of plans that make substeps again.
    Keep,
    /// The same for those that go back to what was kept.
    Restore,
}

impl Arguments {
    /// Number of indirect dispatches; the arguments of drawing come after them.
    pub const COUNT: u32 = 16;

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
    /// Whether it is a part of an iteration, which is encoded several times.
    pub iterates: bool,
    /// Words of each particle it reads or writes in [`Binding::Solves`] or [`Binding::Histories`]: no plan has both.
    pub words: u64,
}

impl Pass {
    fn bytes_per_particle(&self) -> u64 {
        let bytes = |&(binding, _): &(Binding, Access)| match binding {
            Binding::Solves | Binding::Histories => 4 * self.words,
            // As in `before_words`.
            Binding::Befores => 4 * (RECORD_WORDS + self.words),
            _ => binding.particle_bytes().unwrap_or(0),
        };
        self.uses.iter().map(bytes).sum()
    }

    /// Whether this one and the next are parts of the same iteration.
    pub fn iterates_with(&self, next: &Self) -> bool {
        self.iterates && next.iterates && self.stage == next.stage
    }

    /// The entry of the schedule and of time stamps that it is a part of: passes that iterate share one.
    pub fn entry(&self) -> &'static str {
        match (self.iterates, self.stage) {
            (true, Some(StageKind::DivergenceSolve)) => "divergence_iterations",
            (true, Some(StageKind::PositionSolve)) => "position_iterations",
            (true, _) => "density_iterations",
            (false, _) => self.name,
        }
    }
}

/// Passes as they stand in the schedule: those of an iteration are one. None for passes between ticks.
pub(crate) fn scheduled(passes: &[&Pass]) -> Option<ScheduledPass> {
    let first = passes.first()?;
    let bytes_per_particle = passes.iter().map(|pass| pass.bytes_per_particle()).sum::<u64>() as u32;
    Some(ScheduledPass { stage: first.stage?, name: first.entry(), bytes_per_particle })
}

/// Whether pressures are solved for.
pub(crate) fn incompressible(plan: &Plan) -> bool {
    matches!(plan.parameters.pressure_solver, PressureSolver::DivergenceFree(_))
}

/// How many iterations of a substep move particles apart, or are encoded for that.
pub(crate) fn position_iterations(plan: &Plan) -> u32 {
    match plan.parameters.pressure_solver {
        PressureSolver::PositionBased(solver) => solver.iterations,
        PressureSolver::PressureCorrected(solver) => solver.iterations,
        // What is encoded beyond those that are needed dispatches nothing.
        PressureSolver::PressurePoisson(solver) => solver.max_iterations,
        PressureSolver::WeaklyCompressible | PressureSolver::DivergenceFree(_) => 0,
    }
}

/// Whether particles are moved by differences of pressures.
pub(crate) fn by_differences(plan: &Plan) -> bool {
    matches!(
        plan.parameters.pressure_solver,
        PressureSolver::PressureCorrected(PressureCorrected { gradient: PressureGradient::Difference, .. })
    )
}

/// Whether there are bodies that answer to the solves of an incompressible fluid.
pub(crate) fn answering_bodies(plan: &Plan) -> bool {
    incompressible(plan) && !plan.bodies.is_empty()
}

/// Whether passes need to know where sorted samples of bodies are from which body's centre of mass.
pub(crate) fn sample_arms(plan: &Plan) -> bool {
    answering_bodies(plan) || plan.has(StageKind::BodyDrag) || plan.has(StageKind::BodyFriction)
}

/// Words of each particle in [`Binding::Solves`].
pub(crate) fn solve_words(plan: &Plan) -> u32 {
    if plan.bodies.is_empty() { 8 } else { 10 }
}

/// Numbers kept of each particle in [`Binding::Histories`], once in the order of the state and once in that of the sort: first what the integrator keeps,
/// then the density that is carried.
pub(crate) fn history_words(plan: &Plan) -> u64 {
    past_words(plan) + u64::from(plan.parameters.density.is_carried())
}

/// Words of a particle's record and of its density.
const RECORD_WORDS: u64 = 9;

/// Words of each particle in [`Binding::Befores`]: its record, its density, and what is kept of it besides.
pub(crate) fn before_words(plan: &Plan) -> u64 {
    RECORD_WORDS + u64::from(incompressible(plan)) + history_words(plan)
}

/// Those of the integrator.
pub(crate) fn past_words(plan: &Plan) -> u64 {
    plan.parameters.integrator.words() as u64
}

/// Whether pairs need each other's velocities, or the densities that come with them.
pub(crate) fn needs_velocities(plan: &Plan) -> bool {
    let parameters = &plan.parameters;
    let mueller = parameters.pressure_force == PressureForce::Mueller;
    parameters.artificial_viscosity > 0.0 || parameters.dynamic_viscosity > 0.0 || mueller
}

/// Whether fluid sticks to walls some of which move, or rubs on them.
pub(crate) fn moving_walls(plan: &Plan) -> bool {
    let is_felt = WallDrag::of(plan) != WallDrag::None || plan.has(StageKind::Friction);
    !plan.boundary.velocities.is_empty() && is_felt
}

/// The passes of one substep, in order.
pub(crate) fn substep_passes(plan: &Plan) -> Vec<Pass> {
    let mut stages: Vec<StageKind> = plan.stages.iter().map(|stage| stage.kind).collect();
    // Of an incompressible fluid nothing may be dispatched before its solves have ended that depends on what they find. The density
    // solve changes neither velocities nor pressures: what comes before it in the plan may as well come after it.
    if incompressible(plan) {
        stages.sort_by_key(|&stage| is_of_the_end(stage));
    }
    stages.into_iter().flat_map(|stage| stage_passes(stage, plan)).collect()
}

/// Whether a stage comes after the solves of an incompressible fluid.
fn is_of_the_end(stage: StageKind) -> bool {
    matches!(
        stage,
        StageKind::Friction | StageKind::BodyFriction | StageKind::Xsph | StageKind::BodyMotion | StageKind::Integrate
    )
}

fn stage_passes(stage: StageKind, plan: &Plan) -> Vec<Pass> {
    use Access::{Read, Write};
    use Binding as B;

    let bodies = !plan.bodies.is_empty();
    let samples = bodies || plan.sums_walls();
    let faces = !plan.boundary.faces.is_empty();
    let viscous = needs_velocities(plan);
    let pass = |name, file, dispatch, uses: &[(Binding, Access)]| {
        let mut uses = uses.to_vec();
        uses.push((B::Parameters, Read));
        let dispatch = Dispatch::Indirect(dispatch);
        Pass { name, stage: Some(stage), file, uses, dispatch, iterates: false, words: 0 }
    };
    let solves = incompressible(plan);
    let with = |condition: bool, mut uses: Vec<(Binding, Access)>, more: &[(Binding, Access)]| {
        if condition {
            uses.extend_from_slice(more);
        }
        uses
    };
    let state = (B::Particles, Read);
    let neighbours = [(B::SortedPositions, Read), (B::CellStarts, Read), (B::Control, Write)];
    let with_words = |words, pass| Pass { words, ..pass };
    let (kept, past) = (history_words(plan), past_words(plan));
    let answers = solves && bodies;
    let control = |name| {
        let uses = with(answers, vec![(B::Control, Write), (B::Arguments, Write)], &[(B::Answers, Write)]);
        let pass = pass(name, passes::SOLVE_CONTROL, Arguments::Particles, &uses);
        Pass { dispatch: Dispatch::Single, ..pass }
    };
    // Forces on samples by the pressures in a buffer, and what is written of their sums.
    let loads = |names: [&'static str; 2], dispatches: [Arguments; 2], pressures, sums: &[(Binding, Access)]| {
        let on_samples = [
            (B::Bodies, Read),
            (B::BodySamples, Read),
            (B::SortedPositions, Read),
            (B::CellStarts, Read),
            (pressures, Read),
            (B::SampleLoads, Write),
        ];
        let on_bodies = with(true, vec![(B::SampleLoads, Read)], sums);
        let samples = pass(names[0], passes::BODY_LOAD, dispatches[0], &on_samples);
        [with_words(1, samples), pass(names[1], passes::BODY_LOAD, dispatches[1], &on_bodies)]
    };
    let touches = with(true, neighbours.to_vec(), &[(B::Samples, Read), (B::Hits, Read), (B::Answers, Write)]);
    let iteration = || {
        let uses = with(samples, neighbours.to_vec(), &[(B::Samples, Read)]);
        let change = with(true, uses.clone(), &[(B::Hits, Read), (B::Solves, Read), (B::Motions, Write)]);
        let project = with(true, uses, &[(B::Hits, Read), (B::Solves, Write), (B::Motions, Read)]);
        let project = with(answers, project, &[(B::Answers, Write)]);
        let change = pass("pressure_change", passes::PROJECTION, Arguments::Iterations, &change);
        let project = pass("project", passes::PROJECTION, Arguments::Iterations, &project);
        let mut passes = vec![with_words(2, change)];
        if answers {
            let dispatches = [Arguments::Pushes, Arguments::Answers];
            let sums = [(B::Bodies, Read), (B::Answers, Write)];
            passes.extend(loads(["body_push", "body_answer"], dispatches, B::Solves, &sums));
        }
        passes.extend([with_words(if answers { 10 } else { 8 }, project), control("solve_control")]);
        passes.into_iter().map(|pass| Pass { iterates: true, ..pass })
    };
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
            with_words(
                if solves { 2 } else { 2 * kept },
                pass(
                    "sort_reorder",
                    passes::SORT,
                    Arguments::Particles,
                    &with(
                        kept > 0,
                        with(
                            solves,
                            vec![
                                state,
                                (B::CellStarts, Read),
                                (B::Slots, Read),
                                (B::SortedPositions, Write),
                                (B::Accelerations, Write),
                                (B::SortedLives, Write),
                                (B::Control, Write),
                            ],
                            &[(B::Solves, Write)],
                        ),
                        &[(B::Histories, Write)],
                    ),
                ),
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
        // It finds the neighbours too: densities come with eight buffers already, as many as WebGPU has by default.
        StageKind::Support => {
            let uses = with(samples, neighbours.to_vec(), &[(B::Samples, Read)]);
            let uses = with(true, uses, &[(B::Hits, Write), (B::Accelerations, Write), (B::Widths, Write)]);
            vec![pass("support", passes::SUPPORT, Arguments::Particles, &uses)]
        }
        // In two: with its neighbours and what is carried there is no room for more buffers.
        StageKind::Density if plan.parameters.density.is_carried() => {
            let uses = with(samples, neighbours.to_vec(), &[(B::Samples, Read)]);
            let uses = with(true, uses, &[(B::Accelerations, Write), (B::Hits, Write), (B::Histories, Write)]);
            let of_excess = [
                (B::Control, Write),
                (B::Accelerations, Read),
                (B::Histories, Read),
                (B::SortedVelocities, Write),
                (B::Densities, Write),
            ];
            let carry = pass("continuity", passes::CONTINUITY, Arguments::Particles, &uses);
            let take = pass("carried_density", passes::CONTINUITY, Arguments::Particles, &of_excess);
            vec![with_words(2, carry), with_words(1, take)]
        }
        StageKind::Density => {
            let uses = with(samples, neighbours.to_vec(), &[(B::Samples, Read)]);
            let uses = with(true, uses, &[(B::SortedVelocities, Write), (B::Accelerations, Write)]);
            let widths = plan.has(StageKind::Support);
            let uses = with(true, uses, &[if widths { (B::Widths, Read) } else { (B::Hits, Write) }]);
            // Of an incompressible fluid they are written when its pressures are known.
            let uses = with(!solves, uses, &[(B::Densities, Write)]);
            vec![pass("density", passes::DENSITY, Arguments::Particles, &uses)]
        }
        StageKind::Acceleration => {
            let uses = with(samples, neighbours.to_vec(), &[(B::Samples, Read)]);
            let uses = with(true, uses, &[(if viscous || solves { B::SortedVelocities } else { B::Densities }, Read)]);
            let uses = with(solves, uses, &[(B::Solves, Write)]);
            let uses = with(true, uses, &[(B::Accelerations, Write), (B::Hits, Read)]);
            let uses = with(plan.has(StageKind::Support), uses, &[(B::Widths, Read)]);
            let uses = with(!plan.boundary.own_densities.is_empty(), uses, &[(B::WallDensities, Read)]);
            vec![with_words(3, pass("acceleration", passes::ACCELERATION, Arguments::Particles, &uses))]
        }
        StageKind::PositionSolve => {
            let pass = |name, uses: &[(Binding, Access)]| {
                pass(name, passes::POSITION_SOLVE, Arguments::Particles, &with(true, vec![(B::Control, Write)], uses))
            };
            let begin = [(B::SortedPositions, Read), (B::Accelerations, Read), (B::Motions, Write), (B::Places, Write)];
            let uses = with(samples, vec![(B::SortedPositions, Read), (B::CellStarts, Read)], &[(B::Samples, Read)]);
            let uses = with(true, uses, &[(B::Hits, Read), (B::Motions, Read), (B::Places, Write)]);
            let finish = [
                (B::SortedPositions, Read),
                (B::Accelerations, Read),
                (B::Places, Read),
                (B::SortedVelocities, Write),
                (B::Densities, Write),
            ];
            if let PressureSolver::PressurePoisson(_) = plan.parameters.pressure_solver {
                let around = [
                    (B::SortedPositions, Read),
                    (B::CellStarts, Read),
                    (B::Hits, Read),
                    (B::Densities, Read),
                    (B::Places, Write),
                ];
                let places = [(B::Places, Write)];
                let diagonal = pass("poisson_diagonal", &with(samples, around.to_vec(), &[(B::Samples, Read)]));
                let iterates = |pass| Pass { iterates: true, ..pass };
                let of_iteration = |name, uses: &[(Binding, Access)]| {
                    iterates(Pass { dispatch: Dispatch::Indirect(Arguments::Iterations), ..pass(name, uses) })
                };
                return vec![
                    pass("position_begin", &begin),
                    diagonal,
                    control("poisson_first"),
                    of_iteration("poisson_relax", &around),
                    iterates(control("poisson_control")),
                    of_iteration("poisson_exchange", &places),
                    pass("poisson_end", &places),
                    pass("displace", &uses),
                    pass("position_finish", &finish),
                ];
            }
            let iteration = [
                pass("multiply", &uses),
                pass("displace", &uses),
                pass("follow", &[(B::Places, Read), (B::Motions, Write)]),
            ];
            let iteration = iteration.into_iter().map(|pass| Pass { iterates: true, ..pass });
            let begin = [pass("position_begin", &begin)];
            begin.into_iter().chain(iteration).chain([pass("position_finish", &finish)]).collect()
        }
        StageKind::BodyDensity => vec![pass(
            "body_density",
            passes::BODY_SORT,
            Arguments::Samples,
            &[
                (B::Bodies, Read),
                (B::BodySamples, Read),
                (B::CellStarts, Read),
                (B::BodySlots, Read),
                (B::SortedPositions, Read),
                (B::Samples, Write),
            ],
        )],
        StageKind::WallDensity if plan.boundary.own_densities.is_empty() => {
            let uses = with(faces, neighbours.to_vec(), &[(B::Samples, Read), (B::WallFaces, Read)]);
            let more = [(B::Accelerations, Read), (B::SortedVelocities, Write), (B::Densities, Write)];
            vec![pass("wall_density", passes::WALL_DENSITY, Arguments::Particles, &with(true, uses, &more))]
        }
        StageKind::WallDensity => vec![pass(
            "wall_density",
            passes::WALL_DENSITY,
            Arguments::WallSamples,
            &[(B::SortedPositions, Read), (B::CellStarts, Read), (B::Samples, Read), (B::WallDensities, Write)],
        )],
        StageKind::WallForce => {
            let uses = with(true, neighbours.to_vec(), &[(B::Samples, Read), (B::SortedVelocities, Read)]);
            let uses = with(faces, uses, &[(B::WallFaces, Read)]);
            let uses = with(true, uses, &[(B::Accelerations, Write)]);
            vec![pass("wall_force", passes::WALL_FORCE, Arguments::Particles, &uses)]
        }
        StageKind::BodyDrag => vec![pass(
            "body_drag",
            passes::BODY_DRAG,
            Arguments::Particles,
            &[
                (B::SortedPositions, Read),
                (B::CellStarts, Read),
                (B::Samples, Read),
                (B::SortedVelocities, Read),
                (B::Bodies, Read),
                (B::Control, Read),
                (B::Accelerations, Write),
                (B::Contacts, Write),
            ],
        )],
        StageKind::BodyLoad => {
            let sums = with(solves, vec![(B::Bodies, Write)], &[(B::Answers, Write)]);
            let pressures = if solves { B::Solves } else { B::Densities };
            let dispatches = [Arguments::Samples, Arguments::Bodies];
            let mut load = loads(["body_load", "body_sum"], dispatches, pressures, &sums).to_vec();
            if plan.has(StageKind::BodyDrag) {
                load[0].uses.push((B::Contacts, Read));
            }
            if solves {
                let uses = with(true, touches, &[(B::Bodies, Read), (B::Solves, Write)]);
                load.push(with_words(2, pass("body_touch", passes::BODY_TOUCH, Arguments::Particles, &uses)));
            }
            load
        }
        StageKind::StepControl => {
            let uses = with(bodies, vec![(B::Control, Write), (B::Arguments, Write)], &[(B::Bodies, Read)]);
            let uses = with(answers, uses, &[(B::Answers, Read)]);
            // Dispatched in any case: past the tick's end it switches the motion off.
            let control = pass("step_control", passes::STEP_CONTROL, Arguments::Particles, &uses);
            let mut all = vec![Pass { dispatch: Dispatch::Single, ..control }];
            if plan.parameters.redo_substeps {
                let keep = [
                    (B::SortedPositions, Read),
                    (B::SortedVelocities, Read),
                    (B::SortedLives, Read),
                    (B::Control, Read),
                    (B::Befores, Write),
                ];
                let restore = [(B::Befores, Read), (B::Control, Read), (B::Particles, Write)];
                let keep = with(bodies, keep.to_vec(), &[(B::Bodies, Read), (B::BodiesBefore, Write)]);
                let restore = with(bodies, restore.to_vec(), &[(B::Bodies, Write), (B::BodiesBefore, Read)]);
                let keep = with(solves, keep, &[(B::Solves, Read)]);
                let restore = with(solves, restore, &[(B::Solves, Write), (B::Densities, Write)]);
                let keep = with(kept > 0, keep, &[(B::Histories, Read)]);
                let restore = with(kept > 0, restore, &[(B::Histories, Write)]);
                let words = if solves { 1 } else { kept };
                all.push(with_words(words, pass("keep_state", passes::REDO, Arguments::Keep, &keep)));
                all.push(with_words(words, pass("restore_state", passes::REDO, Arguments::Restore, &restore)));
            }
            all
        }
        StageKind::DivergenceSolve => {
            let uses = with(samples, neighbours.to_vec(), &[(B::Samples, Read)]);
            let more = [(B::Hits, Read), (B::SortedVelocities, Read), (B::Accelerations, Read), (B::Solves, Write)];
            let uses = with(true, uses, &more);
            let first = pass("divergence_first", passes::PROJECTION, Arguments::First, &uses);
            let mut begin = vec![with_words(8, first)];
            if answers {
                let uses = with(true, touches.clone(), &[(B::Bodies, Read), (B::Solves, Write)]);
                let rates = pass("divergence_bodies", passes::BODY_TOUCH, Arguments::First, &uses);
                begin.insert(0, with_words(4, rates));
                let uses = with(true, touches, &[(B::Solves, Read)]);
                begin.push(with_words(3, pass("left_at_bodies", passes::BODY_TOUCH, Arguments::First, &uses)));
            }
            begin.push(control("first_control"));
            begin.into_iter().chain(iteration()).collect()
        }
        StageKind::DensitySolve => {
            let uses = [
                (B::Control, Write),
                (B::SortedVelocities, Read),
                (B::Motions, Read),
                (B::Accelerations, Write),
                (B::Densities, Write),
                (B::Solves, Write),
            ];
            let begin = pass("density_begin", passes::PROJECTION, Arguments::Density, &uses);
            let begin = vec![with_words(7, begin), control("density_control")];
            begin.into_iter().chain(iteration()).collect()
        }
        StageKind::Friction => vec![with_words(
            1,
            pass(
                "friction",
                passes::FRICTION,
                Arguments::Motion,
                &with(
                    solves || faces,
                    vec![
                        (B::SortedPositions, Read),
                        (B::SortedVelocities, Read),
                        (B::CellStarts, Read),
                        (B::Samples, Read),
                        (B::WallFrictions, Read),
                        (B::Control, Read),
                        (B::Accelerations, Write),
                    ],
                    &[(if faces { B::WallFaces } else { B::Solves }, Read)],
                ),
            ),
        )],
        StageKind::BodyFriction => {
            let pressures = [(B::Solves, Read), (B::Control, Read), (B::Contacts, Write)];
            let rub = [
                (B::SortedPositions, Read),
                (B::SortedVelocities, Read),
                (B::CellStarts, Read),
                (B::Samples, Read),
                (B::Bodies, Read),
                (B::Control, Read),
                (B::Accelerations, Write),
                (B::Contacts, Write),
            ];
            let on_samples = [
                (B::Bodies, Read),
                (B::BodySamples, Read),
                (B::SortedPositions, Read),
                (B::CellStarts, Read),
                (B::Contacts, Read),
                (B::SampleLoads, Write),
            ];
            let on_bodies = [(B::SampleLoads, Read), (B::Bodies, Write)];
            let rough = |name, dispatch, uses: &[(Binding, Access)]| pass(name, passes::BODY_FRICTION, dispatch, uses);
            let copy = solves.then(|| with_words(1, rough("contact_pressure", Arguments::Motion, &pressures)));
            let passes = [
                rough("body_friction", Arguments::Motion, &rub),
                rough("friction_load", Arguments::FrictionLoads, &on_samples),
                pass("friction_sum", passes::BODY_LOAD, Arguments::FrictionSums, &on_bodies),
            ];
            copy.into_iter().chain(passes).collect()
        }
        StageKind::Xsph => vec![with_words(
            past,
            pass(
                "xsph",
                passes::XSPH,
                Arguments::Motion,
                &with(
                    past > 0,
                    vec![
                        (B::SortedPositions, Read),
                        (B::SortedVelocities, Read),
                        (B::CellStarts, Read),
                        (B::Hits, Read),
                        (B::Accelerations, Read),
                        (B::Control, Read),
                        (B::Drifts, Write),
                    ],
                    &[(B::Histories, Read)],
                ),
            ),
        )],
        StageKind::BodyMotion => vec![pass(
            "body_motion",
            passes::BODY_MOTION,
            Arguments::BodyMotion,
            &with(answers, vec![(B::Bodies, Write), (B::Control, Write)], &[(B::Answers, Read)]),
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
            let uses = with(solves || plan.has(StageKind::PositionSolve), uses, &[(B::Motions, Read)]);
            let uses = with(past > 0, uses, &[(B::Histories, Write)]);
            vec![with_words(2 * past, pass("integrate", passes::INTEGRATE, Arguments::Motion, &uses))]
        }
        StageKind::WallCollision => vec![pass(
            "wall_collision",
            passes::WALL_COLLISION,
            Arguments::Motion,
            &[
                (B::Particles, Write),
                (B::CellStarts, Read),
                (B::Samples, Read),
                (B::WallFaces, Read),
                (B::Control, Read),
            ],
        )],
    }
}

/// The passes that end what solves a tick has left open: first the one, then the other.
pub(crate) fn closing_passes(plan: &Plan) -> Vec<Pass> {
    if !incompressible(plan) {
        return Vec::new();
    }
    let mut uses = vec![(Binding::Control, Access::Write), (Binding::Arguments, Access::Write)];
    if answering_bodies(plan) {
        uses.push((Binding::Answers, Access::Write));
    }
    let close = |name| between(name, passes::SOLVE_CONTROL, Dispatch::Single, &uses);
    let mut passes = vec![close("close_solve")];
    let substep = substep_passes(plan);
    passes.extend(substep.iter().filter(|pass| matches!(pass.name, "density_begin" | "density_control")).cloned());
    passes.push(close("close_density_solve"));
    passes.extend(substep.into_iter().filter(|pass| pass.stage.is_some_and(is_of_the_end)));
    passes
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
pub(crate) fn command_passes(plan: &Plan) -> [Pass; 4] {
    use Access::{Read, Write};
    use Binding as B;
    let state = [(B::Particles, Write), (B::Control, Write), (B::Command, Read)];
    let mut spawn: Vec<_> =
        state.into_iter().chain([(B::Spawned, Read), (B::Densities, Write), (B::Accelerations, Write)]).collect();
    if incompressible(plan) {
        spawn.push((B::Solves, Write));
    }
    if history_words(plan) > 0 {
        spawn.push((B::Histories, Write));
    }
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
    Pass { name, stage: None, file, uses, dispatch, iterates: false, words: 0 }
}
