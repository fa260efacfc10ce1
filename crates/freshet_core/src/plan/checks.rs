//! What a scene as a whole may not be.

use glam::Vec3;

use super::SceneError;
use crate::error::InvalidInput;
use crate::grid::Grid;
use crate::integrator::Integrator;
use crate::periodic::{AXES, Periodic};
use crate::pressure_force::PressureForce;
use crate::pressure_solver::PressureSolver;
use crate::scene::{Body, BodySampling, Boundary, BoundaryShape, FluidScene, FluidSide, MAX_PARTICLES, side_of};
use crate::wall_method::WallMethod;
use crate::wall_method::ghosts::RIGHT;

/// Refuses particles so far from the origin that `f32` cannot tell a sixty-fourth of their spacing.
pub(super) fn check_precision(corner: Vec3, spacing: f32) -> Result<(), InvalidInput> {
    let reach = corner.max_element();
    let least = reach / (1 << 17) as f32;
    if spacing < least {
        let allowed =
            format!("at least {least} m where positions are up to {reach} m from the origin, as f32 rounds them");
        return Err(InvalidInput::new("resolution", format_args!("spacing {spacing} m"), allowed));
    }
    Ok(())
}

/// Refuses quasi-fluid bodies with what they do not go with.
pub(super) fn check_quasi_fluid(scene: &FluidScene) -> Result<(), InvalidInput> {
    let is_quasi_fluid = |body: &Body| matches!(body.sampling, BodySampling::QuasiFluid { .. });
    let Some(index) = scene.bodies.iter().position(is_quasi_fluid) else { return Ok(()) };
    let reason = if scene.settings.pressure_solver != PressureSolver::WeaklyCompressible {
        "any settings.pressure_solver but WeaklyCompressible"
    } else if scene.settings.widest_support != 1.0 {
        "a settings.widest_support above 1"
    } else if scene.physical_viscosity().is_some() {
        "a settings.viscosity_model"
    } else if scene.bodies.iter().any(|body| body.friction.is_some()) {
        "the friction of a body"
    } else {
        return Ok(());
    };
    let allowed = format!("SingleLayer, with {reason}");
    Err(InvalidInput::new(format_args!("bodies[{index}].sampling"), "QuasiFluid", allowed))
}

/// Refuses solvers that move particles apart beside what acts on fluid, or is acted on, by pressures in the course of a substep.
pub(super) fn check_moved_apart(scene: &FluidScene) -> Result<(), InvalidInput> {
    let solver = scene.settings.pressure_solver;
    let held = scene.boundaries.iter().position(|boundary| boundary.friction.is_some());
    let reason = match held {
        _ if !solver.moves_apart() => return Ok(()),
        _ if !scene.bodies.is_empty() => {
            format!("the scene has {} bodies, which it does not push", scene.bodies.len())
        }
        Some(index) => {
            format!("boundaries[{index}] has friction, by forces that it does not have")
        }
        None => return Ok(()),
    };
    Err(InvalidInput::new("settings.pressure_solver", solver.name(), format_args!("another one, as {reason}")))
}

/// Refuses densities that are carried beside bodies: one that comes out of the fluid, or swells in it, is there without a velocity that a rate could be of.
pub(super) fn check_carried_density(scene: &FluidScene) -> Result<(), InvalidInput> {
    let density = scene.settings.density;
    if density.is_carried() && !scene.bodies.is_empty() {
        let allowed = format!("a summed one, as the scene has {} bodies", scene.bodies.len());
        return Err(InvalidInput::new("settings.density", density.name(), allowed));
    }
    Ok(())
}

/// Refuses an integrator under which what friction holds does not come to rest: it may take all of a velocity in a substep.
pub(super) fn check_friction(scene: &FluidScene) -> Result<(), InvalidInput> {
    let integrator = scene.settings.integrator;
    let wall = scene.boundaries.iter().position(|boundary| boundary.friction.is_some());
    let body = scene.bodies.iter().position(|body| body.friction.is_some());
    let held = wall.map(|index| ("boundaries", index)).or(body.map(|index| ("bodies", index)));
    if let Some((kind, index)) = held.filter(|_| integrator.drag_limit() < 1.0) {
        let allowed = format!("another one, as {kind}[{index}] has friction");
        return Err(InvalidInput::new("settings.integrator", integrator.name(), allowed));
    }
    Ok(())
}

