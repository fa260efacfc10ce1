//! `column`: half a metre of water at rest.

use clap::Args;
use freshet_core::field::Field;
use freshet_core::plan::Plan;

use crate::backend::Backend;
use crate::chart::{self, Chart, Colour, Mark, Panel, Scale, Series};
use crate::drive::{Account, Drive};
use crate::error::LabError;
use crate::measure::column::{floor_pressure, level_from_centre_of_mass, surface_level};
use crate::measure::curve::Curve;
use crate::measure::statistics::{mean, spread};
use crate::options::{BackendChoice, CommonOptions, ThreadOption};
use crate::output::{Csv, Output, say, say_files};
use crate::progress::Progress;
use crate::reference::hydrostatics;
use crate::scenes::GRAVITY;
use crate::scenes::column::{BASE, Container, DEPTH, PER_LAYER, SPACING, scene};
use crate::table::Table;
use crate::verdict::{Bound, Verdict};

/// A column of water at rest: 0.25 x 0.25 m wide, 0.5 m deep, 2,000 particles in a container that fits: once a body, which
/// reports its load, once walls.
///
/// From half time on: pressure on the floor (mean of the lowest layer, plus what lies below it) within 5 % of rho g D, load on
/// the body within 1 % of the weight, mean speed below 5 mm/s, all three averaged over time (the table shows the worst tick
/// too); surface level (mean height of the two highest layers, plus a spacing) within half a spacing at every tick. Mean
/// compression below 1.5 % in every substep of the whole run; the largest of any particle is in the table. Writes column.csv (the values tick by tick) and column.svg.
#[derive(Args, Clone, Debug)]
pub struct ColumnArgs {
    /// Options every command has.
    #[command(flatten)]
    pub common: CommonOptions,
    /// Threads of the CPU solver.
    #[command(flatten)]
    pub threads: ThreadOption,
    /// Time to simulate, s [default: 10; quick: 2]. Below 10 the mean speed is printed, but has no bound.
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub seconds: Option<f64>,
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if (0.1..=600.0).contains(&value) => Ok(value),
        _ => Err("allowed: 0.1 to 600".to_owned()),
    }
}

/// Time from which on the mean speed has to be below its bound, s.
const SETTLED: f64 = 5.0;
/// Duration of a tick, s.
const TICK: f64 = 0.01;
/// Files of the command.
const FILES: [&str; 2] = ["column.csv", "column.svg"];

/// A column that has been simulated.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Where it ran.
    pub backend: Backend,
    /// What held it.
    pub container: Container,
    /// Time simulated, s.
    pub seconds: f64,
    /// Pressure on the floor, Pa.
    pub floor_pressure: Curve,
    /// Load on the container, N, the mean of each tick; empty for walls.
    pub load: Curve,
    /// Surface level, m.
    pub level: Curve,
    /// Twice the height of the centre of mass, m.
    pub level_from_mass: Curve,
    /// Mean speed, m/s.
    pub mean_speed: Curve,
    /// Largest mean compression of a substep in the tick.
    pub compression: Curve,
    /// What it cost.
    pub account: Account,
}

impl Run {
    fn name(&self) -> String {
        format!("{} in {}", self.backend, self.container.name())
    }

    /// Time from which on averages are taken.
    fn settled(&self) -> f64 {
        self.seconds / 2.0
    }

    fn late_mean(&self, curve: &Curve) -> f64 {
        mean(curve.values_from(self.settled())).unwrap_or(f64::NAN)
    }

    fn late_spread(&self, curve: &Curve) -> (f64, f64) {
        let values: Vec<f64> = curve.values_from(self.settled()).collect();
        spread(&values).unwrap_or((f64::NAN, f64::NAN))
    }
}

/// Weight of the water, N.
pub fn weight() -> f64 {
    hydrostatics::pressure(1000.0, GRAVITY, DEPTH) * BASE * BASE
}

