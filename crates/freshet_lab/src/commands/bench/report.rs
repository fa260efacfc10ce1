//! CSV and chart of the benchmark.

use super::flatness::{self, FlatRun};
use super::simulate::OPENING;
use super::tables::{pass, pass_names, plural_threads, shown};
use super::{BenchScene, Configuration, Run, Skipped, nanoseconds, opening_nanoseconds, over, threads_of};
use crate::backend::Backend;
use crate::chart::{self, Chart, Colour, Mark, Panel, Scale, Series};
use crate::error::LabError;
use crate::measure::machine::{Rates, processor_name};
use crate::output::{Csv, Output};
use crate::reference::published_time::PublishedTime;

/// A row a run; nanoseconds over size.
pub const FILES: [&str; 2] = ["bench.csv", "bench.svg"];

/// All that was found.
#[derive(Clone, Debug, Default)]
pub struct Results {
    /// Runs, in the order they were made.
    pub runs: Vec<Run>,
    /// What the budget left out.
    pub skipped: Vec<Skipped>,
    /// Sizes of the tank in turn.
    pub flat: Vec<FlatRun>,
    /// What the machine does, for every number of threads.
    pub rates: Vec<Rates>,
}

impl Results {
    /// Everything that ran, by scene and size.
    pub(super) fn configurations(&self) -> Vec<Configuration> {
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

    pub(super) fn over(&self, configuration: &Configuration, value: impl Fn(&Run) -> f64) -> (f64, f64, f64) {
        over(&self.runs, configuration, value)
    }

    pub(super) fn median(&self, configuration: &Configuration, value: impl Fn(&Run) -> f64) -> f64 {
        self.over(configuration, value).0
    }

    /// What the processor could do in the place of a run; none for one on a graphics card.
    fn rates_of(&self, run: &Run) -> Option<&Rates> {
        let threads = threads_of(&run.configuration);
        self.rates.iter().find(|rates| rates.threads == threads && run.hardware.is_processor)
    }

    /// Arithmetic per second over the machine's, as a fraction; not a number where there is nothing to compare with.
    pub(super) fn of_operations(&self, run: &Run) -> f64 {
        let rate = self.rates_of(run).map_or(f64::NAN, |rates| rates.operations);
        run.operations / nanoseconds(run) * 1e9 / rate
    }

    /// Bytes per second over the machine's, as a fraction; not a number where there is nothing to compare with.
    pub(super) fn of_copies(&self, run: &Run) -> f64 {
        let rate = self.rates_of(run).map_or(f64::NAN, |rates| rates.copied_bytes);
        run.moved_bytes / nanoseconds(run) * 1e9 / rate
    }
}

/// Writes all files anew.
pub fn write(output: &Output, results: &Results) -> Result<(), LabError> {
    output.write(FILES[0], csv(results).text())?;
    chart::draw(output, FILES[1], &chart(results))?;
    if !results.flat.is_empty() {
        output.write(flatness::FILE, flatness::csv(&results.flat).text())?;
    }
    Ok(())
}

/// Explains the columns of the CSV that do not explain themselves.
const COLUMNS: &str = "\
Freshet's speed: `cargo run --release -p freshet_lab -- bench`; a row a run. Times are of the stepping alone; nothing is drawn.
particles: asked for; scene_particles: what the scene has of them. substeps: how many were timed, over simulated_s.
ns_per_particle_step: wall_s over substeps and particles; opening_ns: the same over the first 0.1 s or less. Sizes ran one after
the other, minutes apart: what a step costs over sizes is in bench_flat.csv.
flop_per_particle_step, bytes_per_particle_step: counted from the schedule, with the neighbours of water at rest: too few where
mean_compression_percent is large, as in Krog's soft fluid, by about as many percent.
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
        title: title(results, scene),
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

/// Head line of a scene's panel: that the tank's sizes are compared by the first 0.1 s, which of them ran for less, and the least.
fn title(results: &Results, scene: BenchScene) -> String {
    let title = scene.title();
    let of_scene = results.runs.iter().filter(|run| run.configuration.scene == scene);
    // Whole ticks, so that half of one is none.
    let short = of_scene.filter(|run| run.account.simulated < OPENING - 0.5 * scene.tick());
    let size_and_time = short.map(|run| (run.configuration.particles, run.account.simulated));
    let least = size_and_time.reduce(|a, b| (a.0.min(b.0), a.1.min(b.1)));
    match (scene, least) {
        (BenchScene::Tank, Some((particles, seconds))) => {
            format!("{title} (from {particles} on {seconds:.3} s)")
        }
        _ => title.to_owned(),
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
    use super::super::tests::{in_scene, results, run};
    use super::*;
    use crate::backend::Hardware;

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
    fn published_times_are_drawn_beside_ours() {
        let krog = in_scene(BenchScene::Krog, run(2, 65_536, 200));
        let pirovano = in_scene(BenchScene::Pirovano, run(2, 4_096, 200));
        let results = results(&[run(2, 8_000, 200), pirovano, krog]);
        let drawn = chart(&results);
        assert_eq!(drawn.panels.len(), 3);
        assert!(drawn.panels[1].y.0 < 200.0 && drawn.panels[1].y.1 > 58_838.0, "{:?}", drawn.panels[1].y);
        let names: Vec<&str> = drawn.panels[2].series.iter().map(|series| series.name.as_str()).collect();
        assert!(names.contains(&"GeForce GTX 260"), "{names:?}");
    }

    #[test]
    fn the_chart_says_where_less_than_a_tenth_of_a_second_ran() {
        let title = |runs: &[Run]| chart(&results(runs)).panels[0].title.clone();
        let of = |particles, simulated| {
            let mut run = run(2, particles, 200);
            run.account.simulated = simulated;
            run
        };
        assert_eq!(title(&[of(64_000, 0.5), of(125_000, 0.1)]), "tank, six walls, first 0.1 s");
        let with_large = title(&[of(64_000, 0.5), of(262_144, 0.05), of(512_000, 1.0 / 30.0)]);
        assert_eq!(with_large, "tank, six walls, first 0.1 s (from 262144 on 0.033 s)");
    }
}
