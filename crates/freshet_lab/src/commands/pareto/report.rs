//! Table, CSV and chart of all points.

use freshet_core::configuration::{Configuration, Family};

use super::front::{Point, Presets, choices, dominator, front};
use super::scenes::{Benchmark, CHOSEN_BY, HELD_OUT};
use super::trial::{Failure, Trial};
use crate::backend::Backend;
use crate::chart::Colour;
use crate::chart::scatter::{self, Dot, Entry, Scatter, Shape};
use crate::error::LabError;
use crate::output::{Csv, Output};
use crate::table::Table;

/// Files of the command.
pub const FILES: [&str; 2] = ["pareto.csv", "pareto.svg"];

/// Names of the presets, in the order of [`Presets`].
pub const PRESETS: [&str; 3] = ["Fast", "Balanced", "Accurate"];

/// Where there is nothing.
const NONE: &str = "none";

/// Columns before those of the scenes.
const HEAD: [&str; 8] = [
    "configuration",
    "backend",
    "across",
    "error_percent",
    "wall_s_per_simulated_s",
    "failure",
    "on_front",
    "dominated_by",
];

/// Those of a scene: failure, cost, error, then its parts.
fn columns_of(scene: &Benchmark) -> Vec<String> {
    let own = ["failure", "wall_s_per_simulated_s", "error_percent"].map(str::to_owned);
    let parts = scene.parts.iter().map(|part| format!("{part}_percent"));
    own.into_iter().chain(parts).map(|column| format!("{}_{column}", scene.name)).collect()
}

fn columns() -> Vec<String> {
    let scenes = CHOSEN_BY.into_iter().chain([HELD_OUT]);
    HEAD.map(str::to_owned).into_iter().chain(scenes.flat_map(columns_of)).collect()
}

/// Sorts points as the registry has them and writes the files.
pub fn write(output: &Output, points: &mut [Point]) -> Result<(), LabError> {
    let place = |of: &Configuration| freshet_core::configuration::CONFIGURATIONS.iter().position(|known| known == of);
    points.sort_by_key(|point| (point.backend == Backend::Gpu, place(point.configuration), point.across));
    output.write(FILES[0], csv(points).text())?;
    scatter::draw(output, FILES[1], &chart(points))?;
    Ok(())
}

fn csv(points: &[Point]) -> Csv {
    let mut comments = vec![
        "Freshet, every configuration on five scenes: `cargo run --release -p freshet_lab -- pareto`.".to_owned(),
        "error: of the scene it does worst on. wall s per simulated s: geometric mean of the five scenes, one thread a run. across: particles across the fluid."
            .to_owned(),
        "dominated_by: what is as cheap and as good and on the front; of several the one with the smallest product of cost and error."
            .to_owned(),
    ];
    comments.extend(CHOSEN_BY.iter().map(|scene| format!("{}: {}", scene.name, scene.about)));
    comments.push(format!("{} (takes no part in the front): {}", HELD_OUT.name, HELD_OUT.about));
    let columns = columns();
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    let mut csv = Csv::new(comments.iter().map(String::as_str), &columns);
    for point in points {
        let on_front = front(points, point.backend).contains(&point);
        let failure = point.failure(&CHOSEN_BY).map_or(NONE, |(_, failure)| failure.name());
        let own = [
            point.configuration.name.to_owned(),
            point.backend.name().to_owned(),
            point.across.to_string(),
            percent(point.error()),
            number(point.cost()),
            failure.to_owned(),
            if on_front { "yes".to_owned() } else { "no".to_owned() },
            dominator(points, point).map_or(NONE.to_owned(), Point::name),
        ];
        let judged = point.trials.iter().map(Some).chain([point.held_out.as_ref()]);
        let scenes = CHOSEN_BY.into_iter().chain([HELD_OUT]);
        csv.row(own.into_iter().chain(scenes.zip(judged).flat_map(|(scene, trial)| cells_of(scene, trial))));
    }
    csv
}

fn cells_of(scene: &Benchmark, trial: Option<&Trial>) -> Vec<String> {
    let empty = vec![String::new(); 3 + scene.parts.len()];
    let Some(trial) = trial else { return empty };
    let mut cells =
        vec![trial.failure().map_or(NONE, Failure::name).to_owned(), number(trial.cost), percent(trial.error())];
    match &trial.parts {
        Ok(parts) if !scene.parts.is_empty() => cells.extend(parts.iter().map(|&part| percent(Some(part)))),
        _ => cells.extend(scene.parts.iter().map(|_| String::new())),
    }
    cells
}

