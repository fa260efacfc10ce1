//! What each integrator makes of a fluid: a dam break, and the largest stable step of a violent and of a calm scene.

use freshet_core::integrator::Integrator;

use crate::backend::Backend;
use crate::commands::dam_break::{Run, simulate_with};
use crate::commands::stability::{self, Configuration, Situation, search, survives_by};
use crate::error::LabError;
use crate::output::Csv;
use crate::progress::Progress;
use crate::reference::dam_break::DamBreakExperiment;
use crate::table::Table;

/// A fluid with one integrator.
#[derive(Clone, Debug, PartialEq)]
pub struct Fluid {
    /// Which.
    pub integrator: Integrator,
    /// The dam break.
    pub run: Run,
    /// Largest stable steps as CFL numbers, of the violent and of the calm scene; empty where they were not searched for.
    pub stable: Vec<stability::Found>,
}

/// Largest stable step over smallest that is not.
const PRECISION: f64 = 1.1;

/// Those that solvers have.
pub fn stepped() -> Vec<Integrator> {
    Integrator::ALL.into_iter().filter(|integrator| integrator.in_solvers().is_some()).collect()
}

/// Makes the runs of one integrator on one backend.
pub fn simulate(
    integrator: Integrator,
    experiment: &'static DamBreakExperiment,
    resolution: u32,
    backend: Backend,
    threads: Option<usize>,
    searches: bool,
    progress: &mut Progress,
) -> Result<Fluid, LabError> {
    let with = |mut scene: freshet_core::scene::FluidScene| {
        scene.settings.integrator = integrator;
        scene
    };
    let run = simulate_with(experiment, resolution, with, backend, threads, progress)?;
    let mut stable = Vec::new();
    for situation in Situation::ALL.into_iter().filter(|_| searches) {
        let configuration = Configuration::of_defaults(backend, situation);
        stable.push(search(&configuration, PRECISION, |number| survives_by(integrator, &configuration, number))?);
    }
    Ok(Fluid { integrator, run, stable })
}

/// Of stable numbers: the largest tried may not be the limit.
fn number(found: &stability::Found) -> String {
    let above = found.failure.map_or("none".to_owned(), |failure| failure.name().to_owned());
    format!("{:.2} ({above})", found.stable)
}

/// A line for each, and one for each that solvers refuse.
pub fn table(fluids: &[Fluid]) -> Table {
    let mut table = Table::new([
        "dam break, integrator",
        "front, RMS",
        "with shift",
        "shift",
        "compression",
        "substeps",
        "ns/particle-step",
        "stable CFL, dam break",
        "column",
    ]);
    for Fluid { integrator, run, stable } in fluids {
        let account = &run.account;
        table.row([
            format!("{} a/d = {}, {}, {}", run.experiment.name, run.resolution, run.backend, integrator.name()),
            format!("{:.2} %", 100.0 * run.error.rms),
            format!("{:.2} %", 100.0 * run.error.rms_shifted),
            format!("{:.3}", run.error.shift),
            format!("{:.3} %", 100.0 * account.compression),
            account.substeps.to_string(),
            format!("{:.0}", 1e9 * account.wall.as_secs_f64() / account.particle_steps),
            stable.first().map_or(String::new(), number),
            stable.get(1).map_or(String::new(), number),
        ]);
    }
    for integrator in Integrator::ALL.into_iter().filter(|integrator| integrator.in_solvers().is_none()) {
        let name = format!("any, {}", integrator.name());
        table.row([name.as_str(), "refused: every oscillation grows, see above"]);
    }
    table
}

/// The same numbers.
pub fn csv(fluids: &[Fluid]) -> Csv {
    let comment = "Freshet, the dam break with each integrator: `cargo run --release -p freshet_lab -- integrators`. Front as in dam_break.csv; stable_*:\n\
                   largest stable dt (c + v) / h to 10 %, with how the next one failed, as in stability.csv; empty where not searched for.";
    let columns = [
        "integrator",
        "case",
        "backend",
        "a_over_d",
        "rms_percent",
        "rms_shifted_percent",
        "shift",
        "mean_compression_percent",
        "substeps",
        "ns_per_particle_step",
        "stable_dam_break",
        "failure_dam_break",
        "stable_column",
        "failure_column",
    ];
    let mut csv = Csv::new([comment], &columns);
    for Fluid { integrator, run, stable } in fluids {
        let account = &run.account;
        let mut row = vec![
            integrator.name().to_owned(),
            run.experiment.name.to_owned(),
            run.backend.name().to_owned(),
            run.resolution.to_string(),
            format!("{:.2}", 100.0 * run.error.rms),
            format!("{:.2}", 100.0 * run.error.rms_shifted),
            format!("{:.3}", run.error.shift),
            format!("{:.3}", 100.0 * account.compression),
            account.substeps.to_string(),
            format!("{:.0}", 1e9 * account.wall.as_secs_f64() / account.particle_steps),
        ];
        for found in stable {
            row.push(format!("{:.3}", found.stable));
            row.push(found.failure.map_or("none", stability::Failure::name).to_owned());
        }
        csv.row(row);
    }
    csv
}
