//! Table, CSV and heat map of the largest stable steps.

use freshet_core::kernel::KernelKind;

use super::search::{Found, LEAST, MOST};
use super::trial::{Configuration, Failure, Situation, SolverOption};
use crate::backend::Backend;
use crate::chart::heat::{self, Cell, HeatMap};
use crate::error::LabError;
use crate::output::{Csv, Output};
use crate::table::Table;

/// Files of the command.
pub const FILES: [&str; 2] = ["stability.csv", "stability.svg"];

/// Writes the files for all that was found so far.
pub fn write(output: &Output, found: &[Found]) -> Result<(), LabError> {
    let mut sorted: Vec<&Found> = found.iter().collect();
    sorted.sort_by_key(|found| found.configuration.place());
    output.write(FILES[0], csv(&sorted).text())?;
    heat::draw(output, FILES[1], &map(&sorted))?;
    Ok(())
}

fn csv(found: &[&Found]) -> Csv {
    let comments = [
        "Freshet, largest stable step as a CFL number dt (c + v) / h: `cargo run --release -p freshet_lab -- stability`.",
        "failure: how the smallest step failed that was not stable; none: the largest tried was stable.",
    ];
    let columns = ["backend", "scene", "option", "kernel", "neighbours", "sound_over_speed", "stable_cfl", "failure"];
    let mut csv = Csv::new(comments, &columns);
    for Found { configuration: of, stable, failure, .. } in found {
        csv.row([
            of.backend.name(),
            of.situation.name(),
            of.option.name(),
            of.kernel.name(),
            &of.neighbours.to_string(),
            &of.sound.to_string(),
            &format!("{stable:.3}"),
            failure.map_or("none", Failure::name),
        ]);
    }
    csv
}

/// What was found, a line each.
pub fn table(found: &[Found]) -> Table {
    let mut table = Table::new(["configuration", "largest stable CFL", "above it", "runs"]);
    for found in found {
        table.row([
            found.configuration.to_string(),
            number(found),
            found.failure.map_or("stable", Failure::name).to_owned(),
            found.runs.to_string(),
        ]);
    }
    table
}

fn number(found: &Found) -> String {
    match found.stable {
        0.0 => format!("< {LEAST}"),
        stable if stable >= MOST => format!(">= {MOST}"),
        stable => format!("{stable:.2}"),
    }
}

/// Different values in the order of their first appearance.
fn distinct<T: PartialEq>(values: impl Iterator<Item = T>) -> Vec<T> {
    values.fold(Vec::new(), |mut all, value| {
        if !all.contains(&value) {
            all.push(value);
        }
        all
    })
}

/// Kernels and numbers of neighbours down, scenes, pressures and speeds of sound across.
fn map(found: &[&Found]) -> HeatMap {
    let of = || found.iter().map(|found| found.configuration);
    let kernels: Vec<KernelKind> = distinct(of().map(|of| of.kernel));
    let mut neighbours: Vec<f32> = distinct(of().map(|of| of.neighbours));
    let mut sounds: Vec<f32> = distinct(of().map(|of| of.sound));
    neighbours.sort_by(f32::total_cmp);
    sounds.sort_by(f32::total_cmp);
    let groups: Vec<(Backend, SolverOption, Situation)> =
        distinct(of().map(|of| (of.backend, of.option, of.situation)));
    let backends = distinct(of().map(|of| of.backend));
    let cell = |wanted: Configuration| {
        let found = found.iter().find(|found| found.configuration == wanted)?;
        // From a tenth to four in the logarithm.
        let shade = (found.stable.max(LEAST) / LEAST).ln() / (MOST / LEAST).ln();
        let label = format!("{} {}", number(found), found.failure.map_or("", Failure::letter));
        Some(Cell { shade, label: label.trim().to_owned() })
    };
    let mut cells = Vec::new();
    for &kernel in &kernels {
        for &neighbours in &neighbours {
            let of_group = |&(backend, option, situation): &(Backend, SolverOption, Situation)| {
                let wanted = |&sound: &f32| Configuration { backend, option, kernel, neighbours, sound, situation };
                sounds.iter().map(wanted).map(cell).collect::<Vec<_>>()
            };
            cells.push(groups.iter().flat_map(of_group).collect());
        }
    }
    let letters = [Failure::Lost, Failure::Energy, Failure::Compression, Failure::Crowded];
    let letters: Vec<String> = letters.map(|failure| format!("{}: {}", failure.letter(), failure.name())).into();
    HeatMap {
        title: "Largest stable step, dt (c + v) / h".to_owned(),
        notes: vec![
            format!("Above that number the run fails by {}.", letters.join(", ")),
            "h is half the support radius, v the largest speed in the flow; c over the largest speed expected in the head."
                .to_owned(),
        ],
        columns: groups
            .iter()
            .map(|(backend, option, situation)| {
                let names = sounds.iter().map(|sound| format!("c = {sound} v")).collect();
                let of = if backends.len() > 1 { format!(", {backend}") } else { String::new() };
                (format!("{}, {}{of}", situation.name(), option.name()), names)
            })
            .collect(),
        rows: kernels
            .iter()
            .map(|kernel| {
                (kernel.name().to_owned(), neighbours.iter().map(|count| format!("{count} neighbours")).collect())
            })
            .collect(),
        cells,
    }
}
