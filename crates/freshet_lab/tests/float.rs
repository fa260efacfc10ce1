//! One ball floats: the command's own bounds, at every latency on the CPU and at two on the GPU.

use freshet_lab::backend::Backend;
use freshet_lab::commands::float::{Case, Latency, Pool, Run, simulate, verdict};
use freshet_lab::error::LabError;
use freshet_lab::progress::Progress;

/// The ball of six spacings.
fn float(backend: Backend, latency: Latency, seconds: f64) -> Result<Run, LabError> {
    let pool = Pool::for_ball(6).unwrap_or_else(|| unreachable!("six is one of the two sizes"));
    let case = Case { backend, pool, latency, seconds };
    simulate(&case, |plan| backend.open(plan, None), &mut Progress::hidden())
}

fn assert_floats(backend: Backend, latency: Latency) -> Result<(), LabError> {
    let verdict = verdict(&[float(backend, latency, 4.0)?]);
    println!("{verdict}");
    assert!(verdict.passes(), "\n{verdict}");
    Ok(())
}

#[test]
fn in_lockstep_on_the_cpu() -> Result<(), LabError> {
    assert_floats(Backend::Cpu, Latency::Lockstep)
}

#[test]
fn one_tick_late_on_the_cpu() -> Result<(), LabError> {
    assert_floats(Backend::Cpu, Latency::Ticks(1))
}

#[test]
fn two_ticks_late_on_the_cpu() -> Result<(), LabError> {
    assert_floats(Backend::Cpu, Latency::Ticks(2))
}

#[test]
fn three_ticks_late_on_the_cpu() -> Result<(), LabError> {
    assert_floats(Backend::Cpu, Latency::Ticks(3))
}

/// The impulse of a tick that is there before rapier steps needs no forecast: zero ticks late is lockstep, to the bit.
#[test]
fn no_tick_late_is_lockstep() -> Result<(), LabError> {
    let (lockstep, late) = (Latency::Lockstep, Latency::Ticks(0));
    let heights = |latency| -> Result<_, LabError> { Ok(float(Backend::Cpu, latency, 0.25)?.height) };
    assert_eq!(heights(lockstep)?, heights(late)?);
    Ok(())
}

/// Chaos parts the water's particles, not the ball: lateness moves it by less than a tenth of a spacing in the mean, while it
/// falls by six tenths.
#[test]
fn late_and_in_time_fall_alike() -> Result<(), LabError> {
    let lockstep = float(Backend::Cpu, Latency::Lockstep, 1.0)?;
    let late = float(Backend::Cpu, Latency::Ticks(2), 1.0)?;
    let (from, count) = (0.2, 48.0);
    let mean = |run: &Run| run.height.values_from(from).sum::<f64>() / count;
    assert!((mean(&lockstep) - mean(&late)).abs() < 0.005, "{} {}", mean(&lockstep), mean(&late));
    Ok(())
}

#[test]
fn two_ticks_late_on_the_gpu() -> Result<(), LabError> {
    assert_floats(Backend::Gpu, Latency::Ticks(2))
}

#[test]
fn in_lockstep_on_the_gpu_as_on_the_cpu() -> Result<(), LabError> {
    let (gpu, cpu) = (float(Backend::Gpu, Latency::Lockstep, 1.0)?, float(Backend::Cpu, Latency::Lockstep, 1.0)?);
    assert!(gpu.ledger < 1e-4 && gpu.momentum < 1e-4, "{} {}", gpu.ledger, gpu.momentum);
    for (&(time, gpu), &(_, cpu)) in gpu.height.samples().iter().zip(cpu.height.samples()) {
        assert!((gpu - cpu).abs() < 0.01, "{time} s: {gpu} m on the GPU, {cpu} m on the CPU");
    }
    Ok(())
}
