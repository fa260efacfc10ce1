//! The quick forms of the commands that time. What they say of speed is not judged: tests share their machine.

use std::path::Path;

use clap::Parser;
use freshet_lab::commands::bench::{self, BenchArgs};
use freshet_lab::commands::peers::{self, PeersArgs};
use freshet_lab::error::LabError;

#[derive(Parser)]
struct Line<A: clap::Args> {
    #[command(flatten)]
    args: A,
}

fn parse<A: clap::Args>(folder: &Path, options: &[&str]) -> A {
    let out = folder.display().to_string();
    let line = ["lab", "--quick", "--out", &out].into_iter().chain(options.iter().copied());
    Line::try_parse_from(line).unwrap_or_else(|error| panic!("{error}")).args
}

/// Rows of a CSV file, comments and head left out.
fn rows(folder: &Path, name: &str) -> Result<Vec<String>, LabError> {
    let path = folder.join(name);
    let text = std::fs::read_to_string(&path).map_err(LabError::file(&path))?;
    Ok(text.lines().filter(|line| !line.starts_with('#')).skip(1).map(str::to_owned).collect())
}

#[test]
fn bench_times_the_tank_and_the_cube_on_both_backends() -> Result<(), LabError> {
    let folder = std::env::temp_dir().join(format!("freshet_lab_bench_{}", std::process::id()));
    let verdict = bench::run(&parse::<BenchArgs>(&folder, &["--seconds", "0.02"]))?;
    assert!(verdict.passes() && !verdict.checks.is_empty(), "\n{verdict}");
    let rows = rows(&folder, "bench.csv")?;
    for (scene, backend) in [("tank", "cpu"), ("tank", "gpu"), ("pirovano", "cpu")] {
        let of = |row: &&String| row.contains(scene) && row.contains(backend);
        assert!(rows.iter().any(|row| of(&row)), "no row of {scene} on {backend}: {rows:#?}");
    }
    std::fs::remove_dir_all(&folder).map_err(LabError::file(&folder))
}

#[test]
fn peers_runs_both_methods_and_says_who_is_missing() -> Result<(), LabError> {
    let folder = std::env::temp_dir().join(format!("freshet_lab_peers_{}", std::process::id()));
    let nobody = folder.join("no_python").display().to_string();
    let verdict = peers::run(&parse::<PeersArgs>(&folder, &["--python", &nobody, "--backend", "both"]))?;
    // Few particles are many beside walls, where the compression is, and nobody is there to be compared with: those bounds are the full form's.
    let of_full = |name: &str| ["99th percentile", "SPlisHSPlasH"].iter().any(|part| name.contains(part));
    let judged = || verdict.checks.iter().filter(|check| !of_full(&check.name));
    assert!(judged().count() >= 9 && judged().all(|check| check.passes()), "\n{verdict}");
    let rows = rows(&folder, "peers.csv")?;
    let freshet = rows.iter().filter(|row| row.starts_with("Freshet")).count();
    assert!(freshet >= 3 && !rows.iter().any(|row| row.starts_with("SPlisHSPlasH")), "{rows:#?}");
    std::fs::remove_dir_all(&folder).map_err(LabError::file(&folder))
}
