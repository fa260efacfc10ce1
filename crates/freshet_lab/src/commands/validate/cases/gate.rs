//! A gate on a hinge that holds water back: the moment that the water has about it.

use freshet_core::scene::Volume;
use glam::Vec3;
use rapier3d::dynamics::{RevoluteJointBuilder, RigidBodyBuilder};
use rapier3d::geometry::{ColliderBuilder, InteractionGroups};

use super::super::{Case, Job, Level, Study, Trace};
use crate::afloat::{Afloat, DIAMETER, TICK, Tank};
use crate::drive::Account;
use crate::error::LabError;
use crate::measure::column::level_from_centre_of_mass;
use crate::measure::statistics::mean;
use crate::progress::Progress;
use crate::scenes::GRAVITY;
use crate::verdict::{Bound, Check};

/// The case.
pub const CASE: Case = Case {
    name: "gate",
    about: "a gate on a rapier hinge at the floor, shut by a stop, with water 2 D deep behind it, by DFSPH, in lockstep and two ticks late: moment; hydrostatics",
    run: |job| STUDY.run(job),
};

const STUDY: Study = Study {
    name: "gate",
    title: "A gate on a hinge holds back water 2 D deep",
    measure: "error of the moment on the hinge",
    bound: 0.05,
    coarse_bound: Some(0.05),
    smooth: false,
    resolutions: [6, 10, 16],
    quick: &[6],
    axes: ["time (s)", "moment of the fluid on the hinge / hydrostatic"],
    simulate,
};

/// Length and width of the water, its depth, and thickness and height of the gate, over D.
const WATER: [f32; 3] = [2.0, 2.0, 2.0];
const GATE: [f32; 2] = [0.5, 3.0];
/// Its density, kg/m3.
const DENSITY: f32 = 500.0;
/// How far the water turns it until it is stopped, rad.
const STOP: f64 = 0.01;
/// Time to simulate, s, and the quick form's.
const END: [f64; 2] = [8.0, 2.0];
/// Ticks until rapier hears of an impulse in the second run.
const LATENCY: u64 = 2;

fn simulate(job: &Job, resolution: u32, progress: &mut Progress) -> Result<Level, LabError> {
    let in_time = hold_back(job, resolution, 0, &mut |fraction| progress.at(0.5 * fraction))?;
    let late = hold_back(job, resolution, LATENCY, &mut |fraction| progress.at(0.5 + 0.5 * fraction))?;
    let percent = |run: &Run| (run.moment / run.expected - 1.0) * 100.0;
    let checks = vec![
        Check::new(
            "angle at which the gate stands over that of its stop",
            in_time.turn / STOP,
            "",
            Bound::Within(0.5, 1.5),
        ),
        Check::new("particles beyond the gate", in_time.beyond as f64, "", Bound::AtMost(0.0)),
        Check::new("two ticks late: error of the moment", percent(&late), "%", Bound::Within(-5.0, 5.0)),
        Check::new("two ticks late: particles beyond the gate", late.beyond as f64, "", Bound::AtMost(0.0)),
    ];
    let remark = |(when, run): (&str, &Run)| {
        format!("{when}: moment {:.4}, hydrostatics of the level {:.4}, over that of 2 D", run.moment, run.expected)
    };
    let remarks = [("in lockstep", &in_time), ("two ticks late", &late)].map(remark).to_vec();
    let account = in_time.account.with(&late.account);
    let trace = |name: &str, run: Run| Trace { name: name.to_owned(), points: run.points };
    Ok(Level {
        resolution,
        particles: in_time.particles,
        error: (in_time.moment / in_time.expected - 1.0).abs(),
        traces: vec![trace("in lockstep", in_time), trace("two ticks late", late)],
        checks,
        remarks,
        account,
    })
}

/// A gate that has held water back, in the second half of its time.
struct Run {
    /// Of the fluid on the hinge, over that of 2 D of water.
    moment: f64,
    /// That of the level that the water has.
    expected: f64,
    /// Of the gate, rad.
    turn: f64,
    /// Particles beyond the gate at the end.
    beyond: usize,
    points: Vec<(f64, f64, f64)>,
    particles: usize,
    account: Account,
}

fn hold_back(job: &Job, resolution: u32, latency: u64, progress: &mut dyn FnMut(f64)) -> Result<Run, LabError> {
    let [length, depth, width] = WATER.map(|over| over * DIAMETER);
    let [thickness, height] = GATE.map(|over| over * DIAMETER);
    // The gate stands in the middle of a channel, as wide as it.
    let tank = Tank { floor: [2.0 * length + thickness, width], depth, spacing: DIAMETER / resolution as f32 };
    let face = -0.5 * thickness;
    let mut scene = tank.scene("gate");
    let back = -0.5 * tank.floor[0];
    let middle = Vec3::new(0.5 * (back + face), 0.5 * depth, 0.0);
    scene.volumes = vec![Volume::block(Vec3::new(0.5 * (face - back), 0.5 * depth, 0.5 * width), middle)];
    let moment = 1000.0 * GRAVITY * f64::from(width) * f64::from(depth).powi(3) / 6.0;

    let mut world = tank.world();
    let gate = RigidBodyBuilder::dynamic().translation(Vec3::Y * height / 2.0).can_sleep(false);
    let half = Vec3::new(thickness, height, width) / 2.0;
    // The channel's walls would rub on it.
    let collider = ColliderBuilder::cuboid(half.x, half.y, half.z).density(DENSITY);
    let (handle, _) = world.insert(gate, collider.collision_groups(InteractionGroups::none()));
    let floor = world.insert_body(RigidBodyBuilder::fixed());
    let hinge = RevoluteJointBuilder::new(Vec3::Z)
        .local_anchor1(Vec3::ZERO)
        .local_anchor2(Vec3::NEG_Y * height / 2.0)
        .limits([-STOP as f32, STOP as f32]);
    world.insert_impulse_joint(floor, handle, hinge);
    let mut afloat = Afloat::open(job, scene, world, &[handle], latency)?;

    let ticks = (END[usize::from(job.quick)] / TICK).round() as u32;
    let (mut points, mut moments, mut turns, mut levels) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut beyond = 0;
    for tick in 1..=ticks {
        let pose = *afloat.body(0).position();
        let given = afloat.tick()?;
        // About the hinge, positive as the water turns it, which is clockwise.
        let arm = pose.translation;
        let fluid =
            given.first().map_or(f64::NAN, |given| -f64::from((given.angular + arm.cross(given.linear)).z) / TICK);
        let turn = -f64::from(afloat.body(0).rotation().to_scaled_axis().z);
        points.push((f64::from(tick) * TICK, fluid / moment, 1.0));
        if 2 * tick > ticks {
            let positions = afloat.positions()?;
            let (inside, others): (Vec<Vec3>, Vec<Vec3>) = positions.into_iter().partition(|at| at.x < 0.0);
            beyond = others.len();
            levels.push(level_from_centre_of_mass(&inside).unwrap_or(f64::NAN));
            moments.push(fluid);
            turns.push(turn);
        }
        progress(f64::from(tick) / f64::from(ticks));
    }
    let mean = |values: Vec<f64>| mean(values).unwrap_or(f64::NAN);
    Ok(Run {
        moment: mean(moments) / moment,
        expected: (mean(levels) / f64::from(depth)).powi(3),
        turn: mean(turns),
        beyond,
        points,
        particles: afloat.particles()?,
        account: afloat.account().clone(),
    })
}