/// Five digits: what is read again is what was written.
fn number(value: Option<f64>) -> String {
    value.map_or(String::new(), |value| format!("{value:.4e}"))
}

fn percent(share: Option<f64>) -> String {
    share.map_or(String::new(), |share| format!("{:.4}", 100.0 * share))
}

/// What an earlier run left in the folder; nothing if there was none.
pub fn read(output: &Output) -> Result<Vec<Point>, LabError> {
    let path = output.path(FILES[0]);
    if !path.exists() {
        return Ok(Vec::new());
    }
    let text = std::fs::read_to_string(&path).map_err(LabError::file(&path))?;
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let bad = |line: &str| LabError::Argument {
        argument: "--out",
        reason: format!("{} has a line that is none of this command's: {line}; move it away", path.display()),
    };
    match lines.next() {
        Some(head) if head == columns().join(",") => {}
        head => return Err(bad(head.unwrap_or_default())),
    }
    lines.map(|line| parse(line).ok_or_else(|| bad(line))).collect()
}

fn parse(line: &str) -> Option<Point> {
    let cells: Vec<&str> = line.split(',').collect();
    let (own, mut rest) = cells.split_at_checked(HEAD.len())?;
    let mut trial = |scene: &Benchmark| {
        let (of_scene, after) = rest.split_at_checked(3 + scene.parts.len())?;
        rest = after;
        trial_of(scene, of_scene)
    };
    let trials = CHOSEN_BY.into_iter().map(&mut trial).collect::<Option<Option<Vec<Trial>>>>()??;
    let held_out = trial(HELD_OUT)?;
    Some(Point {
        configuration: Configuration::named(own[0]).ok()?,
        backend: [Backend::Cpu, Backend::Gpu].into_iter().find(|known| known.name() == own[1])?,
        across: own[2].parse().ok()?,
        trials,
        held_out,
    })
}

/// The outer none: not of this command; the inner: not run.
fn trial_of(scene: &Benchmark, cells: &[&str]) -> Option<Option<Trial>> {
    let (&[failure, cost, error], parts) = cells.split_first_chunk()?;
    if failure.is_empty() {
        return Some(None);
    }
    let share = |cell: &&str| cell.parse::<f64>().ok().map(|percent| percent / 100.0);
    let parts = match Failure::ALL.into_iter().find(|known| known.name() == failure) {
        Some(failure) => Err(failure),
        None if failure == NONE && scene.parts.is_empty() => Ok(vec![share(&error)?]),
        None if failure == NONE => Ok(parts.iter().map(share).collect::<Option<Vec<f64>>>()?),
        None => return None,
    };
    let cost = if cost.is_empty() { None } else { Some(cost.parse().ok()?) };
    Some(Some(Trial { parts, cost }))
}

/// A line for each point, the cheapest first, failures last.
pub fn table(points: &[Point]) -> Table {
    let scenes = CHOSEN_BY.iter().map(|scene| format!("{} %", scene.title));
    let head = ["configuration", "across", "backend", "wall s / s", "error %"].map(str::to_owned).into_iter();
    let mut table = Table::new(head.chain(scenes).chain(["on the front, or dominated by".to_owned()]));
    let mut sorted: Vec<&Point> = points.iter().collect();
    let key = |point: &Point| point.place().map_or(f64::INFINITY, |place| place.0);
    sorted.sort_by(|a, b| key(a).total_cmp(&key(b)));
    let short = |share: Option<f64>| share.map_or("-".to_owned(), |share| format!("{:.2}", 100.0 * share));
    for point in sorted {
        let of_scene = |trial: &Trial| trial.failure().map_or_else(|| short(trial.error()), |of| of.name().to_owned());
        let standing = match (point.failure(&CHOSEN_BY), dominator(points, point)) {
            (Some((scene, failure)), _) => format!("{}: {}", scene.title, failure.name()),
            (None, Some(better)) => better.name(),
            (None, None) => "front".to_owned(),
        };
        let own = [
            point.configuration.name.to_owned(),
            point.across.to_string(),
            point.backend.to_string(),
            point.cost().map_or("-".to_owned(), |cost| format!("{cost:.3}")),
            short(point.error()),
        ];
        table.row(own.into_iter().chain(point.trials.iter().map(of_scene)).chain([standing]));
    }
    table
}

