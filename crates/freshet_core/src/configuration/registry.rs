//! All configurations there are, one entry each. To have another on the chart, in `docs/methods.md` and among what
//! [`FluidFidelity`](crate::fidelity::FluidFidelity) chooses from, add it here.

use super::{Configuration, Family};
use crate::density_form::DensityForm;
use crate::equation_of_state::EquationOfState;
use crate::integrator::Integrator;
use crate::kernel::KernelKind;
use crate::position_based::PositionBased;
use crate::pressure_corrected::{PressureCorrected, PressureGradient};
use crate::pressure_force::PressureForce;
use crate::pressure_poisson::PressurePoisson;
use crate::pressure_solver::{DivergenceFree, PressureSolver};
use crate::relaxation::Relaxation;
use crate::scene::{FluidScene, Support};
use crate::wall_method::{Penalty, QuasiFluid, SpringDamper, WallMethod};

const fn of(
    family: Family,
    name: &'static str,
    change: fn(&mut FluidScene, f32),
    purpose: &'static str,
    weakness: &'static str,
) -> Configuration {
    Configuration { name, family, purpose, weakness, change }
}

/// Divergence-free SPH with one tolerance for compression and divergence.
fn divergence_free(scene: &mut FluidScene, tolerance: f32) {
    let solver = DivergenceFree { compression: tolerance, divergence: tolerance, ..DivergenceFree::default() };
    scene.settings.pressure_solver = PressureSolver::DivergenceFree(solver);
}

/// Position-based fluid of so many iterations a substep.
fn position_based(scene: &mut FluidScene, iterations: u32) {
    scene.settings.pressure_solver =
        PressureSolver::PositionBased(PositionBased { iterations, ..PositionBased::default() });
}

/// Pressure-corrected SPH of so many iterations a substep.
fn pressure_corrected(scene: &mut FluidScene, iterations: u32, gradient: PressureGradient) {
    scene.settings.pressure_solver = PressureSolver::PressureCorrected(PressureCorrected { iterations, gradient });
}

/// A Poisson equation solved to so much of what it begins with.
fn poisson(scene: &mut FluidScene, tolerance: f32, max_iterations: u32) {
    scene.settings.pressure_solver = PressureSolver::PressurePoisson(PressurePoisson { tolerance, max_iterations });
}

/// A speed of sound of so many times the expected speed.
fn sound(scene: &mut FluidScene, expected_speed: f32, times: f32) {
    scene.settings.sound_speed = Some(times * expected_speed);
    scene.settings.allow_compressible = times < 10.0;
}

/// Viscosity by the kernel made for it, where there is viscosity.
fn viscosity_kernel(scene: &mut FluidScene, _: f32) {
    scene.settings.viscosity_kernel = scene.settings.viscosity_model.map(|_| KernelKind::Viscosity);
}

/// A linear equation of state with the plan's own speed of sound.
fn linear(scene: &mut FluidScene, expected_speed: f32) {
    scene.settings.equation_of_state = Some(EquationOfState::Linear { sound_speed: 10.0 * expected_speed });
}

use Family::{
    Cohesion, Density, EquationOfState as Equation, Integrator as Integration, Kernel, Neighbours,
    PressureForce as Force, PressureSolver as Solver, SpeedOfSound, Step, Viscosity, Walls,
};

