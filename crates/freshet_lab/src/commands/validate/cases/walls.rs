//! A metre of water at rest between walls of every [method](WallMethod): how it stands on them, what leaks, and what it costs.
//!
//! Every method must hold the water and let it come to rest: that has bounds. Walls that are not in the sums make densities fall towards them, so that
//! particles crowd there and pressures are wrong; how much is written down in the table as it is, and has bounds for those that are.

use freshet_core::field::Field;
use freshet_core::leaks::LeakWatch;
use freshet_core::plan::Plan;
use freshet_core::relaxation::Relaxation;
use freshet_core::wall_method::{QuasiFluid, Reflection, WallMethod};

use super::super::{Case, Findings, Job};
use crate::drive::Drive;
use crate::error::LabError;
use crate::measure::column::{floor_pressure, gap, surface_level};
use crate::measure::statistics::mean;
use crate::output::{Csv, say};
use crate::progress::Progress;
use crate::reference::hydrostatics;
use crate::scenes::GRAVITY;
use crate::scenes::column::walled;
use crate::table::Table;
use crate::verdict::{Bound, Verdict};

/// The case.
pub const CASE: Case = Case {
    name: "walls",
    about: "a column of water, 1 m, at rest between walls of every method: leaks, stand-off, pressure on the floor, speed, cost over Akinci's walls",
    run,
};

/// Depth of the water, m.
const DEPTH: f64 = 1.0;
/// Width of its square base, spacings.
const WIDTH: u32 = 8;
/// Particles along the depth; those of the quick form.
const RESOLUTION: [u32; 2] = [24, 16];
/// Time to simulate, s; that of the quick form.
const END: [f64; 2] = [4.0, 1.0];
/// Last part of it over which is averaged.
const LATE: f64 = 0.4;
/// Duration of a tick, s.
const TICK: f64 = 1.0 / 60.0;

/// What became of the column.
struct Outcome {
    method: WallMethod,
    /// Particles that went through a wall or were lost.
    leaked: u64,
    /// Mean distance of the first layer from the floor, and from a side, spacings.
    gaps: [f64; 2],
    /// Pressure on the floor over that of the water above.
    pressure: f64,
    /// Level of the surface over the depth.
    level: f64,
    /// Mean speed, mm/s.
    speed: f64,
    substeps: u64,
    nanoseconds: f64,
}

/// Bounds of a method: pressure on the floor over the water's, level over the depth, none where it does not keep any; mean speed in mm/s at the end, and a
/// second after the start, which is not at rest for walls that are not in the sums.
struct Bounds {
    pressure: Option<(f64, f64)>,
    level: Option<(f64, f64)>,
    speed: [f64; 2],
}

/// Of every method but one: the first layer off the floor, spacings.
const GAP: (f64, f64) = (0.3, 0.7);
/// Of walls that are denser than fluid, which stands off them.
const GAP_OF_PLAIN: (f64, f64) = (0.6, 0.8);

fn is_plain(method: WallMethod) -> bool {
    matches!(method, WallMethod::QuasiFluid(QuasiFluid::Plain { .. }))
}

fn bounds(method: WallMethod) -> Bounds {
    let of_none = |speed: [f64; 2]| Bounds { pressure: None, level: None, speed };
    match method {
        WallMethod::VolumeWeights => {
            Bounds { pressure: Some((0.95, 1.05)), level: Some((0.99, 1.01)), speed: [10.0, 40.0] }
        }
        WallMethod::QuasiFluid(_) | WallMethod::Ghosts => of_none([20.0, 100.0]),
        WallMethod::LennardJones | WallMethod::SpringDamper(_) => of_none([20.0, 100.0]),
        WallMethod::KernelForcing | WallMethod::MonaghanRepulsion => of_none([80.0, 400.0]),
        WallMethod::Penalty(penalty) if penalty.reflection == Reflection::Mirrored => of_none([150.0, 150.0]),
        WallMethod::Penalty(_) => of_none([25.0, 80.0]),
    }
}

