//! Tables of the benchmark.

use super::flatness;
use super::report::Results;
use super::{BenchScene, Configuration, Run, nanoseconds, opening_nanoseconds};
use crate::backend::Backend;
use crate::measure::machine::processor_name;
use crate::output::say;
use crate::reference::published_time::PublishedTime;
use crate::table::Table;

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
    if !results.flat.is_empty() {
        say(flatness::table(&results.flat));
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

/// A number of threads in words.
pub fn plural_threads(threads: usize) -> String {
    if threads == 1 { "1 thread".to_owned() } else { format!("{threads} threads") }
}

/// A number with some decimals; nothing where there is none.
pub fn shown(value: f64, decimals: usize) -> String {
    if value.is_nan() { String::new() } else { format!("{value:.decimals$}") }
}

fn cost(results: &Results) -> Table {
    let mut table = Table::new([
        "cost",
        "ns/(p step)",
        "least",
        "most",
        "first 0.1 s or all",
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
        "remarks",
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
            remarks(results, configuration, run),
        ]);
    }
    table
}

/// Mean compression from which on a particle has so many more neighbours than in water at rest that counts of work should say so.
const COMPRESSED: f64 = 0.02;

/// What has to be known to read the counts of work.
fn remarks(results: &Results, configuration: &Configuration, run: &Run) -> String {
    let compression = results.median(configuration, |run| run.account.compression);
    let card = (!run.hardware.is_processor).then(|| format!("{}: not compared", run.hardware.name));
    let counted = (compression > COMPRESSED)
        .then(|| format!("counted as at rest, but compressed by {:.0} %: more neighbours", compression * 100.0));
    [card, counted].into_iter().flatten().collect::<Vec<_>>().join("; ")
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

/// Names of all passes, in the order they were first seen.
pub fn pass_names<'a>(runs: impl IntoIterator<Item = &'a Run>) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for (name, _) in runs.into_iter().flat_map(|run| &run.account.passes) {
        if !names.contains(name) {
            names.push(name.clone());
        }
    }
    names
}

/// Nanoseconds per particle-step of a pass; not a number for one that the solver has not.
pub fn pass(run: &Run, name: &str) -> f64 {
    run.account.nanoseconds_of_passes().find(|pass| pass.0 == name).map_or(f64::NAN, |pass| pass.1)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{in_scene, results, run};
    use super::*;
    use crate::backend::Hardware;

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
    fn work_of_a_card_is_not_compared_with_the_processor() {
        let mut on_card = run(2, 64_000, 200);
        on_card.configuration = Configuration { backend: Backend::Gpu, threads: None, ..on_card.configuration };
        on_card.hardware = Hardware { name: "a card".to_owned(), is_processor: false };
        assert!(work(&results(&[on_card])).to_string().contains("a card: not compared"));
    }

    #[test]
    fn work_of_a_fluid_that_is_compressed_says_so() {
        let soft = |compression| {
            let mut run = in_scene(BenchScene::Krog, run(2, 65_536, 200));
            run.account.compression = compression;
            work(&results(&[run])).to_string()
        };
        assert!(soft(0.274).contains("counted as at rest, but compressed by 27 %: more neighbours"), "{}", soft(0.274));
        assert!(!soft(0.01).contains("at rest"), "{}", soft(0.01));
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
    }
}
