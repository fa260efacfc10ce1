//! Bodies at rest in still water fall asleep.

use freshet_core::viscosity::ViscosityModel;
use freshet_lab::afloat::{Afloat, DIAMETER, TICK, Tank};
use freshet_lab::backend::Backend;
use freshet_lab::commands::validate::Job;
use freshet_lab::output::Output;
use glam::Vec3;
use rapier3d::prelude::*;

/// Ticks until a ball of half the water's density sleeps, let go where it floats; none if that takes more than five seconds. With a viscosity,
/// Pa s, the fluid sticks to it.
fn asleep_after(tank: &Tank, latency: u64, viscosity: Option<f32>) -> Option<u32> {
    let mut world = tank.world();
    let body = RigidBodyBuilder::dynamic().translation(Vec3::Y * tank.depth);
    let (handle, _) = world.insert(body, ColliderBuilder::ball(DIAMETER / 2.0).density(500.0));
    let output = Output::new(&std::env::temp_dir()).unwrap();
    let job = Job {
        backend: Backend::Cpu,
        quick: true,
        threads: Default::default(),
        bodies: Default::default(),
        lockstep: false,
        output,
    };
    let mut scene = tank.scene("sleep");
    if let Some(viscosity) = viscosity {
        scene.material.dynamic_viscosity = viscosity;
        scene.settings.viscosity_model = Some(ViscosityModel::Morris1997);
    }
    let mut afloat = Afloat::open(&job, scene, world, &[handle], latency).unwrap();
    (1..=(5.0 / TICK) as u32).find(|_| {
        afloat.tick().unwrap();
        afloat.body(0).is_sleeping()
    })
}

#[test]
fn a_ball_in_still_water_sleeps_within_five_seconds() {
    let small = Tank { floor: [0.8; 2], depth: 0.4, spacing: DIAMETER / 6.0 };
    for (tank, latency) in [(small, 0), (small, 2), (Tank::for_bodies(6), 2)] {
        let slept = asleep_after(&tank, latency, None);
        println!("{tank:?}, {latency} ticks late: {slept:?}");
        assert!(slept.is_some_and(|ticks| ticks > 60), "{latency} ticks late: {slept:?}");
    }
}

/// One of three spacings that slips along the particles around it goes on turning; one that a fluid a thousand times as viscous as water sticks
/// to does not. With water's own viscosity it still does: that takes ten minutes to stop a ball of this size.
#[test]
fn a_small_ball_sleeps_where_the_fluid_sticks_to_it() {
    let slept = asleep_after(&Tank::for_bodies(3), 0, Some(1.0));
    assert!(slept.is_some_and(|ticks| ticks > 60), "{slept:?}");
}
