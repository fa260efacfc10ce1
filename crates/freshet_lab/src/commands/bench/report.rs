//! Tables, CSV and chart of the benchmark.

use super::{BenchScene, Configuration, Run, Skipped, nanoseconds, opening_nanoseconds, over, threads_of};
use crate::backend::Backend;
use crate::chart::{self, Chart, Colour, Mark, Panel, Scale, Series};
use crate::error::LabError;
use crate::measure::machine::{Rates, processor_name};
use crate::output::{Csv, Output, say};
use crate::reference::published_time::PublishedTime;
use crate::table::Table;

/// A row a run; nanoseconds over size.
pub const FILES: [&str; 2] = ["bench.csv", "bench.svg"];

/// All that was found.
#[derive(Clone, Debug, Default)]
pub struct Results {
    /// Runs, in the order they were made.
    pub runs: Vec<Run>,
    /// What the budget left out.
    pub skipped: Vec<Skipped>,
    /// What the machine does, for every number of threads.
    pub rates: Vec<Rates>,
}

impl Results {
    /// Everything that ran, by scene and size.
    fn configurations(&self) -> Vec<Configuration> {
        let mut configurations: Vec<Configuration> = Vec::new();
        for run in &self.runs {
            if !configurations.contains(&run.configuration) {
                configurations.push(run.configuration);
            }
        }
        let place = |scene| BenchScene::ALL.iter().position(|&other| other == scene);
        configurations.sort_by_key(|configuration| (place(configuration.scene), configuration.particles));
        configurations
    }

    fn over(&self, configuration: &Configuration, value: impl Fn(&Run) -> f64) -> (f64, f64, f64) {
        over(&self.runs, configuration, value)
    }

    fn median(&self, configuration: &Configuration, value: impl Fn(&Run) -> f64) -> f64 {
        self.over(configuration, value).0
    }

    /// What the processor could do in the place of a run; none for one on a graphics card.
    fn rates_of(&self, run: &Run) -> Option<&Rates> {
        let threads = threads_of(&run.configuration);
        self.rates.iter().find(|rates| rates.threads == threads && run.hardware.is_processor)
    }

    /// Arithmetic per second over the machine's, as a fraction; not a number where there is nothing to compare with.
    fn of_operations(&self, run: &Run) -> f64 {
        let rate = self.rates_of(run).map_or(f64::NAN, |rates| rates.operations);
        run.operations / nanoseconds(run) * 1e9 / rate
    }

    /// Bytes per second over the machine's, as a fraction; not a number where there is nothing to compare with.
    fn of_copies(&self, run: &Run) -> f64 {
        let rate = self.rates_of(run).map_or(f64::NAN, |rates| rates.copied_bytes);
        run.moved_bytes / nanoseconds(run) * 1e9 / rate
    }
}

/// Writes all files anew.
pub fn write(output: &Output, results: &Results) -> Result<(), LabError> {
    output.write(FILES[0], csv(results).text())?;
    chart::draw(output, FILES[1], &chart(results))?;
    Ok(())
}

/// Names of all passes, in the order they were first seen.
fn pass_names<'a>(runs: impl IntoIterator<Item = &'a Run>) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for (name, _) in runs.into_iter().flat_map(|run| &run.account.passes) {
        if !names.contains(name) {
            names.push(name.clone());
        }
    }
    names
}

fn pass(run: &Run, name: &str) -> f64 {
    run.account.nanoseconds_of_passes().find(|pass| pass.0 == name).map_or(f64::NAN, |pass| pass.1)
}

/// Prints the tables: machine, cost, passes, work, flow, what others published, what was left out.
pub fn print(results: &Results) {
    say(machine(results));
    say(cost(results));
    for backend in [Backend::Cpu, Backend::Gpu] {
        if let Some(table) = passes(results, backend) {
            say(table);
        }
    }
    say(work(results));
    say(flow(results));
    if results.configurations().iter().any(|configuration| !configuration.scene.published().is_empty()) {
        say(published(results));
    }
    for skipped in &results.skipped {
        say(format_args!("skipped: {skipped}"));
    }
    say("nothing was drawn: these are times of the simulation alone");
}

fn machine(results: &Results) -> Table {
    let mut table = Table::new([format!("machine: {}", processor_name()), "copies GB/s".into(), "Gflop/s".into()]);
    for rates in &results.rates {
        table.row([
            plural_threads(rates.threads),
            format!("{:.1}", rates.copied_bytes / 1e9),
            format!("{:.1}", rates.operations / 1e9),
        ]);
    }
    table
}

