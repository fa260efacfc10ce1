//! Table, CSV and chart of the peers.

use super::{Kept, Peer, Run};
use crate::chart::{self, Chart, Colour, Mark, Panel, Scale, Series};
use crate::date::today;
use crate::error::LabError;
use crate::measure::statistics::{median, spread};
use crate::output::{Csv, Output};
use crate::reference::martin_moyce_1952::SQUARE;
use crate::scenes::GRAVITY;
use crate::table::Table;

/// A row a run; cost against compression, and the front.
pub const FILES: [&str; 2] = ["peers.csv", "peers.svg"];

/// Writes all files anew.
pub fn write(output: &Output, runs: &[Run]) -> Result<(), LabError> {
    output.write(FILES[0], csv(runs, &today()).text())?;
    chart::draw(output, FILES[1], &chart(runs))?;
    Ok(())
}

/// The peers, each once, in order.
fn peers(runs: &[Run]) -> Vec<Peer> {
    let mut peers: Vec<Peer> = Vec::new();
    for run in runs {
        if !peers.contains(&run.peer) {
            peers.push(run.peer);
        }
    }
    peers
}

fn of(runs: &[Run], peer: Peer) -> impl Iterator<Item = &Run> {
    runs.iter().filter(move |run| run.peer == peer)
}

fn middle(values: impl IntoIterator<Item = f64>) -> f64 {
    median(&values.into_iter().collect::<Vec<_>>()).unwrap_or(f64::NAN)
}

/// Cost over that of the first peer, repeat by repeat.
fn ratios(runs: &[Run], peer: Peer) -> Vec<f64> {
    let Some(first) = runs.first().map(|run| run.peer) else { return Vec::new() };
    let pairs = of(runs, peer).filter_map(|run| {
        let base = of(runs, first).find(|base| base.repeat == run.repeat)?;
        Some(run.cost() / base.cost())
    });
    pairs.collect()
}

/// A row a peer: medians over the repeats.
pub fn table(runs: &[Run]) -> Table {
    let mut table = Table::new([
        "system",
        "settings",
        "s/s",
        "over the first",
        "steps",
        "us/(p step)",
        "compr. % mean",
        "99th",
        "max",
        "volume lost %",
        "front at 0.1, 0.2... s (m)",
    ]);
    for peer in peers(runs) {
        let runs_of = || of(runs, peer);
        let Some(last) = runs_of().last() else { continue };
        let ratios = ratios(runs, peer);
        let (least, most) = spread(&ratios).unwrap_or((f64::NAN, f64::NAN));
        let per_step = |run: &Run| 1e6 * run.wall / run.steps as f64 / f64::from(run.particles);
        let fronts: Vec<String> = last.front.iter().map(|front| format!("{front:.3}")).collect();
        table.row([
            format!("{} {}", peer.system(), last.version),
            peer.settings(),
            format!("{:.2}", middle(runs_of().map(Run::cost))),
            format!("{:.2} ({least:.2} to {most:.2})", middle(ratios)),
            last.steps.to_string(),
            format!("{:.3}", middle(runs_of().map(per_step))),
            format!("{:.3}", middle(runs_of().map(|run| run.crowding.mean))),
            format!("{:.2}", middle(runs_of().map(|run| run.crowding.percentile_99))),
            format!("{:.1}", middle(runs_of().map(|run| run.crowding.maximum))),
            format!("{:.3}", middle(runs_of().map(|run| run.crowding.lost_volume))),
            fronts.join(" "),
        ]);
    }
    table
}

fn csv(runs: &[Run], date: &str) -> Csv {
    let comment = format!(
        "Systems in the benchmark tank, {date}: \
         `cargo run --release -p freshet_lab --features peers -- peers`; wall time of the stepping alone; compression by one \
         cubic-spline sum for all, mean over frames of 0.05 s, its maximum over all of them. Ratios are repeat by repeat, the median \
         and the spread."
    );
    let columns = [
        "system",
        "version",
        "settings",
        "particles",
        "threads",
        "repeat",
        "simulated_s",
        "wall_s",
        "wall_per_simulated",
        "steps",
        "compression_mean_percent",
        "compression_99th_percent",
        "compression_max_percent",
        "lost_volume_percent",
        "lost_particles",
        "time_scale",
        "front_m",
    ];
    let over = |peer: &Peer| {
        let ratios = ratios(runs, *peer);
        let (least, most) = spread(&ratios).unwrap_or((f64::NAN, f64::NAN));
        let of = format!("{}, {}", peer.system(), peer.settings());
        format!("{of}: {:.2} ({least:.2} to {most:.2}) times the time of the first", middle(ratios))
    };
    let ratios: Vec<String> = peers(runs).iter().skip(1).map(over).collect();
    let mut csv = Csv::new(std::iter::once(comment.as_str()).chain(ratios.iter().map(String::as_str)), &columns);
    for run in runs {
        let fronts: Vec<String> = run.front.iter().map(|front| format!("{front:.4}")).collect();
        let kept = |text: fn(&Kept) -> String| run.kept.as_ref().map_or("unknown".to_owned(), text);
        csv.row([
            run.peer.system().to_owned(),
            run.version.clone(),
            run.peer.settings(),
            run.particles.to_string(),
            run.threads.to_string(),
            run.repeat.to_string(),
            format!("{:.2}", run.seconds),
            format!("{:.4}", run.wall),
            format!("{:.4}", run.cost()),
            run.steps.to_string(),
            format!("{:.4}", run.crowding.mean),
            format!("{:.4}", run.crowding.percentile_99),
            format!("{:.3}", run.crowding.maximum),
            format!("{:.4}", run.crowding.lost_volume),
            kept(|kept| kept.lost.to_string()),
            kept(|kept| format!("{:.4}", kept.time_scale)),
            fronts.join(" "),
        ]);
    }
    csv
}

