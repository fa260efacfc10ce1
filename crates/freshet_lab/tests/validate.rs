//! Cases of `validate` in their quick form, with their own bounds: those that keep them.

use freshet_lab::afloat::BodyMethod;
use freshet_lab::backend::Backend;
use freshet_lab::commands::validate::{CASES, Job};
use freshet_lab::error::LabError;
use freshet_lab::output::Output;
use freshet_lab::verdict::Check;

fn assert_passes(name: &str, backend: Backend) -> Result<(), LabError> {
    assert_passes_with(name, backend, BodyMethod::default(), false)
}

fn assert_passes_with(name: &str, backend: Backend, bodies: BodyMethod, lockstep: bool) -> Result<(), LabError> {
    assert_misses_only(name, backend, bodies, lockstep, &[])
}

/// Every bound is kept but those whose names hold one of `known`: what is missed and is said to be in the docs.
fn assert_misses_only(
    name: &str,
    backend: Backend,
    bodies: BodyMethod,
    lockstep: bool,
    known: &[&str],
) -> Result<(), LabError> {
    // Two tests of a case may run at once.
    let form = format!("{name}_{backend}{}_{lockstep}_{}", bodies.suffix(), std::process::id());
    let folder = std::env::temp_dir().join(format!("freshet_lab_validate_{form}"));
    let output = Output::new(&folder)?;
    let job = Job { backend, quick: true, threads: Default::default(), bodies, lockstep, output };
    let case = CASES.iter().find(|case| case.name == name).unwrap_or_else(|| panic!("no case {name}"));
    let found = (case.run)(&job)?;
    println!("{}", found.verdict);
    let is_known = |check: &&Check| known.iter().any(|part| check.name.contains(part));
    assert!(found.verdict.missed().all(|check| is_known(&check)), "\n{}", found.verdict);
    let judged = found.verdict.checks.iter().filter(|check| !is_known(check)).count();
    assert!(judged > 2, "\n{}", found.verdict);
    for file in ["csv", "svg"] {
        let path = job.output.path(&format!("{name}{}.{file}", job.suffix()));
        assert!(std::fs::read_to_string(&path).map_err(LabError::file(&path))?.len() > 1000, "{}", path.display());
    }
    std::fs::remove_dir_all(&folder).map_err(LabError::file(&folder))
}

#[test]
fn a_thrown_block_keeps_its_momentum() -> Result<(), LabError> {
    assert_passes("free-flight", Backend::Cpu)?;
    assert_passes("free-flight", Backend::Gpu)
}

#[test]
fn flow_under_a_force_becomes_a_parabola() -> Result<(), LabError> {
    assert_passes("poiseuille", Backend::Cpu)?;
    assert_passes("poiseuille", Backend::Gpu)
}

#[test]
fn a_plate_drags_a_fluid_along() -> Result<(), LabError> {
    assert_passes("couette", Backend::Cpu)?;
    assert_passes("couette", Backend::Gpu)
}

#[test]
fn a_ball_of_quasi_fluid_bobs_as_long_as_it_should() -> Result<(), LabError> {
    assert_passes_with("heave", Backend::Cpu, BodyMethod::QuasiFluid, false)
}

/// Two ticks late the lightest cube goes on bobbing in a weakly compressible fluid, whatever its samples.
#[test]
fn balls_and_cubes_of_quasi_fluid_float_as_deep_as_they_should() -> Result<(), LabError> {
    assert_passes_with("draft", Backend::Cpu, BodyMethod::QuasiFluid, true)
}

#[test]
fn a_ball_that_turns_feels_the_torque_of_a_viscous_fluid() -> Result<(), LabError> {
    assert_passes("spin", Backend::Cpu)?;
    assert_passes("spin", Backend::Gpu)
}

#[test]
fn a_cube_under_tension_rounds_itself_off_and_does_not_clump() -> Result<(), LabError> {
    assert_passes("relaxing-cube", Backend::Cpu)?;
    assert_passes("relaxing-cube", Backend::Gpu)
}

#[test]
fn a_block_dropped_into_a_pool_keeps_volume_and_momentum() -> Result<(), LabError> {
    assert_passes("pool-drop", Backend::Cpu)?;
    assert_passes("pool-drop", Backend::Gpu)
}

#[test]
fn vortices_decay_as_fast_as_they_should() -> Result<(), LabError> {
    assert_passes("taylor-green", Backend::Cpu)?;
    assert_passes("taylor-green", Backend::Gpu)
}

/// Both swing as gravity and the shear moduli of the lattice say; as gravity alone says only the one whose lattice has next to none.
#[test]
fn waves_swing_as_gravity_and_the_lattice_say() -> Result<(), LabError> {
    assert_passes("standing-wave-2.15", Backend::Cpu)?;
    assert_passes("standing-wave-2.15", Backend::Gpu)?;
    assert_misses_only("standing-wave", Backend::Cpu, BodyMethod::default(), false, &["error of the period"])
}

