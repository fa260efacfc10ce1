//! One ball floats: the command's own bounds, at every latency on the CPU and at two on the GPU.
//!
//! Tests run side by side, so that each solver has one thread; what it finds does not depend on that.

use freshet_lab::backend::Backend;
use freshet_lab::commands::float::{Case, Latency, Pool, Run, simulate, verdict};
use freshet_lab::error::LabError;
use freshet_lab::method::Method;
use freshet_lab::progress::Progress;

/// The ball of six spacings.
fn float(backend: Backend, latency: Latency, seconds: f64) -> Result<Run, LabError> {
    float_by(Method::WeaklyCompressible, backend, latency, seconds)
}

fn float_by(method: Method, backend: Backend, latency: Latency, seconds: f64) -> Result<Run, LabError> {
    let pool = Pool::for_ball(6).unwrap_or_else(|| unreachable!("six is one of the two sizes"));
    let case = Case { backend, method, pool, latency, seconds };
    simulate(&case, |plan| backend.open(plan, Some(1)), &mut Progress::hidden())
}

/// Floats the ball for 4 s; returns the run, so that more can be asked of it.
fn assert_floats(backend: Backend, latency: Latency) -> Result<Run, LabError> {
    let run = float(backend, latency, 4.0)?;
    let verdict = verdict(std::slice::from_ref(&run));
    println!("{verdict}");
    assert!(verdict.passes(), "\n{verdict}");
    Ok(run)
}

/// Also: the impulse of a tick that is there before rapier steps needs no forecast, so zero ticks late is lockstep, to the bit.
/// And the GPU's ball falls as the CPU's does.
#[test]
fn in_lockstep_on_the_cpu_and_as_it_on_the_gpu() -> Result<(), LabError> {
    let lockstep = assert_floats(Backend::Cpu, Latency::Lockstep)?;
    let at_once = float(Backend::Cpu, Latency::Ticks(0), 0.25)?;
    assert!(!at_once.height.samples().is_empty());
    assert!(lockstep.height.samples().starts_with(at_once.height.samples()));

    let gpu = float(Backend::Gpu, Latency::Lockstep, 1.0)?;
    assert!(gpu.ledger < 1e-4 && gpu.momentum < 1e-4, "{} {}", gpu.ledger, gpu.momentum);
    for (&(time, gpu), &(_, cpu)) in gpu.height.samples().iter().zip(lockstep.height.samples()) {
        assert!((gpu - cpu).abs() < 0.01, "{time} s: {gpu} m on the GPU, {cpu} m on the CPU");
    }
    Ok(())
}

#[test]
fn one_tick_late_on_the_cpu() -> Result<(), LabError> {
    assert_floats(Backend::Cpu, Latency::Ticks(1)).map(|_| ())
}

/// Chaos parts the water's particles, not the ball: lateness moves it by less than a tenth of a spacing in the mean of the first
/// second, while it falls by six tenths.
#[test]
fn two_ticks_late_on_the_cpu_it_falls_as_in_time() -> Result<(), LabError> {
    let late = assert_floats(Backend::Cpu, Latency::Ticks(2))?;
    let lockstep = float(Backend::Cpu, Latency::Lockstep, 1.0)?;
    let mean = |run: &Run| {
        let heights = run.height.samples().iter().filter(|(time, _)| (0.2..=1.0).contains(time));
        let (count, sum) = heights.fold((0, 0.0), |(count, sum), (_, height)| (count + 1, sum + height));
        assert!((48..=49).contains(&count), "{count} ticks");
        sum / f64::from(count)
    };
    assert!((mean(&lockstep) - mean(&late)).abs() < 0.005, "{} {}", mean(&lockstep), mean(&late));
    Ok(())
}

#[test]
fn three_ticks_late_on_the_cpu() -> Result<(), LabError> {
    assert_floats(Backend::Cpu, Latency::Ticks(3)).map(|_| ())
}

#[test]
fn two_ticks_late_on_the_gpu() -> Result<(), LabError> {
    assert_floats(Backend::Gpu, Latency::Ticks(2)).map(|_| ())
}

/// By the same bounds as in a weakly compressible fluid.
fn assert_floats_incompressible(backend: Backend, latency: Latency) -> Result<(), LabError> {
    let run = float_by(Method::DivergenceFree, backend, latency, 4.0)?;
    let verdict = verdict(std::slice::from_ref(&run));
    println!("{verdict}");
    assert!(verdict.passes(), "{latency}\n{verdict}");
    Ok(())
}

#[test]
fn in_an_incompressible_fluid_in_time_and_late() -> Result<(), LabError> {
    assert_floats_incompressible(Backend::Cpu, Latency::Lockstep)?;
    assert_floats_incompressible(Backend::Cpu, Latency::Ticks(2))
}

#[test]
fn in_an_incompressible_fluid_on_the_gpu() -> Result<(), LabError> {
    assert_floats_incompressible(Backend::Gpu, Latency::Ticks(2))
}
