//! Table, CSV and chart of the dam breaks.

use crate::backend::Backend;
use crate::chart::{self, Chart, Colour, Mark, Panel, Scale, Series};
use crate::error::LabError;
use crate::measure::reference_error::ReferenceError;
use crate::measure::statistics::order;
use crate::method::Method;
use crate::output::{Csv, Output};
use crate::reference::dam_break::DamBreakExperiment;
use crate::table::Table;

use super::{HeightError, Run, inviscid};

/// Errors and cost; all fronts; all heights; the chart.
pub fn files(method: Method) -> [String; 4] {
    [".csv", "_fronts.csv", "_heights.csv", ".svg"].map(|end| format!("dam_break{}{end}", method.suffix()))
}

/// The command that a file is from.
fn command(method: Method) -> String {
    let option = method.option();
    format!("Freshet, dam break: `cargo run --release -p freshet_lab -- dam-break{option} --out docs/charts`.")
}

/// Written on top of the CSV files of errors and fronts.
const COMMENT: &str = "T = n t sqrt(g/a), Z = front/a, n^2 = height/width; front = 99.5th percentile of x plus d/2; slab 10 d deep.\n\
    RMS of (Z - Z_measured)/Z_measured over the measured points with 1 < T < 3.3 (Lobovsky 1.57). The simulation at T - shift is\n\
    compared with the experiment at T. The tip of potential flow is measured likewise. Times are of the machine that ran it.";

/// Written on top of those of errors and heights.
const HEIGHT_COMMENT: &str = "H = height of the column at the back wall/(n^2 a), over tau = t sqrt(g/a) = T/n: volume in a strip 4 d thick at the wall over the\n\
    strip's floor. Error of H in units of the height at the start: RMS of H - H_measured over all measured points, with a shift of\n\
    T of its own (shift within 0.2 as for the front), and with that of the front; then relative: RMS of\n\
    (H - H_measured)/H_measured, as it is and with the best shift for it. Potential flow: without viscosity, by boundary elements.";

/// Writes all files anew.
pub fn write(output: &Output, method: Method, runs: &[Run]) -> Result<(), LabError> {
    let [table, curves, columns, drawing] = files(method);
    output.write(&table, summary(method, runs).text())?;
    output.write(&curves, fronts(method, runs).text())?;
    output.write(&columns, heights(method, runs).text())?;
    chart::draw(output, &drawing, &chart(method, runs))?;
    Ok(())
}

fn percent(share: f64) -> String {
    format!("{:.2}", share * 100.0)
}

/// A number about the height; nothing where it was not measured.
fn of_height(run: &Run, text: impl Fn(&HeightError) -> String) -> String {
    run.height_error.as_ref().map_or_else(String::new, text)
}

/// Observed order of convergence of the front's error, shifted, from the next coarser run of the same; nothing at the coarsest.
fn order_of(run: &Run, runs: &[Run]) -> String {
    let same = |other: &&Run| other.experiment == run.experiment && other.backend == run.backend;
    let coarser = runs.iter().filter(same).filter(|other| other.resolution < run.resolution);
    let point = |run: &Run| (f64::from(run.resolution), run.error.rms_shifted);
    let order = coarser.max_by_key(|other| other.resolution).and_then(|coarser| order(point(coarser), point(run)));
    order.map_or_else(String::new, |order| format!("{order:.2}"))
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
        "order",
        "shift",
        "inviscid %",
        "height %",
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
            order_of(run, runs),
            format!("{:+.3}", error.shift),
            percent(run.inviscid_error.rms),
            of_height(run, |height| percent(height.error.rms)),
            of_height(run, |height| percent(height.error.rms_shifted)),
            of_height(run, |height| format!("{:+.3}", height.error.shift)),
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

fn summary(method: Method, runs: &[Run]) -> Csv {
    let sources = DamBreakExperiment::ALL.map(|experiment| format!("{}: {}", experiment.name, experiment.source));
    let command = command(method);
    let comments = [command.as_str(), COMMENT, HEIGHT_COMMENT].into_iter().chain(sources.iter().map(String::as_str));
    let columns = [
        "case",
        "backend",
        "a_over_d",
        "particles",
        "rms_percent",
        "bias_percent",
        "rms_shifted_percent",
        "observed_order",
        "shift",
        "points",
        "rms_against_potential_flow_percent",
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
        "height_rms_percent",
        "height_bias_percent",
        "height_rms_shifted_percent",
        "height_shift",
        "height_rms_with_shift_of_front_percent",
        "height_relative_rms_percent",
        "height_relative_rms_shifted_percent",
        "height_points",
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
            order_of(run, runs),
            format!("{:.3}", error.shift),
            error.points.to_string(),
            percent(run.inviscid_error.rms),
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
            of_height(run, |height| percent(height.error.rms)),
            of_height(run, |height| percent(height.error.bias)),
            of_height(run, |height| percent(height.error.rms_shifted)),
            of_height(run, |height| format!("{:.3}", height.error.shift)),
            of_height(run, |height| percent(height.rms_with_shift_of_front)),
            of_height(run, |height| percent(height.relative.rms)),
            of_height(run, |height| percent(height.relative.rms_shifted)),
            of_height(run, |height| height.error.points.to_string()),
        ]);
    }
    csv
}

