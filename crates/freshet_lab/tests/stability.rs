//! `stability` in its quick form.

use freshet_core::kernel::KernelKind;
use freshet_lab::backend::Backend;
use freshet_lab::commands::stability::{Configuration, Failure, PressureOption, Situation, survives};
use freshet_lab::error::LabError;

fn configuration(backend: Backend, situation: Situation) -> Configuration {
    let (option, kernel) = (PressureOption::Tait, KernelKind::WendlandC2);
    Configuration { backend, option, kernel, neighbours: 32.0, sound: 10.0, situation }
}

/// The plan's own factor, and one that no explicit step can bear: what fails is named.
fn assert_bracketed(backend: Backend, situation: Situation) -> Result<(), LabError> {
    let configuration = configuration(backend, situation);
    assert!(configuration.is_default());
    assert_eq!(survives(&configuration, 0.4)?, None, "{configuration} at the plan's own step");
    let failure = survives(&configuration, 3.5)?;
    assert!(
        matches!(failure, Some(Failure::Energy | Failure::Compression | Failure::Lost)),
        "{configuration}: {failure:?}"
    );
    Ok(())
}

#[test]
fn the_default_step_is_stable_and_a_long_one_is_not_on_the_cpu() -> Result<(), LabError> {
    assert_bracketed(Backend::Cpu, Situation::Violent)?;
    assert_bracketed(Backend::Cpu, Situation::Calm)
}

#[test]
fn the_default_step_is_stable_and_a_long_one_is_not_on_the_gpu() -> Result<(), LabError> {
    assert_bracketed(Backend::Gpu, Situation::Violent)
}
