//! Whether a step's time per particle depends on the size: sizes in turn, with both methods.
//!
//! The ladder runs one size after the other, minutes apart, in which the machine's pace changes by more than the bound. Here all
//! sizes make their ticks in turn, forwards and backwards, so that a change meets all of them.

use std::time::{Duration, Instant};

use freshet_core::plan::Plan;

use super::simulate::OPENING;
use crate::backend::Backend;
use crate::drive::Drive;
use crate::error::LabError;
use crate::measure::statistics::{median, spread};
use crate::method::Method;
use crate::output::Csv;
use crate::progress::Progress;
use crate::scenes::tank;
use crate::table::Table;

/// Sizes over which the time per particle-step on two threads is to be flat.
pub const FLAT_SIZES: [u32; 3] = [8_000, super::scene::AIM_PARTICLES, 125_000];
/// Threads on which it is to be.
pub const THREADS: usize = 2;
/// Written where it ran.
pub const FILE: &str = "bench_flat.csv";

/// Ticks a second.
const TICKS_PER_SECOND: f64 = 60.0;

/// What is simulated, s: an incompressible fluid's first substep, from rest, takes more iterations than twenty of the others.
fn seconds(method: Method) -> f64 {
    match method {
        method if method.is_weakly_compressible() => OPENING,
        _ => 0.5,
    }
}

/// A size of the tank that ran in turn with the others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlatRun {
    /// How pressure was found.
    pub method: Method,
    /// Particles.
    pub particles: u32,
    /// Which of the repeats, from 1.
    pub repeat: u16,
    /// Wall nanoseconds per particle and substep.
    pub nanoseconds: f64,
    /// Wall nanoseconds of the pressure solves per particle and iteration; not a number without iterations.
    pub of_iteration: f64,
    /// Substeps timed.
    pub substeps: u64,
    /// Iterations of both solves in all of them.
    pub iterations: u64,
    /// Wall seconds per simulated second.
    pub pace: f64,
}

impl FlatRun {
    fn of(drive: &Drive, method: Method, particles: u32, repeat: u16, iterations: u64) -> Self {
        let account = drive.account();
        let solves = account.nanoseconds_of_passes().filter(|(name, _)| name.ends_with("_solve"));
        let of_solves: f64 = solves.map(|(_, nanoseconds)| nanoseconds).sum();
        Self {
            method,
            particles,
            repeat,
            nanoseconds: account.nanoseconds_per_particle_step(),
            of_iteration: of_solves * account.substeps as f64 / iterations as f64,
            substeps: account.substeps,
            iterations,
            pace: account.wall_per_simulated(),
        }
    }

    fn iterations_per_substep(&self) -> f64 {
        self.iterations as f64 / self.substeps as f64
    }
}

/// How often the time of the first 0.1 s of the weakly compressible tank all of it takes, about.
pub const WORK_OVER_OPENING: f64 = 3.5;

/// Runs all sizes with both methods; returns the runs and the time that all of it took.
pub fn simulate(repeats: u16, progress: &mut Progress, work: f64) -> Result<(Vec<FlatRun>, Duration), LabError> {
    let start = Instant::now();
    let mut runs = Vec::new();
    for repeat in 1..=repeats {
        for method in Method::ALL {
            progress.begin(format!("sizes in turn, {}, run {repeat}", method.name()), work / f64::from(2 * repeats));
            runs.extend(in_turn(&FLAT_SIZES, method, repeat, progress)?);
        }
    }
    Ok((runs, start.elapsed()))
}

fn in_turn(sizes: &[u32], method: Method, repeat: u16, progress: &mut Progress) -> Result<Vec<FlatRun>, LabError> {
    let open = |&size: &u32| -> Result<(Drive, u32, u64), LabError> {
        let plan = Plan::new(&method.on(tank::scene(size)))?;
        Ok((Drive::open(Backend::Cpu, plan, Some(THREADS), Vec::new())?, size, 0))
    };
    let mut drives = sizes.iter().map(open).collect::<Result<Vec<_>, _>>()?;
    let ticks = (seconds(method) * TICKS_PER_SECOND).round() as u32;
    for tick in 1..=ticks {
        for (drive, _, iterations) in &mut drives {
            let report = drive.tick(1.0 / TICKS_PER_SECOND)?;
            *iterations += u64::from(report.divergence_iterations) + u64::from(report.density_iterations);
        }
        drives.reverse();
        progress.at(f64::from(tick) / f64::from(ticks));
    }
    drives.sort_by_key(|&(_, size, _)| size);
    Ok(drives.iter().map(|(drive, size, iterations)| FlatRun::of(drive, method, *size, repeat, *iterations)).collect())
}

