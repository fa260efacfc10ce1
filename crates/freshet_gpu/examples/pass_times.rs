//! Prints what each pass costs: `cargo run -p freshet_gpu --example pass_times -- 20 10` for a dam break of 20^3 x 8
//! particles and 10 ticks.

use freshet_core::prelude::*;
use freshet_gpu::{DeviceRequest, GpuOptions, GpuSolver, open_device};

/// CPU time of this process, s; zero where there is no /proc. On a software adapter it is what counts on a busy machine.
fn cpu_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = stat.rsplit(')').next().unwrap_or_default().split_whitespace();
    fields.skip(11).take(2).filter_map(|ticks| ticks.parse::<f64>().ok()).sum::<f64>() / 100.0
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1).filter_map(|argument| argument.parse::<u32>().ok());
    let edge = arguments.next().unwrap_or(10);
    let ticks = arguments.next().unwrap_or(4);
    let workgroup_size = arguments.next().unwrap_or(64);
    let opened = open_device(DeviceRequest { time_stamps: true, large_buffers: true })?;
    println!("{} ({:?})", opened.adapter.name, opened.adapter.device_type);
    let half = Vec3::splat(edge as f32 * 0.05);
    let scene = FluidScene {
        volumes: vec![Volume::block(half, half)],
        boundaries: vec![Boundary::open_box(half * Vec3::new(6.0, 3.0, 2.0), half * Vec3::new(3.0, 1.5, 1.0))],
        ..FluidScene::with_spacing(0.05)
    };
    let once = std::env::args().any(|argument| argument == "once");
    for time_stamps in if once { vec![false] } else { vec![false, true] } {
        let options = GpuOptions { time_stamps, workgroup_size, ..Default::default() };
        let plan = Plan::new(&scene)?;
        let (made, cpu) = (std::time::Instant::now(), cpu_seconds());
        let mut solver = GpuSolver::new(&opened.device, &opened.queue, plan, options)?;
        println!("made in {:.2} s, {:.2} s of CPU time", made.elapsed().as_secs_f32(), cpu_seconds() - cpu);
        let mut run = |first: u64, ticks: u64| -> Result<_, SolverError> {
            let (started, cpu) = (std::time::Instant::now(), cpu_seconds());
            let mut total = StepReport::default();
            for tick in first..first + ticks {
                let report = solver.step(&StepInput { tick, duration: 1.0 / 60.0, ..Default::default() })?;
                total.substeps += report.substeps;
                total.particles = report.particles;
                if total.passes.is_empty() {
                    total.passes = report.passes;
                } else {
                    for (sum, pass) in total.passes.iter_mut().zip(report.passes) {
                        sum.milliseconds += pass.milliseconds;
                    }
                }
            }
            Ok((total, started.elapsed().as_secs_f64(), cpu_seconds() - cpu))
        };
        // The first tick compiles.
        run(0, 1)?;
        let (total, seconds, cpu) = run(1, u64::from(ticks))?;
        let particle_steps = f64::from(total.particles) * f64::from(total.substeps);
        println!(
            "{} particles, {} substeps in {seconds:.3} s: {:.0} ns a particle-step, {:.0} ns of CPU time",
            total.particles,
            total.substeps,
            seconds * 1e9 / particle_steps,
            cpu * 1e9 / particle_steps
        );
        for pass in &total.passes {
            println!("  {:<20} {:>8.1} ns", pass.pass, f64::from(pass.milliseconds) * 1e6 / particle_steps);
        }
        if !time_stamps {
            println!("{}", solver.schedule());
        }
    }
    Ok(())
}
