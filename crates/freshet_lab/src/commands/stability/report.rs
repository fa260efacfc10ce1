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

const COLUMNS: [&str; 8] =
    ["backend", "scene", "option", "kernel", "neighbours", "sound_over_speed", "stable_cfl", "failure"];
/// Where there is nothing.
const NONE: &str = "none";

/// What an earlier run left in the folder; nothing if there was none.
pub fn read(output: &Output) -> Result<Vec<Found>, LabError> {
    let path = output.path(FILES[0]);
    if !path.exists() {
        return Ok(Vec::new());
    }
    let text = std::fs::read_to_string(&path).map_err(LabError::file(&path))?;
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let bad = |line: &str| LabError::Argument {
        argument: "--options",
        reason: format!("{} has a line that is none of this command's: {line}; try without", path.display()),
    };
    match lines.next() {
        Some(head) if head == COLUMNS.join(",") => {}
        head => return Err(bad(head.unwrap_or_default())),
    }
    lines.map(|line| parse(line).ok_or_else(|| bad(line))).collect()
}

fn parse(line: &str) -> Option<Found> {
    let cells: Vec<&str> = line.split(',').collect();
    let &[backend, situation, option, kernel, neighbours, sound, stable, failure] = &cells[..] else { return None };
    let configuration = Configuration {
        backend: [Backend::Cpu, Backend::Gpu].into_iter().find(|known| known.name() == backend)?,
        situation: Situation::ALL.into_iter().find(|known| known.name() == situation)?,
        option: SolverOption::ALL.into_iter().find(|known| known.name() == option)?,
        kernel: KernelKind::WITH_GRADIENT.into_iter().find(|known| known.name() == kernel)?,
        neighbours: neighbours.parse().ok()?,
        sound: if sound == NONE { Configuration::SOUND } else { sound.parse().ok()? },
    };
    let failure = match failure {
        NONE => None,
        name => Some(Failure::ALL.into_iter().find(|known| known.name() == name)?),
    };
    Some(Found { configuration, stable: stable.parse().ok()?, failure, runs: 0 })
}