/// Colour of a family.
fn colour(family: Family) -> Colour {
    match family {
        Family::EquationOfState => Colour(0x0b, 0x45, 0x86),
        Family::SpeedOfSound => Colour(0x3a, 0x9a, 0xd9),
        Family::PressureForce => Colour(0x7a, 0x5a, 0xb8),
        Family::PressureSolver => Colour(0xd9, 0x6a, 0x1b),
        Family::Density => Colour(0xe0, 0xa8, 0x2e),
        Family::Walls => Colour(0x4a, 0x4a, 0x4a),
        Family::Kernel => Colour(0x2e, 0x8b, 0x57),
        Family::Neighbours => Colour(0x8f, 0xb4, 0x2a),
        Family::Integrator => Colour(0xc9, 0x3a, 0x7d),
        Family::Step => Colour(0x8a, 0x5a, 0x2b),
        Family::Viscosity => Colour(0x1a, 0xa3, 0xa3),
        Family::Cohesion => Colour(0x7f, 0x86, 0x8d),
    }
}

fn chart(points: &[Point]) -> Scatter {
    let on_cpu = front(points, Backend::Cpu);
    let across = |backend| points.iter().filter(move |point| point.backend == backend).map(|point| point.across);
    let coarsest = across(Backend::Cpu).min().unwrap_or_default();
    let dot = |point: &Point| {
        let shape = match (point.backend, point.across == coarsest) {
            (Backend::Gpu, _) => Shape::Square,
            (Backend::Cpu, true) => Shape::Ring,
            (Backend::Cpu, false) => Shape::Disc,
        };
        let number = on_cpu.iter().position(|on_front| *on_front == point).map(|index| index + 1);
        let y = point.error().map(|error| 100.0 * error);
        Some(Dot { x: point.cost()?, y, shape, colour: colour(point.configuration.family), number })
    };
    let entry = |(index, point): (usize, &&Point)| Entry {
        name: point.name(),
        numbers: [
            format!("{:.1} %", 100.0 * point.error().unwrap_or(f64::NAN)),
            format!("{:.3} s", point.cost().unwrap_or(f64::NAN)),
        ],
        colour: colour(point.configuration.family),
        number: index + 1,
    };
    let families = Family::ALL.into_iter().filter(|family| points.iter().any(|of| of.configuration.family == *family));
    let mut shapes = vec![(Shape::Ring, format!("{coarsest} particles across"))];
    if let Some(finest) = across(Backend::Cpu).max().filter(|&finest| finest != coarsest) {
        shapes.push((Shape::Disc, format!("{finest} particles across")));
    }
    if let Some(across) = across(Backend::Gpu).max() {
        shapes.push((Shape::Square, format!("GPU solver, {across} across")));
    }
    shapes.push((Shape::Cross, "fails on a scene".to_owned()));
    Scatter {
        title: format!("Speed against accuracy: {} runs of {} configurations", runs(points), configurations(points)),
        x_label: "wall seconds per simulated second, one thread, geometric mean of five scenes".to_owned(),
        y_label: "error on the worst of five scenes, %".to_owned(),
        failed: "fails".to_owned(),
        dots: points.iter().filter_map(dot).collect(),
        front: on_cpu.iter().filter_map(|point| point.place()).map(|(cost, error)| (cost, 100.0 * error)).collect(),
        entries_head: "The front: nothing is both faster and better".to_owned(),
        entries: on_cpu.iter().enumerate().map(entry).collect(),
        colours: families.map(|family| (colour(family), family.name().to_owned())).collect(),
        shapes,
        notes: notes(points),
    }
}

/// Runs that started.
fn runs(points: &[Point]) -> usize {
    let started = |trial: &&Trial| trial.cost.is_some();
    points.iter().map(|point| point.trials.iter().chain(&point.held_out).filter(started).count()).sum()
}

fn configurations(points: &[Point]) -> usize {
    let mut names: Vec<&str> = points.iter().map(|point| point.configuration.name).collect();
    names.sort_unstable();
    names.dedup();
    names.len()
}