/// All, those of a family together; the first is [`Settings::default`](crate::scene::Settings::default).
pub const CONFIGURATIONS: &[Configuration] = &[
    of(
        Equation,
        "tait",
        |_, _| {},
        "water: stiffer the more it is compressed; the default",
        "steps as short as its sound demands",
    ),
    of(
        Equation,
        "linear",
        linear,
        "water: as stiff at any density, cheaper than a power",
        "softer than Tait's under impacts",
    ),
    of(
        Equation,
        "desbrun",
        |scene, v| scene.settings.equation_of_state = Some(EquationOfState::Desbrun { stiffness: (10.0 * v).powi(2) }),
        "the same as linear, given by its stiffness, as in Desbrun & Gascuel 1996",
        "the stiffness that a scene needs has to be known",
    ),
    of(
        Equation,
        "harada",
        |scene, v| {
            scene.settings.equation_of_state =
                Some(EquationOfState::Harada { reference_pressure: 1000.0 * v * v, stiffness: (10.0 * v).powi(2) })
        },
        "closed or periodic domains, which a pressure at rest keeps from coming apart",
        "free surfaces: the pressure at rest blows them up",
    ),
    of(
        Equation,
        "ideal-gas",
        |scene, v| scene.settings.equation_of_state = Some(EquationOfState::IdealGas { stiffness: (10.0 * v).powi(2) }),
        "gases, which fill what holds them",
        "liquids: it has no surface",
    ),
    of(
        SpeedOfSound,
        "sound-5",
        |scene, v| sound(scene, v, 5.0),
        "twice the step, half the drag of artificial viscosity, which goes with it",
        "soft: up to 4 % of compression in depths and impacts",
    ),
    of(
        SpeedOfSound,
        "sound-7",
        |scene, v| sound(scene, v, 7.0),
        "steps longer by two fifths, less drag",
        "2 % of compression",
    ),
    of(
        SpeedOfSound,
        "sound-20",
        |scene, v| sound(scene, v, 20.0),
        "a quarter of the compression",
        "substeps half as long, twice the drag of artificial viscosity",
    ),
    of(
        SpeedOfSound,
        "sound-5-linear",
        |scene, v| {
            scene.settings.equation_of_state = Some(EquationOfState::Linear { sound_speed: 5.0 * v });
            scene.settings.allow_compressible = true;
        },
        "the cheapest weakly compressible pressure",
        "soft, and no stiffer under impacts",
    ),
    of(
        Force,
        "mueller",
        |scene, _| scene.settings.pressure_force = PressureForce::Mueller,
        "comparison with Mueller et al. 2003, the force put right",
        "supports of different width; it keeps no energy of summed densities",
    ),
    of(
        Force,
        "mueller-linear",
        |scene, v| {
            linear(scene, v);
            scene.settings.pressure_force = PressureForce::Mueller;
        },
        "Mueller's own pair of force and equation of state",
        "as mueller and linear",
    ),
    of(
        Solver,
        "dfsph",
        |scene, _| divergence_free(scene, 1e-3),
        "water, in steps as long as the flow allows",
        "particles crowd beside walls",
    ),
    of(
        Solver,
        "dfsph-0.01-percent",
        |scene, _| divergence_free(scene, 1e-4),
        "the least compression",
        "more iterations a substep",
    ),
    of(
        Solver,
        "dfsph-1-percent",
        |scene, _| divergence_free(scene, 1e-2),
        "fewer iterations where 1 % of compression does no harm",
        "deep water is compressed by its weight",
    ),
    of(
        Solver,
        "dfsph-long-steps",
        |scene, _| {
            divergence_free(scene, 1e-3);
            scene.settings.courant_factor = 0.8;
        },
        "few substeps in fast flows",
        "impacts are blurred over a spacing",
    ),
    of(
        Solver,
        "dfsph-short-steps",
        |scene, _| {
            divergence_free(scene, 1e-3);
            scene.settings.courant_factor = 0.2;
        },
        "fast flows in detail",
        "twice the substeps",
    ),
    of(
        Solver,
        "dfsph-fast",
        |scene, _| {
            divergence_free(scene, 1e-2);
            scene.settings.courant_factor = 0.8;
        },
        "the cheapest incompressible fluid",
        "deep water is compressed, impacts are blurred",
    ),
    of(
        Solver,
        "dfsph-inviscid",
        |scene, _| {
            divergence_free(scene, 1e-3);
            scene.settings.artificial_viscosity = 0.0;
        },
        "flows without any drag but the material's own",
        "splashes do not calm down",
    ),
    of(
        Solver,
        "dfsph-four-iterations",
        |scene, _| {
            let solver = DivergenceFree { max_iterations: 4, ..DivergenceFree::default() };
            scene.settings.pressure_solver = PressureSolver::DivergenceFree(solver);
        },
        "a bound on the time of a substep",
        "what four iterations leave is compression",
    ),
    of(
        Solver,
        "dfsph-2.15",
        |scene, _| {
            divergence_free(scene, 1e-3);
            scene.settings.support = Support::Ratio(2.15);
        },
        "waves and heeling bodies: the support at which particles under pressure resist shear least",
        "a quarter more pairs; water packs closer as it leaves its lattice",
    ),
    of(
        Solver,
        "dfsph-2.15-fast",
        |scene, _| {
            divergence_free(scene, 1e-2);
            scene.settings.support = Support::Ratio(2.15);
            scene.settings.courant_factor = 0.8;
        },
        "the same, in few long steps",
        "as dfsph-2.15 and dfsph-fast",
    ),
    of(
        Solver,
        "dfsph-quintic-2.7",
        |scene, _| {
            divergence_free(scene, 1e-3);
            scene.settings.kernel = KernelKind::QuinticSpline;
            scene.settings.support = Support::Ratio(2.7);
        },
        "the same with smoother sums",
        "two and a half times the pairs",
    ),
    of(
        Solver,
        "dfsph-notch",
        |scene, _| {
            divergence_free(scene, 1e-3);
            scene.settings.kernel = KernelKind::WendlandNotch;
            scene.settings.support = Support::Ratio(2.3);
        },
        "waves and heeling bodies: sums that see no lattice, so that water under pressure resists no shear",
        "half as many pairs again",
    ),
    of(
        Solver,
        "dfsph-notch-fast",
        |scene, _| {
            divergence_free(scene, 1e-2);
            scene.settings.kernel = KernelKind::WendlandNotch;
            scene.settings.support = Support::Ratio(2.3);
            scene.settings.courant_factor = 0.8;
        },
        "the same, in few long steps",
        "as dfsph-notch and dfsph-fast",
    ),
    of(
        Solver,
        "dfsph-50-neighbours",
        |scene, _| {
            divergence_free(scene, 1e-3);
            scene.settings.support = Support::Neighbours(50.0);
        },
        "smoother pressures",
        "half as many pairs again",
    ),
    of(
        Solver,
        "dfsph-cubic",
        |scene, _| {
            divergence_free(scene, 1e-3);
            scene.settings.kernel = KernelKind::CubicSpline;
        },
        "comparison with SPlisHSPlasH, whose kernel it is",
        "pairs of particles",
    ),
    of(
        Solver,
        "position-based",
        |scene, _| position_based(scene, 4),
        "fluid that bears any step, in as many iterations as it may cost (Macklin & Mueller 2013)",
        "stiffness is that of iterations and step: deep water sinks in",
    ),
    of(
        Solver,
        "position-based-16",
        |scene, _| position_based(scene, 16),
        "the same, stiffer: three times with eight times the iterations",
        "four times the iterations, still a spring",
    ),
    of(
        Solver,
        "position-based-short-steps",
        |scene, _| {
            position_based(scene, 4);
            scene.settings.courant_factor = 0.1;
        },
        "stiffer by shorter steps",
        "four times the substeps in fast flows, none the more in slow ones",
    ),
    of(
        Solver,
        "pressure-corrected",
        |scene, _| pressure_corrected(scene, 4, PressureGradient::Sum),
        "comparison with Bao et al. 2009: pressures from what velocities compress, without a system of equations",
        "stiffness is that of iterations and step: deep water sinks in",
    ),
    of(
        Solver,
        "pressure-corrected-16",
        |scene, _| pressure_corrected(scene, 16, PressureGradient::Sum),
        "the same, stiffer",
        "four times the iterations, still a spring",
    ),
    of(
        Solver,
        "pressure-corrected-difference",
        |scene, _| pressure_corrected(scene, 4, PressureGradient::Difference),
        "comparison with Pirovano 2011, whose gradient it is: exact for an even pressure",
        "it keeps no momentum: dam breaks gain energy, and water stands too high, with too much pressure at floors",
    ),
    of(
        Solver,
        "mps",
        |scene, _| poisson(scene, 0.02, 60),
        "comparison with Koshizuka & Oka 1996: pressures by a Poisson equation",
        "a spring whatever the tolerance, as each substep begins from zero; short steps add energy",
    ),
    of(
        Solver,
        "mps-fine",
        |scene, _| poisson(scene, 0.002, 300),
        "the same, solved ten times as exactly",
        "twice the time, and as soft",
    ),
    of(
        Density,
        "adapted-density",
        |scene, _| scene.settings.density = DensityForm::Adapted,
        "comparison with Solenthaler & Pajarola 2008, whose form is for several densities",
        "with one mass it is the sum: the same pass",
    ),
    of(
        Density,
        "continuity",
        |scene, _| scene.settings.density = DensityForm::Continuity,
        "free surfaces without a lack of density, jets",
        "densities drift from where particles are, and never come back",
    ),
    of(
        Density,
        "adapted-continuity",
        |scene, _| scene.settings.density = DensityForm::AdaptedContinuity,
        "the same, carried",
        "with one mass it is continuity: the same pass",
    ),
    of(
        Walls,
        "quasi-fluid-walls",
        |scene, _| scene.settings.wall_method = WallMethod::QuasiFluid(QuasiFluid::Adapted),
        "walls that fluid meets as it meets itself (Pirovano 2011)",
        "three times the samples, whose densities are summed in each substep",
    ),
    of(
        Walls,
        "quasi-fluid-walls-plain",
        |scene, _| {
            scene.settings.wall_method = WallMethod::QuasiFluid(QuasiFluid::PLAIN);
            scene.settings.relaxation = Some(Relaxation::default());
        },
        "comparison with the form that is not adapted: walls twice as dense as the fluid",
        "fluid stands off the walls, and is thrown off them where it has not settled before",
    ),
    of(
        Walls,
        "ghost-particles",
        |scene, _| scene.settings.wall_method = WallMethod::Ghosts,
        "tanks: plane walls behind which the fluid is its own mirror image (Randles & Libersky 1996)",
        "walls of any other shape, which it refuses",
    ),
    of(
        Walls,
        "lennard-jones",
        |scene, _| scene.settings.wall_method = WallMethod::LennardJones,
        "comparison with Monaghan 1994: walls that need no density",
        "single samples are felt; fluid thins out towards walls",
    ),
    of(
        Walls,
        "kernel-forcing",
        |scene, _| scene.settings.wall_method = WallMethod::KernelForcing,
        "walls of a kernel that is there anyway (Pirovano 2011)",
        "as strong as the speed that is expected, and no stronger",
    ),
    of(
        Walls,
        "monaghan-repulsion",
        |scene, _| scene.settings.wall_method = WallMethod::MonaghanRepulsion,
        "comparison with Becker, Tessendorf & Teschner 2009",
        "fluid thins out towards walls, and stands off",
    ),
    of(
        Walls,
        "spring-damper",
        |scene, _| scene.settings.wall_method = WallMethod::SpringDamper(SpringDamper::DEFAULT),
        "terrain with friction (Krog 2010): smooth along the face",
        "deep water sinks into the spring",
    ),
    of(
        Walls,
        "penalty-reposition",
        |scene, _| scene.settings.wall_method = WallMethod::Penalty(Penalty::DEFAULT),
        "particles that get into a wall are put back (Pirovano 2011)",
        "particles pile up on the face, in as many layers as pressure presses in",
    ),
    of(
        Walls,
        "penalty-share",
        |scene, _| scene.settings.wall_method = WallMethod::Penalty(Penalty::SHARE),
        "the same, bouncing by the share of the step that they were in the wall (Kelager 2006)",
        "as penalty-reposition, and what bounces is not still",
    ),
    of(
        Walls,
        "penalty-mirrored",
        |scene, _| scene.settings.wall_method = WallMethod::Penalty(Penalty::MIRRORED),
        "the same, as a mirror sends them back",
        "keeps all energy: no fluid comes to rest on it",
    ),
    of(
        Kernel,
        "gaussian",
        |scene, _| scene.settings.kernel = KernelKind::Gaussian,
        "comparison with Gingold & Monaghan 1977",
        "narrow: a third of its support",
    ),
    of(
        Kernel,
        "cubic-spline",
        |scene, _| scene.settings.kernel = KernelKind::CubicSpline,
        "comparison with most of the literature",
        "particles pair with 50 neighbours and more",
    ),
    of(
        Kernel,
        "quintic-spline",
        |scene, _| scene.settings.kernel = KernelKind::QuinticSpline,
        "smooth pressures with many neighbours",
        "narrow with 32 neighbours",
    ),
    of(
        Kernel,
        "quadratic",
        |scene, _| scene.settings.kernel = KernelKind::Quadratic,
        "strong compression: it never lets particles pair",
        "a noisy gradient",
    ),
    of(
        Kernel,
        "quartic",
        |scene, _| scene.settings.kernel = KernelKind::Quartic,
        "comparison with Krog 2010 and Enneking 2018",
        "it attracts in the outermost tenth",
    ),
    of(
        Kernel,
        "poly6",
        |scene, _| scene.settings.kernel = KernelKind::Poly6,
        "densities, not pressures",
        "pressure: no gradient at the centre, so that particles clump",
    ),
    of(
        Kernel,
        "spiky",
        |scene, _| scene.settings.kernel = KernelKind::Spiky,
        "pressures of Mueller et al. 2003: it never lets particles pair",
        "densities of a lattice a quarter too large before calibration",
    ),
    of(
        Kernel,
        "wendland-notch",
        |scene, _| {
            scene.settings.kernel = KernelKind::WendlandNotch;
            scene.settings.support = Support::Ratio(2.3);
        },
        "waves and heeling bodies: sums that see no lattice (2.3 spacings of support)",
        "half as many pairs again",
    ),
    of(
        Kernel,
        "spiky-pressure",
        |scene, _| scene.settings.pressure_kernel = Some(KernelKind::Spiky),
        "pressures that never let particles pair, with densities that see little of a lattice",
        "forces and densities follow from no common energy",
    ),
    of(
        Kernel,
        "viscosity-kernel",
        viscosity_kernel,
        "viscous forces by a Laplacian that is nowhere negative (Mueller et al. 2003)",
        "a sweep of its own over the pairs on the CPU; nothing where the fluid has no viscosity model",
    ),
    of(
        Kernel,
        "mueller-kernels",
        |scene, expected_speed| {
            scene.settings.kernel = KernelKind::Poly6;
            scene.settings.pressure_kernel = Some(KernelKind::Spiky);
            viscosity_kernel(scene, expected_speed);
        },
        "comparison with Mueller et al. 2003 and Krog 2010: poly6, spiky and viscosity",
        "forces and densities follow from no common energy",
    ),
    of(
        Neighbours,
        "neighbours-24",
        |scene, _| scene.settings.support = Support::Neighbours(24.0),
        "a quarter fewer pairs",
        "noisier sums over neighbours",
    ),
    of(
        Neighbours,
        "support-2.15",
        |scene, _| scene.settings.support = Support::Ratio(2.15),
        "waves and heeling bodies: the support at which particles under pressure resist shear least",
        "a quarter more pairs; water packs closer as it leaves its lattice",
    ),
    of(
        Neighbours,
        "neighbours-50",
        |scene, _| scene.settings.support = Support::Neighbours(50.0),
        "smoother sums over neighbours",
        "half as many pairs again; blurs a spacing more",
    ),
    of(
        Neighbours,
        "neighbours-80",
        |scene, _| scene.settings.support = Support::Neighbours(80.0),
        "Taylor-Green vortices and other fields without a surface",
        "violent flows fail at steps that 32 neighbours bear",
    ),
    of(
        Neighbours,
        "quintic-80",
        |scene, _| {
            scene.settings.kernel = KernelKind::QuinticSpline;
            scene.settings.support = Support::Neighbours(80.0);
        },
        "the quintic spline with the neighbours it is made for",
        "two and a half times the pairs",
    ),
    of(
        Neighbours,
        "variable-support",
        |scene, _| scene.settings.widest_support = 1.5,
        "fluid that thins out and keeps its neighbours",
        "four times the time; half of the dam breaks fail at larger steps",
    ),
    of(
        Integration,
        "forward-euler",
        |scene, _| scene.settings.integrator = Integrator::ForwardEuler,
        "nothing: charted as a failure",
        "every oscillation grows",
    ),
    of(
        Integration,
        "verlet",
        |scene, _| scene.settings.integrator = Integrator::Verlet,
        "positions of second order",
        "velocities a substep late",
    ),
    of(
        Integration,
        "velocity-verlet",
        |scene, _| scene.settings.integrator = Integrator::VelocityVerlet,
        "the same with velocities of the same time",
        "viscous limits an eighth shorter",
    ),
    of(
        Integration,
        "modified-velocity-verlet",
        |scene, _| scene.settings.integrator = Integrator::ModifiedVelocityVerlet,
        "second order at the cost of the first",
        "velocities half a substep late in forces",
    ),
    of(
        Integration,
        "leapfrog",
        |scene, _| scene.settings.integrator = Integrator::Leapfrog,
        "second order at the cost of the first",
        "velocities half a substep late",
    ),
    of(
        Integration,
        "clavet",
        |scene, _| scene.settings.integrator = Integrator::Clavet,
        "viscous toys: it takes energy",
        "flows that should keep theirs",
    ),
    of(
        Integration,
        "beeman",
        |scene, _| scene.settings.integrator = Integrator::Beeman,
        "velocities of second order in undamped motion",
        "two accelerations kept; viscous limits a third shorter",
    ),
    of(
        Integration,
        "velocity-corrected-beeman",
        |scene, _| scene.settings.integrator = Integrator::VelocityCorrectedBeeman,
        "second order with forces that depend on velocities",
        "viscous limits a third as long",
    ),
    of(
        Integration,
        "position-corrected-beeman",
        |scene, _| scene.settings.integrator = Integrator::PositionCorrectedBeeman,
        "nothing: charted as a failure",
        "every oscillation grows, slowly",
    ),
    of(
        Step,
        "courant-0.2",
        |scene, _| scene.settings.courant_factor = 0.2,
        "finding out what the step costs in accuracy",
        "twice the substeps",
    ),
    of(
        Step,
        "courant-0.8",
        |scene, _| scene.settings.courant_factor = 0.8,
        "half as many substeps",
        "little is left to the limit of 0.99 of a dam break",
    ),
    of(
        Step,
        "courant-1",
        |scene, _| scene.settings.courant_factor = 1.0,
        "the longest steps there are",
        "violent flows, whose limit it is",
    ),
    of(
        Step,
        "courant-0.8-redone",
        |scene, _| {
            scene.settings.courant_factor = 0.8;
            scene.settings.redo_substeps = true;
        },
        "long steps, and shorter ones made again at impacts",
        "flows without impacts, which pay for the copies",
    ),
    of(
        Step,
        "sound-5-courant-0.8",
        |scene, v| {
            sound(scene, v, 5.0);
            scene.settings.courant_factor = 0.8;
        },
        "a quarter of the substeps",
        "soft, and next to the limit",
    ),
    of(
        Viscosity,
        "alpha-0",
        |scene, _| scene.settings.artificial_viscosity = 0.0,
        "flows without drag, viscous materials",
        "nothing calms sound and splashes",
    ),
    of(
        Viscosity,
        "alpha-0.01",
        |scene, _| scene.settings.artificial_viscosity = 0.01,
        "a third of the drag",
        "more noise at rest and in splashes",
    ),
    of(
        Viscosity,
        "alpha-0.1",
        |scene, _| scene.settings.artificial_viscosity = 0.1,
        "water that calms down soon",
        "honey instead of water at coarse resolution",
    ),
    of(
        Viscosity,
        "xsph-0.1",
        |scene, _| scene.settings.xsph = 0.1,
        "streams that meet and do not pass through each other",
        "a pass more a substep",
    ),
    of(
        Viscosity,
        "xsph-0.5",
        |scene, _| scene.settings.xsph = 0.5,
        "the same, as strong as Monaghan 1989 has it",
        "blurs shear over a support",
    ),
    of(
        Cohesion,
        "unclamped",
        |scene, _| scene.settings.clamp_negative_pressure = false,
        "fluid under tension, drops that hold together",
        "particles clump, and nearly every dam break fails",
    ),
    of(
        Cohesion,
        "near-pressure",
        |scene, _| {
            scene.settings.clamp_negative_pressure = false;
            scene.settings.near_pressure = 0.01;
        },
        "free fluid under tension without clumps (Pirovano 2011)",
        "between walls it adds energy",
    ),
    of(
        Cohesion,
        "tensile-correction",
        |scene, _| {
            scene.settings.clamp_negative_pressure = false;
            scene.settings.tensile_correction = 0.2;
        },
        "the same by a force instead of a density (Monaghan 2000)",
        "violent flows under tension fail with it, too",
    ),
];
