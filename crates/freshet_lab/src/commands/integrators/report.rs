//! Tables, CSV and chart of `integrators`.

use freshet_core::integrator::Integrator;

use super::oscillation::{DRIFT_STEP, Found, NONE, PERIODS, radius};
use super::printed::Comparison;
use crate::chart::{Chart, Colour, Mark, Panel, Scale, Series};
use crate::output::Csv;
use crate::table::Table;
use crate::verdict::short;

/// What was found, a line each.
pub fn table(found: &[Found]) -> Table {
    let mut table = Table::new([
        "oscillator, integrator",
        "limit of omega h",
        "just below",
        "just above",
        "order of x, v",
        &format!("energy after {PERIODS} periods"),
    ]);
    for one in found {
        let [position, velocity] = one.orders();
        table.row([
            format!("{}, {}", oscillator(one.damped), one.integrator.name()),
            if one.limit < NONE { "none".to_owned() } else { format!("{:.4}", one.limit) },
            one.below.map_or("".to_owned(), short),
            growth(one.above),
            format!("{position:.2}, {velocity:.2}"),
            one.energy.map_or("".to_owned(), energy),
        ]);
    }
    table
}

fn oscillator(damped: bool) -> &'static str {
    if damped { "damped" } else { "undamped" }
}

fn growth(amplitude: f64) -> String {
    if amplitude > 1e12 { "> 1e12".to_owned() } else { short(amplitude) }
}

fn energy(ratio: f64) -> String {
    match ratio {
        ratio if (1e-3..1e3).contains(&ratio) => format!("{ratio:.4}"),
        ratio if ratio < 1e-3 => "< 0.001".to_owned(),
        _ => "> 1000".to_owned(),
    }
}

/// The limits.
pub fn limits(found: &[Found]) -> Csv {
    let comment = format!(
        "Freshet, integrators on an oscillator: `cargo run --release -p freshet_lab -- integrators`.\n\
         limit_omega_h: spectral radius of the one-step matrix up to 1 + 1e-9; below {NONE} it is none. amplitude: of 100000 steps 0.1 % below and above it.\n\
         orders: observed, of position and velocity. energy: after {PERIODS} periods with omega h = {DRIFT_STEP} over that at the start."
    );
    let columns = [
        "oscillator",
        "integrator",
        "limit_omega_h",
        "amplitude_below",
        "amplitude_above",
        "order_position",
        "order_velocity",
        "energy",
    ];
    let mut csv = Csv::new([comment.as_str()], &columns);
    for one in found {
        let [position, velocity] = one.orders();
        csv.row([
            oscillator(one.damped).to_owned(),
            one.integrator.name().to_owned(),
            format!("{:.6}", one.limit),
            one.below.map_or(String::new(), |amplitude| format!("{amplitude:.4}")),
            format!("{:.3e}", one.above),
            format!("{position:.3}"),
            format!("{velocity:.3}"),
            one.energy.map_or(String::new(), |energy| format!("{energy:.5e}")),
        ]);
    }
    csv
}

/// Beside the source's tables.
pub fn printed(comparisons: &[Comparison]) -> Csv {
    let comment = "Freshet, Pirovano 2011, tables 2.1 to 2.4, beside the same runs here: `cargo run --release -p freshet_lab -- integrators`.";
    let mut csv = Csv::new([comment], &["table", "integrator", "pirovano_2011", "here", "agrees", "why"]);
    for Comparison { table, name, said, found, why } in comparisons {
        let agrees = if why.is_some() { "no" } else { "yes" };
        csv.row([table, *name, said, found, agrees, why.unwrap_or("")]);
    }
    csv
}

/// Those that have the same spectral radius share a line.
const LINES: [(&str, Colour, &[Integrator]); 7] = [
    ("forward Euler", Colour::RED, &[Integrator::ForwardEuler]),
    (
        "semi-implicit Euler, modified velocity Verlet, leapfrog",
        Colour::BLUES[2],
        &[Integrator::SemiImplicitEuler, Integrator::ModifiedVelocityVerlet, Integrator::Leapfrog],
    ),
    ("Verlet, velocity Verlet", Colour::BLUES[0], &[Integrator::Verlet, Integrator::VelocityVerlet]),
    ("Clavet", Colour::ORANGE, &[Integrator::Clavet]),
    ("Beeman", Colour(0x2e, 0x8b, 0x57), &[Integrator::Beeman]),
    ("velocity-corrected", Colour(0x7d, 0x3c, 0x98), &[Integrator::VelocityCorrectedBeeman]),
    ("position-corrected", Colour(0xb0, 0x7a, 0x10), &[Integrator::PositionCorrectedBeeman]),
];

/// Spectral radii and errors over the step.
pub fn chart(found: &[Found]) -> Chart {
    let panels = [false, true].map(radii).into_iter().chain([false, true].map(|damped| errors(found, damped)));
    Chart {
        title: "Integrators on an oscillator, one evaluation of the force a step".to_owned(),
        panels: panels.collect(),
        size: (1720, 560),
    }
}

fn radii(damped: bool) -> Panel {
    let steps = || (1..=220).map(|n| f64::from(n) * 0.01);
    let series = LINES.map(|(name, colour, integrators)| Series {
        name: name.to_owned(),
        mark: Mark::Line(2),
        colour,
        points: steps().map(|step| (step, radius(integrators[0], damped, step))).collect(),
    });
    let limit = Series {
        name: "stable up to here".to_owned(),
        mark: Mark::Dashes(1),
        colour: Colour::INK,
        points: vec![(0.0, 1.0), (2.2, 1.0)],
    };
    Panel {
        title: if damped { "Critically damped" } else { "Undamped" }.to_owned(),
        notes: Vec::new(),
        x_label: "omega h".to_owned(),
        y_label: "spectral radius of a step".to_owned(),
        x_scale: Scale::Linear,
        x: (0.0, 2.2),
        y_scale: Scale::Linear,
        y: (0.0, 2.0),
        series: series.into_iter().chain([limit]).collect(),
    }
}

fn errors(found: &[Found], damped: bool) -> Panel {
    let of = |integrator: Integrator| found.iter().find(|one| one.integrator == integrator && one.damped == damped);
    let series = LINES.into_iter().flat_map(|(name, colour, integrators)| {
        integrators.iter().filter_map(move |&integrator| {
            let points = of(integrator)?.errors.clone();
            Some(Series { name: name.to_owned(), mark: Mark::Line(2), colour, points })
        })
    });
    Panel {
        title: if damped { "Critically damped" } else { "Undamped" }.to_owned(),
        notes: vec!["up to omega t = 4".to_owned()],
        x_label: "omega h".to_owned(),
        y_label: "largest error of x / amplitude".to_owned(),
        x_scale: Scale::Decades,
        x: (0.005, 0.25),
        y_scale: Scale::Decades,
        y: (1e-8, 1.0),
        series: series.collect(),
    }
}
