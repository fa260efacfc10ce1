//! salva3d (DFSPH), linked behind the feature `peers`.

use std::time::{Duration, Instant};

use glam::Vec3;
use salva3d::LiquidWorld;
use salva3d::kernel::CubicSplineKernel;
use salva3d::math::Vector;
use salva3d::object::interaction_groups::InteractionGroups;
use salva3d::object::{Boundary, Fluid};
use salva3d::solver::{ArtificialViscosity, DFSPHSolver};

use super::run::{FRAME_INTERVAL, Finished, Frame, Task};
use crate::error::LabError;
use crate::progress::Progress;
use crate::scenes::GRAVITY;

/// The version that Cargo.toml pins.
pub const VERSION: &str = "0.11.0";

type Point = Vector<f32>;

/// Runs the tank with a tolerance on density: a fraction, although salva's documentation says percent.
pub fn run(task: &Task, tolerance: f32, progress: &mut Progress) -> Result<Finished, LabError> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(task.threads)
        .build()
        .map_err(|error| LabError::Peer { peer: "salva3d", reason: error.to_string() })?;
    pool.install(|| simulate(task, tolerance, progress))
}

fn simulate(task: &Task, tolerance: f32, progress: &mut Progress) -> Result<Finished, LabError> {
    let d = task.spacing as f32;
    let mut world = LiquidWorld::new(DFSPHSolver::<CubicSplineKernel>::new(), d / 2.0, 2.0, 1.0);
    let accepted = world.dfsph_parameters().is_some_and(|mut parameters| {
        parameters.max_density_error = tolerance;
        world.set_dfsph_parameters(parameters)
    });
    if !accepted {
        return Err(LabError::Peer { peer: "salva3d", reason: "its solver does not take a tolerance".to_owned() });
    }
    let mut water = Fluid::new(block(d), d / 2.0, 1000.0, InteractionGroups::default());
    // Its own value is 0.8 d^3: the block would weigh 800 kg.
    water.volumes.fill(d * d * d);
    water.nonpressure_forces.push(Box::new(ArtificialViscosity::new(0.01, 0.0)));
    let water = world.add_fluid(water);
    world.add_boundary(Boundary::new(walls(d), InteractionGroups::default()));

    let (mut time, mut wall, mut steps) = (0.0, Duration::ZERO, 0_u64);
    let mut frames = Vec::new();
    let of_water = |world: &LiquidWorld| world.fluids().get(water).map(|fluid| fluid.velocities.clone());
    while frames.len() < task.frames() as usize {
        let next = (frames.len() + 1) as f64 * FRAME_INTERVAL;
        // It has no adaptive step: SPlisHSPlasH's rule with a factor of 0.5.
        let fastest = of_water(&world).unwrap_or_default().iter().map(Vector::norm).fold(0.0, f32::max);
        let speed = f64::from(fastest) + GRAVITY * 1e-3;
        let wanted: f64 = if steps == 0 { 1e-3 } else { (0.2 * task.spacing / speed).clamp(1e-4, 5e-3) };
        let dt = wanted.min(next - time);
        let start = Instant::now();
        world.step(dt as f32, &Point::new(0.0, -GRAVITY as f32, 0.0));
        wall += start.elapsed();
        time += dt;
        steps += 1;
        if time >= next - 1e-9 {
            time = next;
            let fluid = world.fluids().get(water);
            let positions = fluid.map(|fluid| fluid.positions.iter().map(|x| Vec3::new(x.x, x.y, x.z)).collect());
            frames.push(Frame { time, positions: positions.unwrap_or_default() });
        }
        progress.at(time / task.seconds);
    }
    Ok(Finished { wall, steps, frames, kept: None })
}

/// A cubic metre of water.
fn block(d: f32) -> Vec<Point> {
    let n = (1.0 / d).round() as usize;
    let at = |index: usize| (index as f32 + 0.5) * d;
    (0..n * n * n).map(|i| Point::new(at(i % n), at(i / n % n), at(i / (n * n)))).collect()
}

/// One layer of samples on the faces of the tank, 0.6 d outside: with 0.5 d the water starts 6 % too dense.
fn walls(d: f32) -> Vec<Point> {
    let outside = 0.6 * d;
    let edges = [2.0, 1.5, 1.0].map(|edge: f32| edge + 2.0 * outside);
    let counts = edges.map(|edge| (edge / d).round() as usize);
    let at = |axis: usize, index: usize| -outside + edges[axis] * index as f32 / counts[axis] as f32;
    let mut samples = Vec::new();
    for i in 0..=counts[0] {
        for j in 0..=counts[1] {
            for k in 0..=counts[2] {
                if [i, j, k].iter().zip(counts).any(|(&index, last)| index == 0 || index == last) {
                    samples.push(Point::new(at(0, i), at(1, j), at(2, k)));
                }
            }
        }
    }
    samples
}