fn csv(found: &[&Found]) -> Csv {
    let comments = [
        "Freshet, largest stable step as a CFL number dt (c + v) / h, of DFSPH dt v / d: `cargo run --release -p freshet_lab -- stability`.",
        "failure: how the smallest step failed that was not stable; none: the largest tried was stable.",
    ];
    let mut csv = Csv::new(comments, &COLUMNS);
    for Found { configuration: of, stable, failure, .. } in found {
        csv.row([
            of.backend.name(),
            of.situation.name(),
            of.option.name(),
            of.kernel.name(),
            &of.neighbours.to_string(),
            &if of.option.has_sound() { of.sound.to_string() } else { NONE.to_owned() },
            &format!("{stable:.3}"),
            failure.map_or(NONE, Failure::name),
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

/// Scenes, kernels and numbers of neighbours down, options and speeds of sound across.
fn map(found: &[&Found]) -> HeatMap {
    let of = || found.iter().map(|found| found.configuration);
    let kernels: Vec<KernelKind> = distinct(of().map(|of| of.kernel));
    let mut neighbours: Vec<f32> = distinct(of().map(|of| of.neighbours));
    let mut sounds: Vec<f32> = distinct(of().filter(|of| of.option.has_sound()).map(|of| of.sound));
    neighbours.sort_by(f32::total_cmp);
    sounds.sort_by(f32::total_cmp);
    let groups: Vec<(Backend, SolverOption)> = distinct(of().map(|of| (of.backend, of.option)));
    let situations: Vec<Situation> =
        Situation::ALL.into_iter().filter(|situation| of().any(|of| of.situation == *situation)).collect();
    let blocks = || situations.iter().flat_map(|&situation| kernels.iter().map(move |&kernel| (situation, kernel)));
    let backends = distinct(of().map(|of| of.backend));
    let sounds_of = |option: SolverOption| if option.has_sound() { &sounds[..] } else { &[Configuration::SOUND] };
    let cell = |wanted: Configuration| {
        let found = found.iter().find(|found| found.configuration == wanted)?;
        // From a tenth to four in the logarithm.
        let shade = (found.stable.max(LEAST) / LEAST).ln() / (MOST / LEAST).ln();
        let label = format!("{} {}", number(found), found.failure.map_or("", Failure::letter));
        Some(Cell { shade, label: label.trim().to_owned() })
    };
    let mut cells = Vec::new();
    for (situation, kernel) in blocks() {
        for &neighbours in &neighbours {
            let of_group = |&(backend, option): &(Backend, SolverOption)| {
                let wanted = |&sound: &f32| Configuration { backend, option, kernel, neighbours, sound, situation };
                sounds_of(option).iter().map(wanted).map(cell).collect::<Vec<_>>()
            };
            cells.push(groups.iter().flat_map(of_group).collect());
        }
    }
    let letters: Vec<String> =
        Failure::ALL.iter().map(|failure| format!("{}: {}", failure.letter(), failure.name())).collect();
    HeatMap {
        title: "Largest stable step, dt (c + v) / h".to_owned(),
        notes: vec![
            format!("Above that number the run fails by {}.", letters.join(", ")),
            format!(">= {MOST}: the largest step tried was stable; < {LEAST}: the smallest was not. The limit itself is unknown."),
            "h is half the support radius, v the largest speed in the flow; c over the largest speed expected in the head."
                .to_owned(),
            "DFSPH has no sound: its number is dt v / d, and its steps are limited by pressure, too.".to_owned(),
        ],
        columns: groups
            .iter()
            .map(|(backend, option)| {
                let name = |sound: &f32| match option.has_sound() {
                    true => format!("c = {sound} v"),
                    false => "dt v / d".to_owned(),
                };
                let names = sounds_of(*option).iter().map(name).collect();
                let of = if backends.len() > 1 { format!(", {backend}") } else { String::new() };
                (format!("{}{of}", option.name()), names)
            })
            .collect(),
        rows: blocks()
            .map(|(situation, kernel)| {
                let names = neighbours.iter().map(|count| format!("{count} neighbours")).collect();
                (format!("{}, {}", situation.name(), kernel.name().replace('_', " ")), names)
            })
            .collect(),
        cells,
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn the_recorded_map_is_read_and_written_as_it_is() -> Result<(), LabError> {
        let recorded = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/charts");
        let found = read(&Output::new(&recorded)?)?;
        let options = distinct(found.iter().map(|found| found.configuration.option));
        assert_eq!(options.len(), SolverOption::ALL.len(), "{options:?}");
        let folder = std::env::temp_dir().join(format!("freshet_lab_stability_map_{}", std::process::id()));
        let output = Output::new(&folder)?;
        write(&output, &found)?;
        let text = |path: &Path| std::fs::read_to_string(path).map_err(LabError::file(path));
        assert_eq!(text(&output.path(FILES[0]))?, text(&recorded.join(FILES[0]))?);
        let map = text(&output.path(FILES[1]))?;
        assert!(map.contains("L: particle lost") && map.contains("&gt;= 4"));
        std::fs::remove_dir_all(&folder).map_err(LabError::file(&folder))
    }

    #[test]
    fn the_legend_has_a_letter_of_its_own_for_each_failure() {
        let configuration = Configuration::of_defaults(Backend::Cpu, Situation::Calm);
        let found = Found { configuration, stable: MOST, failure: None, runs: 1 };
        let map = map(&[&found]);
        assert!(map.notes[0].contains("N: not finite, L: particle lost, E: energy"), "{}", map.notes[0]);
        assert!(map.notes[1].starts_with(">= 4"), "{:?}", map.notes);
        assert_eq!(map.cells[0][0].as_ref().map(|cell| cell.label.as_str()), Some(">= 4"));
    }
}
