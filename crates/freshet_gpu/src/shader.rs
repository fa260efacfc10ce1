//! Composes WGSL: library modules, the generated bindings and a pass become one naga module.

use std::borrow::Cow;
use std::collections::HashMap;

use freshet_core::equation_of_state::EquationOfState;
use freshet_core::integrator::Integrator;
use freshet_core::kernel::KernelKind;
use freshet_core::plan::{Parameters, Plan, StageKind};
use freshet_core::pressure_force::PressureForce;
use freshet_core::pressure_solver::PressureSolver;
use freshet_core::solver::SolverError;
use freshet_core::variable_support::EVALUATIONS;
use freshet_core::wall_method::{Reflection, WallMethod};
use freshet_shaders::{ShaderFile, library};
use naga_oil::compose::{ComposableModuleDescriptor, Composer, NagaModuleDescriptor, ShaderDefValue};
use wgpu::naga;

use crate::cells::WallDrag;
use crate::fine_grid::CELLS_PER_RADIUS;
use crate::layout::bindings_module;
use crate::options::GpuOptions;
use crate::passes::{
    Arguments, Pass, before_words, by_differences, history_words, incompressible, moving_walls, needs_velocities,
    past_words, sample_arms, solve_words,
};

/// Cells that a workgroup of the prefix sum handles.
pub(crate) const SCAN_BLOCK: u32 = 1024;

/// Most workgroups along one axis of a dispatch, WebGPU's default limit.
pub(crate) const MAX_WORKGROUPS: u32 = 65_535;

pub(crate) type Definitions = HashMap<String, ShaderDefValue>;

/// Whether the GPU solver has the methods of a plan, asked without a device.
///
/// # Errors
/// [`SolverError::Unsupported`] names the first that it has not.
pub fn check(plan: &Plan) -> Result<(), SolverError> {
    definitions(plan, &GpuOptions::default()).map(|_| ())
}

