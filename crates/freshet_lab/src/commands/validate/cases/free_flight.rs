//! A block of water thrown through empty space, as it is, turning, and turning while it is squeezed, so that pressures act: what must stay as it
//! is.

use freshet_core::field::Field;
use freshet_core::plan::Plan;
use freshet_core::scene::{FluidScene, Volume};
use glam::{DVec3, Vec3};

use super::super::{Case, Job, Level, Study, Trace};
use crate::drive::Drive;
use crate::error::LabError;
use crate::progress::Progress;
use crate::scenes::GRAVITY;
use crate::verdict::{Bound, Check};

/// The case.
pub const CASE: Case = Case {
    name: "free-flight",
    about: "a thrown block: path against the parabola, momentum, extent; the same turning, and turning under pressure: angular momentum",
    run: |job| STUDY.run(job),
};

const STUDY: Study = Study {
    name: "free-flight",
    title: "A thrown block of water",
    measure: "error of the momentum",
    bound: 1e-5,
    coarse_bound: None,
    smooth: false,
    resolutions: [6, 10, 16],
    quick: &[6, 10],
    axes: ["time (s)", "height of the centre of mass (m)"],
    simulate,
};

/// Edge of the block, m.
const EDGE: f32 = 0.5;
/// Velocity of the throw, m/s.
const THROW: Vec3 = Vec3::new(2.0, 4.0, -1.0);
/// Spin of the turning block, rad/s, about no axis of its lattice. Nothing holds the water together, so it comes apart.
const SPIN: Vec3 = Vec3::new(0.5, 1.0, 0.3);
/// How fast the squeezed block comes together, 1/s: what is half a metre from the middle with 1 m/s.
const SQUEEZE: f32 = 2.0;
/// Time of flight, s.
const END: f64 = 1.0;
/// Duration of a tick, s.
const TICK: f64 = 0.02;

fn scene(resolution: u32) -> FluidScene {
    let block = Volume { velocity: THROW, hydrostatic: false, ..Volume::block(Vec3::splat(EDGE / 2.0), Vec3::ZERO) };
    let mut scene = FluidScene { volumes: vec![block], ..FluidScene::with_spacing(EDGE / resolution as f32) };
    // Only differences of velocity count in free flight: those of the spin.
    scene.settings.expected_speed = Some(1.0);
    scene
}

fn simulate(job: &Job, resolution: u32, progress: &mut Progress) -> Result<Level, LabError> {
    let straight = fly(job, resolution, Vec3::ZERO, 0.0, progress)?;
    let turning = fly(job, resolution, SPIN, 0.0, progress)?;
    let squeezed = fly(job, resolution, SPIN, SQUEEZE, progress)?;
    let extent = straight.extents.1 / straight.extents.0 - DVec3::ONE;
    let check = |name: &str, value: f64, most: f64| Check::new(name, value * 100.0, "%", Bound::AtMost(most * 100.0));
    let checks = vec![
        check("change of the extent", extent.abs().max_element(), 0.01),
        check("error of the momentum, turning", turning.momentum, 1e-5),
        check("error of the angular momentum, turning", turning.angular_momentum, 1e-3),
        check("error of the momentum, turning and squeezed", squeezed.momentum, 1e-5),
        check("error of the angular momentum, turning and squeezed", squeezed.angular_momentum, 1e-3),
        // Else nothing pressed, and nothing was tested.
        Check::new("growth of the extent, turning and squeezed", squeezed.growth(), "", Bound::AtLeast(1.2)),
    ];
    let traces = vec![Trace { name: "height".to_owned(), points: straight.heights }];
    let particles = (resolution as usize).pow(3);
    Ok(Level {
        resolution,
        particles,
        error: straight.momentum,
        traces,
        checks,
        remarks: Vec::new(),
        account: straight.account,
    })
}

/// What a flight showed.
struct Flight {
    heights: Vec<(f64, f64, f64)>,
    /// Largest error of the momentum at any tick, over the momentum.
    momentum: f64,
    /// Largest change of the angular momentum about the centre of mass, over that at the start.
    angular_momentum: f64,
    /// Size along x, y and z at the start and at the end, m.
    extents: (DVec3, DVec3),
    account: crate::drive::Account,
}

impl Flight {
    /// Mean size at the end over that at the start.
    fn growth(&self) -> f64 {
        (self.extents.1 / self.extents.0).element_sum() / 3.0
    }
}

fn fly(job: &Job, resolution: u32, spin: Vec3, squeeze: f32, progress: &mut Progress) -> Result<Flight, LabError> {
    let plan = Plan::new(&scene(resolution))?;
    let mut drive = Drive::open(job.backend, plan, job.threads.count(), Vec::new())?;
    drive.set_velocities(|position| THROW + spin.cross(position) - squeeze * position)?;
    let start = State::of(&mut drive)?;
    let mut flight = Flight {
        heights: vec![(0.0, start.centre.y, start.centre.y)],
        momentum: 0.0,
        angular_momentum: 0.0,
        extents: (start.extent, start.extent),
        account: drive.account().clone(),
    };
    let gravity = DVec3::NEG_Y * GRAVITY;
    let ticks = (END / TICK).round() as u32;
    for tick in 1..=ticks {
        drive.tick(TICK)?;
        let (time, now) = (drive.time(), State::of(&mut drive)?);
        let velocity = start.velocity + gravity * time;
        let centre = start.centre + start.velocity * time + 0.5 * gravity * time * time;
        flight.heights.push((time, now.centre.y, centre.y));
        // Relative to what was there and what gravity gave, as the momentum itself passes through little.
        let whole = start.velocity.length() + (gravity * time).length();
        flight.momentum = flight.momentum.max((now.velocity - velocity).length() / whole);
        let turned = (now.spin - start.spin).length() / start.spin.length();
        flight.angular_momentum = flight.angular_momentum.max(turned);
        flight.extents.1 = now.extent;
        progress.at(f64::from(tick) / f64::from(ticks));
    }
    flight.account = drive.account().clone();
    Ok(flight)
}

/// Means over the particles of a block, which all have the same mass.
struct State {
    centre: DVec3,
    velocity: DVec3,
    /// Angular momentum about the centre over the mass.
    spin: DVec3,
    extent: DVec3,
}

impl State {
    fn of(drive: &mut Drive) -> Result<Self, LabError> {
        let (positions, velocities) = (drive.positions()?, drive.vectors(Field::Velocity)?);
        let count = positions.len() as f64;
        let centre = positions.iter().map(|x| x.as_dvec3()).sum::<DVec3>() / count;
        let velocity = velocities.iter().map(|v| v.as_dvec3()).sum::<DVec3>() / count;
        let moments =
            positions.iter().zip(&velocities).map(|(x, v)| (x.as_dvec3() - centre).cross(v.as_dvec3() - velocity));
        let low = positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
        let high = positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
        let spin = moments.sum::<DVec3>() / count;
        Ok(Self { centre, velocity, spin, extent: (high - low).as_dvec3() })
    }
}