/// Refuses boundaries that have what the walls' method does not.
pub(super) fn check_wall_method(scene: &FluidScene, support_radius: f32) -> Result<(), InvalidInput> {
    let method = scene.settings.wall_method;
    if method == WallMethod::VolumeWeights {
        return Ok(());
    }
    let with = format!("with a settings.wall_method of {}", method.name());
    if matches!(method, WallMethod::QuasiFluid(_)) && scene.settings.widest_support != 1.0 {
        let widest = scene.settings.widest_support;
        return Err(InvalidInput::new("settings.widest_support", widest, format_args!("1, {with}")));
    }
    if scene.settings.relaxation.is_some() && !method.is_in_sums() {
        let allowed = format!("none, {with}: particles settle by the sums of densities");
        return Err(InvalidInput::new("settings.relaxation", "Some", allowed));
    }
    if method.collides() && scene.settings.redo_substeps {
        let allowed = format!("false, {with}: it changes what a shorter substep is judged by");
        return Err(InvalidInput::new("settings.redo_substeps", true, allowed));
    }
    let integrator = scene.settings.integrator;
    if method.collides() && integrator != Integrator::default() {
        let allowed = format!(
            "{}, with a settings.wall_method of {}: others remember motions that a wall changes",
            Integrator::default().name(),
            method.name()
        );
        return Err(InvalidInput::new("settings.integrator", integrator.name(), allowed));
    }
    if method == WallMethod::Ghosts {
        check_ghosts(scene, support_radius)?;
    }
    for (index, boundary) in scene.boundaries.iter().enumerate() {
        let refused = |field: &str, value: &dyn std::fmt::Display, allowed: &str| {
            let allowed = format!("{allowed}, with a settings.wall_method of {}", method.name());
            Err(InvalidInput::new(format_args!("boundaries[{index}].{field}"), value, allowed))
        };
        if boundary.velocity != Vec3::ZERO && !method.is_in_sums() {
            return refused("velocity", &boundary.velocity, "zero");
        }
        if boundary.friction.is_some() && !method.has_friction() {
            return refused("friction.at_rest", &boundary.friction.at_rest, "0");
        }
        if (method.needs_faces() || method.is_in_sums()) && has_two_sides(boundary) {
            return refused("shape.fluid", &"Both", "Inside or Outside");
        }
    }
    Ok(())
}

/// Refuses belts that would stand still: a boundary's velocity is that of its viscous faces.
pub(super) fn check_belts(scene: &FluidScene) -> Result<(), InvalidInput> {
    let stands = |boundary: &Boundary| boundary.velocity != Vec3::ZERO && boundary.viscous().next().is_none();
    let Some(index) = scene.boundaries.iter().position(stands) else { return Ok(()) };
    let velocity = scene.boundaries[index].velocity;
    let allowed = "zero, as the boundary has no viscous face, and it is those that move";
    Err(InvalidInput::new(format_args!("boundaries[{index}].velocity"), velocity, allowed))
}

/// Refuses ghost particles with what has no image, and where images would stand in each other's fluid.
fn check_ghosts(scene: &FluidScene, support_radius: f32) -> Result<(), InvalidInput> {
    let settings = &scene.settings;
    let with = "with a settings.wall_method of ghost particles: their pairs have pressure and viscosity only";
    for (field, value, least) in [
        ("settings.widest_support", settings.widest_support, 1.0),
        ("settings.near_pressure", settings.near_pressure, 0.0),
        ("settings.tensile_correction", settings.tensile_correction, 0.0),
    ] {
        if value > least {
            return Err(InvalidInput::new(field, value, format_args!("{least}, {with}")));
        }
    }
    if settings.pressure_force != PressureForce::Monaghan {
        let name = settings.pressure_force.name();
        return Err(InvalidInput::new("settings.pressure_force", name, format_args!("Monaghan, {with}")));
    }
    let mut axes: Vec<(usize, Vec3)> = Vec::new();
    for (index, boundary) in scene.boundaries.iter().enumerate() {
        let of_boundary = match boundary.shape {
            BoundaryShape::Container { half_extents, open } => {
                let closed = |&axis: &usize| !open[2 * axis] && !open[2 * axis + 1];
                let narrow = |&axis: &usize| half_extents[axis] < support_radius;
                if let Some(axis) = (0..3).filter(closed).find(narrow) {
                    let field = format_args!("boundaries[{index}].shape.half_extents.{}", AXES[axis]).to_string();
                    let allowed = format!(
                        "at least {support_radius} m, the support radius, with a settings.wall_method of ghost particles"
                    );
                    return Err(InvalidInput::new(field, half_extents[axis], allowed));
                }
                Vec3::AXES.to_vec()
            }
            BoundaryShape::Plane { .. } | BoundaryShape::HalfSpace { .. } => vec![Vec3::Y],
            _ => {
                let allowed = "Container, HalfSpace or Plane, with a settings.wall_method of ghost particles: images in a face that \
                               is curved, or has an edge the fluid goes round, stand in the fluid or leave gaps";
                return Err(InvalidInput::new(
                    format_args!("boundaries[{index}].shape"),
                    shape_name(&boundary.shape),
                    allowed,
                ));
            }
        };
        for axis in of_boundary {
            let axis = boundary.rotation * axis;
            let slanted = |cosine: f32| cosine > RIGHT && cosine < 0.9999;
            if let Some((other, known)) = axes.iter().find(|(_, known)| slanted(known.dot(axis).abs())) {
                let value = format!(
                    "a face {:.1} degrees from one of boundaries[{other}]",
                    known.angle_between(axis).to_degrees()
                );
                let allowed = "0 or 90 degrees, with a settings.wall_method of ghost particles: other edges have no images of images";
                return Err(InvalidInput::new(format_args!("boundaries[{index}].rotation"), value, allowed));
            }
            axes.push((index, axis));
        }
    }
    Ok(())
}

