//! `dam-break`: the front of collapsing columns against three published experiments, and their height against two.

mod inviscid;
mod report;
mod simulate;

use clap::Args;

pub use simulate::{HeightError, Run, simulate, simulate_with};

use crate::backend::Backend;
use crate::error::LabError;
use crate::method::Method;
use crate::options::{BackendChoice, CommonOptions, ThreadOption};
use crate::output::{Output, say, say_files};
use crate::progress::Progress;
use crate::reference::dam_break::DamBreakExperiment;
use crate::verdict::{Bound, Verdict};

/// Dam breaks against Martin & Moyce 1952 (n^2 = 1 and 2, a = 0.05715 m) and Lobovsky 2014 (0.6 m column).
///
/// Each column is simulated as a slab ten spacings deep, at several numbers of particles along its width `a`, all with the
/// default settings of a scene. Z = x/a is the front, T = n t sqrt(g/a) the time, n^2 = height/width. The front is the 99.5th
/// percentile of the particles' x plus half a spacing. The error is the root mean square of (Z - Z_measured)/Z_measured over
/// the measured points with 1 < T < 3.3 (Lobovsky: until the wall, T = 1.57), as it is and with the best shift of the clock
/// (up to 0.2; positive: the experiment is late).
///
/// Martin & Moyce also measured H, the height of the column at the back wall over its first height: here the volume in a
/// strip four spacings thick at that wall over the strip's floor. Its error is H - H_measured, in units of the height at the
/// start, over all measured points; relative to what is left of the height it is given too.
///
/// Bounds, on the CPU: 8 % at the finest resolution as it is, 5 % with the shift, and the error at the finest below that at
/// the coarsest; the same 5 % with the shift for the height. With water's viscosity alone fronts leave as early as those of potential
/// flow, before the experiments' clocks: as it is, the front is then held against potential flow, to 5 %, and does not have to get
/// better. Writes dam_break.csv (errors and cost), dam_break_fronts.csv and
/// dam_break_heights.csv (all curves) and dam_break.svg.
#[derive(Args, Clone, Debug)]
pub struct DamBreakArgs {
    /// Options every command has.
    #[command(flatten)]
    pub common: CommonOptions,
    /// Threads of the CPU solver.
    #[command(flatten)]
    pub threads: ThreadOption,
    /// Particles along the column's width, coarse to fine. A GPU driver in software runs the coarsest only [default: 12,20,32; quick:
    /// 12,20, weakly compressible, which takes more steps, 12].
    #[arg(long, value_name = "N,N,...", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(4..=200))]
    pub resolutions: Vec<u32>,
    /// How pressure is found. Files of another method than the default have its name; the GPU is left out where it cannot.
    #[arg(long, value_enum, default_value_t)]
    pub method: Method,
}

/// Largest error at the finest resolution, as it is.
pub const RMS_BOUND: f64 = 0.08;
/// Largest error at the finest resolution against potential flow, of water's viscosity alone.
pub const INVISCID_RMS_BOUND: f64 = 0.05;
/// Largest error at the finest resolution with the best shift.
pub const SHIFTED_RMS_BOUND: f64 = 0.05;

/// Largest error of the height with the best shift, in units of the height at the start.
pub const HEIGHT_RMS_BOUND: f64 = 0.05;

impl DamBreakArgs {
    fn resolutions(&self) -> Vec<u32> {
        let mut resolutions = match (self.resolutions.is_empty(), self.common.quick) {
            (false, _) => self.resolutions.clone(),
            (true, true) if self.method.is_weakly_compressible() => vec![12],
            (true, true) => vec![12, 20],
            (true, false) => vec![12, 20, 32],
        };
        resolutions.sort_unstable();
        resolutions.dedup();
        resolutions
    }
}

/// A run to make.
struct Job {
    experiment: &'static DamBreakExperiment,
    backend: Backend,
    resolution: u32,
}

