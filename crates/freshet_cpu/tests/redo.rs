//! Substeps that turn out too long are made again, if the scene asks for it.

use freshet_core::field::Field;
use freshet_core::plan::{Parameters, Plan};
use freshet_core::pressure_solver::PressureSolver;
use freshet_core::scene::{FluidScene, Settings};
use freshet_core::solver::FluidSolver;
use freshet_core::step::{BodyInput, StepInput, StepReport};
use freshet_cpu::{CpuOptions, CpuSolver};
use glam::Vec3;

#[path = "common/redo.rs"]
mod scenes;
use scenes::{SPACING, SPEED, block_on_a_body, collision, supersonic};

/// What a tick does, and what the state would allow that it leaves.
struct Tick {
    report: StepReport,
    /// The shortest substep over the limit by the state after the tick: more than this the last one is too long by.
    too_long: f32,
    /// Momentum of fluid and body, N s.
    momentum: Vec3,
    /// Kinetic energy of the fluid, J.
    energy: f32,
}

/// Runs ticks; a body gets the impulses of the fluid as an engine would give them.
fn run(scene: &FluidScene, bodies: &[BodyInput], duration: f32, ticks: u64, threads: usize) -> Vec<Tick> {
    let plan = Plan::new(scene).unwrap();
    let options = CpuOptions { threads: Some(threads), ..CpuOptions::default() };
    let mut solver = CpuSolver::new(plan.clone(), options.clone()).unwrap();
    let mut still = Settings { redo_substeps: false, ..scene.settings.clone() };
    still.relaxation = None;
    let still = Plan::new(&FluidScene { settings: still, ..scene.clone() }).unwrap();
    let mut probe = CpuSolver::new(still, options).unwrap();
    let mut bodies = bodies.to_vec();
    let mut tick = |tick| {
        let input = StepInput { tick, duration, bodies: bodies.clone(), ..StepInput::default() };
        let report = solver.step(&input).unwrap();
        for (body, impulse) in bodies.iter_mut().zip(&report.bodies) {
            body.linear_velocity += impulse.linear * body.inverse_mass;
            body.position += body.linear_velocity * duration;
        }
        let end = solver.snapshot().unwrap();
        // A tick of no length evaluates the state and moves nothing.
        probe.restore(&end).unwrap();
        probe.step(&StepInput { tick: tick + 1, bodies: bodies.clone(), ..StepInput::default() }).unwrap();
        let largest = |values: &mut dyn Iterator<Item = f32>| values.fold(0.0, f32::max);
        let accelerations = probe.read(Field::Acceleration).unwrap().vectors().unwrap();
        let acceleration = largest(&mut accelerations.iter().map(|a| a.length()));
        let fastest = largest(&mut end.velocities.iter().map(|v| v.length()));
        let p = &plan.parameters;
        let limit = match p.pressure_solver {
            PressureSolver::WeaklyCompressible => p.substep_limit(fastest, acceleration),
            PressureSolver::PositionBased(_)
            | PressureSolver::PressureCorrected(_)
            | PressureSolver::PressurePoisson(_) => p.position_based_limit(fastest, p.gravity.length()),
            PressureSolver::DivergenceFree(_) => {
                let pressure = largest(&mut end.pressures.iter().copied()) * p.rest_density;
                p.incompressible_limit(fastest, p.gravity.length(), pressure)
            }
        };
        let of_bodies = bodies.iter().map(|body| body.linear_velocity / body.inverse_mass).sum::<Vec3>();
        Tick {
            too_long: report.smallest_substep / limit,
            momentum: p.particle_mass * end.velocities.iter().sum::<Vec3>() + of_bodies,
            energy: 0.5 * p.particle_mass * end.velocities.iter().map(|v| v.length_squared()).sum::<f32>(),
            report,
        }
    };
    (0..ticks).map(&mut tick).collect()
}

fn redone(ticks: &[Tick]) -> u32 {
    ticks.iter().map(|tick| tick.report.redone).sum()
}

fn longest(ticks: &[Tick]) -> f32 {
    ticks.iter().map(|tick| tick.too_long).fold(0.0, f32::max)
}

/// The first substep in which the blocks touch is as long as their speed allows. What is pressed out between them is faster: it goes farther than
/// any particle may, meets what it should not reach, and is compressed. Made again, no substep is too long. Neither gains energy.
#[test]
fn an_incompressible_impact_is_made_again() {
    let duration = 0.4 * SPACING / SPEED;
    let [without, with] = [false, true].map(|redo| run(&collision(redo), &[], duration, 20, 2));
    assert_eq!(redone(&without), 0);
    assert!(longest(&without) > 1.3, "{}", longest(&without));
    assert!(redone(&with) > 0);
    assert!(longest(&with) <= Parameters::REDO_SLACK, "{}", longest(&with));
    let gain = |ticks: &[Tick]| ticks.windows(2).map(|two| two[1].energy / two[0].energy - 1.0).fold(0.0, f32::max);
    assert!(gain(&without) < 1e-4 && gain(&with) < 1e-4, "{} {}", gain(&without), gain(&with));
    let compression = |ticks: &[Tick]| ticks[4..].iter().map(|tick| tick.report.max_compression).fold(0.0, f32::max);
    let (before, after) = (compression(&without), compression(&with));
    assert!(before > 0.1 && after < 0.5 * before, "{before} {after}");
    // Taken back as a whole: nothing is lost, time and momentum are kept.
    for tick in &with {
        assert_eq!((tick.report.removed, tick.report.time_scale), (0, 1.0));
        assert!(tick.momentum.length() < 1e-2, "{} N s of 640", tick.momentum);
    }
}

/// By the largest acceleration: fluid faster than its sound finds out about the floor within a substep.
#[test]
fn a_supersonic_impact_is_made_again() {
    let [without, with] = [false, true].map(|redo| run(&supersonic(redo), &[], 2e-3, 40, 2));
    assert_eq!(redone(&without), 0);
    assert!(longest(&without) > 1.5, "{}", longest(&without));
    assert!(redone(&with) > 0);
    assert!(longest(&with) <= Parameters::REDO_SLACK, "{}", longest(&with));
}

/// What a body got in a substep that was taken back is taken back, too, and results do not depend on the number of threads.
#[test]
fn bodies_go_back_as_well() {
    let (scene, body) = block_on_a_body();
    let [one, three] = [1, 3].map(|threads| run(&scene, &[body], 4e-3, 12, threads));
    assert!(redone(&one) > 0);
    let (start, end) = (one[0].momentum, one[11].momentum);
    let given = one.iter().map(|tick| tick.report.bodies[0].linear).sum::<Vec3>();
    assert!(given.x > 10.0, "the fluid pushes the body: {given}");
    assert!(start.distance(end) < 1e-3 * start.length(), "{start} {end}");
    for (one, three) in one.iter().zip(&three) {
        assert_eq!((one.report.redone, one.energy), (three.report.redone, three.energy));
    }
}
