//! `pareto`: every configuration on five scenes, cost against error, and presets from what nothing beats.

mod front;
mod methods;
mod report;
pub mod scenes;
mod trial;

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use freshet_core::configuration::{CONFIGURATIONS, Configuration};

pub use front::{Point, Presets, choices, dominator, front};
pub use methods::{document, table_of_fidelity};
pub use report::read;
pub use trial::{Failure, Trial};

use self::scenes::{CHOSEN_BY, HELD_OUT, Job};
use crate::backend::Backend;
use crate::error::LabError;
use crate::options::{BackendChoice, CommonOptions, ThreadOption};
use crate::output::{Output, say, say_files};
use crate::progress::Progress;
use crate::side_by_side::{cores, side_by_side};
use crate::verdict::{Bound, Verdict};

/// Speed against accuracy: every configuration of the registry on five scenes, at two resolutions.
///
/// The scenes: a dam break against Martin & Moyce 1952, a column at rest, a free ball that is drawn out, a viscous channel, a standing wave (the last four exact). A point's
/// error is that of the scene it does worst on; its cost is wall seconds per simulated second, the geometric mean of the five. Runs take one thread each
/// and go side by side. A run fails by numbers that are not finite, a lost particle, energy above 1.05 of the start, a mean compression above 5 %, more wall
/// time than --cap, an error above 100 %, or because plan or backend refuse it; a configuration that fails on a scene has no error and is drawn as a failure.
/// Of the points the front is marked (nothing is both faster and better), of every other what dominates it is named.
///
/// Presets are chosen among configurations that fail at no resolution on the CPU, by the error at the worse one and the cost at the finest: Accurate has the
/// smallest error, Fast is the cheapest within 10 %, Balanced has the smallest product of cost and error of what is between both. Bounds: on a sixth scene that took no part (Lobovsky's dam break, front with the best shift of the clock) each preset's error
/// is at most the error it is named by; the default configuration fails nowhere.
///
/// Writes pareto.csv and pareto.svg after each finished configuration; with --sources also the table that FluidFidelity chooses from
/// (crates/freshet_core/src/fidelity/measured.rs) and docs/methods.md. All of it in one go, on a quiet machine, half an hour on two cores at the most:
/// `cargo run --release -p freshet_lab -- pareto --out docs/charts --sources .`
#[derive(Args, Clone, Debug)]
pub struct ParetoArgs {
    /// Options every command has. The GPU runs the coarsest resolution only.
    #[command(flatten)]
    pub common: CommonOptions,
    /// Runs side by side on the CPU, one thread each.
    #[command(flatten)]
    pub threads: ThreadOption,
    /// Configurations to run [default: all; quick: seven]. What pareto.csv in the folder holds of the others stays, and what it holds of
    /// the other backend in any case.
    #[arg(long, value_name = "NAME,NAME", value_delimiter = ',', value_parser = configuration)]
    pub configurations: Vec<&'static Configuration>,
    /// Particles across the fluid [default: 12,24; quick: 12].
    #[arg(long, value_name = "N,N", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(8..=48))]
    pub across: Vec<u32>,
    /// Most wall time of a run, s.
    #[arg(long, value_name = "S", value_parser = clap::value_parser!(u16).range(1..=3600), default_value_t = 60)]
    pub cap: u16,
    /// Root of the source tree: writes the table of FluidFidelity and docs/methods.md there.
    #[arg(long, value_name = "DIR")]
    pub sources: Option<PathBuf>,
    /// Runs nothing, and writes all files anew from pareto.csv.
    #[arg(long, conflicts_with_all = ["quick", "configurations", "across"])]
    pub redraw: bool,
}

fn configuration(text: &str) -> Result<&'static Configuration, String> {
    Configuration::named(text).map_err(|error| format!("allowed: {}", error.allowed))
}

/// Configurations of the quick form.
const QUICK: [&str; 7] = ["tait", "linear", "dfsph", "dfsph-fast", "courant-0.8", "ideal-gas", "forward-euler"];

