//! `stability`: how long a step may be, for every kernel, number of neighbours, speed of sound and option.

mod report;
mod search;
mod trial;

use clap::Args;
use freshet_core::kernel::KernelKind;

pub use search::{Found, search};
pub use trial::{Configuration, Failure, Situation, SolverOption, survives, survives_by};

use crate::backend::Backend;
use crate::error::LabError;
use crate::options::{BackendChoice, CommonOptions, ThreadOption};
use crate::output::{Output, say, say_files};
use crate::progress::Progress;
use crate::side_by_side::{cores, side_by_side};
use crate::verdict::{Bound, Verdict};

/// The largest stable time step as a CFL number, `dt (c + v) / h`, with no other limit on the step; of divergence-free SPH `dt v / d`.
///
/// Bisected to 5 % on a violent scene (a dam break against the far wall) and a calm one (a tall column at rest). A run fails by
/// numbers that are not finite, mechanical energy above 1.05 of the start, a mean compression above 5 %, a lost particle, or when
/// the nearest neighbour of one particle in a hundred is nearer than 0.3 d; the map says by which. Bound: with default settings
/// the plan's own factor is stable.
#[derive(Args, Clone, Debug)]
pub struct StabilityArgs {
    /// Options every command has. The GPU runs the quick form only.
    #[command(flatten)]
    pub common: CommonOptions,
    /// Configurations that run side by side on the CPU, one thread each.
    #[command(flatten)]
    pub threads: ThreadOption,
    /// Solver options to try [default: all; quick: tait]; allowed: tait, linear, unclamped, near-pressure, tensile-correction, morris-viscosity, xsph,
    /// variable-support, continuity, position-based, pressure-corrected, poisson, tensile-correction, dfsph. What stability.csv in the folder holds of the others stays in it and in the map.
    #[arg(long, value_name = "NAME,NAME", value_delimiter = ',', value_parser = option)]
    pub options: Vec<SolverOption>,
}

fn option(text: &str) -> Result<SolverOption, String> {
    SolverOption::ALL.into_iter().find(|option| option.argument() == text).ok_or_else(|| {
        let names = SolverOption::ALL.map(SolverOption::argument);
        format!("allowed: {}", names.join(", "))
    })
}

/// Neighbours of the full form.
const NEIGHBOURS: [f32; 4] = [24.0, 32.0, 50.0, 80.0];
/// Speeds of sound of the full form, over the largest speed expected.
const SOUND: [f32; 3] = [5.0, 10.0, 20.0];

impl StabilityArgs {
    /// What is tried on a backend: everything, or in the quick form the plan's defaults and one other kernel.
    pub fn configurations(&self, backend: Backend) -> Vec<Configuration> {
        let quick = self.common.quick || backend == Backend::Gpu;
        let kernels = match (quick, backend) {
            (false, _) => KernelKind::WITH_GRADIENT.to_vec(),
            (true, Backend::Cpu) => vec![KernelKind::WendlandC2, KernelKind::Spiky],
            (true, Backend::Gpu) => vec![KernelKind::WendlandC2],
        };
        let (neighbours, sound) = if quick { (&NEIGHBOURS[1..2], &SOUND[1..2]) } else { (&NEIGHBOURS[..], &SOUND[..]) };
        let options = match (self.options.is_empty(), quick) {
            (false, _) => &self.options[..],
            (true, true) => &SolverOption::ALL[..1],
            (true, false) => &SolverOption::ALL[..],
        };
        let by_option = |option: SolverOption| if option.has_sound() { sound } else { &[Configuration::SOUND][..] };
        let mut all = Vec::new();
        for &kernel in &kernels {
            for &neighbours in neighbours {
                for &option in options.iter().filter(|option| backend == Backend::Cpu || option.has_sound()) {
                    for situation in Situation::ALL {
                        all.extend(by_option(option).iter().map(|&sound| Configuration {
                            backend,
                            option,
                            kernel,
                            neighbours,
                            sound,
                            situation,
                        }));
                    }
                }
            }
        }
        all
    }

    /// What is known of the options that are not tried.
    fn kept(&self, output: &Output) -> Result<Vec<Found>, LabError> {
        if self.options.is_empty() {
            return Ok(Vec::new());
        }
        let mut found = report::read(output)?;
        found.retain(|found| !self.options.contains(&found.configuration.option));
        Ok(found)
    }

    fn precision(&self, backend: Backend) -> f64 {
        if self.common.quick || backend == Backend::Gpu { 1.25 } else { 1.05 }
    }
}

/// Runs the command.
pub fn run(args: &StabilityArgs) -> Result<Verdict, LabError> {
    let output = Output::new(&args.common.out)?;
    let mut found = args.kept(&output)?;
    for &backend in args.common.backends(BackendChoice::Cpu) {
        let configurations = args.configurations(backend);
        let workers = match backend {
            Backend::Gpu => 1,
            Backend::Cpu => args.threads.count().unwrap_or_else(cores),
        };
        let mut progress = Progress::new(configurations.len() as f64);
        let precision = args.precision(backend);
        let of =
            |configuration: &Configuration| search(configuration, precision, |number| survives(configuration, number));
        side_by_side(&configurations, workers, of, |result| {
            progress.begin(result.configuration.to_string(), 1.0);
            found.push(result);
            report::write(&output, &found)
        })?;
    }
    found.sort_by_key(|found| found.configuration.place());
    report::write(&output, &found)?;
    say(report::table(&found));
    say_files(&output, &report::FILES);
    Ok(verdict(&found))
}

/// The plan's default step is stable with the plan's other defaults.
fn verdict(found: &[Found]) -> Verdict {
    let mut verdict = Verdict::default();
    for result in found.iter().filter(|result| result.configuration.is_default()) {
        let bound = Bound::AtLeast(f64::from(freshet_core::scene::Settings::default().courant_factor));
        verdict.check(format!("{}: largest stable CFL number", result.configuration), result.stable, "", bound);
    }
    verdict
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_default_step_that_does_not_hold_misses_the_bound() {
        let configuration = Configuration::of_defaults(Backend::Cpu, Situation::Calm);
        let found = |stable| Found { configuration, stable, failure: Some(Failure::Energy), runs: 1 };
        assert!(verdict(&[found(f64::from(0.4f32))]).passes());
        assert!(!verdict(&[found(0.39)]).passes());
        let dfsph = Configuration { option: SolverOption::DivergenceFree, ..configuration };
        assert!(!verdict(&[Found { configuration: dfsph, ..found(0.39) }]).passes(), "DFSPH has the same factor");
        let other = Found { configuration: Configuration { neighbours: 80.0, ..configuration }, ..found(0.0) };
        assert!(verdict(&[other]).checks.is_empty(), "what is not the default may fail");
    }
}
