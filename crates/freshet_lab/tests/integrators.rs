//! `integrators` in its quick form, and the two solvers with each integrator from the same states.

use freshet_core::integrator::Integrator;
use freshet_core::prelude::*;
use freshet_cpu::{CpuOptions, CpuSolver};
use freshet_gpu::{DeviceRequest, GpuOptions, GpuSolver, open_device};
use freshet_lab::commands::integrators::{IntegratorsArgs, run, stepped};
use freshet_lab::error::LabError;
use freshet_lab::options::{BackendChoice, CommonOptions};

#[test]
fn the_quick_form_keeps_its_bounds_and_writes_what_it_says() -> Result<(), LabError> {
    let folder = std::env::temp_dir().join(format!("freshet_lab_integrators_{}", std::process::id()));
    let common = CommonOptions { quick: true, backend: Some(BackendChoice::Cpu), out: folder.clone() };
    let verdict = run(&IntegratorsArgs { common, threads: Default::default() })?;
    assert!(verdict.passes(), "\n{verdict}");
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).map_err(LabError::file(&folder));
    for (name, lines) in [
        ("integrators.csv", 2 * Integrator::ALL.len()),
        ("integrators_pirovano_2011.csv", 9 + 9 + 9 + 7),
        ("integrators_dam_break.csv", stepped().len()),
    ] {
        let text = read(name)?;
        assert_eq!(text.lines().filter(|line| !line.starts_with('#')).count(), 1 + lines, "{text}");
    }
    assert!(read("integrators.svg")?.contains("spectral radius"));
    std::fs::remove_dir_all(&folder).map_err(LabError::file(&folder))
}

/// Fluid that collapses in an open box.
fn scene(integrator: Integrator) -> FluidScene {
    let mut scene = FluidScene {
        volumes: vec![Volume::block(Vec3::new(0.25, 0.3, 0.2), Vec3::new(0.25, 0.3, 0.2))],
        boundaries: vec![Boundary::open_box(Vec3::new(1.0, 0.8, 0.4), Vec3::new(0.5, 0.4, 0.2))],
        ..FluidScene::with_spacing(0.05)
    };
    scene.settings.integrator = integrator;
    scene
}

/// From the CPU's state after 0.2 s, three substeps of different length: positions, velocities and what particles keep, relative to the way of a
/// substep, the largest speed and the largest number kept.
#[test]
fn both_solvers_make_the_same_steps_with_every_integrator() {
    let device = open_device(DeviceRequest::default()).unwrap();
    for integrator in stepped() {
        let plan = Plan::new(&scene(integrator)).unwrap();
        let mut cpu = CpuSolver::new(plan.clone(), CpuOptions::default()).unwrap();
        let mut gpu = GpuSolver::new(&device.device, &device.queue, plan, GpuOptions::default()).unwrap();
        let input = |tick, duration| StepInput { tick, duration, ..StepInput::default() };
        for tick in 0..12 {
            cpu.step(&input(tick, 1.0 / 60.0)).unwrap();
        }
        gpu.restore(&cpu.snapshot().unwrap()).unwrap();
        for (tick, duration) in [(12, 3e-4), (13, 2e-4), (14, 3.5e-4)] {
            let counts = [cpu.step(&input(tick, duration)).unwrap(), gpu.step(&input(tick, duration)).unwrap()];
            assert_eq!(counts.map(|report| report.substeps), [1, 1], "{}", integrator.name());
        }
        let (a, b) = (cpu.snapshot().unwrap(), gpu.snapshot().unwrap());
        assert_eq!((&a.ids, a.integrator, a.histories.len()), (&b.ids, b.integrator, b.histories.len()));
        let fastest = a.velocities.iter().map(|v| v.length()).fold(0.0, f32::max);
        let largest =
            |pairs: &mut dyn Iterator<Item = (Vec3, Vec3)>| pairs.map(|(a, b)| (a - b).length()).fold(0.0, f32::max);
        let velocity = largest(&mut a.velocities.iter().copied().zip(b.velocities.iter().copied()));
        let position = largest(&mut a.positions.iter().copied().zip(b.positions.iter().copied()));
        // Sums of some thirty terms in another order, three times; positions of a metre have roundings of 6e-8 m.
        assert!(velocity < 1e-4 * fastest, "{}: velocities differ by {velocity} of {fastest}", integrator.name());
        assert!(position < 1e-4 * fastest * 8.5e-4 + 4e-7, "{}: positions differ by {position}", integrator.name());
        let most = a.histories.iter().fold(0.0f32, |most, value| most.max(value.abs()));
        let apart = a.histories.iter().zip(&b.histories).fold(0.0f32, |most, (a, b)| most.max((a - b).abs()));
        assert!(apart <= 1e-3 * most, "{}: what is kept differs by {apart} of {most}", integrator.name());
    }
}