/// Resolutions of the full form; those of the quick form and of the GPU are the first.
const ACROSS: [u32; 2] = [12, 24];

impl ParetoArgs {
    /// What is run on a backend, the longest first, so that no core waits long for another in the end.
    pub fn jobs(&self, backend: Backend) -> Vec<Job> {
        let is_asked = |known: &&Configuration| match (self.configurations.is_empty(), self.common.quick) {
            (false, _) => self.configurations.contains(known),
            (true, true) => QUICK.contains(&known.name),
            (true, false) => true,
        };
        let mut across = match (self.across.is_empty(), self.common.quick) {
            (false, _) => self.across.clone(),
            (true, true) => ACROSS[..1].to_vec(),
            (true, false) => ACROSS.to_vec(),
        };
        across.sort_unstable();
        across.dedup();
        if backend == Backend::Gpu {
            across.truncate(1);
        }
        let cap = Duration::from_secs(self.cap.into());
        let of = |across: u32| {
            let asked = CONFIGURATIONS.iter().filter(is_asked);
            asked.map(move |configuration| Job { configuration, across, backend, cap })
        };
        across.iter().rev().flat_map(|&across| of(across).collect::<Vec<Job>>()).collect()
    }

    fn workers(&self, backend: Backend) -> usize {
        match backend {
            Backend::Gpu => 1,
            Backend::Cpu => self.threads.count().unwrap_or_else(cores),
        }
    }
}

/// Runs a job on all scenes it is judged by.
pub fn simulate(job: &Job) -> Result<Point, LabError> {
    let trials = CHOSEN_BY.iter().map(|scene| (scene.simulate)(job)).collect::<Result<Vec<Trial>, LabError>>()?;
    let Job { configuration, across, backend, .. } = *job;
    Ok(Point { configuration, backend, across, trials, held_out: None })
}

/// Runs the command.
pub fn run(args: &ParetoArgs) -> Result<Verdict, LabError> {
    let output = Output::new(&args.common.out)?;
    let mut points = read(&output)?;
    if !args.redraw {
        for &backend in args.common.backends(BackendChoice::Cpu) {
            let jobs = args.jobs(backend);
            let is_of =
                |point: &Point, job: &Job| (job.configuration, job.across) == (point.configuration, point.across);
            let stays = |point: &Point| !args.configurations.is_empty() && !jobs.iter().any(|job| is_of(point, job));
            points.retain(|point| point.backend != backend || stays(point));
            judge(args, &output, &jobs, &mut points)?;
        }
        hold_out(args, &output, &mut points)?;
    }
    // What is in the file, rounded as it is, is what all else is made of.
    report::write(&output, &mut points)?;
    let mut points = read(&output)?;
    report::write(&output, &mut points)?;
    say(report::table(&points));
    if let Some(root) = &args.sources {
        methods::write(root, &points)?;
    }
    say_files(&output, &report::FILES);
    Ok(verdict(&points))
}

fn judge(args: &ParetoArgs, output: &Output, jobs: &[Job], points: &mut Vec<Point>) -> Result<(), LabError> {
    let work = |across: u32| f64::from(across).powi(4);
    let mut progress = Progress::new(jobs.iter().map(|job| work(job.across)).sum());
    let workers = jobs.first().map_or(1, |job| args.workers(job.backend));
    side_by_side(jobs, workers, simulate, |point| {
        progress.begin(point.name(), work(point.across));
        points.push(point);
        report::write(output, points)
    })
}