/// The median over the repeats of a size.
fn over(runs: &[FlatRun], method: Method, particles: u32, value: impl Fn(&FlatRun) -> f64) -> f64 {
    let of = runs.iter().filter(|run| (run.method, run.particles) == (method, particles));
    median(&of.map(value).collect::<Vec<_>>()).unwrap_or(f64::NAN)
}

/// The slowest size's time over the fastest's, each the median of its repeats.
pub fn most_over_least(runs: &[FlatRun], method: Method) -> f64 {
    let times = FLAT_SIZES.map(|size| over(runs, method, size, |run| run.nanoseconds));
    spread(&times).map_or(f64::NAN, |(least, most)| most / least)
}

/// Medians of all sizes.
pub fn table(runs: &[FlatRun]) -> Table {
    let head = ["sizes in turn, 2 threads", "ns/(p step)", "iterations a step", "ns/(p iteration)", "s of wall a s"];
    let mut table = Table::new(head);
    for method in Method::ALL {
        for size in FLAT_SIZES {
            let shown = |value: &dyn Fn(&FlatRun) -> f64, decimals| {
                super::tables::shown(over(runs, method, size, value), decimals)
            };
            table.row([
                format!("{}, {size} particles", method.name()),
                shown(&|run| run.nanoseconds, 1),
                shown(&FlatRun::iterations_per_substep, 2),
                shown(&|run| run.of_iteration, 1),
                shown(&|run| run.pace, 2),
            ]);
        }
    }
    table
}

/// A row a run.
pub fn csv(runs: &[FlatRun]) -> Csv {
    let comments = "Freshet's speed over sizes of the tank, `cargo run --release -p freshet_lab -- bench`; a row a run. All \
                    sizes of a method\nran in turn, tick by tick, on two threads: WCSPH the first 0.1 s, DFSPH the first \
                    0.5 s. ns_per_particle_iteration: of the\npressure solves alone.";
    let columns = [
        "method",
        "particles",
        "repeat",
        "ns_per_particle_step",
        "substeps",
        "iterations",
        "ns_per_particle_iteration",
        "wall_per_simulated",
    ];
    let mut csv = Csv::new([comments], &columns);
    for run in runs {
        csv.row([
            run.method.name().to_owned(),
            run.particles.to_string(),
            run.repeat.to_string(),
            format!("{:.2}", run.nanoseconds),
            run.substeps.to_string(),
            run.iterations.to_string(),
            super::tables::shown(run.of_iteration, 2),
            format!("{:.3}", run.pace),
        ]);
    }
    csv
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub fn flat_runs(method: Method, times: [f64; 3]) -> Vec<FlatRun> {
        let run = |(&particles, nanoseconds): (&u32, f64)| FlatRun {
            method,
            particles,
            repeat: 1,
            nanoseconds,
            of_iteration: f64::NAN,
            substeps: 10,
            iterations: 0,
            pace: 1.0,
        };
        FLAT_SIZES.iter().zip(times).map(run).collect()
    }

    #[test]
    fn medians_of_sizes_are_compared() {
        let mut runs = flat_runs(Method::WeaklyCompressible, [120.0, 100.0, 110.0]);
        assert!((most_over_least(&runs, Method::WeaklyCompressible) - 1.2).abs() < 1e-12);
        runs.extend(flat_runs(Method::WeaklyCompressible, [120.0, 100.0, 900.0]));
        runs.extend(flat_runs(Method::WeaklyCompressible, [120.0, 100.0, 100.0]));
        assert!((most_over_least(&runs, Method::WeaklyCompressible) - 1.2).abs() < 1e-12, "one bad minute");
        assert!(most_over_least(&runs, Method::DivergenceFree).is_nan());
        assert_eq!(csv(&runs).text().lines().filter(|line| !line.starts_with('#')).count(), 1 + 9);
    }

    #[test]
    fn sizes_run_in_turn_with_both_methods() -> Result<(), LabError> {
        for method in Method::ALL {
            let runs = in_turn(&[1_000, 125], method, 1, &mut Progress::hidden())?;
            assert_eq!(runs.iter().map(|run| run.particles).collect::<Vec<_>>(), [125, 1_000]);
            for run in runs {
                let is_solved = method == Method::DivergenceFree;
                assert_eq!((run.iterations > run.substeps, run.of_iteration > 0.0), (is_solved, is_solved), "{run:?}");
                assert!(run.nanoseconds > run.of_iteration || !is_solved, "{run:?}");
            }
        }
        Ok(())
    }
}
