//! What the source tree holds of the chart: the table of [`FluidFidelity`](freshet_core::fidelity::FluidFidelity) and `docs/methods.md`.

use std::path::Path;

use freshet_core::configuration::{CONFIGURATIONS, Configuration, Family};
use freshet_core::plan::Plan;
use freshet_core::scene::{Boundary, FluidScene, Volume};
use freshet_cpu::{CpuOptions, CpuSolver};
use glam::Vec3;

use super::front::{Point, Presets, choices, front};
use super::report::PRESETS;
use super::scenes::{CHOSEN_BY, HELD_OUT};
use super::trial::Failure;
use crate::backend::Backend;
use crate::error::LabError;
use crate::output::{Output, say_files};

/// Folder and name of the table in the source tree.
pub const TABLE: [&str; 2] = ["crates/freshet_core/src/fidelity", "measured.rs"];
/// Of the document.
pub const DOCUMENT: [&str; 2] = ["docs", "methods.md"];

/// Writes both.
pub fn write(root: &Path, points: &[Point]) -> Result<(), LabError> {
    for ([folder, file], text) in [(TABLE, table_of_fidelity(points)?), (DOCUMENT, document(points)?)] {
        let output = Output::new(&root.join(folder))?;
        output.write(file, &text)?;
        say_files(&output, &[file]);
    }
    Ok(())
}

/// The table as Rust.
///
/// # Errors
/// If there is nothing on the front.
pub fn table_of_fidelity(points: &[Point]) -> Result<String, LabError> {
    let choices = choices(points);
    let on_front = front(&choices, Backend::Cpu);
    let presets = presets(&on_front)?;
    // Choices are of the CPU: the GPU has points at coarser resolutions.
    let on_cpu = points.iter().filter(|point| point.backend == Backend::Cpu);
    let coarsest = on_cpu.map(|point| point.across).min().unwrap_or_default();
    let mut text = format!(
        "//! Written by `freshet_lab pareto --sources` from `docs/charts/pareto.csv`; not to be edited.\n\n\
         use super::Measured;\n\n\
         /// The front of what fails at no resolution, the cheapest first.\n\
         #[rustfmt::skip]\n\
         pub const MEASURED: [Measured; {}] = [\n",
        on_front.len()
    );
    for point in &on_front {
        let held_out = point.held_out.as_ref().and_then(|trial| trial.error()).unwrap_or(f64::INFINITY);
        text += &format!(
            "    Measured {{ configuration: {:?}, coarsest: {coarsest}, finest: {}, error: {}, cost: {}, held_out: {} }},\n",
            point.configuration.name,
            point.across,
            literal(point.error().unwrap_or(f64::INFINITY)),
            literal(point.cost().unwrap_or(f64::INFINITY)),
            literal(held_out)
        );
    }
    text += "];\n";
    for (preset, name) in presets.0.iter().zip(PRESETS) {
        let index = on_front.iter().position(|point| point == preset).unwrap_or_default();
        text += &format!("/// [`FluidFidelity::{name}`](super::FluidFidelity::{name}).\n");
        text += &format!("pub const {}: Measured = MEASURED[{index}];\n", name.to_uppercase());
    }
    Ok(text)
}

fn presets<'a>(on_front: &[&'a Point]) -> Result<Presets<'a>, LabError> {
    Presets::of(on_front).ok_or_else(|| LabError::Measure {
        what: "a preset",
        reason: "no configuration was run on the CPU without a failure".to_owned(),
    })
}

/// Four digits, as Rust has them.
fn literal(value: f64) -> String {
    match format!("{value:.3e}").parse::<f32>() {
        Ok(value) if value.is_finite() => format!("{value:?}"),
        _ => "f32::INFINITY".to_owned(),
    }
}

