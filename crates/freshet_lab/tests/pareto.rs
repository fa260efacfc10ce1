//! `pareto`: the quick form of the command, scenes on both backends, and what the source tree holds of the recorded chart.

use std::path::{Path, PathBuf};
use std::time::Duration;

use freshet_core::configuration::Configuration;
use freshet_core::fidelity::{FAST, FluidFidelity, MEASURED};
use freshet_core::plan::Plan;
use freshet_core::scene::{Body, Boundary, FluidScene, Friction, Volume};
use freshet_lab::backend::Backend;
use freshet_lab::commands::pareto::scenes::{CHOSEN_BY, HELD_OUT, Job};
use freshet_lab::commands::pareto::{Failure, ParetoArgs, choices, document, front, read, run, table_of_fidelity};
use freshet_lab::error::LabError;
use freshet_lab::options::{BackendChoice, CommonOptions};
use freshet_lab::output::Output;
use glam::Vec3;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn text(path: &Path) -> Result<String, LabError> {
    std::fs::read_to_string(path).map_err(LabError::file(path))
}

fn job(configuration: &str, backend: Backend, cap: u64) -> Result<Job, LabError> {
    let configuration = Configuration::named(configuration)?;
    Ok(Job { configuration, across: 12, backend, cap: Duration::from_secs(cap) })
}

#[test]
fn the_table_and_the_document_are_what_the_recorded_chart_gives() -> Result<(), LabError> {
    let points = read(&Output::new(&root().join("docs/charts"))?)?;
    let again = "write them with `freshet_lab pareto --redraw --out docs/charts --sources .`";
    let table = text(&root().join("crates/freshet_core/src/fidelity/measured.rs"))?;
    assert!(
        table == table_of_fidelity(&points)?,
        "the table of FluidFidelity is not that of docs/charts/pareto.csv: {again}"
    );
    assert!(text(&root().join("docs/methods.md"))? == document(&points)?, "docs/methods.md is not up to date: {again}");
    // What `peers` holds the cheapest preset to.
    let fast =
        points.iter().filter(|point| point.backend == Backend::Cpu && point.configuration.name == FAST.configuration);
    let fronts: Vec<f64> = fast.filter_map(|point| point.trials[0].parts.as_ref().ok()?.first().copied()).collect();
    assert!(fronts.len() == 2 && fronts.iter().all(|front| *front <= 0.05), "{fronts:?}");
    // What is compiled is what is written.
    let choices = choices(&points);
    let on_front = front(&choices, Backend::Cpu);
    assert_eq!(on_front.len(), MEASURED.len());
    for (point, row) in on_front.iter().zip(&MEASURED) {
        assert_eq!((point.configuration.name, point.across), (row.configuration, row.finest));
        assert!(point.error().is_some_and(|error| (error as f32 / row.error - 1.0).abs() < 1e-3), "{row:?}");
    }
    Ok(())
}

/// Whoever names an error does not know what is chosen: it has to go with all that a scene may have.
#[test]
fn what_is_offered_goes_with_bodies_and_rough_walls_on_both_backends() -> Result<(), LabError> {
    let half = Vec3::splat(0.25);
    let body = Body { samples: vec![Vec3::X * 0.1, Vec3::NEG_X * 0.1], ..Body::default() };
    let scene = FluidScene {
        volumes: vec![Volume::block(half, half)],
        boundaries: vec![Boundary::open_box(Vec3::ONE, Vec3::splat(0.5)).with_friction(Friction::coulomb(0.5))],
        bodies: vec![body],
        ..FluidScene::with_spacing(0.0625)
    };
    for row in &MEASURED {
        let plan = Plan::new(&Configuration::named(row.configuration)?.on(&scene)?)?;
        freshet_gpu::check(&plan)?;
    }
    Ok(())
}

#[test]
fn presets_hold_the_error_they_are_named_by_where_they_were_not_chosen() -> Result<(), LabError> {
    for preset in FluidFidelity::PRESETS {
        let named = preset.choice()?;
        let job = Job { across: named.finest, ..job(named.configuration, Backend::Cpu, 300)? };
        let error = (HELD_OUT.simulate)(&job)?.error().unwrap_or(f64::INFINITY);
        assert!(error <= f64::from(named.error), "{preset:?}: {error} of {named:?}");
    }
    Ok(())
}