fn fronts(method: Method, runs: &[Run]) -> Csv {
    let mut csv = Csv::new([command(method).as_str(), COMMENT], &["case", "source", "a_over_d", "T", "Z"]);
    for experiment in DamBreakExperiment::ALL {
        for &(time, front) in experiment.points {
            csv.row([experiment.name, "experiment", "", &format!("{time:.4}"), &format!("{front:.4}")]);
        }
    }
    for experiment in DamBreakExperiment::ALL.into_iter().filter(|_| method == Method::WaterAlone) {
        for (time, front) in inviscid::front(experiment, 0.0) {
            csv.row([experiment.name, "potential flow", "", &format!("{time:.4}"), &format!("{front:.4}")]);
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

/// Over the time that is compared, by the clock of the heights.
fn heights(method: Method, runs: &[Run]) -> Csv {
    let mut csv = Csv::new([command(method).as_str(), HEIGHT_COMMENT], &["case", "source", "a_over_d", "tau", "H"]);
    for experiment in measured_heights() {
        for &(tau, height) in experiment.heights {
            csv.row([experiment.name, "experiment", "", &format!("{tau:.4}"), &format!("{height:.4}")]);
        }
    }
    for experiment in measured_heights() {
        for (tau, height) in inviscid::height(experiment) {
            csv.row([experiment.name, "potential flow", "", &format!("{tau:.4}"), &format!("{height:.4}")]);
        }
    }
    for run in runs.iter().filter(|run| run.height_error.is_some()) {
        let resolution = run.resolution.to_string();
        for (tau, height) in heights_over_tau(run) {
            let (tau, height) = (format!("{tau:.4}"), format!("{height:.4}"));
            csv.row([run.experiment.name, run.backend.name(), &resolution, &tau, &height]);
        }
    }
    csv
}

/// The experiments that measured the height of the column.
fn measured_heights() -> impl Iterator<Item = &'static DamBreakExperiment> {
    DamBreakExperiment::ALL.into_iter().filter(|experiment| !experiment.heights.is_empty())
}

/// `(tau, H)` of a run.
fn heights_over_tau(run: &Run) -> Vec<(f64, f64)> {
    let n = run.experiment.aspect.sqrt();
    run.height.samples().iter().map(|&(time, height)| (time / n, height)).collect()
}

fn chart(method: Method, runs: &[Run]) -> Chart {
    let fronts = DamBreakExperiment::ALL.into_iter().map(|experiment| front_panel(method, experiment, runs));
    let heights = measured_heights().map(|experiment| height_panel(experiment, runs));
    Chart {
        title: format!("Dam break, {}: front and height of the water against experiments", method.name()),
        panels: fronts.chain(heights).collect(),
        size: (1320, 960),
    }
}

/// A line a run, and the circles of the experiment.
fn series(
    experiment: &'static DamBreakExperiment,
    runs: &[Run],
    simulated: impl Fn(&Run) -> Vec<(f64, f64)>,
    measured: &[(f64, f64)],
) -> Vec<Series> {
    let mut resolutions: Vec<u32> = runs.iter().map(|run| run.resolution).collect();
    resolutions.sort_unstable();
    resolutions.dedup();
    // The finest is the darkest.
    let colour = |resolution: u32| {
        let finer = resolutions.iter().filter(|&&other| other > resolution).count();
        Colour::BLUES[(Colour::BLUES.len() - 1).saturating_sub(finer)]
    };
    let lines = runs.iter().filter(|run| run.experiment == experiment).map(|run| Series {
        name: format!("{} at a/d = {}", run.backend.name().to_uppercase(), run.resolution),
        mark: if run.backend == Backend::Gpu { Mark::Dashes(3) } else { Mark::Line(3) },
        colour: if run.backend == Backend::Gpu { Colour::ORANGE } else { colour(run.resolution) },
        points: simulated(run),
    });
    let circles = Series {
        name: "experiment".to_owned(),
        mark: Mark::Circles(5),
        colour: Colour::INK,
        points: measured.to_vec(),
    };
    lines.chain([circles]).collect()
}

fn potential_flow(points: Vec<(f64, f64)>) -> Series {
    Series { name: "potential flow".to_owned(), mark: Mark::Dashes(2), colour: Colour::INK, points }
}

/// The finest run of a case on the CPU.
fn finest(experiment: &'static DamBreakExperiment, runs: &[Run]) -> Option<Run> {
    let of_cpu = runs.iter().filter(|run| run.experiment == experiment && run.backend == Backend::Cpu);
    of_cpu.max_by_key(|run| run.resolution).cloned()
}

fn notes(run: &Run, error: &ReferenceError, of: &str) -> Vec<String> {
    vec![
        format!("RMS error at a/d = {}: {:.1} %{of}", run.resolution, error.rms * 100.0),
        format!("clock shifted by {:+.2}: {:.1} %", error.shift, error.rms_shifted * 100.0),
    ]
}

fn front_panel(method: Method, experiment: &'static DamBreakExperiment, runs: &[Run]) -> Panel {
    let end = experiment.points.last().map_or(experiment.window.1, |point| point.0);
    let highest = experiment.points.last().map_or(experiment.tank_length, |point| point.1);
    // Nothing without viscosity is as late as the experiments: where water's own is all, it is what to compare with.
    let inviscid = match method {
        Method::WaterAlone => vec![potential_flow(inviscid::front(experiment, 0.0))],
        _ => Vec::new(),
    };
    Panel {
        title: experiment.title.to_owned(),
        notes: finest(experiment, runs).map_or_else(Vec::new, |run| notes(&run, &run.error, "")),
        x_label: "T = n t √(g/a), dimensionless".to_owned(),
        y_label: "Z = front / a, dimensionless".to_owned(),
        x_scale: Scale::Linear,
        x: (0.0, end * 1.05),
        y_scale: Scale::Linear,
        y: (1.0, 1.0 + (highest - 1.0) * 1.2),
        series: [series(experiment, runs, |run| run.front.samples().to_vec(), experiment.points), inviscid].concat(),
    }
}

fn height_panel(experiment: &'static DamBreakExperiment, runs: &[Run]) -> Panel {
    let end = experiment.heights.last().map_or(1.0, |point| point.0);
    let inviscid = vec![potential_flow(inviscid::height(experiment))];
    let of_finest = finest(experiment, runs).and_then(|run| Some((run.height_error?.error, run)));
    Panel {
        title: format!("{}, height", experiment.title),
        notes: of_finest.map_or_else(Vec::new, |(error, run)| notes(&run, &error, " of the start's height")),
        x_label: "τ = t √(g/a), dimensionless".to_owned(),
        y_label: "H = height / (n² a), dimensionless".to_owned(),
        x_scale: Scale::Linear,
        x: (0.0, end * 1.05),
        y_scale: Scale::Linear,
        // Room for the notes over the curves.
        y: (0.0, 1.3),
        series: [series(experiment, runs, heights_over_tau, experiment.heights), inviscid].concat(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::Account;
    use crate::measure::curve::Curve;
    use crate::measure::reference_error::Measure;

    fn run(experiment: &'static DamBreakExperiment, resolution: u32, factor: f64) -> Option<Run> {
        let front: Curve = experiment.points.iter().map(|&(time, z)| (time, z * factor)).collect();
        let error = ReferenceError::between(&front, experiment.points, experiment.window, Measure::Relative)?;
        let height = experiment.heights_over_time().into_iter().map(|(time, height)| (time, height * factor)).collect();
        let height_error = HeightError::between(experiment, &height, 0.0);
        let account =
            Account { time_scale: 1.0, simulated: 1.0, substeps: 10, particle_steps: 1e4, ..Account::default() };
        Some(Run {
            experiment,
            backend: Backend::Cpu,
            resolution,
            particles: 1000,
            front,
            error,
            inviscid_error: ReferenceError { rms: error.rms / 2.0, ..error },
            height,
            height_error,
            escaped: 0,
            account,
        })
    }

    /// With its default settings.
    const METHOD: Method = Method::DivergenceFree;

    fn runs(factors: [f64; 2]) -> Vec<Run> {
        let pairs =
            DamBreakExperiment::ALL.into_iter().flat_map(|experiment| [(experiment, 12, 0), (experiment, 32, 1)]);
        pairs.filter_map(|(experiment, resolution, index)| run(experiment, resolution, factors[index])).collect()
    }

    #[test]
    fn bounds_are_those_of_the_finest_and_of_the_trend() {
        assert!(super::super::verdict(METHOD, &runs([1.2, 1.04])).passes(), "4 % at the finest, 20 % at the coarsest");
        assert!(!super::super::verdict(METHOD, &runs([1.2, 1.1])).passes(), "10 % at the finest");
        let against_potential_flow = |share: f64| {
            let mut runs = runs([1.2, 1.04]);
            runs.iter_mut().filter(|run| run.resolution == 32).for_each(|run| run.inviscid_error.rms = share);
            super::super::verdict(Method::WaterAlone, &runs)
        };
        assert!(against_potential_flow(0.049).passes() && !against_potential_flow(0.051).passes());
        assert!(!super::super::verdict(METHOD, &runs([1.01, 1.02])).passes(), "the finest is worse");
        let low = |share: f64| {
            let mut runs = runs([1.2, 1.04]);
            for run in runs.iter_mut().filter(|run| run.resolution == 32) {
                if let Some(height) = &mut run.height_error {
                    height.error.rms_shifted = share;
                }
            }
            super::super::verdict(METHOD, &runs)
        };
        assert!(low(0.049).passes() && !low(0.051).passes(), "5 % for the height");
        let mut lossy = runs([1.2, 1.04]);
        lossy[0].account.lost = 1;
        assert!(!super::super::verdict(METHOD, &lossy).passes(), "a particle is lost");
        let mut leaky = runs([1.2, 1.04]);
        leaky[0].escaped = 1;
        assert!(!super::super::verdict(METHOD, &leaky).passes(), "a particle is through a wall");
    }

    #[test]
    fn files_say_what_was_measured() {
        let runs = runs([1.2, 1.04]);
        let text = summary(Method::DivergenceFree, &runs).text().to_owned();
        assert!(text.contains("martin_moyce_tall,cpu,32,1000,4.00,4.00"), "{text}");
        assert!(text.contains("--method divergence-free"), "{text}");
        let rows =
            fronts(Method::WeaklyCompressible, &runs).text().lines().filter(|line| line.contains(",cpu,")).count();
        assert_eq!(rows, 2 * DamBreakExperiment::ALL.iter().map(|e| e.points.len()).sum::<usize>());
        assert!(text.lines().next_back().is_some_and(|line| line.ends_with(",0,0,,,,,,,,")), "no height there: {text}");
        let tall = text.lines().find(|line| line.starts_with("martin_moyce_tall,cpu,32")).unwrap_or_default();
        let last: Vec<&str> = tall.rsplit(',').take(3).collect();
        assert!(last[0] == "17" && last[2] == "4.00", "points, and relative error as it is: {tall}");
        let columns = heights(Method::DivergenceFree, &runs).text().to_owned();
        assert!(columns.contains("martin_moyce_tall,experiment,,7.4000,0.0600"), "{columns}");
        assert!(
            columns.contains("martin_moyce_tall,cpu,32,7.4000,0.0624") && !columns.contains("lobovsky"),
            "{columns}"
        );
        assert!(!fronts(Method::DivergenceFree, &runs).text().contains(",potential flow,"));
        assert!(fronts(Method::WaterAlone, &runs).text().contains("martin_moyce_tall,potential flow"));
        let drawn = chart(Method::DivergenceFree, &runs);
        assert!(drawn.title.contains("DFSPH"));
        assert_eq!(drawn.panels.len(), 5);
        assert_eq!(drawn.panels[0].notes[0], "RMS error at a/d = 32: 4.0 %");
        let of_height = &drawn.panels[4].notes[0];
        assert!(of_height.ends_with(" % of the start's height"), "{of_height}");
    }
}