/// What the plan and the options select in the shaders.
pub(crate) fn definitions(plan: &Plan, options: &GpuOptions) -> Result<Definitions, SolverError> {
    let parameters = &plan.parameters;
    let mut definitions = Definitions::new();
    let mut number = |name: &str, value: u32| definitions.insert(name.to_owned(), ShaderDefValue::UInt(value));
    number("WORKGROUP_SIZE", options.workgroup_size);
    number("MAX_WORKGROUPS", MAX_WORKGROUPS);
    number("SCAN_BLOCK", SCAN_BLOCK);
    number("CELLS_PER_RADIUS", CELLS_PER_RADIUS);
    number("ARGUMENTS_PARTICLES", Arguments::Particles as u32);
    number("ARGUMENTS_CELLS", Arguments::Cells as u32);
    number("ARGUMENTS_SAMPLES", Arguments::Samples as u32);
    number("ARGUMENTS_BODIES", Arguments::Bodies as u32);
    number("ARGUMENTS_MOTION", Arguments::Motion as u32);
    number("ARGUMENTS_BODY_MOTION", Arguments::BodyMotion as u32);
    number("ARGUMENTS_FIRST", Arguments::First as u32);
    number("ARGUMENTS_ITERATIONS", Arguments::Iterations as u32);
    number("ARGUMENTS_DENSITY", Arguments::Density as u32);
    number("ARGUMENTS_PUSHES", Arguments::Pushes as u32);
    number("ARGUMENTS_ANSWERS", Arguments::Answers as u32);
    number("ARGUMENTS_WALL_SAMPLES", Arguments::WallSamples as u32);
    number("ARGUMENTS_FRICTION_LOADS", Arguments::FrictionLoads as u32);
    number("ARGUMENTS_FRICTION_SUMS", Arguments::FrictionSums as u32);
    number("ARGUMENTS_KEEP", Arguments::Keep as u32);
    number("ARGUMENTS_RESTORE", Arguments::Restore as u32);
    number("ARGUMENTS_DRAW", 3 * Arguments::COUNT);
    number("SOLVE_WORDS", solve_words(plan));
    number("HISTORY_WORDS", history_words(plan) as u32);
    number("BEFORE_WORDS", before_words(plan) as u32);
    number("MOST_REDOS", Parameters::MOST_REDOS);
    number("REDO_SLACK_PERCENT", (100.0 * Parameters::REDO_SLACK).round() as u32);
    number("PAST_WORDS", past_words(plan) as u32);
    number("WIDTH_EVALUATIONS", EVALUATIONS);
    let [_, beside] = parameters.wall_method.reach_of_planes(1.0, parameters.support_radius / parameters.spacing);
    number("WALL_LATERAL_PERCENT", (100.0 * beside).round() as u32);
    let contact = parameters.wall_method.collision().map_or(0.0, |(_, contact)| contact);
    number("WALL_CONTACT_PERCENT", (100.0 * contact).round() as u32);

    let mut set = |name: &str| definitions.insert(name.to_owned(), ShaderDefValue::Bool(true));
    let walls = plan.sums_walls();
    let bodies = !plan.bodies.is_empty();
    let drag = WallDrag::of(plan);
    let penalty = match parameters.wall_method {
        WallMethod::Penalty(penalty) => Some(penalty),
        _ => None,
    };
    for (name, condition) in [
        ("WALLS", walls),
        ("BODIES", bodies),
        ("SAMPLES", walls || bodies),
        ("PAIR_VELOCITIES", needs_velocities(plan)),
        ("ARTIFICIAL_VISCOSITY", parameters.artificial_viscosity > 0.0),
        ("MUELLER_FORCE", parameters.pressure_force == PressureForce::Mueller),
        ("NEAR_PRESSURE", parameters.near_pressure > 0.0),
        ("TENSILE_CORRECTION", parameters.tensile_correction > 0.0),
        ("XSPH_DRIFT", parameters.xsph > 0.0),
        ("WIDTHS", parameters.widest_support > 1.0),
        ("MORRIS_VISCOSITY", parameters.dynamic_viscosity > 0.0),
        ("OWN_VISCOSITY_KERNEL", parameters.has_own_viscosity_kernel()),
        ("DRAGGING_WALLS", walls && drag == WallDrag::Artificial),
        ("STICKING_WALLS", walls && drag == WallDrag::Morris),
        ("MOVING_WALLS", moving_walls(plan)),
        ("INCOMPRESSIBLE", incompressible(plan)),
        ("SAMPLE_ARMS", sample_arms(plan)),
        ("QUASI_FLUID", plan.has(StageKind::BodyDensity)),
        ("QUASI_FLUID_WALLS", !plan.boundary.own_densities.is_empty()),
        ("WALL_GHOSTS", parameters.wall_method == WallMethod::Ghosts && plan.has(StageKind::WallDensity)),
        ("STICKING_BODIES", plan.has(StageKind::BodyDrag)),
        ("ROUGH_BODIES", plan.has(StageKind::BodyFriction)),
        ("PERIODIC", plan.grid.periodic.any()),
        ("HISTORIES", history_words(plan) > 0),
        ("PASTS", past_words(plan) > 0),
        ("PRESSURE_CORRECTED", matches!(parameters.pressure_solver, PressureSolver::PressureCorrected(_))),
        ("POISSON", matches!(parameters.pressure_solver, PressureSolver::PressurePoisson(_))),
        ("DIFFERENCES", by_differences(plan)),
        ("MOVED_APART", plan.has(StageKind::PositionSolve)),
        ("LAST_SUBSTEP", parameters.density.is_carried() || plan.has(StageKind::PositionSolve)),
        ("SPEEDS_OF_STATE", (!incompressible(plan) && !plan.has(StageKind::PositionSolve)) || parameters.redo_substeps),
        ("KEPT_EXCESS", parameters.density.is_carried()),
        ("REDO", parameters.redo_substeps),
        ("WALL_LENNARD_JONES", parameters.wall_method == WallMethod::LennardJones),
        ("WALL_KERNEL_FORCING", parameters.wall_method == WallMethod::KernelForcing),
        ("WALL_MONAGHAN", parameters.wall_method == WallMethod::MonaghanRepulsion),
        ("WALL_SPRINGS", matches!(parameters.wall_method, WallMethod::SpringDamper(_))),
        ("WALL_SHARE", penalty.is_some_and(|penalty| penalty.reflection == Reflection::Share)),
        ("WALL_MIRRORED", penalty.is_some_and(|penalty| penalty.reflection == Reflection::Mirrored)),
        ("WALL_ONE_WAY", penalty.is_some_and(|penalty| penalty.one_way.is_some())),
        ("CLAMP_NEGATIVE_PRESSURE", parameters.pressure_law.clamp_negative),
    ] {
        if condition {
            set(name);
        }
    }
    let terms = [("", parameters.kernel), ("PRESSURE_", parameters.pressure_kernel)];
    if let Some((_, kernel)) = terms.into_iter().find(|(_, kernel)| *kernel == KernelKind::Viscosity) {
        return Err(SolverError::Unsupported {
            backend: "gpu",
            what: format!("kernel {}", kernel.name()),
            reason: "it is a Laplacian only; use another kernel for density and pressure".to_owned(),
        });
    }
    for (term, kernel) in terms.into_iter().chain([("VISCOSITY_", parameters.viscosity_kernel)]) {
        set(&format!("{term}KERNEL_{}", kernel.name().to_uppercase()));
    }
    if let Some(name) = integrator_definition(parameters.integrator)? {
        set("INTEGRATOR");
        set(name);
    }
    match parameters.pressure_law.equation {
        EquationOfState::IdealGas { .. } => set("EQUATION_IDEAL_GAS"),
        EquationOfState::Tait { exponent, .. } => {
            if exponent == 7.0 {
                set("EXPONENT_SEVEN");
            }
            set("EQUATION_TAIT")
        }
        EquationOfState::Desbrun { .. } | EquationOfState::Harada { .. } | EquationOfState::Linear { .. } => {
            set("EQUATION_LINEAR")
        }
    };
    Ok(definitions)
}