/// The document.
///
/// # Errors
/// As [`table_of_fidelity`].
pub fn document(points: &[Point]) -> Result<String, LabError> {
    let choices = choices(points);
    let on_front = front(&choices, Backend::Cpu);
    let presets = presets(&on_front)?;
    let mut text = "\
# Methods: what there is, what it is for, where it fails

Written by `freshet_lab pareto --out docs/charts --sources .` from the registry of configurations
(`crates/freshet_core/src/configuration/registry.rs`) and [`charts/pareto.csv`](charts/pareto.csv); not to be edited.

![Every configuration: wall seconds per simulated second against the error on the worst of five scenes](charts/pareto.svg)

Each configuration is run on five scenes at one or two resolutions, on one thread of the CPU. Its error is that of the scene it does worst on, its cost the
geometric mean of wall seconds per simulated second.

"
    .to_owned();
    for scene in CHOSEN_BY {
        text += &format!("- *{}*: {}.\n", capital(scene.title), scene.about);
    }
    text += &format!("\nA sixth takes no part in any choice. *{}*: {}.\n", capital(HELD_OUT.title), HELD_OUT.about);
    text += "
## Presets

`FluidFidelity` (`Settings::fidelity`, `FluidDomain::with_fidelity`, `fidelity: Balanced` in scene files) chooses settings, which go with any spacing. So it chooses among configurations
that fail at no resolution, by the error at the worse one and the cost at the finest; of these the front is below. `Fast` is the cheapest within 10 %,
`Accurate` has the smallest error, `Balanced` the smallest product of cost and error of what is between them. `FluidFidelity::within(error)` takes the cheapest that keeps
an error, and is an error itself where none does. A plan's notes say what was chosen and why.

| preset | configuration | finest particles across | error | on the sixth scene | wall s per simulated s |
|---|---|---|---|---|---|
";
    for point in &on_front {
        let names = presets.0.iter().zip(PRESETS).filter(|(preset, _)| *preset == point).map(|(_, name)| name);
        let names: Vec<&str> = names.collect();
        let held_out = point.held_out.as_ref().and_then(|trial| trial.error());
        text += &row([
            names.join(", "),
            format!("`{}`", point.configuration.name),
            point.across.to_string(),
            percent(point.error()),
            held_out.map_or("fails".to_owned(), |error| percent(Some(error))),
            point.cost().map_or(String::new(), significant),
        ]);
    }
    text += "
## Configurations

Any of them can be had by `Configuration::named(\"...\")?.on(&scene)?`, or by the settings beside it; speeds there are over the largest that is expected in the scene. Errors and costs
are of the resolutions in turn.
";
    text += "
Walls of the family *walls* but for quasi-fluid and ghost particles do not hold fluid back along their faces: in the viscous channel, which lives by that, they are wholly wrong, whatever they do elsewhere.
Of the methods of Pirovano 2011, Krog 2010 and Enneking 2018 there are not yet: the springs, penalties, images and forces of this family for walls that move.
";
    for family in Family::ALL {
        let mut of_family = CONFIGURATIONS.iter().filter(|known| known.family == family).peekable();
        if of_family.peek().is_none() {
            continue;
        }
        text += &format!("\n### {}\n\n", capital(family.name()));
        text += "| configuration | settings | for | where it fails, what it lacks | CPU | GPU | error | wall s per simulated s |\n";
        text += "|---|---|---|---|---|---|---|---|\n";
        for configuration in of_family {
            text += &row(cells(configuration, points)?);
        }
    }
    Ok(text)
}

fn cells(configuration: &Configuration, points: &[Point]) -> Result<[String; 8], LabError> {
    let changes = configuration.changes()?;
    let settings = if changes.is_empty() { "all defaults".to_owned() } else { format!("`{}`", changes.join("`, `")) };
    let of_it = || points.iter().filter(|point| point.configuration == configuration && point.backend == Backend::Cpu);
    let failures: Vec<String> = of_it()
        .flat_map(|point| CHOSEN_BY.iter().zip(&point.trials).map(move |(scene, trial)| (scene, trial, point.across)))
        .filter_map(|(scene, trial, across)| Some((scene, trial.failure()?, across)))
        .filter(|(_, failure, _)| *failure != Failure::Refused)
        .map(|(scene, failure, across)| format!("{} at {across}: {}", scene.title, failure.name()))
        .collect();
    let mut weakness = configuration.weakness.to_owned();
    if !failures.is_empty() {
        weakness += &format!("; **fails** on {}", failures.join(", "));
    }
    let of_backend =
        |backend| support(configuration, backend).map_or_else(|reason| format!("no: {reason}"), |()| "yes".to_owned());
    let (cpu, gpu) = (of_backend(Backend::Cpu), of_backend(Backend::Gpu));
    let errors: Vec<String> = of_it().map(|point| percent(point.error())).collect();
    let costs: Vec<String> = of_it().map(|point| point.cost().map_or("-".to_owned(), significant)).collect();
    Ok([
        format!("`{}`", configuration.name),
        settings,
        configuration.purpose.to_owned(),
        weakness,
        cpu.clone(),
        if gpu != "yes" && gpu == cpu { "no, as on the CPU".to_owned() } else { gpu },
        errors.join(", "),
        costs.join(", "),
    ])
}

