//! Table, CSV and chart of `convergence`.

use freshet_cpu::Iteration;

use super::{GOAL, Run, Trace};
use crate::chart::{Chart, Colour, Mark, Panel, Scale, Series};
use crate::measure::statistics::spread;
use crate::output::Csv;
use crate::table::Table;

pub(super) fn table(runs: &[Run]) -> Table {
    let goal = format!("until {GOAL} of it");
    let mut table = Table::new(["state", "steps", "start", "first error", &goal, "ms", "us/iteration"]);
    for run in runs {
        for trace in &run.traces {
            let last = trace.points.last();
            let each = last.map_or(f64::NAN, |last| 1e3 * last.milliseconds / f64::from(last.iterations));
            let cell = |value: Option<f64>| value.map_or("not reached".to_owned(), |value| format!("{value:.1}"));
            let (iterations, milliseconds) = trace.until(trace.goal()).unzip();
            table.row([
                run.name.to_owned(),
                trace.kind.steps().to_owned(),
                trace.kind.start().to_owned(),
                format!("{:.2e}", trace.first),
                cell(iterations),
                cell(milliseconds),
                format!("{each:.0}"),
            ]);
        }
    }
    table
}

pub(super) fn csv(runs: &[Run]) -> Csv {
    let comment = "Freshet, what pressure solves leave: `cargo run --release -p freshet_lab -- convergence`. Error: mean over particles of |R| \
                   where there is pressure, of max(R, 0) elsewhere, after a substep's divergence solve; 1 iteration: before it.";
    let columns =
        ["state", "particles", "substep_s", "tolerance", "steps", "start", "iterations", "error", "milliseconds"];
    let mut csv = Csv::new([comment], &columns);
    for run in runs {
        for trace in &run.traces {
            let mut row = |iterations: u32, error: f64, milliseconds: String| {
                csv.row([
                    run.name.to_owned(),
                    run.particles.to_string(),
                    format!("{:.6}", run.substep),
                    format!("{:.3e}", run.tolerance),
                    trace.kind.steps().to_owned(),
                    trace.kind.start().to_owned(),
                    iterations.to_string(),
                    format!("{error:.5e}"),
                    milliseconds,
                ]);
            };
            row(1, trace.first, String::new());
            trace.points.iter().for_each(|p| row(p.iterations, p.error, format!("{:.3}", p.milliseconds)));
        }
    }
    csv
}

/// A row of panels over iterations, one over time.
pub(super) fn chart(runs: &[Run]) -> Chart {
    let by_iterations = |trace: &Trace| {
        let first = (1.0, trace.first);
        std::iter::once(first).chain(trace.points.iter().map(|p| (f64::from(p.iterations), p.error))).collect()
    };
    let by_time = |trace: &Trace| trace.points.iter().map(|p| (p.milliseconds, p.error)).collect();
    let counts = runs.iter().map(|run| panel(run, "iterations", Scale::Doubling, by_iterations));
    let times = runs.iter().map(|run| panel(run, "time of the solve (ms)", Scale::Doubling, by_time));
    Chart {
        title: "What is left after the divergence solve of a substep".to_owned(),
        panels: counts.chain(times).collect(),
        size: (1320, 900),
    }
}

fn panel(run: &Run, x_label: &str, x_scale: Scale, points: impl Fn(&Trace) -> Vec<(f64, f64)>) -> Panel {
    let mut series: Vec<Series> = run
        .traces
        .iter()
        .map(|trace| {
            let colour = if trace.kind.iteration == Iteration::Momentum { Colour::BLUES[2] } else { Colour::ORANGE };
            let mark = if trace.kind.warm { Mark::Line(2) } else { Mark::Dashes(2) };
            Series { name: trace.kind.name(), mark, colour, points: points(trace) }
        })
        .collect();
    let ends = |values: &mut dyn Iterator<Item = f64>| {
        let values: Vec<f64> = values.filter(|value| *value > 0.0 && value.is_finite()).collect();
        spread(&values).unwrap_or((0.1, 1.0))
    };
    let x = ends(&mut series.iter().flat_map(|series| &series.points).map(|point| point.0));
    let (low, high) = ends(&mut series.iter().flat_map(|series| &series.points).map(|point| point.1));
    let points = vec![(x.0, run.tolerance), (x.1, run.tolerance)];
    series.push(Series { name: "asked for by default".to_owned(), mark: Mark::Dashes(1), colour: Colour::INK, points });
    Panel {
        title: format!("{}, {} particles", run.name, run.particles),
        notes: Vec::new(),
        x_label: x_label.to_owned(),
        y_label: "mean |R|".to_owned(),
        x_scale,
        x: (x.0, 2.0 * x.1.max(x.0)),
        y_scale: Scale::Decades,
        y: (10f64.powf(low.log10().floor()), 10f64.powf(high.log10().ceil())),
        series,
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, Point};
    use super::*;

    #[test]
    fn every_point_is_in_the_file_and_in_both_rows_of_the_chart() {
        let point = |iterations: u32| Point { iterations, error: 0.1 / f64::from(iterations), milliseconds: 1.5 };
        let trace = |kind| Trace { kind, first: 0.5, points: vec![point(2), point(3)] };
        let run = Run {
            name: "made up",
            still: false,
            particles: 7,
            substep: 1e-3,
            tolerance: 1e-3,
            traces: Kind::ALL.map(trace).to_vec(),
        };
        let runs = [run];
        assert_eq!(csv(&runs).text().lines().count(), 2 + 4 * 3);
        let chart = chart(&runs);
        let counts: Vec<usize> = chart.panels.iter().map(|panel| panel.series[0].points.len()).collect();
        assert_eq!(counts, [3, 2]);
        assert_eq!(chart.panels[0].y, (0.01, 1.0));
        assert!(table(&runs).to_string().contains("not reached"));
    }
}