fn shape_name(shape: &BoundaryShape) -> &'static str {
    match shape {
        BoundaryShape::Container { .. } => "Container",
        BoundaryShape::Box { .. } => "Box",
        BoundaryShape::Sphere { .. } => "Sphere",
        BoundaryShape::Cylinder { .. } => "Cylinder",
        BoundaryShape::Capsule { .. } => "Capsule",
        BoundaryShape::Cone { .. } => "Cone",
        BoundaryShape::Cup { .. } => "Cup",
        BoundaryShape::ConvexHull { .. } => "ConvexHull",
        BoundaryShape::Mesh { .. } => "Mesh",
        BoundaryShape::HeightField { .. } => "HeightField",
        BoundaryShape::Plane { .. } => "Plane",
        BoundaryShape::HalfSpace { .. } => "HalfSpace",
    }
}

/// Whether there is fluid on both sides of a boundary's surface.
fn has_two_sides(boundary: &Boundary) -> bool {
    match &boundary.shape {
        BoundaryShape::Sphere { fluid, .. }
        | BoundaryShape::Cylinder { fluid, .. }
        | BoundaryShape::Capsule { fluid, .. }
        | BoundaryShape::Cone { fluid, .. } => *fluid == FluidSide::Both,
        BoundaryShape::Mesh { mesh, fluid } => side_of(mesh, *fluid) == FluidSide::Both,
        _ => false,
    }
}

/// Refuses particles that settle among bodies whose places are not known yet.
pub(super) fn check_relaxation(scene: &FluidScene) -> Result<(), InvalidInput> {
    if scene.settings.relaxation.is_some() && !scene.bodies.is_empty() {
        let value = format!("Some in a scene with {} bodies", scene.bodies.len());
        return Err(InvalidInput::new("settings.relaxation", value, "none, if there are bodies"));
    }
    Ok(())
}

/// Refuses bounds that leave out particles of the start: they would be gone after the first substep.
pub(super) fn check_bounds(
    (min, max): (Vec3, Vec3),
    positions: &[Vec3],
    periodic: &Periodic,
) -> Result<(Vec3, Vec3), InvalidInput> {
    let low = positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    if !(min.cmple(low).all() && max.cmpge(high).all()) {
        let allowed = format!("corners up to {low} and from {high} on, around all particles of the start");
        return Err(InvalidInput::new("settings.bounds", format_args!("{min} {max}"), allowed));
    }
    for (axis, name) in AXES.into_iter().enumerate() {
        let Some((low, high)) = periodic.along(axis) else { continue };
        if min[axis] > low || max[axis] < high {
            let allowed = format!("corners around the whole of periodic.{name}, {low} to {high}");
            return Err(InvalidInput::new("settings.bounds", format_args!("{min} {max}"), allowed));
        }
    }
    Ok((min, max))
}

/// Most samples of a body in a cube of the support radius: a layer a spacing apart has about ten there. All that share a place
/// are each other's neighbours, so the work grows with the square of this.
const MAX_CROWD: usize = 1000;

/// Refuses bodies with a crowd of samples.
pub(super) fn check_crowding(samples: &[Vec3], support_radius: f32) -> Result<(), InvalidInput> {
    let cell = |sample: &Vec3| (*sample / support_radius).floor().as_i64vec3().to_array();
    let mut cells: Vec<[i64; 3]> = samples.iter().map(cell).collect();
    cells.sort_unstable();
    let Some(crowd) = cells.chunk_by(|a, b| a == b).find(|crowd| crowd.len() > MAX_CROWD) else { return Ok(()) };
    let near = Vec3::from(crowd[0].map(|index| index as f32)) * support_radius;
    let value = format!("{} in a cube of {support_radius} m near {near}", crowd.len());
    Err(InvalidInput::new("samples", value, format_args!("up to {MAX_CROWD} there; they should lie a spacing apart")))
}

