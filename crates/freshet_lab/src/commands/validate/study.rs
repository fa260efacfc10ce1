//! One case at several resolutions: errors, the observed order of convergence, files.

use super::registry::{Findings, Job};
use crate::backend::Backend;
use crate::chart::{self, Chart, Colour, Mark, Panel, Scale, Series};
use crate::drive::Account;
use crate::error::LabError;
use crate::measure::statistics::order;
use crate::output::Csv;
use crate::progress::Progress;
use crate::table::Table;
use crate::verdict::{Bound, Check, Verdict, short};

/// One quantity of a run over another, with its reference.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// Which, for the CSV.
    pub name: String,
    /// x, simulated, reference (not-a-number where there is none).
    pub points: Vec<(f64, f64, f64)>,
}

/// One resolution of a case.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Particles along the case's length.
    pub resolution: u32,
    /// Particles in all.
    pub particles: usize,
    /// Error, as the case measures it; no unit.
    pub error: f64,
    /// What was compared.
    pub traces: Vec<Trace>,
    /// Further numbers with bounds.
    pub checks: Vec<Check>,
    /// Further numbers without, a line each.
    pub remarks: Vec<String>,
    /// What it cost.
    pub account: Account,
}

/// A case that is run at several resolutions.
pub struct Study {
    /// Name of the case and its files.
    pub name: &'static str,
    /// Head line of the chart.
    pub title: &'static str,
    /// What the error is.
    pub measure: &'static str,
    /// Most it may be at the finest resolution, a share.
    pub bound: f64,
    /// Most it may be at the coarsest resolution of either form, a share: what every backend runs. None if `bound` holds there.
    pub coarse_bound: Option<f64>,
    /// Whether the error has to shrink to 0.6 of that at the coarsest.
    pub smooth: bool,
    /// Resolutions, the coarsest first.
    pub resolutions: [u32; 3],
    /// Those of the quick form.
    pub quick: &'static [u32],
    /// Names of the chart's axes.
    pub axes: [&'static str; 2],
    /// Simulates one resolution.
    pub simulate: fn(&Job, u32, &mut Progress) -> Result<Level, LabError>,
}

/// Finest over coarsest error of a smooth case.
const SMOOTH: f64 = 0.6;

/// A share in percent, with its leading digits where it is small.
fn percent(share: f64) -> String {
    let percent = share * 100.0;
    if percent.abs() < 0.01 { format!("{percent:.1e}") } else { format!("{percent:.3}") }
}

impl Level {
    /// The observed order of convergence from a coarser one to this.
    fn order_from(&self, coarse: &Self) -> Option<f64> {
        let point = |level: &Self| (f64::from(level.resolution), level.error);
        order(point(coarse), point(self))
    }
}

impl Study {
    /// Simulates all resolutions, writing the files anew after each.
    pub fn run(&self, job: &Job) -> Result<Findings, LabError> {
        let resolutions = if job.quick { self.quick } else { &self.resolutions[..] };
        let is_software = job.backend == Backend::Gpu && job.backend.is_processor()?;
        let resolutions = if is_software { &resolutions[..1] } else { resolutions };
        let work = |resolution: u32| f64::from(resolution).powi(3);
        let mut progress = Progress::new(resolutions.iter().map(|&resolution| work(resolution)).sum());
        let mut levels = Vec::new();
        for &resolution in resolutions {
            progress.begin(format!("{} at {resolution}, {}", self.name, job.backend), work(resolution));
            levels.push((self.simulate)(job, resolution, &mut progress)?);
            let file = format!("{}{}", self.name, job.suffix());
            job.output.write(&format!("{file}.csv"), self.csv(&levels, &job.body_options()).text())?;
            chart::draw(&job.output, &format!("{file}.svg"), &self.chart(&levels))?;
        }
        Ok(Findings { verdict: self.verdict(job, &levels), levels })
    }

    /// The bounds of its levels. The quick form is too coarse for the bound on the error.
    fn verdict(&self, job: &Job, levels: &[Level]) -> Verdict {
        let mut verdict = Verdict::default();
        let suffix = job.suffix();
        let name =
            |resolution: u32, what: &str| format!("{}{suffix} at {resolution}, {}: {what}", self.name, job.backend);
        if let ([coarsest, ..], Some(finest)) = (levels, levels.last()) {
            let full = finest.resolution == self.resolutions[2];
            if full || !self.smooth {
                let bound = Bound::AtMost(self.bound * 100.0);
                verdict.check(name(finest.resolution, self.measure), finest.error * 100.0, "%", bound);
            }
            if let Some(bound) = self.coarse_bound {
                let bound = Bound::AtMost(bound * 100.0);
                verdict.check(name(coarsest.resolution, self.measure), coarsest.error * 100.0, "%", bound);
            }
            if self.smooth && levels.len() > 1 {
                let what = format!("error over that at {}", coarsest.resolution);
                let bound = Bound::AtMost(if full { SMOOTH } else { 1.0 });
                verdict.check(name(finest.resolution, &what), finest.error / coarsest.error, "", bound);
            }
        }
        for level in levels {
            verdict.checks.extend(level.checks.iter().map(|check| {
                let name = name(level.resolution, &check.name);
                Check { name, ..check.clone() }
            }));
            verdict.check(name(level.resolution, "particles lost"), level.account.lost as f64, "", Bound::AtMost(0.0));
            verdict.check(name(level.resolution, "time scale"), level.account.time_scale, "", Bound::AtLeast(0.999));
        }
        verdict
    }

