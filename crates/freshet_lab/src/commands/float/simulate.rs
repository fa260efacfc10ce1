//! One ball, one solver, one latency.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use freshet_core::field::Field;
use freshet_core::plan::Plan;
use freshet_core::run::SceneRun;
use freshet_core::solver::{FluidSolver, SolverError};
use freshet_core::step::StepReport;
use freshet_rapier::{Coupling, CouplingError, RapierView};
use glam::Vec3;

use super::scene::{Pool, SPACING, Scene, TICK, scene};
use super::{Case, Sway};
use crate::error::LabError;
use crate::measure::column::surface_level;
use crate::measure::curve::Curve;
use crate::progress::Progress;

/// A ball that has floated.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// What was run.
    pub case: Case,
    /// Height of the ball's centre, m.
    pub height: Curve,
    /// Draft over diameter below the level that water and ball fill.
    pub draft: Curve,
    /// Draft over diameter below the measured surface.
    pub draft_by_surface: Curve,
    /// Vertical velocity of the ball, m/s.
    pub velocity: Curve,
    /// Vertical impulse of the fluid on the ball in each tick, N s, at the tick's end.
    pub impulse: Curve,
    /// Largest linear imbalance of the ledger over the impulses exchanged, after any tick.
    pub ledger: f64,
    /// Rapier's momentum at the end minus what fluid and gravity gave, over the impulses exchanged.
    pub momentum: f64,
    /// How far the ball has drifted sideways, m.
    pub drift: f64,
    /// Particles lost.
    pub lost: u64,
    /// Smallest time covered over time asked for.
    pub time_scale: f64,
    /// Largest mean compression of a substep.
    pub compression: f64,
    /// Substeps made.
    pub substeps: u64,
    /// Sum over substeps of the particles moved.
    pub particle_steps: f64,
    /// Wall time of the solver and rapier.
    pub wall: Duration,
}

impl Run {
    /// Time from which on it is judged, s.
    pub fn settled(&self) -> f64 {
        self.case.seconds / 2.0
    }

    /// Heave from half time on, m. Below a two-hundredth of the diameter it is noise.
    pub fn sway(&self) -> Sway {
        Sway::of(&self.height, self.settled(), 2.0 * f64::from(self.case.pool.radius()) / 200.0)
    }
}

/// Floats a ball with the solver that `open` makes.
pub fn simulate(
    case: &Case,
    open: impl FnOnce(Plan) -> Result<Box<dyn FluidSolver>, LabError>,
    progress: &mut Progress,
) -> Result<Run, LabError> {
    let Scene { plan, mut carve, mut world, ball, water } = scene(&case.pool, case.method)?;
    let mut solver = open(plan)?;
    let mut coupling = Coupling::new([ball], 0);
    let mut clock = SceneRun::new();
    let mut late: VecDeque<StepReport> = VecDeque::new();
    let mut run = Run::new(*case);
    let ticks = (case.seconds / f64::from(TICK)).round() as u64;
    let mut largest_imbalance = 0.0f64;
    for tick in 0..ticks {
        let start = Instant::now();
        receive(&mut coupling, &mut late, tick, case.latency.ticks(), &mut world.bodies)?;
        let bodies = coupling.begin_tick(tick, &RapierView::from(&world)).map_err(refused)?;
        let mut input = clock.next(solver.plan(), TICK, bodies);
        input.commands.append(&mut carve);
        let report = solver.step(&input)?;
        clock.hear(&report);
        run.account(&report);
        let impulse = report.bodies.first().map_or(Vec3::ZERO, |impulse| impulse.linear);
        late.push_back(report);
        receive(&mut coupling, &mut late, tick, case.latency.ticks(), &mut world.bodies)?;
        coupling.apply_forecast(&mut world.bodies).map_err(refused)?;
        world.step();
        coupling.complete(&mut world.bodies).map_err(refused)?;
        run.wall += start.elapsed();

        let body = &world.bodies[ball];
        let (time, height) = ((tick + 1) as f64 * f64::from(TICK), f64::from(body.translation().y));
        run.height.push(time, height);
        run.velocity.push(time, body.linvel().y.into());
        run.impulse.push(time, impulse.y.into());
        let draft = |level: f64| (level - height) / (2.0 * f64::from(case.pool.radius())) + 0.5;
        run.draft.push(time, draft(case.pool.level(water, height)));
        run.draft_by_surface.push(time, draft(open_surface(solver.as_mut(), &case.pool, body.translation())?));
        run.drift = Vec3::new(body.translation().x, 0.0, body.translation().z).length().into();
        largest_imbalance = largest_imbalance.max(coupling.bodies()[0].ledger().imbalance().linear.length());
        progress.at((tick + 1) as f64 / ticks as f64);
    }
    let (ledger, body) = (coupling.bodies()[0].ledger(), &world.bodies[ball]);
    let weight = world.gravity.as_dvec3() * f64::from(body.mass()) * f64::from(TICK) * ticks as f64;
    let momentum = body.linvel().as_dvec3() * f64::from(body.mass());
    run.ledger = largest_imbalance / ledger.exchanged;
    run.momentum = (momentum - ledger.delivered.linear - ledger.advanced.linear - weight).length() / ledger.exchanged;
    Ok(run)
}

