//! The cases `validate` knows.

use super::cases;
use super::study::Level;
use crate::afloat::BodyMethod;
use crate::backend::Backend;
use crate::error::LabError;
use crate::options::{BackendChoice, CommonOptions, ThreadOption};
use crate::output::Output;
use crate::verdict::Verdict;

/// How a case is to be run.
#[derive(Clone, Debug)]
pub struct Job {
    /// Where.
    pub backend: Backend,
    /// Coarser or shorter.
    pub quick: bool,
    /// Threads of the CPU solver.
    pub threads: ThreadOption,
    /// How cases with bodies have them.
    pub bodies: BodyMethod,
    /// Whether rapier hears of impulses in the same tick, whatever the case says.
    pub lockstep: bool,
    /// Where the files go.
    pub output: Output,
}

impl Job {
    /// What is added to the names of files for how it has bodies.
    pub fn suffix(&self) -> String {
        format!("{}{}", self.bodies.suffix(), if self.lockstep { "_lockstep" } else { "" })
    }

    /// The options that ask for that, each with a space before.
    pub fn body_options(&self) -> String {
        format!("{}{}", self.bodies.option(), if self.lockstep { " --lockstep" } else { "" })
    }

    /// The same as options of a command.
    pub fn options(&self) -> CommonOptions {
        let backend = match self.backend {
            Backend::Cpu => BackendChoice::Cpu,
            Backend::Gpu => BackendChoice::Gpu,
        };
        CommonOptions { quick: self.quick, backend: Some(backend), out: self.output.path("") }
    }
}

/// What a case found.
#[derive(Clone, Debug, Default)]
pub struct Findings {
    /// Its resolutions, the coarsest first; none for commands, which print their own tables.
    pub levels: Vec<Level>,
    /// Its bounds.
    pub verdict: Verdict,
}

/// A case.
pub struct Case {
    /// Name on the command line and of its files.
    pub name: &'static str,
    /// Geometry, reference and source in a line.
    pub about: &'static str,
    /// Runs it.
    pub run: fn(&Job) -> Result<Findings, LabError>,
}

/// All cases.
pub const CASES: [&Case; 38] = [
    &cases::free_flight::CASE,
    &cases::relaxing_cube::CASE,
    &cases::pool_drop::CASE,
    &cases::poiseuille::CASE,
    &cases::poiseuille::KERNELS,
    &cases::couette::CASE,
    &cases::taylor_green::CASE,
    &cases::standing_wave::CASE,
    &cases::standing_wave::WIDE,
    &cases::hydrostatic::CASE,
    &cases::hydrostatic::MUELLER,
    &cases::hydrostatic::CONTINUITY,
    &cases::hydrostatic::DIVERGENCE_FREE,
    &cases::density_drift::CASE,
    &cases::position_based::CASE,
    &cases::pressure_corrected::CASE,
    &cases::poisson::CASE,
    &cases::deep_column::CASE,
    &cases::deep_column::DIVERGENCE_FREE,
    &cases::calm::CASE,
    &cases::walls::CASE,
    &cases::draft::CASE,
    &cases::light_and_heavy::CASE,
    &cases::added_mass::CASE,
    &cases::gate::CASE,
    &cases::heave::CASE,
    &cases::righting::CASE,
    &cases::stacked::CASE,
    &cases::pinned::CASE,
    &cases::splash::CASE,
    &cases::wet::CASE,
    &cases::crates::CASE,
    &cases::spin::CASE,
    &cases::commands::COLUMN,
    &cases::commands::FLOAT,
    &cases::commands::DAM_BREAK,
    &cases::commands::DAM_BREAK_DFSPH,
    &cases::commands::DAM_BREAK_WATER,
];

/// Names of the cases that have bodies in each of the ways there are.
pub const WITH_BODIES: [&str; 11] = [
    cases::draft::CASE.name,
    cases::light_and_heavy::CASE.name,
    cases::added_mass::CASE.name,
    cases::gate::CASE.name,
    cases::heave::CASE.name,
    cases::righting::CASE.name,
    cases::stacked::CASE.name,
    cases::pinned::CASE.name,
    cases::splash::CASE.name,
    cases::wet::CASE.name,
    cases::crates::CASE.name,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_every_case_says_what_it_is() {
        for (index, case) in CASES.iter().enumerate() {
            assert!(CASES[..index].iter().all(|other| other.name != case.name), "{}", case.name);
            assert!(case.about.len() > 30, "{}", case.name);
        }
    }
}