    fn csv(&self, levels: &[Level], options: &str) -> Csv {
        let mut comments = vec![format!(
            "Freshet, {}: `cargo run --release -p freshet_lab -- validate --case {}{}`.",
            self.title, self.name, options
        )];
        for (index, level) in levels.iter().enumerate() {
            let order = index
                .checked_sub(1)
                .and_then(|before| level.order_from(&levels[before]))
                .map_or(String::new(), |order| format!(", observed order {order:.2}"));
            comments.push(format!(
                "{} particles along the length, {} in all: {} {} %{order}; {:.1} s of wall time",
                level.resolution,
                level.particles,
                self.measure,
                percent(level.error),
                level.account.wall.as_secs_f64()
            ));
            comments.extend(level.checks.iter().map(|Check { name, value, bound, unit }| {
                format!("{} particles: {name} {} {unit} (bound {bound})", level.resolution, short(*value))
            }));
            comments.extend(level.remarks.iter().map(|remark| format!("{} particles: {remark}", level.resolution)));
        }
        let comments = comments.iter().map(String::as_str);
        let mut csv = Csv::new(comments, &["resolution", "trace", self.axes[0], self.axes[1], "reference"]);
        for level in levels {
            for trace in &level.traces {
                for (x, value, reference) in &trace.points {
                    let numbers = [x, value, reference].map(|number| format!("{number:.6}"));
                    csv.row([level.resolution.to_string(), trace.name.clone()].into_iter().chain(numbers));
                }
            }
        }
        csv
    }

    fn chart(&self, levels: &[Level]) -> Chart {
        let mut series = Vec::new();
        for (level, colour) in levels.iter().zip(colours(levels.len())) {
            series.extend(level.traces.iter().map(|trace| Series {
                name: format!("{} particles", level.resolution),
                mark: Mark::Line(2),
                colour,
                points: trace.points.iter().map(|&(x, value, _)| (x, value)).collect(),
            }));
        }
        for trace in levels.last().into_iter().flat_map(|level| &level.traces) {
            let points = trace.points.iter().filter(|point| point.2.is_finite()).map(|&(x, _, value)| (x, value));
            let (mark, colour) = (Mark::Dashes(2), Colour::ORANGE);
            series.push(Series { name: "reference".to_owned(), mark, colour, points: points.collect() });
        }
        series.retain(|series| !series.points.is_empty());
        let errors: Vec<String> =
            levels.iter().map(|level| format!("{} % at {}", percent(level.error), level.resolution)).collect();
        let orders: Vec<String> = levels
            .windows(2)
            .filter(|_| self.smooth)
            .filter_map(|pair| Some(format!("{:.2}", pair[1].order_from(&pair[0])?)))
            .collect();
        let orders = if orders.is_empty() { String::new() } else { format!("; order {}", orders.join(", ")) };
        let panel = |title: &str, y_label: &str, series: Vec<Series>| Panel {
            title: title.to_owned(),
            notes: Vec::new(),
            x_label: self.axes[0].to_owned(),
            y_label: y_label.to_owned(),
            x_scale: Scale::Linear,
            x: range(&series, |point| point.0),
            y_scale: Scale::Linear,
            y: range(&series, |point| point.1),
            series,
        };
        let mut panels = vec![panel(self.title, self.axes[1], series)];
        let differences = self.differences(levels);
        if !differences.is_empty() {
            panels.push(panel("Simulation less reference", self.axes[1], differences));
        }
        Chart { title: format!("{}: {}{orders}", self.measure, errors.join(", ")), panels, size: (1320, 560) }
    }