/// What fails, by scene and way; what never started is named.
fn notes(points: &[Point]) -> Vec<String> {
    let titles: Vec<&str> = CHOSEN_BY.iter().map(|scene| scene.title).collect();
    let mut notes = vec![format!("Scenes: {}.", titles.join(", "))];
    let choices = choices(points);
    if let Some(presets) = Presets::of(&front(&choices, Backend::Cpu)) {
        let named = presets.0.iter().zip(PRESETS).map(|(preset, name)| {
            format!("{name}: {}, {:.1} %", preset.configuration.name, 100.0 * preset.error().unwrap_or(f64::NAN))
        });
        notes.push(format!("Presets, by the worse resolution: {}.", named.collect::<Vec<_>>().join("; ")));
    }
    let failures = points.iter().filter_map(|point| point.failure(&CHOSEN_BY));
    let mut counts: Vec<((&str, &str), usize)> = Vec::new();
    for (scene, failure) in failures.filter(|(_, failure)| *failure != Failure::Refused) {
        let key = (scene.title, failure.name());
        match counts.iter_mut().find(|known| known.0 == key) {
            Some(known) => known.1 += 1,
            None => counts.push((key, 1)),
        }
    }
    if !counts.is_empty() {
        counts.sort_by_key(|&(_, count)| std::cmp::Reverse(count));
        let counts: Vec<String> =
            counts.iter().map(|((scene, failure), count)| format!("{scene}, {failure}: {count}")).collect();
        // As many as a line of the chart holds.
        for (index, counts) in counts.chunks(5).enumerate() {
            let head = if index == 0 { "Failures: " } else { "" };
            notes.push(format!("{head}{}.", counts.join("; ")));
        }
    }
    let refused = points.iter().filter(|point| point.cost().is_none());
    let mut refused: Vec<&str> = refused.map(|point| point.configuration.name).collect();
    refused.dedup();
    if !refused.is_empty() {
        notes.push(format!("Refused before they start: {}.", refused.join(", ")));
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::super::front::tests::point;
    use super::*;

    fn points() -> Vec<Point> {
        let mut points = vec![point(0, 12, 1.0, 0.2), point(0, 24, 16.0, 0.04), point(1, 12, 2.0, f64::NAN)];
        points.push(point(1, 24, 20.0, 0.05));
        points[1].held_out = None;
        points
    }

    #[test]
    fn what_is_written_is_read_again() -> Result<(), LabError> {
        let folder = std::env::temp_dir().join(format!("freshet_lab_pareto_{}", std::process::id()));
        let output = Output::new(&folder)?;
        let mut written = points();
        write(&output, &mut written)?;
        let found = read(&output)?;
        for (found, written) in found.iter().zip(&written) {
            assert_eq!((found.name(), found.failure(&CHOSEN_BY)), (written.name(), written.failure(&CHOSEN_BY)));
            let close = |a: Option<f64>, b: Option<f64>| match (a, b) {
                (Some(a), Some(b)) => (a / b - 1.0).abs() < 1e-4,
                (a, b) => a == b,
            };
            assert!(close(found.error(), written.error()) && close(found.cost(), written.cost()), "{found:?}");
            assert_eq!(found.held_out.is_some(), written.held_out.is_some());
        }
        assert_eq!(found.len(), written.len());
        let text = csv(&found).text().to_owned();
        assert!(text.contains("linear,cpu,24,5.0000,2.0000e1,none,no,tait at 24,none,"), "{text}");
        assert!(text.contains("linear,cpu,12,,2.0000e0,energy,no,none,energy,"), "{text}");
        write(&output, &mut found.clone())?;
        let again = std::fs::read_to_string(output.path(FILES[0])).map_err(LabError::file(&folder))?;
        assert_eq!(again, text, "reading and writing it changes nothing");
        output.write(FILES[0], "name,value\nx,1\n")?;
        let error = read(&output).map(|points| points.len()).map_err(|error| error.to_string());
        assert!(error.as_ref().is_err_and(|text| text.contains("pareto.csv has a line that is none of")), "{error:?}");
        std::fs::remove_dir_all(&folder).map_err(LabError::file(&folder))
    }

    #[test]
    fn the_chart_numbers_the_front_and_shows_failures_as_such() {
        let chart = chart(&points());
        assert_eq!(chart.dots.iter().filter(|dot| dot.y.is_none()).count(), 1);
        let entries: Vec<&str> = chart.entries.iter().map(|entry| entry.name.as_str()).collect();
        assert_eq!(entries, ["tait at 12", "tait at 24"]);
        assert_eq!(
            chart.notes[1],
            "Presets, by the worse resolution: Fast: tait, 20.0 %; Balanced: tait, 20.0 %; Accurate: tait, 20.0 %."
        );
        assert!(chart.notes[2].contains("dam break, energy: 1"), "{:?}", chart.notes);
        assert_eq!(table(&points()).to_string().lines().count(), 6);
    }
}