#[test]
fn the_quick_form_charts_cost_against_error_and_failures_as_failures() -> Result<(), LabError> {
    let folder = std::env::temp_dir().join(format!("freshet_lab_pareto_quick_{}", std::process::id()));
    let common = CommonOptions { quick: true, backend: None, out: folder.clone() };
    let (threads, configurations, across) = (Default::default(), Vec::new(), Vec::new());
    let sources = Some(folder.join("tree"));
    let args = ParetoArgs { common, threads, configurations, across, cap: 120, sources, redraw: false };
    let jobs = args.jobs(Backend::Cpu);
    let verdict = run(&args)?;
    assert!(verdict.passes() && verdict.checks.len() == 4, "\n{verdict}");
    let points = read(&Output::new(&folder)?)?;
    assert_eq!(points.len(), jobs.len());
    let named = |name: &str| {
        let found = points.iter().find(|point| point.configuration.name == name);
        found.unwrap_or_else(|| panic!("{name} was not run"))
    };
    for name in ["tait", "dfsph"] {
        let (cost, error) = named(name).place().unwrap_or_else(|| panic!("{name} fails: {:?}", named(name)));
        assert!(cost > 0.0 && (0.001..0.1).contains(&error), "{name}: {cost} s, {error}");
        for (scene, trial) in CHOSEN_BY.iter().zip(&named(name).trials) {
            let error = trial.error().unwrap_or(f64::NAN);
            // Waves swing a tenth too fast with the default support, as the lattice's shear moduli say.
            let most = if scene.name == "wave" { 0.1 } else { 0.06 };
            assert!(error < most, "{name} on the {}: {error}", scene.title);
        }
    }
    let failures = |name: &str| named(name).trials.iter().filter_map(|trial| trial.failure()).collect::<Vec<_>>();
    assert_eq!(failures("forward-euler"), [Failure::Refused; 5]);
    assert!(failures("ideal-gas").contains(&Failure::Lost), "{:?}", failures("ideal-gas"));
    let svg = text(&folder.join("pareto.svg"))?;
    assert!(svg.contains("Refused before they start: forward-euler") && svg.contains("Accurate"), "{svg}");
    for file in ["tree/docs/methods.md", "tree/crates/freshet_core/src/fidelity/measured.rs"] {
        assert!(text(&folder.join(file))?.contains("dfsph"), "{file}");
    }

    // A configuration by name replaces its own points only, and another backend none of them.
    let configurations = vec![Configuration::named("forward-euler")?];
    run(&ParetoArgs { configurations: configurations.clone(), sources: None, ..args.clone() })?;
    assert_eq!(read(&Output::new(&folder)?)?, points);
    let common = CommonOptions { backend: Some(BackendChoice::Gpu), ..args.common.clone() };
    run(&ParetoArgs { common, configurations, sources: None, ..args })?;
    let both = read(&Output::new(&folder)?)?;
    assert_eq!(both[..points.len()], points);
    assert_eq!((both.len(), both[points.len()].backend), (points.len() + 1, Backend::Gpu));
    std::fs::remove_dir_all(&folder).map_err(LabError::file(&folder))
}

#[test]
fn a_run_longer_than_allowed_is_too_slow() -> Result<(), LabError> {
    let trial = (CHOSEN_BY[1].simulate)(&job("tait", Backend::Cpu, 0)?)?;
    assert_eq!(trial.failure(), Some(Failure::TooSlow));
    assert!(trial.cost.is_some_and(|cost| cost > 0.0), "{trial:?}");
    Ok(())
}

/// The ball alone: the dam break takes a minute on a driver in software.
#[test]
fn the_gpu_is_as_far_off_as_the_cpu() -> Result<(), LabError> {
    for name in ["tait", "dfsph"] {
        let error = |backend| -> Result<f64, LabError> {
            Ok((CHOSEN_BY[2].simulate)(&job(name, backend, 300)?)?.error().unwrap_or(f64::NAN))
        };
        let (cpu, gpu) = (error(Backend::Cpu)?, error(Backend::Gpu)?);
        assert!((cpu - gpu).abs() < 2e-3, "{name}: {cpu} on the CPU, {gpu} on the GPU");
    }
    Ok(())
}