/// A colour for each peer: ours in blue.
const COLOURS: [Colour; 7] = [
    Colour::BLUES[2],
    Colour(0x9b, 0x59, 0xb6),
    Colour::BLUES[1],
    Colour(0xc7, 0x8f, 0xdd),
    Colour(0x2e, 0x8b, 0x57),
    Colour::ORANGE,
    Colour::RED,
];

fn chart(runs: &[Run]) -> Chart {
    let peers = peers(runs);
    let coloured = || peers.iter().zip(COLOURS.into_iter().cycle());
    let points = coloured().map(|(&peer, colour)| Series {
        name: peer.short(),
        mark: Mark::Circles(7),
        colour,
        points: of(runs, peer).map(|run| (run.crowding.mean, run.cost())).collect(),
    });
    let points: Vec<Series> = points.collect();
    let widest = points.iter().flat_map(|series| &series.points).map(|point| point.0).fold(0.1, f64::max);
    let cost = Panel {
        title: "left and low is better".to_owned(),
        notes: Vec::new(),
        x_label: "mean compression, %".to_owned(),
        y_label: "wall seconds per simulated second".to_owned(),
        x_scale: Scale::Linear,
        x: (0.0, 1.1 * widest),
        y_scale: Scale::Linear,
        y: (0.0, 1.0),
        series: points,
    };
    let fronts = coloured().map(|(&peer, colour)| Series {
        name: peer.short(),
        mark: Mark::Line(2),
        colour,
        points: of(runs, peer).last().map(front_points).unwrap_or_default(),
    });
    // n^2 = 1, a = 1 m: Z = x / a over T = t sqrt(g / a).
    let measured = SQUARE.points.iter().map(|&(t, z)| (t / GRAVITY.sqrt(), z));
    let seconds = runs.iter().map(|run| run.seconds).fold(0.1, f64::max);
    let experiment = Series {
        name: "Martin & Moyce 1952".to_owned(),
        mark: Mark::Circles(4),
        colour: Colour::INK,
        points: measured.filter(|point| point.0 <= seconds).collect(),
    };
    let front = Panel {
        title: "front of the water".to_owned(),
        notes: Vec::new(),
        x_label: "time, s".to_owned(),
        y_label: "front, m".to_owned(),
        x_scale: Scale::Linear,
        x: (0.0, seconds),
        y_scale: Scale::Linear,
        y: (1.0, 2.05),
        series: fronts.chain([experiment]).collect(),
    };
    let particles = runs.first().map_or(0, |run| run.particles);
    let title = format!("The benchmark tank with {particles} particles, one run of all systems");
    Chart { title, panels: vec![cost.fitted(0.0), front], size: (1560, 560) }
}

fn front_points(run: &Run) -> Vec<(f64, f64)> {
    let later = run.front.iter().enumerate().map(|(index, &front)| (0.1 * (index + 1) as f64, front));
    [(0.0, 1.0)].into_iter().chain(later).collect()
}

#[cfg(test)]
mod tests {
    use super::super::tests::measured_run;
    use super::*;
    use crate::backend::Backend;
    use crate::method::Method;

    #[test]
    fn ratios_pair_runs_of_the_same_repeat() {
        let ours =
            |repeat, seconds| measured_run(Peer::Freshet(Backend::Cpu, Method::WeaklyCompressible), repeat, seconds);
        let theirs = |repeat, seconds| measured_run(Peer::Salva { tolerance: 0.05 }, repeat, seconds);
        let runs = [ours(1, 1.0), theirs(1, 3.0), ours(2, 2.0), theirs(2, 8.0)];
        assert_eq!(ratios(&runs, runs[1].peer), [3.0, 4.0]);
        let text = table(&runs).to_string();
        assert!(text.contains("3.50 (3.00 to 4.00)"), "{text}");
        let text = csv(&runs, "2026-01-02").text().to_owned();
        assert_eq!(text.lines().count(), 7, "{text}");
        assert!(text.contains(": 3.50 (3.00 to 4.00) times the time of the first\n"), "{text}");
        assert_eq!(text.matches(",0,1.0000,").count(), 2, "ours say what they lost: {text}");
        assert_eq!(text.matches(",unknown,unknown,").count(), 2, "{text}");
        assert!(text.starts_with("# Systems in the benchmark tank, 2026-01-02"), "{text}");
        assert_eq!(chart(&runs).panels[1].series.len(), 3);
    }
}
