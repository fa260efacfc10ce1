//! `stability`: what survives a step, and the quick form of the whole command.

use freshet_lab::backend::Backend;
use freshet_lab::commands::stability::{Configuration, Failure, Situation, StabilityArgs, run, survives};
use freshet_lab::error::LabError;
use freshet_lab::options::{BackendChoice, CommonOptions};

/// The plan's own factor, and one that no explicit step can bear: what fails is named.
fn assert_bracketed(backend: Backend, situation: Situation) -> Result<(), LabError> {
    let configuration = Configuration::of_defaults(backend, situation);
    assert!(configuration.is_default());
    assert_eq!(survives(&configuration, 0.4)?, None, "{configuration} at the plan's own step");
    let failure = survives(&configuration, 3.5)?;
    assert!(
        matches!(failure, Some(Failure::Energy | Failure::Compression | Failure::Lost | Failure::NotFinite)),
        "{configuration}: {failure:?}"
    );
    Ok(())
}

#[test]
fn the_default_step_is_stable_and_a_long_one_is_not_on_the_cpu() -> Result<(), LabError> {
    assert_bracketed(Backend::Cpu, Situation::Violent)?;
    assert_bracketed(Backend::Cpu, Situation::Calm)
}

/// The quick form of the command: every configuration of it has a limit between the smallest step tried and the largest, and is in the map.
fn assert_maps(choice: BackendChoice, backend: Backend) -> Result<(), LabError> {
    let folder = std::env::temp_dir().join(format!("freshet_lab_stability_{backend}_{}", std::process::id()));
    let common = CommonOptions { quick: true, backend: Some(choice), out: folder.clone() };
    let args = StabilityArgs { common, threads: Default::default(), options: Vec::new() };
    let configurations = args.configurations(backend);
    let verdict = run(&args)?;
    assert!(verdict.passes() && verdict.checks.len() == 2, "\n{verdict}");
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).map_err(LabError::file(&folder));
    let csv = read("stability.csv")?;
    let rows: Vec<Vec<&str>> =
        csv.lines().filter(|line| !line.starts_with('#')).map(|line| line.split(',').collect()).collect();
    assert!(configurations.len() >= 2 && rows.len() == 1 + configurations.len(), "{csv}");
    let svg = read("stability.svg")?;
    for (row, configuration) in rows[1..].iter().zip(&configurations) {
        assert_eq!(
            row[..4],
            [backend.name(), configuration.situation.name(), configuration.option.name(), configuration.kernel.name()]
        );
        let stable: f64 = row[6].parse().unwrap_or(f64::NAN);
        assert!((0.1..4.0).contains(&stable) && row[7] != "none", "{row:?}");
        assert!(svg.contains(&format!("{stable:.2} ")), "{stable} is not in the map");
    }
    std::fs::remove_dir_all(&folder).map_err(LabError::file(&folder))
}

#[test]
fn the_quick_form_finds_and_draws_a_limit_of_every_configuration_on_the_cpu() -> Result<(), LabError> {
    assert_maps(BackendChoice::Cpu, Backend::Cpu)
}

#[test]
fn the_quick_form_finds_and_draws_a_limit_of_every_configuration_on_the_gpu() -> Result<(), LabError> {
    assert_maps(BackendChoice::Gpu, Backend::Gpu)
}
