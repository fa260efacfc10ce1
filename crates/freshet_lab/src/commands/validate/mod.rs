//! `validate`: every case of the registry against its reference.

mod bounds;
pub mod cases;
mod registry;
mod study;

use std::time::Instant;

use clap::Args;

use bounds::Bounds;
pub use registry::{CASES, Case, Findings, Job, WITH_BODIES};
pub use study::{Level, Study, Trace};

use crate::afloat::BodyMethod;
use crate::backend::Backend;
use crate::error::LabError;
use crate::options::{BackendChoice, CommonOptions, ThreadOption};
use crate::output::{Output, say};
use crate::table::Table;
use crate::verdict::Verdict;

/// Simulations against exact solutions and measurements, with the observed order of convergence.
///
/// Most cases run at three resolutions, two in the quick form, the coarsest alone on a GPU driver in software. Each has a bound on its error at the
/// finest of the full form; what is smooth also has to get better: its error there over that at the coarsest is at most 0.6. They
/// write NAME.csv and NAME.svg. The others are commands of their own (column: one resolution; float: two; dam-break: three) with their
/// own bounds and files, see their help. All bounds judged, of this and earlier runs into the folder, are in bounds.csv. What a backend cannot do is named and left out; so are, of the quick form on a GPU driver in software, the cases with
/// bodies, unless they are named.
#[derive(Args, Clone, Debug)]
pub struct ValidateArgs {
    /// Options every command has. A GPU driver in software runs the coarsest resolution only.
    #[command(flatten)]
    pub common: CommonOptions,
    /// Threads of the CPU solver.
    #[command(flatten)]
    pub threads: ThreadOption,
    /// Cases to run [default: all].
    #[arg(long, value_name = "NAME,NAME", value_delimiter = ',')]
    pub case: Vec<String>,
    /// How bodies are in the fluid: for draft, light-and-heavy, added-mass, gate and heave, and for no other case.
    #[arg(long, value_enum, default_value_t)]
    pub bodies: BodyMethod,
    /// Rapier hears of impulses in the same tick, also where a case has it hear of them later. For the same cases.
    #[arg(long)]
    pub lockstep: bool,
    /// Names the cases and ends.
    #[arg(long)]
    pub list: bool,
}

impl ValidateArgs {
    /// The cases asked for.
    ///
    /// # Errors
    /// A name that is none, or [`bodies`](Self::bodies) in another way than by default or [`lockstep`](Self::lockstep) with a case without bodies.
    pub fn cases(&self) -> Result<Vec<&'static Case>, LabError> {
        let cases = self.named()?;
        let without = cases.iter().find(|case| !WITH_BODIES.contains(&case.name));
        match without {
            Some(case) if self.lockstep || self.bodies != BodyMethod::default() => {
                let argument = if self.lockstep { "--lockstep" } else { "--bodies" };
                let reason = format!("not with case {}; allowed: with --case {}", case.name, WITH_BODIES.join(","));
                Err(LabError::Argument { argument, reason })
            }
            _ => Ok(cases),
        }
    }

    fn named(&self) -> Result<Vec<&'static Case>, LabError> {
        if self.case.is_empty() {
            return Ok(CASES.to_vec());
        }
        let find = |name: &String| {
            CASES.into_iter().find(|case| case.name == name).ok_or_else(|| {
                let names: Vec<&str> = CASES.iter().map(|case| case.name).collect();
                let reason = format!("{name} is not allowed; allowed: {}", names.join(", "));
                LabError::Argument { argument: "--case", reason }
            })
        };
        self.case.iter().map(find).collect()
    }
}

/// Runs the command.
pub fn run(args: &ValidateArgs) -> Result<Verdict, LabError> {
    let cases = args.cases()?;
    if args.list {
        let mut table = Table::new(["case", "what it is"]);
        for case in cases {
            table.row([case.name, case.about]);
        }
        say(table);
        return Ok(Verdict::default());
    }
    let output = Output::new(&args.common.out)?;
    let (mut levels, mut verdict, mut left_out) = (Vec::new(), Verdict::default(), Vec::new());
    let mut bounds_of_cases = Bounds::default();
    for &backend in args.common.backends(BackendChoice::Cpu) {
        let ValidateArgs { threads, bodies, lockstep, .. } = *args;
        let job = Job { backend, quick: args.common.quick, threads, bodies, lockstep, output: output.clone() };
        // Asked for by name they run.
        let spares = args.common.quick && args.case.is_empty() && backend == Backend::Gpu && backend.is_processor()?;
        for case in &cases {
            if spares && WITH_BODIES.contains(&case.name) {
                left_out.push(format!(
                    "{} is left out of the quick form: minutes on a GPU driver in software; --case {} runs it",
                    case.name, case.name
                ));
                continue;
            }
            let begin = Instant::now();
            match (case.run)(&job) {
                Ok(found) => {
                    let (seconds, bounds) = (begin.elapsed().as_secs_f64(), found.verdict.checks.len());
                    let kept = bounds - found.verdict.missed().count();
                    say(format_args!("{} on the {backend}: {kept} of {bounds} bounds kept, {seconds:.0} s", case.name));
                    let remarks = found.levels.iter().flat_map(|level| &level.remarks);
                    remarks.for_each(|remark| say(format_args!("  {remark}")));
                    bounds_of_cases.add(case.name, &job, &found.verdict);
                    // After each case: a run that is interrupted keeps what it has judged.
                    bounds_of_cases.write(&output)?;
                    levels.extend(found.levels.into_iter().map(|level| (case.name, backend, level)));
                    verdict.checks.extend(found.verdict.checks);
                    verdict.unmeasured.extend(found.verdict.unmeasured);
                }
                Err(LabError::Solver(error @ freshet_core::solver::SolverError::Unsupported { .. })) => {
                    left_out.push(format!("{} is left out: {error}", case.name));
                }
                Err(error) => return Err(error),
            }
        }
    }
    say(study::table(&levels));
    for line in left_out {
        say(line);
    }
    say(format_args!("written: CSV and SVG files of each case in {}", args.common.out.display()));
    Ok(verdict)
}