/// Hands over the reports that are `latency` ticks old.
fn receive(
    coupling: &mut Coupling,
    late: &mut VecDeque<StepReport>,
    tick: u64,
    latency: u64,
    bodies: &mut rapier3d::dynamics::RigidBodySet,
) -> Result<(), LabError> {
    while let Some(report) = late.pop_front_if(|report| report.tick + latency <= tick) {
        coupling.receive(&report, bodies).map_err(refused)?;
    }
    Ok(())
}

fn refused(error: CouplingError) -> LabError {
    LabError::Measure { what: "the floating ball", reason: error.to_string() }
}

/// Level of the water away from the ball, m: two spacings from it and everything it hides.
fn open_surface(solver: &mut dyn FluidSolver, pool: &Pool, ball: Vec3) -> Result<f64, LabError> {
    let positions = solver.read(Field::Position)?;
    let positions = positions.vectors().ok_or(SolverError::NoSuchField(Field::Position.name()))?;
    let clear = pool.radius() + 2.0 * SPACING;
    let away: Vec<Vec3> =
        positions.into_iter().filter(|position| (*position - ball).with_y(0.0).length() >= clear).collect();
    let area = pool.area() - std::f64::consts::PI * f64::from(clear * clear);
    let per_layer = (area / f64::from(SPACING * SPACING)).round() as usize;
    let missing = || LabError::Measure { what: "the surface level", reason: "particles are missing".to_owned() };
    surface_level(&away, per_layer, SPACING).ok_or_else(missing)
}

impl Run {
    /// Nothing has happened yet.
    pub(super) fn new(case: Case) -> Self {
        Self {
            case,
            height: Curve::default(),
            draft: Curve::default(),
            draft_by_surface: Curve::default(),
            velocity: Curve::default(),
            impulse: Curve::default(),
            ledger: f64::NAN,
            momentum: f64::NAN,
            drift: 0.0,
            lost: 0,
            time_scale: f64::INFINITY,
            compression: 0.0,
            substeps: 0,
            particle_steps: 0.0,
            wall: Duration::ZERO,
        }
    }

    fn account(&mut self, report: &StepReport) {
        self.lost += u64::from(report.removed) + u64::from(report.refused);
        self.time_scale = self.time_scale.min(report.time_scale.into());
        self.compression = self.compression.max(report.mean_compression.into());
        self.substeps += u64::from(report.substeps);
        self.particle_steps += f64::from(report.substeps) * f64::from(report.particles);
    }
}