/// What selects an integrator; none for semi-implicit Euler.
fn integrator_definition(integrator: Integrator) -> Result<Option<&'static str>, SolverError> {
    Ok(match integrator {
        Integrator::SemiImplicitEuler => None,
        Integrator::Verlet => Some("INTEGRATOR_VERLET"),
        Integrator::VelocityVerlet => Some("INTEGRATOR_VELOCITY_VERLET"),
        Integrator::ModifiedVelocityVerlet | Integrator::Leapfrog => Some("INTEGRATOR_LEAPFROG"),
        Integrator::Clavet => Some("INTEGRATOR_CLAVET"),
        Integrator::Beeman => Some("INTEGRATOR_BEEMAN"),
        Integrator::VelocityCorrectedBeeman => Some("INTEGRATOR_VELOCITY_CORRECTED_BEEMAN"),
        Integrator::ForwardEuler | Integrator::PositionCorrectedBeeman => {
            return Err(SolverError::Unsupported {
                backend: "gpu",
                what: integrator.name().to_owned(),
                reason: "every oscillation grows under it; use another integrator".to_owned(),
            });
        }
    })
}

/// What a pass is composed of, with paths: the generated bindings, the library, last its own file.
pub(crate) fn sources(pass: &Pass, options: &GpuOptions) -> Vec<(&'static str, Cow<'static, str>)> {
    let bindings = bindings_module(&pass.uses, options.textures());
    let of_file = |file: &ShaderFile| (file.path, Cow::Borrowed(file.source));
    let mut all = vec![("generated/bindings.wgsl", Cow::Owned(bindings))];
    for file in library::ALL {
        all.push(of_file(file));
        if *file == library::KERNELS {
            all.push(("generated/pressure_kernels.wgsl", kernels_of("pressure", file)));
            all.push(("generated/viscosity_kernels.wgsl", kernels_of("viscosity", file)));
        }
    }
    all.push(of_file(&pass.file));
    all
}

/// The module of kernels again, for a term that may have one of its own.
fn kernels_of(term: &str, file: &ShaderFile) -> Cow<'static, str> {
    let path = file
        .source
        .replace("#define_import_path freshet::kernels", &format!("#define_import_path freshet::{term}_kernels"));
    Cow::Owned(path.replace("#ifdef KERNEL_", &format!("#ifdef {}_KERNEL_", term.to_uppercase())))
}

/// Composes one pass.
pub(crate) fn compose(
    pass: &Pass,
    definitions: &Definitions,
    options: &GpuOptions,
) -> Result<naga::Module, SolverError> {
    let patched = |source: &str| match options.patch {
        Some((from, to)) => source.replace(from, to),
        None => source.to_owned(),
    };
    let mut definitions = definitions.clone();
    definitions.insert(pass.name.to_uppercase(), ShaderDefValue::Bool(true));
    let mut composer = Composer::default();
    let mut modules = sources(pass, options);
    let own = modules.pop().map(|(_, source)| source).unwrap_or_default();
    for (path, source) in modules {
        let added = composer.add_composable_module(ComposableModuleDescriptor {
            source: &patched(&source),
            file_path: path,
            ..Default::default()
        });
        if let Err(error) = added {
            return Err(SolverError::Device(format!("{path}: {}", error.emit_to_string(&composer))));
        }
    }
    let module = composer.make_naga_module(NagaModuleDescriptor {
        source: &patched(&own),
        file_path: pass.file.path,
        shader_defs: definitions,
        ..Default::default()
    });
    module.map_err(|error| {
        SolverError::Device(format!("{} ({}): {}", pass.file.path, pass.name, error.emit_to_string(&composer)))
    })
}

/// A module as WGSL, without what its entry point does not use.
pub(crate) fn text(mut module: naga::Module) -> Option<String> {
    naga::compact::compact(&mut module, naga::compact::KeepUnused::No);
    let mut validator = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), Default::default());
    let info = validator.validate(&module).ok()?;
    naga::back::wgsl::write_string(&module, &info, naga::back::wgsl::WriterFlags::empty()).ok()
}
