//! A plan as text: what a scene costs and why.

use std::fmt;

use super::Plan;
use crate::periodic::AXES;
use crate::pressure_solver::PressureSolver;

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let p = &self.parameters;
        writeln!(f, "plan{}{}", if self.name.is_empty() { "" } else { " of " }, self.name)?;
        writeln!(
            f,
            "  {} particles of {:.4e} kg at the start, at most {}; spacing {} m, {} kernel of support {} m",
            self.positions.len(),
            p.particle_mass,
            self.max_particles,
            p.spacing,
            p.kernel.name(),
            p.support_radius
        )?;
        writeln!(
            f,
            "  density calibration {:.4}, gradient calibration {:.4}, walls {:.3} spacings behind their face with gamma {:.3}; {} wall samples, {} bodies with {} samples",
            p.density_calibration,
            p.gradient_calibration,
            p.boundary_depth / p.spacing,
            p.boundary_gamma,
            self.boundary.positions.len(),
            self.bodies.len(),
            self.body_samples()
        )?;
        if p.pressure_kernel != p.kernel {
            writeln!(f, "  {} kernel of pressure forces", p.pressure_kernel.name())?;
        }
        if p.has_own_viscosity_kernel() {
            writeln!(f, "  {} kernel of viscosity", p.viscosity_kernel.name())?;
        }
        match p.pressure_solver {
            PressureSolver::WeaklyCompressible => writeln!(
                f,
                "  {} with sound speed {:.3} m/s{}; alpha {}; step factors {} {} {}; first limit {:.3e} s",
                p.pressure_law.equation.name(),
                p.sound_speed,
                if p.pressure_law.clamp_negative { ", clamped at zero" } else { "" },
                p.artificial_viscosity,
                p.courant_factor,
                p.force_factor,
                p.viscous_factor,
                p.substep_limit(0.0, p.gravity.length())
            )?,
            PressureSolver::PositionBased(solver) => writeln!(
                f,
                "  position-based, {} iterations, relaxation {:.3}, softness {}; alpha {} with {:.3} m/s; step factors {} {}; first limit {:.3e} s",
                solver.iterations,
                p.relaxation,
                solver.softness,
                p.artificial_viscosity,
                p.sound_speed,
                p.courant_factor,
                p.viscous_factor,
                p.position_based_limit(0.0, p.gravity.length())
            )?,
            PressureSolver::PressureCorrected(solver) => writeln!(
                f,
                "  pressure-corrected, {} iterations, gradient by {}, sound {:.3} m/s but at most {:.3} m a substep; alpha {}; step factors {} {}; first limit {:.3e} s",
                solver.iterations,
                solver.gradient.name(),
                p.sound_speed,
                p.longest_sound,
                p.artificial_viscosity,
                p.courant_factor,
                p.viscous_factor,
                p.position_based_limit(0.0, p.gravity.length())
            )?,
            PressureSolver::PressurePoisson(solver) => writeln!(
                f,
                "  pressure Poisson, to {} of what it begins with in at most {} iterations; alpha {} with {:.3} m/s; step factors {} {}; first limit {:.3e} s",
                solver.tolerance,
                solver.max_iterations,
                p.artificial_viscosity,
                p.sound_speed,
                p.courant_factor,
                p.viscous_factor,
                p.position_based_limit(0.0, p.gravity.length())
            )?,
            PressureSolver::DivergenceFree(_) => writeln!(
                f,
                "  incompressible, relaxation {:.3}; alpha {} with {:.3} m/s; step factors {} {}; first limit {:.3e} s",
                p.relaxation,
                p.artificial_viscosity,
                p.sound_speed,
                p.courant_factor,
                p.viscous_factor,
                p.incompressible_limit(
                    0.0,
                    p.gravity.length(),
                    self.pressures.iter().fold(0.0, |most, &pressure| pressure.max(most)) * p.rest_density
                )
            )?,
        }
        if p.redo_substeps {
            writeln!(
                f,
                "  substeps that turn out too long are made again, up to {} times",
                super::Parameters::MOST_REDOS
            )?;
        }
        if p.tensile_correction > 0.0 {
            writeln!(f, "  tensile correction {}", p.tensile_correction)?;
        }
        if p.near_pressure > 0.0 {
            writeln!(f, "  near pressure {} m2/s2 times the density", p.near_pressure)?;
        }
        if !p.wall_method.is_in_sums() {
            let strength = p.wall_strength;
            writeln!(f, "  walls push by {} of strength {strength:.4e}", p.wall_method.name())?;
        }
        if p.xsph > 0.0 {
            writeln!(f, "  XSPH with epsilon {}", p.xsph)?;
        }
        if p.widest_support > 1.0 {
            writeln!(f, "  supports of particles up to {} times as wide", p.widest_support)?;
        }
        if p.dynamic_viscosity > 0.0 {
            writeln!(f, "  dynamic viscosity {} Pa s, calibration {:.4}", p.dynamic_viscosity, p.viscous_calibration)?;
        }
        for (axis, name) in AXES.into_iter().enumerate() {
            if let Some((low, high)) = self.grid.periodic.along(axis) {
                writeln!(f, "  repeats itself along {name}, from {low} to {high} m")?;
            }
        }
        let cells = self.grid.dimensions();
        writeln!(f, "  wrapped grid of {} x {} x {} cells", cells.x, cells.y, cells.z)?;
        for stage in &self.stages {
            writeln!(f, "  stage {:<16} {}", stage.kind.name(), stage.reason)?;
        }
        for note in &self.notes {
            writeln!(f, "  note  {note}")?;
        }
        Ok(())
    }
}
