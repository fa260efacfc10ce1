//! Table, CSV and chart of the dam breaks.

use crate::backend::Backend;
use crate::chart::{self, Chart, Colour, Mark, Panel, Scale, Series};
use crate::error::LabError;
use crate::method::Method;
use crate::output::{Csv, Output};
use crate::reference::dam_break::DamBreakExperiment;
use crate::table::Table;

use super::Run;

/// Errors and cost; all curves; the chart.
pub fn files(method: Method) -> [String; 3] {
    let suffix = method.suffix();
    [format!("dam_break{suffix}.csv"), format!("dam_break{suffix}_fronts.csv"), format!("dam_break{suffix}.svg")]
}

/// Written on top of the CSV files.
const COMMENT: &str = "Freshet, dam break: `cargo run --release -p freshet_lab -- dam-break --out docs/charts`.\n\
    T = n t sqrt(g/a), Z = front/a, n^2 = height/width; front = 99.5th percentile of x plus d/2; slab 10 d deep.\n\
    RMS of (Z - Z_measured)/Z_measured over the measured points with 1 < T < 3.3 (Lobovsky 1.57). The simulation at T - shift is\n\
    compared with the experiment at T. Times are of the machine that ran it.";

/// Writes all files anew.
pub fn write(output: &Output, method: Method, runs: &[Run]) -> Result<(), LabError> {
    let [table, curves, drawing] = files(method);
    output.write(&table, summary(runs).text())?;
    output.write(&curves, fronts(runs).text())?;
    chart::draw(output, &drawing, &chart(method, runs))?;
    Ok(())
}

fn percent(share: f64) -> String {
    format!("{:.2}", share * 100.0)
}

/// The printed table.
pub fn table(runs: &[Run]) -> Table {
    let mut table = Table::new([
        "case",
        "backend",
        "a/d",
        "particles",
        "RMS %",
        "bias %",
        "shifted %",
        "shift",
        "s/s",
        "ns/(p step)",
        "steps",
        "time scale",
        "compr. %",
        "worst mean %",
    ]);
    for run in runs {
        let (error, account) = (&run.error, &run.account);
        table.row([
            run.experiment.name.to_owned(),
            run.backend.name().to_owned(),
            run.resolution.to_string(),
            run.particles.to_string(),
            percent(error.rms),
            format!("{:+.2}", error.bias * 100.0),
            percent(error.rms_shifted),
            format!("{:+.3}", error.shift),
            format!("{:.2}", account.wall_per_simulated()),
            format!("{:.0}", account.nanoseconds_per_particle_step()),
            account.substeps.to_string(),
            format!("{:.3}", account.time_scale),
            percent(account.compression),
            percent(account.worst_mean_compression),
        ]);
    }
    table
}

fn summary(runs: &[Run]) -> Csv {
    let sources = DamBreakExperiment::ALL.map(|experiment| format!("{}: {}", experiment.name, experiment.source));
    let comments = std::iter::once(COMMENT).chain(sources.iter().map(String::as_str));
    let columns = [
        "case",
        "backend",
        "a_over_d",
        "particles",
        "rms_percent",
        "bias_percent",
        "rms_shifted_percent",
        "shift",
        "points",
        "simulated_s",
        "wall_s_per_simulated_s",
        "ns_per_particle_step",
        "substeps",
        "mean_substep_s",
        "time_scale",
        "mean_compression_percent",
        "worst_mean_compression_percent",
        "lost_particles",
        "escaped_particles",
    ];
    let mut csv = Csv::new(comments, &columns);
    for run in runs {
        let (error, account) = (&run.error, &run.account);
        csv.row([
            run.experiment.name.to_owned(),
            run.backend.name().to_owned(),
            run.resolution.to_string(),
            run.particles.to_string(),
            percent(error.rms),
            percent(error.bias),
            percent(error.rms_shifted),
            format!("{:.3}", error.shift),
            error.points.to_string(),
            format!("{:.4}", account.simulated),
            format!("{:.2}", account.wall_per_simulated()),
            format!("{:.0}", account.nanoseconds_per_particle_step()),
            account.substeps.to_string(),
            format!("{:.3e}", account.mean_substep()),
            format!("{:.3}", account.time_scale),
            percent(account.compression),
            percent(account.worst_mean_compression),
            account.lost.to_string(),
            run.escaped.to_string(),
        ]);
    }
    csv
}

fn fronts(runs: &[Run]) -> Csv {
    let mut csv = Csv::new([COMMENT], &["case", "source", "a_over_d", "T", "Z"]);
    for experiment in DamBreakExperiment::ALL {
        for &(time, front) in experiment.points {
            csv.row([experiment.name, "experiment", "", &format!("{time:.4}"), &format!("{front:.4}")]);
        }
    }
    for run in runs {
        let resolution = run.resolution.to_string();
        for &(time, front) in run.front.samples() {
            let (time, front) = (format!("{time:.4}"), format!("{front:.4}"));
            csv.row([run.experiment.name, run.backend.name(), &resolution, &time, &front]);
        }
    }
    csv
}