/// Simulates the column.
pub fn simulate(
    backend: Backend,
    container: Container,
    seconds: f64,
    threads: Option<usize>,
    progress: &mut Progress,
) -> Result<Run, LabError> {
    let plan = Plan::new(&scene(container)?)?;
    let (rest_density, gravity) = (plan.parameters.rest_density, plan.parameters.gravity.length());
    let mut drive = Drive::open(backend, plan, threads, container.bodies())?;
    let mut run = Run {
        backend,
        container,
        seconds,
        floor_pressure: Curve::default(),
        load: Curve::default(),
        level: Curve::default(),
        level_from_mass: Curve::default(),
        mean_speed: Curve::default(),
        compression: Curve::default(),
        account: Account::default(),
    };
    let missing = |what| LabError::Measure { what, reason: "particles are missing".to_owned() };
    let ticks = (seconds / TICK).round() as u32;
    for tick in 1..=ticks {
        let report = drive.tick(TICK)?;
        let (positions, pressures) = (drive.positions()?, drive.scalars(Field::Pressure)?);
        let speeds = drive.scalars(Field::Speed)?;
        let time = drive.time();
        let pressure = floor_pressure(&positions, &pressures, PER_LAYER, rest_density, gravity);
        run.floor_pressure.push(time, pressure.ok_or(missing("the floor pressure"))?);
        if let Some(impulse) = report.bodies.first() {
            run.load.push(time, -f64::from(impulse.linear.y) / report.simulated);
        }
        let level = surface_level(&positions, PER_LAYER, SPACING as f32);
        run.level.push(time, level.ok_or(missing("the surface level"))?);
        run.level_from_mass.push(time, level_from_centre_of_mass(&positions).ok_or(missing("the surface level"))?);
        let speed = mean(speeds.iter().map(|&speed| f64::from(speed)));
        run.mean_speed.push(time, speed.ok_or(missing("the mean speed"))?);
        run.compression.push(time, f64::from(report.mean_compression));
        progress.at(f64::from(tick) / f64::from(ticks));
    }
    run.account = drive.account().clone();
    Ok(run)
}

/// Runs the command.
pub fn run(args: &ColumnArgs) -> Result<Verdict, LabError> {
    let output = Output::new(&args.common.out)?;
    let seconds = args.seconds.unwrap_or(if args.common.quick { 2.0 } else { 10.0 });
    let backends = args.common.backends(BackendChoice::Cpu);
    let work = |backend| if backend == Backend::Gpu { 8.0 } else { 1.0 };
    let mut progress = Progress::new(backends.iter().map(|&backend| 2.0 * work(backend)).sum());
    let mut runs: Vec<Run> = Vec::new();
    for (&backend, container) in
        backends.iter().flat_map(|backend| Container::ALL.map(|container| (backend, container)))
    {
        progress.begin(format!("column in {}, {backend}", container.name()), work(backend));
        runs.push(simulate(backend, container, seconds, args.threads.count(), &mut progress)?);
        output.write(FILES[0], csv(&runs).text())?;
        chart::draw(&output, FILES[1], &chart(&runs))?;
    }
    drop(progress);
    say(table(&runs));
    say_files(&output, &FILES);
    Ok(verdict(&runs))
}

