//! Tables, CSV and chart of the benchmark.

use super::{Configuration, Run, nanoseconds, over};
use crate::backend::Backend;
use crate::chart::{self, Chart, Colour, Mark, Panel, Scale, Series};
use crate::error::LabError;
use crate::output::{Csv, Output, say};
use crate::table::Table;

/// A row a run; nanoseconds over size.
pub const FILES: [&str; 2] = ["bench.csv", "bench.svg"];

/// Writes all files anew.
pub fn write(output: &Output, runs: &[Run]) -> Result<(), LabError> {
    output.write(FILES[0], csv(runs).text())?;
    chart::draw(output, FILES[1], &chart(runs))?;
    Ok(())
}

/// Names of all passes, in the order they were first seen.
fn pass_names(runs: &[Run]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for (name, _) in runs.iter().flat_map(|run| &run.account.passes) {
        if !names.contains(name) {
            names.push(name.clone());
        }
    }
    names
}

fn pass(run: &Run, name: &str) -> f64 {
    run.account.nanoseconds_of_passes().find(|pass| pass.0 == name).map_or(f64::NAN, |pass| pass.1)
}

/// Prints the tables: cost, passes, flow.
pub fn print(configurations: &[Configuration], runs: &[Run]) {
    say(cost(configurations, runs));
    say(passes(configurations, runs));
    say(flow(configurations, runs));
}

fn cost(configurations: &[Configuration], runs: &[Run]) -> Table {
    let mut table =
        Table::new(["cost", "ns/(p step)", "least", "most", "s/s", "of 1 thread", "B/particle", "MiB in all"]);
    for configuration in configurations {
        let (middle, least, most) = over(runs, configuration, nanoseconds);
        let single = Configuration { threads: Some(1), ..*configuration };
        let scaling = over(runs, &single, nanoseconds).0 / middle;
        table.row([
            configuration.to_string(),
            format!("{middle:.1}"),
            format!("{least:.1}"),
            format!("{most:.1}"),
            format!("{:.2}", over(runs, configuration, |run| run.account.wall_per_simulated()).0),
            if scaling.is_nan() { String::new() } else { format!("{scaling:.2} x") },
            format!("{:.0}", over(runs, configuration, |run| run.bytes_per_particle).0),
            format!("{:.2}", over(runs, configuration, |run| run.bytes as f64).0 / f64::from(1 << 20)),
        ]);
    }
    table
}

fn passes(configurations: &[Configuration], runs: &[Run]) -> Table {
    let names = pass_names(runs);
    let head = ["passes, ns/(p step)".to_owned()].into_iter().chain(names.iter().cloned());
    let mut table = Table::new(head.chain(["the rest".to_owned()]));
    for configuration in configurations {
        let known: f64 = names.iter().map(|name| over(runs, configuration, |run| pass(run, name)).0).sum();
        let times = names.iter().map(|name| format!("{:.1}", over(runs, configuration, |run| pass(run, name)).0));
        let rest = over(runs, configuration, nanoseconds).0 - known;
        table.row([configuration.to_string()].into_iter().chain(times).chain([format!("{rest:.1}")]));
    }
    table
}

fn flow(configurations: &[Configuration], runs: &[Run]) -> Table {
    let mut table = Table::new([
        "flow",
        "steps",
        "mean dt ms",
        "least dt ms",
        "compr. %",
        "worst mean %",
        "time scale",
        "front at 0.1, 0.2... s (m)",
    ]);
    for configuration in configurations {
        let Some(run) = runs.iter().find(|run| run.configuration == *configuration) else { continue };
        let fronts: Vec<String> = run.front.iter().map(|front| format!("{front:.3}")).collect();
        table.row([
            configuration.to_string(),
            run.account.substeps.to_string(),
            format!("{:.4}", run.account.mean_substep() * 1e3),
            format!("{:.4}", run.account.smallest_substep * 1e3),
            format!("{:.3}", run.account.compression * 100.0),
            format!("{:.3}", run.account.worst_mean_compression * 100.0),
            format!("{:.3}", run.account.time_scale),
            fronts.join(" "),
        ]);
    }
    table
}