fn plural_threads(threads: usize) -> String {
    if threads == 1 { "1 thread".to_owned() } else { format!("{threads} threads") }
}

/// A number with some decimals; nothing where there is none.
fn shown(value: f64, decimals: usize) -> String {
    if value.is_nan() { String::new() } else { format!("{value:.decimals$}") }
}

fn cost(results: &Results) -> Table {
    let mut table = Table::new([
        "cost",
        "ns/(p step)",
        "least",
        "most",
        "first 0.1 s",
        "M p steps/s",
        "s/s",
        "of 1 thread",
        "B/particle",
        "MiB in all",
    ]);
    for configuration in &results.configurations() {
        let (middle, least, most) = results.over(configuration, nanoseconds);
        let single = Configuration { threads: Some(1), ..*configuration };
        let scaling = results.median(&single, nanoseconds) / middle;
        table.row([
            configuration.to_string(),
            shown(middle, 1),
            shown(least, 1),
            shown(most, 1),
            shown(results.median(configuration, opening_nanoseconds), 1),
            shown(1e3 / middle, 2),
            shown(results.median(configuration, |run| run.account.wall_per_simulated()), 2),
            if scaling.is_nan() { String::new() } else { format!("{scaling:.2} x") },
            shown(results.median(configuration, |run| run.bytes_per_particle), 0),
            shown(results.median(configuration, |run| run.bytes as f64) / f64::from(1 << 20), 2),
        ]);
    }
    table
}

/// Of one backend, as their passes have different names; none if it did not run.
fn passes(results: &Results, backend: Backend) -> Option<Table> {
    let configurations = results.configurations();
    let mut of_backend = configurations.iter().filter(|configuration| configuration.backend == backend).peekable();
    of_backend.peek()?;
    let names = pass_names(results.runs.iter().filter(|run| run.configuration.backend == backend));
    let head = ["passes, ns/(p step)".to_owned()].into_iter().chain(names.iter().cloned());
    let mut table = Table::new(head.chain(["the rest".to_owned()]));
    for configuration in of_backend {
        let times: Vec<f64> = names.iter().map(|name| results.median(configuration, |run| pass(run, name))).collect();
        let known: f64 = times.iter().filter(|time| !time.is_nan()).sum();
        let rest = results.median(configuration, nanoseconds) - known;
        let cells = times.into_iter().chain([rest]).map(|time| shown(time, 1));
        table.row([configuration.to_string()].into_iter().chain(cells));
    }
    Some(table)
}

fn work(results: &Results) -> Table {
    let mut table = Table::new([
        "work, counted",
        "flop/(p step)",
        "Gflop/s",
        "% of multiply-adds",
        "B/(p step)",
        "GB/s",
        "% of copies",
        "on",
    ]);
    for configuration in &results.configurations() {
        let Some(run) = results.runs.iter().find(|run| run.configuration == *configuration) else { continue };
        let time = results.median(configuration, nanoseconds);
        table.row([
            configuration.to_string(),
            shown(run.operations, 0),
            shown(run.operations / time, 2),
            shown(results.median(configuration, |run| results.of_operations(run)) * 100.0, 1),
            shown(run.moved_bytes, 0),
            shown(run.moved_bytes / time, 2),
            shown(results.median(configuration, |run| results.of_copies(run)) * 100.0, 1),
            if run.hardware.is_processor { String::new() } else { format!("{}: not compared", run.hardware.name) },
        ]);
    }
    table
}