fn run(job: &Job) -> Result<Findings, LabError> {
    let resolution = RESOLUTION[usize::from(job.quick)];
    let mut progress = Progress::new(WallMethod::ALL.len() as f64);
    let mut outcomes = Vec::new();
    for method in WallMethod::ALL {
        progress.begin(format!("walls, {}, {}", method.name(), job.backend), 1.0);
        outcomes.push(simulate(job, method, resolution, &mut progress)?);
    }
    let mut table = Table::new([
        "walls",
        "leaked",
        "gap, floor (d)",
        "gap, side (d)",
        "floor pressure",
        "level",
        "speed (mm/s)",
        "substeps",
        "cost over Akinci",
    ]);
    let comment = format!("{}, {resolution} particles deep, on the {}", CASE.about, job.backend);
    let mut csv = Csv::new(
        [comment.as_str()],
        &[
            "method",
            "leaked",
            "gap_floor_spacings",
            "gap_side_spacings",
            "floor_pressure_over_rho_g_d",
            "level_over_depth",
            "mean_speed_mm_s",
            "substeps",
            "ns_per_particle_step",
        ],
    );
    let akinci = outcomes.first().map_or(f64::NAN, |first| first.nanoseconds * first.substeps as f64);
    let mut verdict = Verdict::default();
    for outcome in &outcomes {
        let Outcome { method, leaked, gaps: [floor, side], pressure, level, speed, substeps, nanoseconds } = *outcome;
        let cost = nanoseconds * substeps as f64 / akinci;
        table.row([
            method.name().to_owned(),
            leaked.to_string(),
            format!("{floor:.2}"),
            format!("{side:.2}"),
            format!("{pressure:.3}"),
            format!("{level:.3}"),
            format!("{speed:.1}"),
            substeps.to_string(),
            format!("{cost:.2}"),
        ]);
        let numbers = [leaked as f64, floor, side, pressure, level, speed, substeps as f64, nanoseconds];
        csv.row([method.name().to_owned()].into_iter().chain(numbers.iter().map(f64::to_string)));
        let name = |what: &str| format!("walls of {} at {resolution}, {}: {what}", method.name(), job.backend);
        let bounds = bounds(method);
        verdict.check(name("particles that leaked"), leaked as f64, "", Bound::AtMost(0.0));
        let (least, most) = if is_plain(method) { GAP_OF_PLAIN } else { GAP };
        verdict.check(name("first layer off the floor"), floor, "d", Bound::Within(least, most));
        if let Some((least, most)) = bounds.pressure {
            verdict.check(name("pressure on the floor over rho g D"), pressure, "", Bound::Within(least, most));
        }
        if let Some((least, most)) = bounds.level {
            verdict.check(name("surface level over the depth"), level, "", Bound::Within(least, most));
        }
        let most = bounds.speed[usize::from(job.quick)];
        verdict.check(name("mean speed"), speed, "mm/s", Bound::AtMost(most));
    }
    say(table);
    job.output.write("walls.csv", csv.text())?;
    Ok(Findings { levels: Vec::new(), verdict })
}

fn simulate(job: &Job, method: WallMethod, resolution: u32, progress: &mut Progress) -> Result<Outcome, LabError> {
    let spacing = DEPTH / f64::from(resolution);
    let base = f64::from(WIDTH) * spacing;
    let mut scene = walled(base as f32, DEPTH, spacing as f32);
    scene.settings.wall_method = method;
    // On a lattice half a spacing off walls that are denser than it is, fluid is thrown off them.
    if is_plain(method) {
        scene.settings.relaxation = Some(Relaxation { under_gravity: true, ..Relaxation::default() });
    }
    let mut watch = LeakWatch::new(&scene.wall_layer()?, &scene.boundaries);
    let mut drive = Drive::open(job.backend, Plan::new(&scene)?, job.threads.count(), Vec::new())?;
    let per_layer = (WIDTH * WIDTH) as usize;
    let ticks = (END[usize::from(job.quick)] / TICK).round() as u32;
    let late = ((1.0 - LATE) * f64::from(ticks)) as u32;
    let mut found: [Vec<f64>; 5] = Default::default();
    for tick in 1..=ticks {
        drive.tick(TICK)?;
        progress.at(f64::from(tick) / f64::from(ticks));
        let positions = drive.positions()?;
        let ids = drive.read(Field::Id)?.integers().unwrap_or_default();
        watch.look(&ids, &positions);
        if tick <= late {
            continue;
        }
        let (pressures, speeds) = (drive.scalars(Field::Pressure)?, drive.scalars(Field::Speed)?);
        let heights: Vec<f64> = positions.iter().map(|x| x.y.into()).collect();
        let sides: Vec<f64> = positions.iter().map(|x| f64::from(x.x) + 0.5 * base).collect();
        let layer_of_side = (WIDTH * resolution) as usize;
        let mean_gap = |distances: &[f64], count| gap(distances, count).map(|gap| gap.mean / spacing);
        let whole = hydrostatics::pressure(1000.0, GRAVITY, DEPTH);
        let on_floor = floor_pressure(&positions, &pressures, per_layer, 1000.0, GRAVITY as f32);
        let values = [
            mean_gap(&heights, per_layer),
            mean_gap(&sides, layer_of_side),
            on_floor.map(|pressure| pressure / whole),
            surface_level(&positions, per_layer, spacing as f32).map(|level| level / DEPTH),
            mean(speeds.iter().map(|&speed| 1e3 * f64::from(speed))),
        ];
        for (all, value) in found.iter_mut().zip(values) {
            all.push(value.unwrap_or(f64::NAN));
        }
    }
    let [floor, side, pressure, level, speed] = found.map(|values| mean(values).unwrap_or(f64::NAN));
    let account = drive.account();
    Ok(Outcome {
        method,
        leaked: watch.total() + account.lost,
        gaps: [floor, side],
        pressure,
        level,
        speed,
        substeps: account.substeps,
        nanoseconds: account.nanoseconds_per_particle_step(),
    })
}
