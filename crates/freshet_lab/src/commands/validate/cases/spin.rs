//! A ball that spins slowly in a viscous fluid: the torque that it feels.

use glam::Vec3;
use rapier3d::dynamics::RigidBodyBuilder;
use rapier3d::geometry::ColliderBuilder;

use super::super::{Case, Job, Level, Study, Trace};
use crate::afloat::{Afloat, DIAMETER, TICK, Tank};
use crate::error::LabError;
use crate::measure::statistics::mean;
use crate::method::Method;
use crate::progress::Progress;
use crate::reference::kirchhoff_1876;

/// The case.
pub const CASE: Case = Case {
    name: "spin",
    about: "a ball held and turned slowly in a fluid 20,000 times as viscous as water, by DFSPH, in lockstep: torque; Kirchhoff 1876",
    run: |job| STUDY.run(job),
};

const STUDY: Study = Study {
    name: "spin",
    title: "A ball turned in a viscous fluid, in a tank 4 D wide and 3 D deep",
    measure: "error of the torque",
    bound: 0.2,
    coarse_bound: Some(0.2),
    smooth: false,
    resolutions: [6, 10, 16],
    quick: &[6],
    axes: ["time (s)", "torque / that of Kirchhoff"],
    simulate,
};

/// Pa s.
const VISCOSITY: f64 = 20.0;
/// `omega R^2 / nu`, no unit: so slow that the flow is not thrown outwards.
const REYNOLDS: f64 = 0.3;
/// `g R^3 / nu^2`, no unit: enough to press the fluid onto the ball. Particles under pressure lie in each other's gaps and resist the shear
/// too: by standard gravity they do not turn at all, and the torque is twice as large.
const GALILEI: f64 = 1.0;
/// Time for which the ball is held, and for which it is turned, over `R^2 / nu`, in which a vortex sheet spreads by a radius; and the quick
/// form's.
const HELD: [f64; 2] = [5.0, 3.0];
const TURNED: [f64; 2] = [5.0, 3.0];
/// Share of it at the end in which the torque is taken.
const MEASURED: f64 = 0.2;

fn simulate(job: &Job, resolution: u32, progress: &mut Progress) -> Result<Level, LabError> {
    let tank = Tank::for_bodies(resolution);
    let radius = f64::from(DIAMETER) / 2.0;
    let mut scene = Method::WaterAlone.on(tank.scene("spin"));
    scene.material.dynamic_viscosity = VISCOSITY as f32;
    let viscosity = VISCOSITY / f64::from(scene.material.rest_density);
    scene.gravity = Vec3::NEG_Y * (GALILEI * viscosity * viscosity / radius.powi(3)) as f32;
    let spreading = radius * radius / viscosity;
    let speed = REYNOLDS / spreading;
    let mut world = tank.world();
    let middle = Vec3::Y * tank.depth / 2.0;
    let body = RigidBodyBuilder::kinematic_velocity_based().translation(middle);
    let (handle, _) = world.insert(body, ColliderBuilder::ball(DIAMETER / 2.0));
    let mut afloat = Afloat::open(job, scene, world, &[handle], 0)?;

    let expected = kirchhoff_1876::torque(VISCOSITY, radius, speed);
    let ticks = |times: [f64; 2]| (times[usize::from(job.quick)] * spreading / TICK).round() as u32;
    let (held, turned) = (ticks(HELD), ticks(TURNED));
    let first = (f64::from(turned) * (1.0 - MEASURED)) as u32;
    let (mut points, mut torques) = (Vec::new(), Vec::new());
    for tick in 1..=held + turned {
        if tick == held + 1 {
            afloat.world.bodies[handle].set_angvel(Vec3::Y * speed as f32, true);
        }
        let given = afloat.tick()?;
        if let Some(since) = tick.checked_sub(held + 1) {
            let torque = given.first().map_or(f64::NAN, |given| -f64::from(given.angular.y) / TICK);
            points.push((f64::from(since) * TICK, torque / expected, 1.0));
            if since >= first {
                torques.push(torque);
            }
        }
        progress.at(f64::from(tick) / f64::from(held + turned));
    }
    let torque = mean(torques).unwrap_or(f64::NAN);
    let nearest = f64::from(tank.floor[0].min(tank.depth)) / 2.0;
    let remark = format!(
        "torque {torque:.4e} N m, {expected:.4e} in an endless fluid, {:.4e} in a ball that the tank holds",
        expected * kirchhoff_1876::confined(radius / nearest)
    );
    Ok(Level {
        resolution,
        particles: afloat.particles()?,
        error: (torque / expected - 1.0).abs(),
        traces: vec![Trace { name: "torque".to_owned(), points }],
        checks: Vec::new(),
        remarks: vec![remark],
        account: afloat.account().clone(),
    })
}