fn flow(results: &Results) -> Table {
    let mut table = Table::new([
        "flow",
        "particles",
        "s",
        "steps",
        "mean dt ms",
        "least dt ms",
        "compr. %",
        "worst mean %",
        "time scale",
        "front at 0.1, 0.2... s (m)",
    ]);
    for configuration in &results.configurations() {
        let Some(run) = results.runs.iter().find(|run| run.configuration == *configuration) else { continue };
        let fronts: Vec<String> = run.front.iter().map(|front| format!("{front:.3}")).collect();
        table.row([
            configuration.to_string(),
            run.particles.to_string(),
            format!("{:.3}", run.account.simulated),
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

/// Each size of a thesis: its figures, then ours.
fn published(results: &Results) -> Table {
    let mut table = Table::new(["a step elsewhere and here", "particles", "ms", "ns/(p step)", "from"]);
    let configurations = results.configurations();
    for scene in BenchScene::ALL {
        let ours = configurations.iter().filter(|configuration| configuration.scene == scene);
        let mut sizes: Vec<u32> = ours.map(|configuration| configuration.particles).collect();
        sizes.dedup();
        for size in sizes {
            let times: Vec<&PublishedTime> = scene.published().iter().filter(|time| time.particles == size).collect();
            for time in &times {
                table.row([
                    format!("{}: {}", scene.name(), time.hardware),
                    size.to_string(),
                    format!("{:.2}", time.milliseconds),
                    format!("{:.1}", time.nanoseconds()),
                    time.source.to_owned(),
                ]);
            }
            if times.is_empty() && !scene.published().is_empty() {
                table.row([format!("{}: no figure in numbers", scene.name()), size.to_string()]);
            }
            for run in results.runs.iter().filter(|run| {
                run.repeat == 1 && run.configuration.scene == scene && run.configuration.particles == size
            }) {
                if scene.published().is_empty() {
                    continue;
                }
                let time = results.median(&run.configuration, nanoseconds);
                table.row([
                    format!("{}: Freshet, {}", scene.name(), run.configuration.solver()),
                    run.particles.to_string(),
                    format!("{:.2}", time * run.particles as f64 / 1e6),
                    format!("{time:.1}"),
                    run.hardware.name.clone(),
                ]);
            }
        }
    }
    table
}

/// Explains the columns of the CSV that do not explain themselves.
const COLUMNS: &str = "\
Freshet's speed: `cargo run --release -p freshet_lab -- bench`; a row a run. Times are of the stepping alone; nothing is drawn.
particles: asked for; scene_particles: what the scene has of them. substeps: how many were timed, over simulated_s.
ns_per_particle_step: wall_s over substeps and particles; opening_ns: the same over the first 0.1 s or less, by which sizes are
compared.
flop_per_particle_step, bytes_per_particle_step: counted from the schedule, with the neighbours of water at rest.
of_multiply_adds, of_copies: these per second, as fractions of what the machine was measured to do on as many threads;
empty for a GPU that is no program on the processor. bytes_per_particle: memory, with the grid; bytes: of all buffers.
PASS_ns: per particle-step, empty where a solver has no such pass.";

fn comments(results: &Results) -> Vec<String> {
    let mut lines = vec![COLUMNS.to_owned(), format!("machine: {}", processor_name())];
    lines.extend(results.rates.iter().map(|rates| {
        let (copied, operations) = (rates.copied_bytes / 1e9, rates.operations / 1e9);
        format!("machine, {}: copies {copied:.2} GB/s, {operations:.2} Gflop/s", plural_threads(rates.threads))
    }));
    for scene in BenchScene::ALL {
        lines.extend(scene.published().iter().map(|time| {
            format!(
                "published: {}, {} particles, {}: {:.1} ns per particle-step ({})",
                scene.name(),
                time.particles,
                time.hardware,
                time.nanoseconds(),
                time.source
            )
        }));
    }
    lines.extend(results.skipped.iter().map(|skipped| format!("skipped: {skipped}")));
    lines
}

fn csv(results: &Results) -> Csv {
    let names = pass_names(&results.runs);
    let mut columns = vec![
        "scene",
        "backend",
        "threads",
        "particles",
        "repeat",
        "hardware",
        "scene_particles",
        "simulated_s",
        "wall_s",
        "ns_per_particle_step",
        "opening_ns",
        "particle_steps_per_s",
        "substeps",
        "mean_substep_s",
        "smallest_substep_s",
        "mean_compression_percent",
        "worst_mean_compression_percent",
        "time_scale",
        "lost_particles",
        "bytes_per_particle",
        "bytes",
        "flop_per_particle_step",
        "bytes_per_particle_step",
        "of_multiply_adds",
        "of_copies",
        "front_m",
    ];
    let pass_columns: Vec<String> = names.iter().map(|name| format!("{name}_ns")).collect();
    columns.extend(pass_columns.iter().map(String::as_str));
    let comments = comments(results);
    let mut csv = Csv::new(comments.iter().map(String::as_str), &columns);
    for run in &results.runs {
        let (configuration, account) = (&run.configuration, &run.account);
        let fronts: Vec<String> = run.front.iter().map(|front| format!("{front:.4}")).collect();
        let cells = [
            configuration.scene.name().to_owned(),
            configuration.backend.name().to_owned(),
            configuration.threads.map_or_else(String::new, |threads| threads.to_string()),
            configuration.particles.to_string(),
            run.repeat.to_string(),
            run.hardware.name.clone(),
            run.particles.to_string(),
            format!("{:.4}", account.simulated),
            format!("{:.4}", account.wall.as_secs_f64()),
            shown(nanoseconds(run), 2),
            shown(run.opening_nanoseconds, 2),
            format!("{:.4e}", 1e9 / nanoseconds(run)),
            account.substeps.to_string(),
            format!("{:.4e}", account.mean_substep()),
            format!("{:.4e}", account.smallest_substep),
            format!("{:.4}", account.compression * 100.0),
            format!("{:.4}", account.worst_mean_compression * 100.0),
            format!("{:.4}", account.time_scale),
            account.lost.to_string(),
            format!("{:.1}", run.bytes_per_particle),
            run.bytes.to_string(),
            format!("{:.0}", run.operations),
            format!("{:.0}", run.moved_bytes),
            shown(results.of_operations(run), 4),
            shown(results.of_copies(run), 4),
            fronts.join(" "),
        ];
        csv.row(cells.into_iter().chain(names.iter().map(|name| shown(pass(run, name), 2))));
    }
    csv
}

/// Looks of hardware elsewhere, in the order of its scene.
const ELSEWHERE: [Colour; 2] = [Colour::INK, Colour(0x8a, 0x90, 0x98)];

/// A panel for each scene that ran: one line for each solver, and what others published.
fn chart(results: &Results) -> Chart {
    let configurations = results.configurations();
    let scenes = BenchScene::ALL.into_iter().filter(|&scene| configurations.iter().any(|c| c.scene == scene));
    let panels: Vec<Panel> = scenes.map(|scene| panel(results, &configurations, scene)).collect();
    let width = if panels.len() > 1 { 480 * panels.len() as u32 } else { 900 };
    Chart { title: "Cost of a step".to_owned(), panels, size: (width, 520) }
}

fn panel(results: &Results, configurations: &[Configuration], scene: BenchScene) -> Panel {
    let of_scene: Vec<&Configuration> = configurations.iter().filter(|c| c.scene == scene).collect();
    let mut solvers: Vec<(Backend, Option<usize>)> = of_scene.iter().map(|c| (c.backend, c.threads)).collect();
    solvers.sort_by_key(|solver| (solver.0 == Backend::Gpu, solver.1));
    solvers.dedup();
    let mut series = Vec::new();
    for (index, &(backend, threads)) in solvers.iter().enumerate() {
        let own = of_scene.iter().filter(|c| (c.backend, c.threads) == (backend, threads));
        let points: Vec<(f64, f64)> = own.map(|c| (f64::from(c.particles), compared(results, c))).collect();
        let colour = if backend == Backend::Gpu { Colour::ORANGE } else { Colour::BLUES[(index + 1).min(2)] };
        let name = Configuration { scene, backend, threads, particles: 0 }.solver();
        series.extend([Mark::Line(2), Mark::Circles(5)].map(|mark| Series {
            name: name.clone(),
            mark,
            colour,
            points: points.clone(),
        }));
    }
    let ran = |time: &&PublishedTime| of_scene.iter().any(|c| c.particles == time.particles);
    let mut hardware: Vec<&str> = scene.published().iter().filter(ran).map(|time| time.hardware).collect();
    hardware.dedup();
    for (name, colour) in hardware.into_iter().zip(ELSEWHERE.into_iter().cycle()) {
        let own = scene.published().iter().filter(ran).filter(|time| time.hardware == name);
        let points: Vec<(f64, f64)> = own.map(|time| (f64::from(time.particles), time.nanoseconds())).collect();
        series.extend([Mark::Dashes(2), Mark::Circles(3)].map(|mark| Series {
            name: name.to_owned(),
            mark,
            colour,
            points: points.clone(),
        }));
    }
    let ends = |values: &mut dyn Iterator<Item = f64>| {
        let (least, most) = values.fold((f64::INFINITY, 0.0), |(least, most), v| (v.min(least), v.max(most)));
        (least / 1.4, most * 1.4)
    };
    let points = || series.iter().flat_map(|series| &series.points);
    let (x, y) = (ends(&mut points().map(|point| point.0)), ends(&mut points().map(|point| point.1)));
    Panel {
        title: scene.title().to_owned(),
        notes: Vec::new(),
        x_label: "particles".to_owned(),
        y_label: "ns per particle-step".to_owned(),
        x_scale: Scale::Doubling,
        x,
        y_scale: Scale::Doubling,
        y,
        series,
    }
}

/// What sizes of a scene are compared by: in the tank the first 0.1 s, as only the size of the aims runs longer.
fn compared(results: &Results, configuration: &Configuration) -> f64 {
    match configuration.scene {
        BenchScene::Tank => results.median(configuration, opening_nanoseconds),
        BenchScene::Pirovano | BenchScene::Krog => results.median(configuration, nanoseconds),
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::run;
    use super::*;
    use crate::backend::Hardware;

    fn results(runs: &[Run]) -> Results {
        let rates = [1, 2].map(|threads| Rates { threads, copied_bytes: 10e9, operations: 100e9 });
        Results { runs: runs.to_vec(), skipped: Vec::new(), rates: rates.to_vec() }
    }

    fn in_scene(scene: BenchScene, run: Run) -> Run {
        Run { configuration: Configuration { scene, ..run.configuration }, ..run }
    }

    #[test]
    fn scaling_passes_and_rest_are_told() {
        let results = results(&[run(1, 64_000, 360), run(2, 64_000, 200)]);
        let text = cost(&results).to_string();
        assert!(text.contains("1.80 x"), "{text}");
        let text = passes(&results, Backend::Cpu).map_or_else(String::new, |table| table.to_string());
        let cells: Vec<&str> = text.lines().last().unwrap_or_default().split_whitespace().rev().take(2).collect();
        assert_eq!(cells, ["100.0", "100.0"], "half in density, half in the rest:\n{text}");
        assert!(passes(&results, Backend::Gpu).is_none());
    }

    #[test]
    fn work_is_a_fraction_of_the_machine() {
        let on_processor = run(2, 64_000, 200);
        let mut on_card = on_processor.clone();
        on_card.configuration = Configuration { backend: Backend::Gpu, threads: None, ..on_card.configuration };
        on_card.hardware = Hardware { name: "a card".to_owned(), is_processor: false };
        let results = results(&[on_processor, on_card]);
        // 2,000 operations in 200 ns are 10 of 100 Gflop/s, 200 bytes 1 of 10 GB/s.
        assert!((results.of_operations(&results.runs[0]) - 0.1).abs() < 1e-9);
        assert!((results.of_copies(&results.runs[0]) - 0.1).abs() < 1e-9);
        assert!(results.of_operations(&results.runs[1]).is_nan(), "nothing is known of a card");
        assert!(work(&results).to_string().contains("a card: not compared"));
        assert!(csv(&results).text().contains(",0.1000,0.1000,"), "{}", csv(&results).text());
    }

    #[test]
    fn a_row_a_run_under_what_explains_it() {
        let mut results = results(&[run(1, 64_000, 360), run(2, 64_000, 200)]);
        let configuration = results.runs[0].configuration;
        results.skipped.push(Skipped { configuration, estimate: 300.0, left: 20.0 });
        let text = csv(&results).text().to_owned();
        let rows: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).collect();
        assert_eq!(rows.len(), 3, "{text}");
        assert!(rows[0].ends_with("front_m,density_ns"), "{text}");
        assert!(rows.iter().all(|row| row.split(',').count() == rows[0].split(',').count()), "{text}");
        for line in
            ["# skipped: tank, 64000 particles, cpu, 1 thread: about 300.0 s", "# machine, 2 threads: copies 10.00"]
        {
            assert!(text.contains(line), "{line} is missing in\n{text}");
        }
        assert_eq!(chart(&results).panels[0].series.len(), 4);
    }

    #[test]
    fn published_times_stand_beside_ours() {
        let krog = in_scene(BenchScene::Krog, run(2, 65_536, 200));
        let coarse = in_scene(BenchScene::Krog, run(2, 32_768, 200));
        let pirovano = in_scene(BenchScene::Pirovano, run(2, 4_096, 200));
        let results = results(&[run(2, 8_000, 200), pirovano, coarse, krog]);
        let text = published(&results).to_string();
        for words in ["GeForce GTX 470", "70.8", "Phenom 8650", "58837.9", "krog: no figure in numbers", "a processor"]
        {
            assert!(text.contains(words), "{words} is missing in\n{text}");
        }
        assert!(!text.contains("tank"), "nothing is published of it");
        let drawn = chart(&results);
        assert_eq!(drawn.panels.len(), 3);
        assert!(drawn.panels[1].y.0 < 200.0 && drawn.panels[1].y.1 > 58_838.0, "{:?}", drawn.panels[1].y);
        let names: Vec<&str> = drawn.panels[2].series.iter().map(|series| series.name.as_str()).collect();
        assert!(names.contains(&"GeForce GTX 260"), "{names:?}");
    }
}