/// Runs what is on the front on the scene that took no part.
fn hold_out(args: &ParetoArgs, output: &Output, points: &mut [Point]) -> Result<(), LabError> {
    let cap = Duration::from_secs(args.cap.into());
    let choices = choices(points);
    let on_front = front(&choices, Backend::Cpu).into_iter().filter(|point| point.held_out.is_none());
    let job =
        |point: &Point| Job { configuration: point.configuration, across: point.across, backend: point.backend, cap };
    let jobs: Vec<Job> = on_front.map(job).collect();
    let mut progress = Progress::new(jobs.len() as f64);
    let work = |job: &Job| Ok((*job, (HELD_OUT.simulate)(job)?));
    let mut found = Vec::new();
    side_by_side(&jobs, args.workers(Backend::Cpu), work, |(job, trial)| {
        progress.begin(format!("{}, {}", HELD_OUT.title, job.configuration.name), 1.0);
        found.push((job, trial));
        Ok(())
    })?;
    for (job, trial) in found {
        let is_of = |point: &&mut Point| {
            (point.configuration, point.across, point.backend) == (job.configuration, job.across, job.backend)
        };
        if let Some(point) = points.iter_mut().find(is_of) {
            point.held_out = Some(trial);
        }
    }
    report::write(output, points)
}

/// Presets hold the error they are named by where they were not chosen, and the default works.
fn verdict(points: &[Point]) -> Verdict {
    let mut verdict = Verdict::default();
    let choices = choices(points);
    let on_front = front(&choices, Backend::Cpu);
    for (preset, name) in Presets::of(&on_front).iter().flat_map(|presets| presets.0.iter().zip(report::PRESETS)) {
        let named = 100.0 * preset.error().unwrap_or(f64::NAN);
        let check = format!("{name}, {}: error on the {}", preset.name(), HELD_OUT.title);
        match &preset.held_out {
            // A failure is no number, and kept by no bound.
            Some(trial) => {
                verdict.check(check, 100.0 * trial.error().unwrap_or(f64::NAN), "%", Bound::AtMost(named));
            }
            None => verdict.leave_open(check, "%", Bound::AtMost(named)),
        }
    }
    for point in points.iter().filter(|point| *point.configuration == CONFIGURATIONS[0]) {
        let failed = point.trials.iter().filter(|trial| trial.failure().is_some()).count();
        let check = format!("{}, the default, {}: scenes it fails on", point.name(), point.backend);
        verdict.check(check, failed as f64, "", Bound::AtMost(0.0));
    }
    verdict
}

#[cfg(test)]
mod tests {
    use super::front::tests::point;
    use super::*;

    #[test]
    fn a_preset_that_does_not_hold_its_error_misses_the_bound() {
        let passes = |held_out: Option<Trial>| {
            let point = Point { held_out, ..point(0, 12, 1.0, 0.05) };
            verdict(&[point]).passes()
        };
        let trial = |error: f64| Some(Trial { parts: Ok(vec![error]), cost: Some(1.0) });
        assert!(passes(trial(0.05)) && !passes(trial(0.0501)));
        assert!(!passes(Some(Trial { parts: Err(Failure::Lost), cost: Some(1.0) })));
        let open = verdict(&[Point { held_out: None, ..point(0, 12, 1.0, 0.05) }]);
        assert_eq!(open.unmeasured.len(), 3);
        assert!(!verdict(&[point(0, 12, 1.0, f64::NAN)]).passes(), "the default fails");
    }

    #[test]
    fn the_full_form_is_as_large_as_asked_for() {
        let common = CommonOptions { quick: false, backend: None, out: PathBuf::new() };
        let (threads, configurations, across) = (Default::default(), Vec::new(), Vec::new());
        let full = ParetoArgs { common, threads, configurations, across, cap: 60, sources: None, redraw: false };
        let jobs = full.jobs(Backend::Cpu);
        assert!(jobs.len() * CHOSEN_BY.len() >= 320, "{} jobs", jobs.len());
        assert_eq!((jobs[0].across, jobs[jobs.len() - 1].across), (24, 12));
        assert!(full.jobs(Backend::Gpu).iter().all(|job| job.across == 12));
        let common = CommonOptions { quick: true, ..full.common.clone() };
        assert_eq!(ParetoArgs { common, ..full }.jobs(Backend::Cpu).len(), QUICK.len());
    }
}
