//! The plan's numbers as the shaders use them, each product of constants formed once in double precision.

use freshet_core::density_form::DensityForm;
use freshet_core::equation_of_state::EquationOfState;
use freshet_core::near_pressure;
use freshet_core::plan::Plan;
use freshet_core::pressure_corrected::PressureGradient;
use freshet_core::pressure_poisson::PressurePoisson;
use freshet_core::pressure_solver::{DivergenceFree, PressureSolver};
use freshet_core::step::StepInput;
use freshet_core::tensile_correction::inverse_shape;
use freshet_core::wall_method::{Penalty, WallMethod};
use glam::{UVec3, Vec3};

use crate::cells::{CellTables, first_body_sample};
use crate::fine_grid::FineGrid;
use crate::layout::Parameters;

/// The uniform of a plan.
pub(crate) fn parameters(plan: &Plan) -> Parameters {
    let p = &plan.parameters;
    let radius = f64::from(p.support_radius);
    let value_scale = p.kernel.normalisation() / radius.powi(3);
    // Of gradients, which pressures act by.
    let slope_scale = p.pressure_kernel.normalisation() / radius.powi(5);
    let (mass, rest) = (f64::from(p.particle_mass), f64::from(p.rest_density));
    let density = value_scale / f64::from(p.density_calibration);
    let force = slope_scale / f64::from(p.gradient_calibration);
    let h = f64::from(p.smoothing_length);
    let (stiffness, reference_pressure, exponent) = match p.pressure_law.equation {
        EquationOfState::IdealGas { stiffness } | EquationOfState::Desbrun { stiffness } => {
            (f64::from(stiffness), 0.0, 1.0)
        }
        EquationOfState::Harada { reference_pressure, stiffness } => (f64::from(stiffness), reference_pressure, 1.0),
        EquationOfState::Tait { sound_speed, exponent } => {
            (rest * f64::from(sound_speed).powi(2) / f64::from(exponent), 0.0, exponent)
        }
        EquationOfState::Linear { sound_speed } => (f64::from(sound_speed).powi(2), 0.0, 1.0),
    };
    let tables = CellTables::of(plan);
    let grid = FineGrid::of(&plan.grid);
    let period = plan.grid.periodic.lengths();
    let ends = |end: usize, none: f32| {
        Vec3::from([0, 1, 2].map(|axis| plan.grid.periodic.along(axis).map_or(none, |(low, high)| [low, high][end])))
    };
    let diagonal_scale =
        (mass * slope_scale).powi(2) / (f64::from(p.density_calibration) * f64::from(p.gradient_calibration) * rest);
    // Of other plans nobody reads it.
    let solver = match p.pressure_solver {
        PressureSolver::DivergenceFree(solver) => solver,
        // A Poisson equation ends by the share that is left.
        PressureSolver::PressurePoisson(PressurePoisson { tolerance, max_iterations }) => {
            DivergenceFree { divergence: tolerance, max_iterations, ..DivergenceFree::default() }
        }
        _ => DivergenceFree::default(),
    };
    let (wall_depth, wall_viscosity) = p.sticking();
    let strength = f64::from(p.wall_strength);
    let (wall_strength, wall_damping) = match p.wall_method {
        WallMethod::KernelForcing => ((strength * value_scale) as f32, 0.0),
        WallMethod::SpringDamper(spring) => {
            ((strength * strength) as f32, 2.0 * spring.damping_ratio * p.wall_strength)
        }
        _ => (p.wall_strength, 0.0),
    };
    // Of other plans nobody reads it.
    let penalty = match p.wall_method {
        WallMethod::Penalty(penalty) => penalty,
        _ => Penalty::DEFAULT,
    };
    Parameters {
        cell_mask: grid.dimensions() - UVec3::ONE,
        cells: grid.cells(),
        bounds_min: p.bounds_min,
        inverse_cell_size: grid.inverse_cell_size,
        grid_origin: grid.origin,
        cells_per_radius: plan.grid.cell_size * grid.inverse_cell_size,
        period,
        inverse_period: period.map(|length| if length > 0.0 { 1.0 / length } else { 0.0 }),
        period_low: ends(0, f32::MIN),
        period_high: ends(1, f32::MAX),
        near_pressure: (2.0 * f64::from(p.near_pressure) / rest * near_pressure::NORMALISATION
            / p.pressure_kernel.normalisation()) as f32,
        xsph_scale: (2.0 * f64::from(p.xsph) * mass * density) as f32,
        pair_viscosity: p.pair_viscosity(),
        wall_viscosity,
        wall_depth,
        wall_relative_density: match p.wall_method {
            WallMethod::QuasiFluid(walls) => walls.relative_density(),
            _ => 1.0,
        },
        wall_reach: p.wall_method.reach_of_planes(p.spacing, p.support_radius)[0],
        body_depth: p.boundary_depth,
        body_viscosity: p.sticking_to_bodies(),
        nearest_wall: 0.25 * p.spacing,
        bounds_max: p.bounds_max,
        inverse_support_radius: (1.0 / radius) as f32,
        log_cells_x: grid.log_cells.x,
        log_cells_xy: grid.log_cells.x + grid.log_cells.y,
        squared_support_radius: (radius * radius) as f32,
        fluid_density_scale: (mass * density) as f32,
        sample_density_scale: (rest * density) as f32,
        fluid_force_scale: (mass * force) as f32,
        sample_force_scale: (rest * force) as f32,
        body_force_scale: (mass * rest * force) as f32,
        rest_density: p.rest_density,
        inverse_rest_density: (1.0 / rest) as f32,
        stiffness: stiffness as f32,
        reference_pressure,
        exponent,
        viscosity_scale: (2.0 * f64::from(p.artificial_viscosity) * f64::from(p.sound_speed) * h) as f32,
        viscosity_softening: (0.01 * h * h) as f32,
        smoothing_length: p.smoothing_length,
        sound_speed: p.sound_speed,
        courant_factor: p.courant_factor,
        force_factor: p.force_factor,
        steady_limit: p.steady_limit(),
        longest_tick: StepInput::MAX_DURATION,
        max_substeps: p.max_substeps,
        wall_samples: plan.boundary.positions.len() as u32,
        first_body_sample: first_body_sample(plan) as u32,
        body_samples: plan.body_samples() as u32,
        bodies: plan.bodies.len() as u32,
        body_counts: tables.body_counts,
        wall_starts: tables.wall_starts,
        body_starts: tables.body_starts,
        block_sums: tables.block_sums,
        expected_speed: p.expected_speed,
        rate_scale: (mass * slope_scale / (f64::from(p.density_calibration) * rest)) as f32,
        number_density: (rest / mass) as f32,
        diagonal_scale: diagonal_scale as f32,
        // Over the largest eigenvalue of the lattice.
        stiffness_scale: (diagonal_scale * mass * f64::from(p.relaxation / DivergenceFree::RELAXATION)) as f32,
        least_diagonal: p.least_diagonal,
        relaxation: p.relaxation,
        softness: p.softness,
        tensile_correction: p.tensile_correction,
        inverse_shape: p.pressure_kernel().map_or(0.0, |kernel| inverse_shape(&kernel, p.spacing)),
        longest_way: p.longest_way(),
        pressure_limit: 2.0 * DivergenceFree::PRESSURE_FACTOR * p.spacing / p.pressure_frequency.max(1e-12),
        shortest_substep: DivergenceFree::SHORTEST,
        compression: solver.compression,
        divergence: solver.divergence,
        least_divergence: DivergenceFree::LEAST_DIVERGENCE,
        least_momentum: DivergenceFree::MOMENTUM,
        lack: DivergenceFree::LACK,
        filling: DivergenceFree::FILLING,
        max_iterations: solver.max_iterations,
        body_reach: p.body_reach(),
        widest_support: p.widest_support,
        push_out_speed: p.push_out_speed(),
        push_out_rate: p.push_out_rate(),
        by_velocity_rate: p.most_by_velocity(1.0),
        longest_correction: DivergenceFree::LONGEST_CORRECTION * p.spacing,
        swelling_way: p.swelling_way(),
        elsewhere: 0.5 * p.spacing,
        particle_mass: p.particle_mass,
        least_excess: DensityForm::LEAST_EXCESS,
        sample_drag: 2.0 * p.dynamic_viscosity * p.spacing,
        wall_spacing: p.spacing,
        wall_strength,
        wall_damping,
        wall_bounce: penalty.bounce,
        wall_slip: penalty.slip,
        wall_way: penalty.way(),
        longest_sound: p.longest_sound,
        poisson_scale: (2.0 * mass * slope_scale / f64::from(p.density_calibration)) as f32,
        surface_density: PressurePoisson::SURFACE * p.rest_density,
        fewest_around: PressureGradient::FEWEST * (1.0 - (mass / rest * density * p.kernel.shape(0.0)) as f32),
        ..Default::default()
    }
}