/// The bounds of all runs.
pub fn verdict(runs: &[Run]) -> Verdict {
    let mut verdict = Verdict::default();
    for run in runs {
        let name = |what: &str| format!("column, {}: {what}", run.name());
        let pressure = run.late_mean(&run.floor_pressure) / hydrostatics::pressure(1000.0, GRAVITY, DEPTH);
        verdict.check(name("floor pressure over rho g D"), pressure, "", Bound::Within(0.95, 1.05));
        if run.container == Container::Body {
            let load = run.late_mean(&run.load) / weight();
            verdict.check(name("load over weight"), load, "", Bound::Within(0.99, 1.01));
        }
        let (low, high) = run.late_spread(&run.level);
        let half = SPACING / 2.0;
        let off = (DEPTH - low).max(high - DEPTH) * 1000.0;
        verdict.check(name("surface level, furthest from the right one"), off, "mm", Bound::AtMost(half * 1000.0));
        let compression = run.account.worst_mean_compression * 100.0;
        verdict.check(name("mean compression, worst substep"), compression, "%", Bound::Below(1.5));
        if run.seconds >= 2.0 * SETTLED {
            // The column rings at its lowest acoustic mode, 22 Hz, so a single tick shows a phase and not a level.
            let speed = run.late_mean(&run.mean_speed) * 1000.0;
            verdict.check(name("mean speed after 5 s, over particles and time"), speed, "mm/s", Bound::Below(5.0));
        }
        verdict.check(name("particles lost"), run.account.lost as f64, "", Bound::AtMost(0.0));
        verdict.check(name("time scale"), run.account.time_scale, "", Bound::AtLeast(0.999));
    }
    verdict
}

fn table(runs: &[Run]) -> Table {
    let mut table = Table::new(["column", "expected", "mean", "least", "most", "unit"]);
    for run in runs {
        let mut row = |what: &str, expected: f64, curve: &Curve, scale: f64, unit: &str| {
            let (least, most) = run.late_spread(curve);
            let cells = [expected, run.late_mean(curve), least, most].map(|value| format!("{:.2}", value * scale));
            let name = format!("{}, {what}", run.name());
            table.row(std::iter::once(name).chain(cells).chain(std::iter::once(unit.to_owned())));
        };
        row("floor pressure", hydrostatics::pressure(1000.0, GRAVITY, DEPTH), &run.floor_pressure, 1.0, "Pa");
        if run.container == Container::Body {
            row("load on the container", weight(), &run.load, 1.0, "N");
        }
        row("surface level", DEPTH, &run.level, 1000.0, "mm");
        row("level from centre of mass", DEPTH, &run.level_from_mass, 1000.0, "mm");
        row("mean speed", 0.0, &run.mean_speed, 1000.0, "mm/s");
        // c = 10 v_max and v_max = 2 sqrt(g D) by default.
        let sound_speed = 20.0 * (GRAVITY * DEPTH).sqrt();
        let compression = hydrostatics::mean_compression(GRAVITY, DEPTH, sound_speed);
        row("mean compression", compression, &run.compression, 100.0, "%");
        let account = &run.account;
        table.row([
            format!("{}, largest compression of a particle, whole run", run.name()),
            String::new(),
            String::new(),
            String::new(),
            format!("{:.2}", account.worst_compression * 100.0),
            "%".to_owned(),
        ]);
        table.row([
            format!("{}, cost", run.name()),
            String::new(),
            format!("{:.0}", account.nanoseconds_per_particle_step()),
            String::new(),
            String::new(),
            "ns/(p step)".to_owned(),
        ]);
    }
    table
}

fn csv(runs: &[Run]) -> Csv {
    let comment = "Freshet, column at rest: `cargo run --release -p freshet_lab -- column`. Load: mean of the tick.";
    let columns = [
        "backend",
        "container",
        "time_s",
        "floor_pressure_pa",
        "load_n",
        "surface_level_m",
        "level_from_centre_of_mass_m",
        "mean_speed_m_s",
        "mean_compression",
    ];
    let mut csv = Csv::new([comment], &columns);
    for run in runs {
        let curves =
            [&run.floor_pressure, &run.load, &run.level, &run.level_from_mass, &run.mean_speed, &run.compression];
        for &(time, _) in run.level.samples() {
            let cells = curves.map(|curve| format!("{:.6}", curve.at(time).unwrap_or(f64::NAN)));
            let names = [run.backend.name(), run.container.name()].map(str::to_owned);
            csv.row(names.into_iter().chain([format!("{time:.3}")]).chain(cells));
        }
    }
    csv
}

