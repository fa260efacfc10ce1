//! The column at rest with the command's own bounds, on both backends.
//!
//! Tests run side by side, so that each solver has one thread; what it finds does not depend on that.

use freshet_lab::backend::Backend;
use freshet_lab::commands::column::{simulate, verdict};
use freshet_lab::error::LabError;
use freshet_lab::progress::Progress;
use freshet_lab::scenes::column::Container;

fn assert_at_rest(backend: Backend, container: Container, seconds: f64) -> Result<(), LabError> {
    let verdict = verdict(&[simulate(backend, container, seconds, Some(1), &mut Progress::hidden())?]);
    println!("{verdict}");
    assert!(verdict.passes(), "\n{verdict}");
    Ok(())
}

#[test]
fn the_column_rests_on_the_cpu() -> Result<(), LabError> {
    assert_at_rest(Backend::Cpu, Container::Body, 10.0)
}

#[test]
fn the_column_rests_between_walls_on_the_cpu() -> Result<(), LabError> {
    assert_at_rest(Backend::Cpu, Container::Walls, 10.0)
}

#[test]
fn the_column_rests_on_the_gpu() -> Result<(), LabError> {
    assert_at_rest(Backend::Gpu, Container::Body, 10.0)
}

/// Half the time of the command's quick form, of which the last half second counts: the GPU here may be a driver on the processor.
#[test]
fn the_column_rests_between_walls_on_the_gpu() -> Result<(), LabError> {
    assert_at_rest(Backend::Gpu, Container::Walls, 1.0)
}
