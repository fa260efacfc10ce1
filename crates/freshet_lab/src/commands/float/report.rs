//! Table, CSV and chart of the floating ball.

use super::{ARCHIMEDES, DRAFT_BOUND, Run};
use crate::backend::Backend;
use crate::chart::{self, Chart, Colour, Mark, Panel, Scale, Series};
use crate::error::LabError;
use crate::measure::curve::Curve;
use crate::measure::statistics::{mean, order};
use crate::method::Method;
use crate::output::{Csv, Output};
use crate::table::Table;

/// Files of the command.
pub fn files(method: Method) -> [String; 2] {
    let suffix = method.suffix();
    [format!("float{suffix}.csv"), format!("float{suffix}.svg")]
}

/// Writes the files for all runs so far.
pub fn write(output: &Output, method: Method, runs: &[Run]) -> Result<(), LabError> {
    let [table, drawing] = files(method);
    output.write(&table, csv(method, runs).text())?;
    chart::draw(output, &drawing, &chart(runs))?;
    Ok(())
}

/// The numbers from half time on, and the observed order of convergence of the draft by volume.
pub fn table(runs: &[Run]) -> Table {
    let mut table = Table::new([
        "ball",
        "draft by volume",
        "by surface",
        "order",
        "heave mm",
        "growth",
        "ledger",
        "momentum",
        "drift mm",
        "ns/(p step)",
        "wall s",
    ]);
    // All runs are as long.
    for run in runs {
        let late = |curve: &Curve| mean(curve.values_from(run.settled())).unwrap_or(f64::NAN);
        let error = |run: &Run| (f64::from(run.case.pool.diameter), (late(&run.draft) - ARCHIMEDES).abs());
        let same = |other: &&Run| (other.case.backend, other.case.latency) == (run.case.backend, run.case.latency);
        let coarser = runs.iter().filter(same).filter(|other| other.case.pool.diameter < run.case.pool.diameter);
        let coarser = coarser.max_by_key(|other| other.case.pool.diameter);
        let order = coarser.and_then(|coarser| order(error(coarser), error(run)));
        let (sway, wall) = (run.sway(), run.wall.as_secs_f64());
        table.row([
            run.case.to_string(),
            format!("{:.4}", late(&run.draft)),
            format!("{:.4}", late(&run.draft_by_surface)),
            order.map_or_else(String::new, |order| format!("{order:.2}")),
            format!("{:.2}", sway.largest * 1000.0),
            format!("{:.2}", sway.growth),
            format!("{:.1e}", run.ledger),
            format!("{:.1e}", run.momentum),
            format!("{:.1}", run.drift * 1000.0),
            format!("{:.0}", wall * 1e9 / run.particle_steps),
            format!("{wall:.1}"),
        ]);
    }
    table
}

fn csv(method: Method, runs: &[Run]) -> Csv {
    let option = method.option();
    let comment = format!(
        "Freshet, floating ball: `cargo run --release -p freshet_lab -- float{option}`. Drafts over the diameter; impulse of the fluid \
         in the tick that ends at the time."
    );
    let columns = [
        "diameter_in_spacings",
        "backend",
        "latency",
        "time_s",
        "height_m",
        "draft_by_volume",
        "draft_by_surface",
        "velocity_m_s",
        "impulse_n_s",
    ];
    let mut csv = Csv::new([comment.as_str()], &columns);
    for run in runs {
        let case = [run.case.pool.diameter.to_string(), run.case.backend.to_string(), run.case.latency.to_string()];
        let curves = [&run.height, &run.draft, &run.draft_by_surface, &run.velocity, &run.impulse];
        for &(time, _) in run.height.samples() {
            let cells = curves.map(|curve| format!("{:.6}", curve.at(time).unwrap_or(f64::NAN)));
            csv.row(case.clone().into_iter().chain([format!("{time:.4}")]).chain(cells));
        }
    }
    csv
}

fn chart(runs: &[Run]) -> Chart {
    let seconds = runs.iter().map(|run| run.case.seconds).fold(0.0, f64::max);
    let mut sizes: Vec<u32> = runs.iter().map(|run| run.case.pool.diameter).collect();
    sizes.dedup();
    let panel = |&diameter: &u32| {
        let of_size = runs.iter().filter(|run| run.case.pool.diameter == diameter);
        let mut series: Vec<Series> = of_size
            .enumerate()
            .map(|(index, run)| Series {
                name: format!("{}, {}", run.case.backend, run.case.latency),
                mark: Mark::Line(2),
                colour: if run.case.backend == Backend::Gpu { Colour::ORANGE } else { Colour::BLUES[index % 3] },
                points: run.draft.samples().to_vec(),
            })
            .collect();
        let level = |name: &str, colour, value: f64| Series {
            name: name.to_owned(),
            mark: Mark::Dashes(2),
            colour,
            points: vec![(0.0, value), (seconds, value)],
        };
        series.push(level("Archimedes", Colour::INK, ARCHIMEDES));
        series.extend([-1.0, 1.0].map(|side| level("bound", Colour::RED, ARCHIMEDES + side * DRAFT_BOUND)));
        Panel {
            title: format!("Ball of {diameter} spacings, density 500"),
            notes: Vec::new(),
            x_label: "time (s)".to_owned(),
            y_label: "draft over diameter".to_owned(),
            x_scale: Scale::Linear,
            x: (0.0, seconds),
            y_scale: Scale::Linear,
            y: (0.3, 0.7),
            series,
        }
    };
    Chart { title: "Floating ball".to_owned(), panels: sizes.iter().map(panel).collect(), size: (1320, 480) }
}
