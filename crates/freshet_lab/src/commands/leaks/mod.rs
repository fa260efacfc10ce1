//! `leaks`: walls and fluid that meet at up to 10 m/s, and what gets through.

mod gate;
mod simulate;
mod trials;

use clap::Args;

pub use simulate::{Found, simulate};
pub use trials::{Trial, trials};

use crate::backend::Backend;
use crate::chart::heat::{self, Cell, HeatMap};
use crate::error::LabError;
use crate::method::Method;
use crate::options::{BackendChoice, CommonOptions, ThreadOption};
use crate::output::{Csv, Output, say, say_files};
use crate::progress::Progress;
use crate::table::Table;
use crate::verdict::{Bound, Verdict};

/// Walls one spacing thick, walls that move, and every shape under fire: nothing may get through.
///
/// A block thrown at a plate, into a bowl of triangles and into a valley; a cup of water that is pulled away (0.5, 2 and 10 m/s2) and turned
/// over; a piston in a channel; a paddle in a tank; each at 0.5, 2 and 10 m/s. Then 10,000 single particles at 10 m/s at every shape, from two to four
/// spacings, up to 60 degrees off the normal. Particles are followed at 240 looks a second, beside paddles up to
/// 2 m/s at 60. One leaks when it goes through the middle of a thin wall or is deeper in a solid than its samples (0.92 spacings with the
/// default kernel). Nothing is clamped or put back. Bound: none. Writes leaks.csv and leaks.svg (leaks_dfsph with `--method divergence-free`).
#[derive(Args, Clone, Debug)]
pub struct LeaksArgs {
    /// Options every command has. Short form: 10 m/s only and a tenth of the shots.
    #[command(flatten)]
    pub common: CommonOptions,
    /// Threads of the CPU solver.
    #[command(flatten)]
    pub threads: ThreadOption,
    /// How pressure is found [default: weakly-compressible].
    #[arg(long, value_enum, default_value_t, hide_default_value = true)]
    pub method: Method,
    /// Only trials whose name holds this.
    #[arg(long, value_name = "TEXT")]
    pub only: Option<String>,
}

/// Runs the command.
pub fn run(args: &LeaksArgs) -> Result<Verdict, LabError> {
    let output = Output::new(&args.common.out)?;
    let mut trials = trials(args.common.quick)?;
    if let Some(text) = &args.only {
        trials.retain(|trial| trial.name().contains(text.as_str()));
        if trials.is_empty() {
            let reason = format!("no trial's name holds {text:?}; allowed: a part of a name in the table of all");
            return Err(LabError::Argument { argument: "--only", reason });
        }
    }
    let backends = args.common.backends(BackendChoice::Cpu);
    let mut progress = Progress::new((trials.len() * backends.len()) as f64);
    let mut found = Vec::new();
    let [file, chart] = ["csv", "svg"].map(|ending| format!("leaks{}.{ending}", args.method.suffix()));
    for &backend in backends {
        for trial in &trials {
            progress.begin(format!("{}, {backend}", trial.name()), 1.0);
            found.push(simulate(trial, backend, args.method, args.threads.count(), &mut progress)?);
            output.write(&file, csv(&found).text())?;
            heat::draw(&output, &chart, &map(args.method, &found))?;
        }
    }
    drop(progress);
    say(table(&found));
    say_files(&output, &[&file, &chart]);
    Ok(verdict(&found))
}

/// None may leak, none may be lost.
pub fn verdict(found: &[Found]) -> Verdict {
    let mut verdict = Verdict::default();
    for one in found {
        let name = format!("{}, {}, {}, {}", one.what, one.pace, one.method.name(), one.backend);
        verdict.check(name, (one.leaks + one.removed as usize) as f64, "", Bound::AtMost(0.0));
    }
    verdict
}

fn cells(one: &Found) -> [String; 8] {
    [
        one.what.clone(),
        one.pace.clone(),
        one.method.name().to_owned(),
        one.backend.to_string(),
        one.particles.to_string(),
        one.leaks.to_string(),
        one.removed.to_string(),
        format!("{:.2}", one.deepest / trials::SPACING),
    ]
}

fn table(found: &[Found]) -> Table {
    let mut table =
        Table::new(["trial", "pace", "method", "backend", "particles", "leaks", "removed", "deepest (spacings)"]);
    found.iter().for_each(|one| table.row(cells(one)));
    table
}

fn csv(found: &[Found]) -> Csv {
    let comments = [
        "What went through walls: `cargo run --release -p freshet_lab -- leaks`, or with `--method divergence-free`. Particles are followed at 240 looks a second, beside paddles up to 2 m/s at 60; spacing 0.05 m.",
        "deepest: how far one got into a solid, in spacings, where that can be told.",
    ];
    let columns = ["trial", "pace", "method", "backend", "particles", "leaks", "removed", "deepest_spacings"];
    let mut csv = Csv::new(comments, &columns);
    found.iter().for_each(|one| csv.row(cells(one)));
    csv
}

/// A row for each trial, a column for each backend: how many leaked, and how deep one got.
fn map(method: Method, found: &[Found]) -> HeatMap {
    let mut backends: Vec<Backend> = found.iter().map(|one| one.backend).collect();
    backends.dedup();
    let first: Vec<&Found> = found.iter().filter(|one| Some(&one.backend) == backends.first()).collect();
    let rows = first.chunk_by(|one, next| one.what == next.what).map(|same| {
        let paces = same.iter().map(|one| one.pace.clone()).collect();
        (same.first().map_or_else(String::new, |one| one.what.clone()), paces)
    });
    let cells = |row: &&Found| {
        let of = |backend: &Backend| {
            let here = |one: &&Found| (&one.what, &one.pace, &one.backend) == (&row.what, &row.pace, backend);
            let one = found.iter().find(here);
            let depth = |one: &Found| f64::from(one.deepest / trials::SPACING);
            [
                one.map(|one| Cell { shade: if one.leaks == 0 { 1.0 } else { 0.0 }, label: one.leaks.to_string() }),
                one.map(|one| Cell { shade: 1.0 - 0.5 * depth(one), label: format!("{:.2}", depth(one)) }),
            ]
        };
        backends.iter().flat_map(of).collect()
    };
    let head = |backend: &Backend| (backend.to_string(), ["leaks", "deepest"].map(str::to_owned).to_vec());
    HeatMap {
        title: format!("What gets through walls, {}", method.name()),
        notes: vec![
            format!(
                "Spacing {} m, walls that are sheets as thick; 240 looks a second at particles, beside slow paddles 60.",
                trials::SPACING
            ),
            "leaks: particles that went through, of 500 to 4,600 and of 10,000 shots (short form: 1,000).".to_owned(),
            "deepest: how far one got into a solid, in spacings, where that can be told; samples lie 0.92 deep."
                .to_owned(),
        ],
        columns: backends.iter().map(head).collect(),
        rows: rows.collect(),
        cells: first.iter().map(cells).collect(),
    }
}