fn chart(runs: &[Run]) -> Chart {
    let seconds = runs.iter().map(|run| run.seconds).fold(0.0, f64::max);
    let panel = |title: &str, unit: &str, scale: f64, bound: &[f64], curve: fn(&Run) -> &Curve| {
        let mut series: Vec<Series> = runs
            .iter()
            .map(|run| Series {
                name: run.name(),
                mark: Mark::Line(2),
                colour: match (run.backend, run.container) {
                    (Backend::Cpu, Container::Body) => Colour::BLUES[0],
                    (Backend::Cpu, Container::Walls) => Colour::BLUES[2],
                    (Backend::Gpu, _) => Colour::ORANGE,
                },
                points: curve(run).samples().iter().map(|&(time, value)| (time, value * scale)).collect(),
            })
            .collect();
        series.extend(bound.iter().map(|&bound| Series {
            name: "bound".to_owned(),
            mark: Mark::Dashes(2),
            colour: Colour::RED,
            points: vec![(0.0, bound), (seconds, bound)],
        }));
        Panel {
            title: title.to_owned(),
            notes: Vec::new(),
            x_label: "time (s)".to_owned(),
            y_label: unit.to_owned(),
            x_scale: Scale::Linear,
            x: (0.0, seconds),
            y_scale: Scale::Linear,
            y: (0.0, 1.0),
            series,
        }
        .fitted(0.0)
    };
    let reference = hydrostatics::pressure(1000.0, GRAVITY, DEPTH);
    Chart {
        title: "Column of water at rest".to_owned(),
        panels: vec![
            panel("Floor pressure", "over rho g D", 1.0 / reference, &[0.95, 1.05], |run| &run.floor_pressure),
            panel("Mean speed", "mm/s", 1000.0, &[5.0], |run| &run.mean_speed),
            panel("Mean compression", "%", 100.0, &[1.5], |run| &run.compression),
        ],
        size: (1320, 480),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settled(speed: f64, load: f64) -> Run {
        let steady = |value: f64| (1..=100).map(|tick| (f64::from(tick) * 0.1, value)).collect::<Curve>();
        Run {
            backend: Backend::Cpu,
            container: Container::Body,
            seconds: 10.0,
            floor_pressure: steady(4905.0),
            load: steady(load),
            level: steady(0.5),
            level_from_mass: steady(0.5),
            mean_speed: steady(speed),
            compression: steady(0.00125),
            account: Account { time_scale: 1.0, worst_mean_compression: 0.01, ..Account::default() },
        }
    }

    #[test]
    fn weight_is_that_of_31_kilograms() {
        assert!((weight() - 31.25 * 9.81).abs() < 1e-9);
    }

    #[test]
    fn each_bound_can_be_missed() {
        assert!(verdict(&[settled(0.001, weight())]).passes());
        assert!(!verdict(&[settled(0.006, weight())]).passes(), "too fast");
        assert!(!verdict(&[settled(0.001, 0.98 * weight())]).passes(), "too light");
        let mut low = settled(0.001, weight());
        low.level = [(1.0, 0.5), (6.0, 0.48), (10.0, 0.5)].into_iter().collect();
        assert!(!verdict(&[low]).passes(), "the level sank once after half time");
        let mut dense = settled(0.001, weight());
        dense.account.worst_mean_compression = 0.016;
        assert!(!verdict(&[dense]).passes(), "compressed");
        let mut weak = settled(0.001, weight());
        weak.floor_pressure = [(1.0, 4905.0), (6.0, 4600.0), (10.0, 4600.0)].into_iter().collect();
        assert!(!verdict(&[weak]).passes(), "pressure 6 % low");
    }

    #[test]
    fn what_happens_before_half_time_does_not_count_for_averages() {
        let mut bouncing = settled(0.001, weight());
        bouncing.load = [(0.1, 900.0), (4.9, 0.0), (5.5, weight()), (10.0, weight())].into_iter().collect();
        assert!(verdict(&[bouncing]).passes());
    }
}
