//! `leaks` in its short form, and proof that it would see a leak.

use freshet_lab::backend::Backend;
use freshet_lab::commands::leaks::{Trial, simulate, trials, verdict};
use freshet_lab::error::LabError;
use freshet_lab::method::Method;
use freshet_lab::progress::Progress;

fn named(text: &str) -> Result<Trial, LabError> {
    let found = trials(true)?.into_iter().find(|trial| trial.name().contains(text));
    Ok(found.unwrap_or_else(|| panic!("there is no trial of {text}")))
}

fn holds(texts: &[&str], backend: Backend, method: Method) -> Result<(), LabError> {
    let found = texts
        .iter()
        .map(|text| simulate(&named(text)?, backend, method, Some(1), &mut Progress::hidden()))
        .collect::<Result<Vec<_>, _>>()?;
    let verdict = verdict(&found);
    assert!(verdict.passes(), "{verdict}");
    Ok(())
}

#[test]
fn nothing_leaks_on_the_cpu() -> Result<(), LabError> {
    let trials = ["plate", "cup of water pulled", "piston", "paddle", "bowl", "valley", "turned over", "a cone,"];
    Method::ALL.into_iter().try_for_each(|method| holds(&trials, Backend::Cpu, method))
}

/// A sheet, a body that moves, a height field, and single particles at a cone: one of each kind, as the GPU here may be a driver on the processor.
#[test]
fn nothing_leaks_on_the_gpu() -> Result<(), LabError> {
    let trials = ["plate", "piston", "valley", "a cone,"];
    Method::ALL.into_iter().try_for_each(|method| holds(&trials, Backend::Gpu, method))
}

/// Without what holds them, particles are counted: through a plate that is not there, and a paddle of one sample.
#[test]
fn a_leak_is_seen() -> Result<(), LabError> {
    let count = |mut trial: Trial, change: fn(&mut Trial)| {
        change(&mut trial);
        simulate(&trial, Backend::Cpu, Method::WeaklyCompressible, Some(1), &mut Progress::hidden())
            .map(|found| found.leaks)
    };
    let plate = count(named("plate")?, |trial| {
        trial.scene.boundaries.pop();
    })?;
    assert!(plate > 900, "{plate} of 1000 fall through a plate that is not there");
    let paddle = count(named("paddle")?, |trial| trial.scene.bodies[0].samples.truncate(1))?;
    assert!(paddle > 500, "{paddle} go through a paddle of one sample");
    Ok(())
}