impl Job {
    /// Particle-steps up to a factor: particles times steps, of which there are more the finer it is.
    fn work(&self) -> f64 {
        let per_particle_step = if self.backend == Backend::Gpu { 8.0 } else { 1.0 };
        let steps = f64::from(self.resolution) * self.experiment.aspect.sqrt();
        let span = self.experiment.end();
        crate::scenes::slab::particles(self.experiment, self.resolution) as f64 * steps * span * per_particle_step
    }
}

/// Runs the command.
pub fn run(args: &DamBreakArgs) -> Result<Verdict, LabError> {
    let output = Output::new(&args.common.out)?;
    let resolutions = args.resolutions();
    let mut jobs = Vec::new();
    for &backend in args.common.backends(BackendChoice::Both) {
        let is_software = backend == Backend::Gpu && backend.is_processor()?;
        let sizes = if is_software { &resolutions[..1] } else { &resolutions[..] };
        for &resolution in sizes {
            jobs.extend(DamBreakExperiment::ALL.map(|experiment| Job { experiment, backend, resolution }));
        }
    }
    let mut progress = Progress::new(jobs.iter().map(Job::work).sum());
    let mut runs: Vec<Run> = Vec::new();
    for job in &jobs {
        progress.begin(format!("{}, a/d = {}, {}", job.experiment.title, job.resolution, job.backend), job.work());
        let threads = args.threads.count();
        runs.push(simulate(job.experiment, job.resolution, args.method, job.backend, threads, &mut progress)?);
        report::write(&output, args.method, &runs)?;
    }
    drop(progress);
    say(report::table(&runs));
    say_files(&output, &report::files(args.method).each_ref().map(String::as_str));
    Ok(verdict(args.method, &runs))
}

/// The bounds of all runs.
pub fn verdict(method: Method, runs: &[Run]) -> Verdict {
    let mut verdict = Verdict::default();
    for experiment in DamBreakExperiment::ALL {
        let of_cpu = || runs.iter().filter(|run| run.experiment == experiment && run.backend == Backend::Cpu);
        let (coarsest, finest) = (of_cpu().min_by_key(|run| run.resolution), of_cpu().max_by_key(|run| run.resolution));
        let (Some(coarsest), Some(finest)) = (coarsest, finest) else { continue };
        let at = |what: &str| format!("{} at a/d = {}: {what}", experiment.name, finest.resolution);
        let (reference, as_it_is, bound): (_, fn(&Run) -> f64, _) = match method {
            Method::WaterAlone => (" against potential flow", |run| run.inviscid_error.rms, INVISCID_RMS_BOUND),
            _ => ("", |run| run.error.rms, RMS_BOUND),
        };
        let name = at(&format!("RMS error{reference}"));
        verdict.check(name, as_it_is(finest) * 100.0, "%", Bound::Below(bound * 100.0));
        let shifted = finest.error.rms_shifted * 100.0;
        verdict.check(at("RMS error with shift"), shifted, "%", Bound::Below(SHIFTED_RMS_BOUND * 100.0));
        if let Some(height) = &finest.height_error {
            let bound = Bound::Below(HEIGHT_RMS_BOUND * 100.0);
            verdict.check(at("RMS error of the height with shift"), height.error.rms_shifted * 100.0, "%", bound);
        }
        // Artificial viscosity goes with the spacing, and with it most of the error; without it the coarsest is as good.
        if method != Method::WaterAlone && coarsest.resolution < finest.resolution {
            let name = at(&format!("RMS error over that at {}", coarsest.resolution));
            verdict.check(name, finest.error.rms / coarsest.error.rms, "", Bound::Below(1.0));
        }
    }
    for run in runs {
        let at = |what: &str| format!("{} at a/d = {}, {}: {what}", run.experiment.name, run.resolution, run.backend);
        let lost = run.account.lost as f64 + run.escaped as f64;
        verdict.check(at("particles lost or through a wall"), lost, "", Bound::AtMost(0.0));
        verdict.check(at("time scale"), run.account.time_scale, "", Bound::AtLeast(0.999));
    }
    verdict
}