    /// How far each level is from the reference, where there is one, and a line for the reference itself.
    fn differences(&self, levels: &[Level]) -> Vec<Series> {
        let mut series = Vec::new();
        for (level, colour) in levels.iter().zip(colours(levels.len())) {
            series.extend(level.traces.iter().map(|trace| Series {
                name: format!("{} particles", level.resolution),
                mark: Mark::Line(2),
                colour,
                points: trace.points.iter().map(|&(x, value, reference)| (x, value - reference)).collect(),
            }));
        }
        for series in &mut series {
            series.points.retain(|point| point.1.is_finite());
        }
        series.retain(|series| !series.points.is_empty());
        if !series.is_empty() {
            let (low, high) = ends(&series, |point| point.0);
            let (mark, colour) = (Mark::Dashes(2), Colour::ORANGE);
            let points = vec![(low, 0.0), (high, 0.0)];
            series.push(Series { name: "reference".to_owned(), mark, colour, points });
        }
        series
    }
}

/// Blues for so many levels, the finest the darkest.
fn colours(levels: usize) -> impl Iterator<Item = Colour> {
    Colour::BLUES.into_iter().skip(Colour::BLUES.len().saturating_sub(levels))
}

/// Ends of an axis that holds all points, with some air.
fn range(series: &[Series], along: fn(&(f64, f64)) -> f64) -> (f64, f64) {
    let (low, high) = ends(series, along);
    if low > high {
        return (0.0, 1.0);
    }
    let air = (0.05 * (high - low)).max(1e-6);
    (low - air, high + air)
}

/// The least and the largest value of all points.
fn ends(series: &[Series], along: fn(&(f64, f64)) -> f64) -> (f64, f64) {
    let values = || series.iter().flat_map(|series| &series.points).map(along).filter(|value| value.is_finite());
    (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max))
}

/// Errors and cost of all cases.
pub(super) fn table(levels: &[(&'static str, Backend, Level)]) -> Table {
    let mut table = Table::new([
        "case",
        "backend",
        "resolution",
        "particles",
        "error %",
        "order",
        "substeps",
        "wall s",
        "ns/(p step)",
    ]);
    for (index, (case, backend, level)) in levels.iter().enumerate() {
        let before = index
            .checked_sub(1)
            .map(|before| &levels[before])
            .filter(|before| before.0 == *case && before.1 == *backend);
        table.row([
            (*case).to_owned(),
            backend.to_string(),
            level.resolution.to_string(),
            level.particles.to_string(),
            percent(level.error),
            before.and_then(|before| level.order_from(&before.2)).map_or(String::new(), |order| format!("{order:.2}")),
            level.account.substeps.to_string(),
            format!("{:.1}", level.account.wall.as_secs_f64()),
            format!("{:.0}", level.account.nanoseconds_per_particle_step()),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(resolution: u32, error: f64) -> Level {
        let account = Account { time_scale: 1.0, substeps: 10, ..Account::default() };
        let traces = vec![Trace { name: "t".to_owned(), points: vec![(0.0, 1.0, f64::NAN), (1.0, 2.0, 2.1)] }];
        Level { resolution, particles: 8, error, traces, checks: Vec::new(), remarks: Vec::new(), account }
    }

    fn study() -> Study {
        Study {
            name: "name",
            title: "Title",
            measure: "L2 error",
            bound: 0.02,
            coarse_bound: Some(0.05),
            smooth: true,
            resolutions: [10, 20, 40],
            quick: &[5, 10],
            axes: ["x", "y"],
            simulate: |_, resolution, _| Ok(level(resolution, 0.4 / f64::from(resolution))),
        }
    }

    fn passes(levels: &[Level]) -> bool {
        let output = crate::output::Output::new(&std::env::temp_dir()).unwrap();
        let job = Job {
            backend: Backend::Cpu,
            quick: false,
            threads: Default::default(),
            bodies: Default::default(),
            lockstep: false,
            output,
        };
        study().verdict(&job, levels).passes()
    }

    #[test]
    fn each_bound_can_be_missed() {
        let order = level(20, 0.01).order_from(&level(10, 0.04));
        assert!(order.is_some_and(|order| (order - 2.0).abs() < 1e-12));
        assert!(passes(&[level(10, 0.04), level(20, 0.02), level(40, 0.01)]));
        assert!(!passes(&[level(10, 0.048), level(20, 0.04), level(40, 0.021)]), "2.1 % at the finest");
        assert!(!passes(&[level(10, 0.051)]), "5.1 % at the coarsest, alone as on the GPU");
        assert!(!passes(&[level(10, 0.02), level(20, 0.02), level(40, 0.013)]), "0.65 of the coarsest");
        let mut lossy = level(40, 0.01);
        lossy.account.lost = 1;
        assert!(!passes(&[level(10, 0.04), lossy]), "a particle is lost");
    }

    #[test]
    fn files_hold_errors_order_and_points() {
        let levels = [level(10, 0.04), level(20, 0.01)];
        let text = study().csv(&levels, "").text().to_owned();
        assert!(text.contains("L2 error 1.000 %, observed order 2.00"), "{text}");
        assert!(text.contains("20,t,1.000000,2.000000,2.100000"), "{text}");
        let chart = study().chart(&levels);
        assert_eq!(chart.panels.iter().map(|panel| panel.series.len()).collect::<Vec<_>>(), [3, 3]);
        let off = chart.panels[1].series[0].points[0];
        assert!((off.1 + 0.1).abs() < 1e-9, "2.0 less 2.1, not {off:?}");
        assert_eq!(chart.title, "L2 error: 4.000 % at 10, 1.000 % at 20; order 2.00");
    }
}