/// The most particles a scene allows, or its emitters can have alive.
pub(super) fn max_particles(scene: &FluidScene, start: usize, spacing: f32) -> Result<u32, SceneError> {
    if let Some(most) = scene.settings.max_particles {
        if (most as usize) < start {
            let allowed = format!("at least {start}, the particles of the start");
            return Err(InvalidInput::new("settings.max_particles", most, allowed).into());
        }
        return Ok(most);
    }
    let mut most = start as u64;
    for (index, emitter) in scene.emitters.iter().enumerate() {
        let Some(count) = emitter.steady_count(spacing) else {
            return Err(InvalidInput::new(
                "settings.max_particles",
                "none",
                format_args!("a number, as emitters[{index}] flows for ever"),
            )
            .into());
        };
        most = most.saturating_add(count);
    }
    if most > u64::from(MAX_PARTICLES) {
        return Err(InvalidInput::new("settings.max_particles", most, format_args!("1 to {MAX_PARTICLES}")).into());
    }
    Ok((most as u32).max(1))
}

/// Refuses periods that are too short for the support.
pub(super) fn check_periods(periodic: &Periodic, support_radius: f32) -> Result<(), InvalidInput> {
    let least = Grid::shortest_period(support_radius);
    for (axis, name) in AXES.into_iter().enumerate() {
        let Some((low, high)) = periodic.along(axis) else { continue };
        if high - low < least {
            let value = format!("a period of {} m", high - low);
            let allowed = format!("at least {} m, four support radii", 4.0 * support_radius);
            return Err(InvalidInput::new(format_args!("periodic.{name}"), value, allowed));
        }
    }
    Ok(())
}

/// Refuses particles of the start outside of the periods: they would meet those whose images they are.
pub(super) fn check_particles_within(
    periodic: &Periodic,
    positions: &[Vec3],
    spacing: f32,
) -> Result<(), InvalidInput> {
    match outside(periodic, positions, spacing) {
        Some((axis, at)) => {
            let allowed = format!("a period around all volumes; one has particles at {} = {at} m", AXES[axis]);
            Err(refused_period(periodic, axis, allowed))
        }
        None => Ok(()),
    }
}

/// Refuses walls outside of the periods: they would stand across them.
pub(super) fn check_walls_within(
    periodic: &Periodic,
    boundary: usize,
    samples: &[Vec3],
    spacing: f32,
) -> Result<(), InvalidInput> {
    match outside(periodic, samples, spacing) {
        Some((axis, at)) => {
            let allowed = format!(
                "a period without a wall across it; boundaries[{boundary}] has samples at {} = {at} m: open its faces there",
                AXES[axis]
            );
            Err(refused_period(periodic, axis, allowed))
        }
        None => Ok(()),
    }
}

/// Axis and coordinate of a point outside of the periods; a box that is no whole number of spacings long reaches out by a
/// quarter.
fn outside(periodic: &Periodic, points: &[Vec3], spacing: f32) -> Option<(usize, f32)> {
    let margin = 0.26 * spacing;
    (0..3).find_map(|axis| {
        let (low, high) = periodic.along(axis)?;
        let mut along = points.iter().map(|point| point[axis]);
        along.find(|&at| at < low - margin || at > high + margin).map(|at| (axis, at))
    })
}

fn refused_period(periodic: &Periodic, axis: usize, allowed: String) -> InvalidInput {
    let (low, high) = periodic.along(axis).unwrap_or_default();
    InvalidInput::new(format_args!("periodic.{}", AXES[axis]), format_args!("({low}, {high})"), allowed)
}

/// Refuses a body that would meet its own image.
pub(super) fn check_width(samples: &[Vec3], periodic: &Periodic, support_radius: f32) -> Result<(), InvalidInput> {
    let reach = samples.iter().map(|sample| sample.length()).fold(0.0, f32::max);
    for (axis, name) in AXES.into_iter().enumerate() {
        let Some((low, high)) = periodic.along(axis) else { continue };
        let most = 0.5 * (high - low - support_radius);
        if reach > most {
            let value = format!("up to {reach} m from the centre of mass");
            return Err(InvalidInput::new(
                "samples",
                value,
                format_args!("up to {most} m, as periodic.{name} repeats"),
            ));
        }
    }
    Ok(())
}

/// Refuses a force without end along an axis that repeats, unless the scene says how fast the flow gets.
pub(super) fn check_driven(scene: &FluidScene) -> Result<(), InvalidInput> {
    if scene.settings.expected_speed.is_none() && scene.periodic.across(scene.gravity) != scene.gravity {
        let allowed = "a number, as gravity drives the flow along an axis that repeats";
        return Err(InvalidInput::new("settings.expected_speed", "none", allowed));
    }
    Ok(())
}