/// Whether a backend has what a configuration asks for, and why not. A tank of water is asked about.
fn support(configuration: &Configuration, backend: Backend) -> Result<(), String> {
    let half = Vec3::splat(0.25);
    let scene = FluidScene {
        volumes: vec![Volume::block(half, half)],
        boundaries: vec![Boundary::open_box(Vec3::ONE, Vec3::splat(0.5))],
        ..FluidScene::with_spacing(0.125)
    };
    let scene = configuration.on(&scene).map_err(|error| error.to_string())?;
    let plan = Plan::new(&scene).map_err(|error| error.to_string())?;
    let checked = match backend {
        Backend::Cpu => CpuSolver::new(plan, CpuOptions { threads: Some(1), ..CpuOptions::default() }).map(|_| ()),
        Backend::Gpu => freshet_gpu::check(&plan),
    };
    checked.map_err(|error| error.to_string())
}

fn row<const N: usize>(cells: [String; N]) -> String {
    format!("| {} |\n", cells.map(|cell| cell.replace('|', "\\|")).join(" | "))
}

fn percent(share: Option<f64>) -> String {
    share.map_or("fails".to_owned(), |share| format!("{} %", significant(100.0 * share)))
}

/// Two digits at least, no more than two behind the point.
fn significant(value: f64) -> String {
    let decimals = if value < 0.1 {
        3
    } else if value < 10.0 {
        2
    } else {
        1
    };
    format!("{value:.decimals$}")
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::super::front::tests::point;
    use super::*;

    #[test]
    fn the_table_is_rust_that_names_the_presets() -> Result<(), LabError> {
        let points = [0, 1, 2].map(|index| {
            let (cost, error) = [(1.0, 0.2), (2.0, 0.05), (3.0, 0.06)][index];
            [point(index, 12, 0.1, 0.04), point(index, 24, cost, error)]
        });
        let points = points.concat();
        let text = table_of_fidelity(&points)?;
        assert!(text.contains("pub const MEASURED: [Measured; 2] = ["), "{text}");
        let line = "    Measured { configuration: \"linear\", coarsest: 12, finest: 24, error: 0.05, cost: 2.0, held_out: 0.025 },";
        assert!(text.contains(line), "{text}");
        assert!(text.ends_with("pub const ACCURATE: Measured = MEASURED[1];\n"), "{text}");
        let error = table_of_fidelity(&[]).map_err(|error| error.to_string());
        assert!(error.as_ref().is_err_and(|text| text.contains("a preset cannot be measured")), "{error:?}");
        Ok(())
    }

    #[test]
    fn every_configuration_is_in_the_document_and_what_is_refused_has_its_reason() -> Result<(), LabError> {
        let text = document(&[point(0, 12, 1.0, 0.2)])?;
        for configuration in CONFIGURATIONS {
            assert!(text.contains(&format!("\n| `{}` | ", configuration.name)), "{}", configuration.name);
        }
        let line = |name: &str| text.lines().find(|line| line.starts_with(&format!("| `{name}`"))).unwrap_or_default();
        for name in ["forward-euler", "position-corrected-beeman"] {
            let line = line(name);
            assert!(line.contains("| no: settings.integrator: ") && line.contains("| no, as on the CPU |"), "{line}");
        }
        assert!(line("courant-0.8-redone").contains("| yes | yes |"), "{}", line("courant-0.8-redone"));
        assert!(line("tait").contains("| yes | yes | 20.0 % | 1.00 |"), "{}", line("tait"));
        Ok(())
    }
}