fn chart(method: Method, runs: &[Run]) -> Chart {
    Chart {
        title: format!("Dam break, {}: front of the water against experiments", method.name()),
        panels: DamBreakExperiment::ALL.map(|experiment| panel(experiment, runs)).into(),
        size: (1320, 520),
    }
}

fn panel(experiment: &'static DamBreakExperiment, runs: &[Run]) -> Panel {
    let mut resolutions: Vec<u32> = runs.iter().map(|run| run.resolution).collect();
    resolutions.sort_unstable();
    resolutions.dedup();
    // The finest is the darkest.
    let colour = |resolution: u32| {
        let finer = resolutions.iter().filter(|&&other| other > resolution).count();
        Colour::BLUES[(Colour::BLUES.len() - 1).saturating_sub(finer)]
    };
    let of_case = || runs.iter().filter(|run| run.experiment == experiment);
    let mut series: Vec<Series> = of_case()
        .map(|run| Series {
            name: format!("{} at a/d = {}", run.backend.name().to_uppercase(), run.resolution),
            mark: if run.backend == Backend::Gpu { Mark::Dashes(3) } else { Mark::Line(3) },
            colour: if run.backend == Backend::Gpu { Colour::ORANGE } else { colour(run.resolution) },
            points: run.front.samples().to_vec(),
        })
        .collect();
    series.push(Series {
        name: "experiment".to_owned(),
        mark: Mark::Circles(5),
        colour: Colour::INK,
        points: experiment.points.to_vec(),
    });
    let finest = of_case().filter(|run| run.backend == Backend::Cpu).max_by_key(|run| run.resolution);
    let notes = finest.map_or_else(Vec::new, |run| {
        vec![
            format!("RMS error at a/d = {}: {:.1} %", run.resolution, run.error.rms * 100.0),
            format!("clock shifted by {:+.2}: {:.1} %", run.error.shift, run.error.rms_shifted * 100.0),
        ]
    });
    let end = experiment.points.last().map_or(experiment.window.1, |point| point.0);
    let highest = experiment.points.last().map_or(experiment.tank_length, |point| point.1);
    Panel {
        title: experiment.title.to_owned(),
        notes,
        x_label: "T = n t √(g/a), dimensionless".to_owned(),
        y_label: "Z = front / a, dimensionless".to_owned(),
        x_scale: Scale::Linear,
        x: (0.0, end * 1.05),
        y_scale: Scale::Linear,
        y: (1.0, 1.0 + (highest - 1.0) * 1.2),
        series,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::Account;
    use crate::measure::curve::Curve;
    use crate::measure::reference_error::ReferenceError;

    fn run(experiment: &'static DamBreakExperiment, resolution: u32, factor: f64) -> Option<Run> {
        let front: Curve = experiment.points.iter().map(|&(time, z)| (time, z * factor)).collect();
        let error = ReferenceError::between(&front, experiment.points, experiment.window)?;
        let account =
            Account { time_scale: 1.0, simulated: 1.0, substeps: 10, particle_steps: 1e4, ..Account::default() };
        Some(Run { experiment, backend: Backend::Cpu, resolution, particles: 1000, front, error, escaped: 0, account })
    }

    fn runs(factors: [f64; 2]) -> Vec<Run> {
        let pairs =
            DamBreakExperiment::ALL.into_iter().flat_map(|experiment| [(experiment, 12, 0), (experiment, 32, 1)]);
        pairs.filter_map(|(experiment, resolution, index)| run(experiment, resolution, factors[index])).collect()
    }

    #[test]
    fn bounds_are_those_of_the_finest_and_of_the_trend() {
        assert!(super::super::verdict(&runs([1.2, 1.04])).passes(), "4 % at the finest, 20 % at the coarsest");
        assert!(!super::super::verdict(&runs([1.2, 1.1])).passes(), "10 % at the finest");
        assert!(!super::super::verdict(&runs([1.01, 1.02])).passes(), "the finest is worse");
        let mut lossy = runs([1.2, 1.04]);
        lossy[0].account.lost = 1;
        assert!(!super::super::verdict(&lossy).passes(), "a particle is lost");
        let mut leaky = runs([1.2, 1.04]);
        leaky[0].escaped = 1;
        assert!(!super::super::verdict(&leaky).passes(), "a particle is through a wall");
    }

    #[test]
    fn files_say_what_was_measured() {
        let runs = runs([1.2, 1.04]);
        let text = summary(&runs).text().to_owned();
        assert!(text.contains("martin_moyce_tall,cpu,32,1000,4.00,4.00"), "{text}");
        let rows = fronts(&runs).text().lines().filter(|line| line.contains(",cpu,")).count();
        assert_eq!(rows, 2 * DamBreakExperiment::ALL.iter().map(|e| e.points.len()).sum::<usize>());
        let drawn = chart(Method::DivergenceFree, &runs);
        assert!(drawn.title.contains("DFSPH"));
        assert_eq!(drawn.panels.len(), 3);
        assert_eq!(drawn.panels[0].notes[0], "RMS error at a/d = 32: 4.0 %");
    }
}