fn csv(runs: &[Run]) -> Csv {
    let names = pass_names(runs);
    let mut columns = vec![
        "backend",
        "threads",
        "particles",
        "repeat",
        "simulated_s",
        "wall_s",
        "ns_per_particle_step",
        "substeps",
        "mean_substep_s",
        "smallest_substep_s",
        "mean_compression_percent",
        "worst_mean_compression_percent",
        "time_scale",
        "lost_particles",
        "bytes_per_particle",
        "bytes",
        "front_m",
    ];
    let pass_columns: Vec<String> = names.iter().map(|name| format!("{name}_ns")).collect();
    columns.extend(pass_columns.iter().map(String::as_str));
    let comment = "Freshet in the benchmark tank: `cargo run --release -p freshet_lab -- bench`; ns per particle-step.";
    let mut csv = Csv::new([comment], &columns);
    for run in runs {
        let account = &run.account;
        let fronts: Vec<String> = run.front.iter().map(|front| format!("{front:.4}")).collect();
        let cells = [
            run.configuration.backend.name().to_owned(),
            run.configuration.threads.map_or_else(String::new, |threads| threads.to_string()),
            run.configuration.particles.to_string(),
            run.repeat.to_string(),
            format!("{:.4}", account.simulated),
            format!("{:.4}", account.wall.as_secs_f64()),
            format!("{:.2}", account.nanoseconds_per_particle_step()),
            account.substeps.to_string(),
            format!("{:.4e}", account.mean_substep()),
            format!("{:.4e}", account.smallest_substep),
            format!("{:.4}", account.compression * 100.0),
            format!("{:.4}", account.worst_mean_compression * 100.0),
            format!("{:.4}", account.time_scale),
            account.lost.to_string(),
            format!("{:.1}", run.bytes_per_particle),
            run.bytes.to_string(),
            fronts.join(" "),
        ];
        csv.row(cells.into_iter().chain(names.iter().map(|name| format!("{:.2}", pass(run, name)))));
    }
    csv
}

fn chart(runs: &[Run]) -> Chart {
    let mut configurations: Vec<Configuration> = Vec::new();
    for run in runs {
        if !configurations.contains(&run.configuration) {
            configurations.push(run.configuration);
        }
    }
    let mut kinds: Vec<(Backend, Option<usize>)> = configurations.iter().map(|c| (c.backend, c.threads)).collect();
    kinds.sort_by_key(|kind| (kind.0 == Backend::Gpu, kind.1));
    kinds.dedup();
    let series = kinds.iter().enumerate().flat_map(|(index, kind)| {
        let of_kind = configurations.iter().filter(move |c| (c.backend, c.threads) == *kind);
        let points: Vec<(f64, f64)> =
            of_kind.map(|c| (f64::from(c.particles) / 1000.0, over(runs, c, nanoseconds).0)).collect();
        let name = match kind {
            (Backend::Gpu, _) => "GPU".to_owned(),
            (Backend::Cpu, Some(1)) => "CPU, 1 thread".to_owned(),
            (Backend::Cpu, threads) => format!("CPU, {} threads", threads.unwrap_or(0)),
        };
        let colour = if kind.0 == Backend::Gpu { Colour::ORANGE } else { Colour::BLUES[index.min(2)] };
        [Mark::Line(2), Mark::Circles(5)].map(|mark| Series {
            name: name.clone(),
            mark,
            colour,
            points: points.clone(),
        })
    });
    let largest = configurations.iter().map(|c| f64::from(c.particles) / 1000.0).fold(0.0, f64::max);
    let panel = Panel {
        title: "tank of 2.0 x 1.5 x 1.0 m, six walls".to_owned(),
        notes: Vec::new(),
        x_label: "thousand particles".to_owned(),
        y_label: "ns per particle-step".to_owned(),
        x_scale: Scale::Linear,
        x: (0.0, largest * 1.1),
        y_scale: Scale::Linear,
        y: (0.0, 1.0),
        series: series.collect(),
    }
    .fitted(0.0);
    Chart { title: "Cost of a step".to_owned(), panels: vec![panel], size: (900, 520) }
}

#[cfg(test)]
mod tests {
    use super::super::tests::run;
    use super::*;

    #[test]
    fn scaling_passes_and_rest_are_told() {
        let runs = [run(1, 64_000, 360), run(2, 64_000, 200)];
        let configurations = [runs[0].configuration, runs[1].configuration];
        let text = cost(&configurations, &runs).to_string();
        assert!(text.contains("1.80 x"), "{text}");
        let text = passes(&configurations, &runs).to_string();
        let cells: Vec<&str> = text.lines().last().unwrap_or_default().split_whitespace().rev().take(2).collect();
        assert_eq!(cells, ["100.0", "100.0"], "half in density, half in the rest:\n{text}");
    }

    #[test]
    fn a_row_a_run() {
        let runs = [run(1, 64_000, 360), run(2, 64_000, 200)];
        let text = csv(&runs).text().to_owned();
        assert_eq!(text.lines().count(), 4, "{text}");
        assert!(text.lines().nth(1).is_some_and(|head| head.ends_with("front_m,density_ns")), "{text}");
        let drawn = chart(&runs);
        assert_eq!(drawn.panels[0].series.len(), 4);
    }
}