#[test]
fn water_at_rest_has_the_pressure_of_its_depth() -> Result<(), LabError> {
    assert_passes("hydrostatic", Backend::Cpu)?;
    assert_passes("hydrostatic-dfsph", Backend::Cpu)?;
    assert_passes("hydrostatic", Backend::Gpu)?;
    assert_passes("hydrostatic-dfsph", Backend::Gpu)
}

#[test]
fn water_whose_particles_carry_their_densities_stands_and_breaks_as_it_should() -> Result<(), LabError> {
    assert_passes("hydrostatic-continuity", Backend::Cpu)?;
    assert_passes("hydrostatic-continuity", Backend::Gpu)?;
    assert_passes("density-drift", Backend::Cpu)
}

#[test]
fn position_based_water_has_the_pressure_of_its_weight_and_sinks_in() -> Result<(), LabError> {
    assert_passes("position-based", Backend::Cpu)?;
    assert_passes("position-based", Backend::Gpu)
}

#[test]
fn pressure_corrected_water_has_the_pressure_of_its_weight_and_sinks_in() -> Result<(), LabError> {
    assert_passes("pressure-corrected", Backend::Cpu)?;
    assert_passes("pressure-corrected", Backend::Gpu)
}

#[test]
fn water_by_a_poisson_equation_has_the_pressure_of_its_weight() -> Result<(), LabError> {
    assert_passes("poisson", Backend::Cpu)?;
    assert_passes("poisson", Backend::Gpu)
}

#[test]
fn water_without_artificial_viscosity_comes_to_rest() -> Result<(), LabError> {
    assert_passes("calm-dfsph", Backend::Cpu)?;
    assert_passes("calm-dfsph", Backend::Gpu)
}

#[test]
fn ten_metres_of_water_are_hardly_compressed() -> Result<(), LabError> {
    assert_passes("deep-column", Backend::Cpu)?;
    assert_passes("deep-column-dfsph", Backend::Cpu)?;
    assert_passes("deep-column", Backend::Gpu)?;
    assert_passes("deep-column-dfsph", Backend::Gpu)
}

#[test]
fn bodies_float_as_deep_as_archimedes_says() -> Result<(), LabError> {
    assert_passes("draft", Backend::Cpu)
}

#[test]
fn the_lightest_and_the_heaviest_ball_throw_nothing_about() -> Result<(), LabError> {
    assert_passes("light-and-heavy", Backend::Cpu)
}

#[test]
fn a_ball_let_go_under_water_begins_to_move_as_it_should() -> Result<(), LabError> {
    assert_passes("added-mass", Backend::Cpu)
}

#[test]
fn a_gate_holds_water_back_in_time_and_late() -> Result<(), LabError> {
    assert_passes("gate", Backend::Cpu)?;
    assert_passes("gate", Backend::Gpu)
}

#[test]
fn a_ball_bobs_as_long_as_it_should() -> Result<(), LabError> {
    assert_passes("heave", Backend::Cpu)?;
    assert_passes("heave", Backend::Gpu)
}

#[test]
fn a_block_between_a_wall_and_water_does_not_shake() -> Result<(), LabError> {
    assert_passes("pinned", Backend::Cpu)?;
    assert_passes("pinned", Backend::Gpu)
}

#[test]
fn water_thrown_at_bodies_keeps_the_momentum_of_all() -> Result<(), LabError> {
    assert_passes("splash", Backend::Cpu)?;
    assert_passes("splash", Backend::Gpu)
}

#[test]
fn a_ball_under_water_takes_its_room_and_is_wet() -> Result<(), LabError> {
    assert_passes("wet", Backend::Cpu)?;
    assert_passes("wet", Backend::Gpu)
}

/// Fluid under pressure is a soft solid, see docs/coupling.md: a barge is not righted as far as it should be.
#[test]
fn a_barge_keeps_all_bounds_but_the_righting_moment() -> Result<(), LabError> {
    let known = ["error of the righting moment"];
    assert_misses_only("righting", Backend::Cpu, BodyMethod::default(), false, &known)?;
    assert_misses_only("righting", Backend::Gpu, BodyMethod::default(), false, &known)
}

/// When rapier hears late, crates throw each other off; in lockstep they do not.
#[test]
fn a_crate_that_carries_another_floats_in_lockstep() -> Result<(), LabError> {
    let known = ["two ticks late: largest heel", "two ticks late: largest way"];
    assert_misses_only("stacked", Backend::Cpu, BodyMethod::default(), false, &known)
}

/// What they cost is for a quiet machine to say.
#[test]
fn twenty_crates_lose_no_particle_and_no_time() -> Result<(), LabError> {
    let known = ["what they cost"];
    assert_misses_only("crates", Backend::Cpu, BodyMethod::default(), false, &known)
}
