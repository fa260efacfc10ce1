//! Particles and samples of a scene.

use std::fmt;

use glam::Vec3;

use super::SceneError;
use super::checks::{check_crowding, check_precision, check_walls_within, check_width};
use crate::error::InvalidInput;
use crate::geometry::convex_hull;
use crate::overlap::check_overlap;
use crate::periodic::Periodic;
use crate::sampling::lattice::{sample_box, sample_sphere};
use crate::sampling::quasi_fluid;
use crate::sampling::wall_layer::WallLayer;
use crate::scene::{
    Body, BodySampling, Boundary, BoundaryShape, FluidSide, Friction, MAX_PARTICLES, Shape, Volume, side_of,
};
use crate::solid::Solid;
use crate::swelling;
use crate::wall_method::{Face, WallMethod, face_of};

/// Samples of all boundaries that do not move.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlannedBoundary {
    /// Positions, m.
    pub positions: Vec<Vec3>,
    /// Volume weights of samples that are in the sums, m3, those of [quasi-fluid](crate::wall_method::QuasiFluid) times their relative density; else the
    /// volume of a particle.
    pub volumes: Vec<f32>,
    /// Whether the fluid's viscosity acts between it and the sample.
    pub viscous: Vec<bool>,
    /// Velocities of the surfaces they stand for, m/s, zero for those that do not drag; empty if none moves.
    pub velocities: Vec<Vec3>,
    /// Coefficients of friction of what sticks and of what slides; empty if there is none.
    pub frictions: Vec<[f32; 2]>,
    /// The faces they stand for; empty if the method does not need them.
    pub faces: Vec<Face>,
    /// What the walls' own samples add to the density of each, over that of the walls at rest, no unit; empty but for
    /// [quasi-fluid](crate::wall_method::QuasiFluid).
    pub own_densities: Vec<f32>,
    /// Where walls are solid, in world coordinates.
    pub solids: Vec<Solid>,
}

/// A body with the weights of its samples.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlannedBody {
    /// Name, for reports.
    pub name: String,
    /// Samples relative to the centre of mass, m.
    pub samples: Vec<Vec3>,
    /// The largest distance of a sample from the centre of mass, m.
    pub reach: f32,
    /// Volume weights, m3.
    pub volumes: Vec<f32>,
    /// Where it is solid, relative to the centre of mass.
    pub solids: Vec<Solid>,
    /// Where each sample [swells](crate::swelling) from, relative to the centre of mass, m.
    pub roots: Vec<Vec3>,
    /// The largest distance of a sample from there, m, at least a spacing.
    pub swelling_reach: f32,
    /// Whether it is wholly there at once, wherever it comes.
    pub at_once: bool,
    /// Friction of its surface.
    pub friction: Friction,
    /// What its own samples add to the density of each, over the density at rest, if they are [quasi-fluid](crate::sampling::quasi_fluid); else
    /// empty.
    pub own_densities: Vec<f32>,
}

/// Particles of all volumes with their velocities, and for each volume its first id and its number of particles.
pub(super) fn sample_volumes(
    volumes: &[Volume],
    spacing: f32,
) -> Result<(Vec<Vec3>, Vec<Vec3>, Vec<(u32, u32)>), SceneError> {
    let too_many = |count: f64| {
        let allowed =
            format!("up to {MAX_PARTICLES} particles in all; this one makes {count:.3e}: choose a larger spacing");
        InvalidInput::new("resolution", format_args!("spacing {spacing} m"), allowed)
    };
    // Before anything is allocated; exact counts follow.
    let expected = volumes.iter().map(|volume| f64::from(volume.size())).sum::<f64>() / f64::from(spacing).powi(3);
    if expected > 2.0 * f64::from(MAX_PARTICLES) {
        return Err(too_many(expected).into());
    }
    let (mut positions, mut velocities, mut ids) = (Vec::new(), Vec::new(), Vec::new());
    for (index, volume) in volumes.iter().enumerate() {
        let sampled =
            sample_volume(volume, spacing).map_err(|error| located(error, format_args!("volumes[{index}]")))?;
        ids.push((positions.len() as u32, sampled.len() as u32));
        velocities.extend(std::iter::repeat_n(volume.velocity, sampled.len()));
        positions.extend(sampled);
        if positions.len() > MAX_PARTICLES as usize {
            return Err(too_many(positions.len() as f64).into());
        }
    }
    check_precision(positions.iter().fold(Vec3::ZERO, |reach, point| reach.max(point.abs())), spacing)?;
    check_overlap(volumes, &positions, &ids, spacing)?;
    Ok((positions, velocities, ids))
}

/// Particles of one volume, in world coordinates.
pub fn sample_volume(volume: &Volume, spacing: f32) -> Result<Vec<Vec3>, InvalidInput> {
    let local = match volume.shape {
        Shape::Box { half_extents } => sample_box(half_extents, spacing),
        Shape::Sphere { radius } => sample_sphere(radius, spacing),
    }
    .map_err(|error| error.inside("shape"))?;
    Ok(local.into_iter().map(|point| volume.rotation * point + volume.center).collect())
}

/// Samples of all boundaries, with their weights.
pub(super) fn sample_boundaries(
    boundaries: &[Boundary],
    method: WallMethod,
    periodic: &Periodic,
    layer: &WallLayer,
) -> Result<PlannedBoundary, SceneError> {
    let spacing = layer.spacing();
    let too_many = |count: f64| {
        let allowed =
            format!("up to {MAX_PARTICLES} wall samples in all; this one makes {count:.3e}: choose a larger spacing");
        InvalidInput::new("resolution", format_args!("spacing {spacing} m"), allowed)
    };
    let expected = boundaries.iter().map(boundary_area).sum::<f64>() / f64::from(spacing).powi(2);
    if expected > 2.0 * f64::from(MAX_PARTICLES) {
        return Err(too_many(expected).into());
    }
    let mut planned = PlannedBoundary::default();
    let samples_layer = layer.of_method(method);
    for (index, boundary) in boundaries.iter().enumerate() {
        let in_layers = matches!(method, WallMethod::QuasiFluid(_));
        let (samples, layers) = match in_layers {
            true => sample_layers(boundary, layer),
            false => sample_boundary(boundary, &samples_layer).map(|samples| (samples, [0; 3])),
        }
        .map_err(|error| located(error, format_args!("boundaries[{index}]")))?;
        check_walls_within(periodic, index, &samples, spacing)?;
        // Of several layers the first, which is next to the fluid.
        let next_to_fluid = if in_layers { layers[0] as usize } else { samples.len() };
        planned.viscous.extend(samples.iter().enumerate().map(|(index, &sample)| match method {
            WallMethod::Ghosts => boundary.viscous_faces[face_index(boundary, face_of(boundary, layer, sample).normal)],
            _ => method.is_in_sums() && index < next_to_fluid && is_viscous(boundary, &samples_layer, sample),
        }));
        if planned.positions.len() + samples.len() > MAX_PARTICLES as usize {
            return Err(too_many((planned.positions.len() + samples.len()) as f64).into());
        }
        match method {
            WallMethod::VolumeWeights => planned.volumes.extend(layer.volumes_among(&samples, periodic)),
            WallMethod::QuasiFluid(_) => {
                planned.volumes.extend(quasi_fluid::volumes(&samples, layers, layer, periodic));
            }
            _ => planned.volumes.extend(samples.iter().map(|_| spacing.powi(3))),
        }
        if method.needs_faces() {
            planned.faces.extend(samples.iter().map(|&sample| face_of(boundary, layer, sample)));
        }
        if boundaries.iter().any(|boundary| boundary.velocity != Vec3::ZERO) {
            let drags = planned.viscous[planned.positions.len()..].iter();
            planned.velocities.extend(drags.map(|&drags| if drags { boundary.velocity } else { Vec3::ZERO }));
        }
        if boundaries.iter().any(|boundary| boundary.friction.is_some()) {
            let friction = boundary.friction;
            planned.frictions.extend(samples.iter().map(|_| [friction.at_rest, friction.sliding]));
        }
        planned.positions.extend(samples);
        planned.solids.extend(boundary.solids(layer));
    }
    if let WallMethod::QuasiFluid(walls) = method {
        let PlannedBoundary { positions, volumes, own_densities, .. } = &mut planned;
        *own_densities = quasi_fluid::thin_out(positions, volumes, layer, periodic);
        volumes.iter_mut().for_each(|volume| *volume *= walls.relative_density());
    }
    Ok(planned)
}

fn boundary_area(boundary: &Boundary) -> f64 {
    let (half_extents, open) = match boundary.shape {
        BoundaryShape::Container { half_extents, open } => (half_extents.as_dvec3(), open),
        BoundaryShape::Box { half_extents } => (half_extents.as_dvec3(), [false; 6]),
        BoundaryShape::Plane { half_extents: [x, z] } | BoundaryShape::HalfSpace { half_extents: [x, z] } => {
            return 4.0 * f64::from(x) * f64::from(z);
        }
        BoundaryShape::Sphere { radius, .. } => return 4.0 * std::f64::consts::PI * f64::from(radius).powi(2),
        // Their samplers refuse what is too large themselves, long before it is too much for a scene.
        _ => return 0.0,
    };
    let face = |axis: usize| 4.0 * half_extents[(axis + 1) % 3] * half_extents[(axis + 2) % 3];
    (0..6).filter(|&index| !open[index]).map(|index| face(index / 2)).sum()
}

/// Moves particles down until each is as dense as the water above it makes it: `rho/rho0 - 1 = g z / c^2` at depth z.
///
/// The lowest stay where they are; at height s of a volume D high the way is `g / c^2 (D s - s^2 / 2)`.
pub(super) fn stand(positions: &mut [Vec3], gravity: Vec3, sound_speed: f32, spacing: f32) {
    let (g, up) = (gravity.length(), -gravity.normalize_or_zero());
    let low = positions.iter().map(|position| position.dot(up)).fold(f32::INFINITY, f32::min) - 0.5 * spacing;
    let high = positions.iter().map(|position| position.dot(up)).fold(f32::NEG_INFINITY, f32::max) + 0.5 * spacing;
    for position in positions {
        let height = position.dot(up) - low;
        let way = g / (sound_speed * sound_speed) * height * (high - low - 0.5 * height);
        *position -= way.min(0.25 * height) * up;
    }
}

/// Gives the particles of a volume that carry their densities those of water standing in it, as `rho/rho0 - 1`: `g depth / c^2`.
pub(super) fn press(excesses: &mut [f32], positions: &[Vec3], gravity: Vec3, sound_speed: f32, spacing: f32) {
    let (g, up) = (gravity.length(), -gravity.normalize_or_zero());
    let high = positions.iter().map(|position| position.dot(up)).fold(f32::NEG_INFINITY, f32::max) + 0.5 * spacing;
    for (excess, position) in excesses.iter_mut().zip(positions) {
        *excess = g * (high - position.dot(up)) / (sound_speed * sound_speed);
    }
}

/// Gives the particles of an incompressible volume the pressure of water standing in it, as `p / rho^2`: `g depth / rho`.
pub(super) fn bear(pressures: &mut [f32], positions: &[Vec3], gravity: Vec3, rest_density: f32, spacing: f32) {
    let (g, up) = (gravity.length(), -gravity.normalize_or_zero());
    let high = positions.iter().map(|position| position.dot(up)).fold(f32::NEG_INFINITY, f32::max) + 0.5 * spacing;
    for (pressure, position) in pressures.iter_mut().zip(positions) {
        *pressure = g * (high - position.dot(up)) / rest_density;
    }
}

/// Samples of one boundary at the depth of `layer`, in world coordinates.
pub fn sample_boundary(boundary: &Boundary, layer: &WallLayer) -> Result<Vec<Vec3>, InvalidInput> {
    let local = match &boundary.shape {
        &BoundaryShape::Container { half_extents, open } => layer.container(half_extents, open),
        &BoundaryShape::Box { half_extents } => layer.box_surface(half_extents),
        &BoundaryShape::Sphere { radius, fluid } => layer.sphere(radius, fluid),
        &BoundaryShape::Cylinder { radius, half_height, fluid } => layer.cylinder(radius, half_height, fluid),
        &BoundaryShape::Capsule { radius, half_height, fluid } => layer.capsule(radius, half_height, fluid),
        &BoundaryShape::Cone { radius, half_height, fluid } => layer.cone(radius, half_height, fluid),
        &BoundaryShape::Cup { radius, half_height, thickness } => layer.cup(radius, half_height, thickness),
        BoundaryShape::ConvexHull { points } => {
            convex_hull(points).and_then(|mesh| layer.mesh(&mesh, FluidSide::Outside))
        }
        BoundaryShape::Mesh { mesh, fluid } => layer.mesh(mesh, side_of(mesh, *fluid)),
        BoundaryShape::HeightField { field } => layer.height_field(field),
        BoundaryShape::Plane { half_extents } | BoundaryShape::HalfSpace { half_extents } => {
            layer.plane(Vec3::Y, half_extents[0], half_extents[1]).map_err(|error| match error.field.as_str() {
                "half_extent_u" => InvalidInput { field: "half_extents[0]".to_owned(), ..error },
                "half_extent_v" => InvalidInput { field: "half_extents[1]".to_owned(), ..error },
                _ => error,
            })
        }
    }
    .map_err(|error| error.inside("shape"))?;
    Ok(local.into_iter().map(|point| boundary.rotation * point + boundary.center).collect())
}

/// Three layers of samples of one boundary, in world coordinates, and how many each has: without those that have no room where it is thin.
fn sample_layers(boundary: &Boundary, layer: &WallLayer) -> Result<(Vec<Vec3>, [u32; 3]), InvalidInput> {
    let layers = layer.quasi_fluid();
    // Walls that nothing is behind are as thick as they have to be.
    let solids = match boundary.shape {
        BoundaryShape::Container { .. } | BoundaryShape::Plane { .. } | BoundaryShape::HalfSpace { .. } => None,
        _ => Some(boundary.solids(&layers[2])),
    };
    let (mut all, mut counts) = (Vec::new(), [0; 3]);
    for (index, of_layer) in layers.iter().enumerate() {
        let mut samples = sample_boundary(boundary, of_layer)?;
        if let Some(solids) = &solids {
            samples.retain(|&sample| quasi_fluid::has_room(index, sample, solids, layer.spacing()));
        }
        counts[index] = samples.len() as u32;
        all.extend(samples);
    }
    Ok((all, counts))
}

/// The index among [`Boundary::viscous_faces`] of the face of a plane, a half-space or a container whose normal, to the fluid, is given.
fn face_index(boundary: &Boundary, normal: Vec3) -> usize {
    let local = boundary.rotation.conjugate() * normal;
    let axis = local.abs().max_position();
    // The fluid is inside of a container: its upper faces look down.
    let inside = matches!(boundary.shape, BoundaryShape::Container { .. });
    2 * axis + usize::from((local[axis] > 0.0) != inside)
}

/// Whether a sample lies behind a viscous face.
fn is_viscous(boundary: &Boundary, layer: &WallLayer, sample: Vec3) -> bool {
    let local = boundary.rotation.conjugate() * (sample - boundary.center);
    // From the centre to where samples of a face lie, less half a spacing for rounding.
    let reach = match boundary.shape {
        BoundaryShape::Container { half_extents, .. } => half_extents + layer.depth,
        BoundaryShape::Box { half_extents } => half_extents - layer.depth,
        BoundaryShape::Plane { .. } | BoundaryShape::HalfSpace { .. } => return boundary.viscous_faces[3],
        _ => return boundary.viscous_faces.contains(&true),
    } - 0.5 * layer.spacing();
    (0..3).any(|axis| {
        let [below, above] = [boundary.viscous_faces[2 * axis], boundary.viscous_faces[2 * axis + 1]];
        (below && local[axis] < -reach[axis]) || (above && local[axis] > reach[axis])
    })
}

/// An error of a sampler, seen from the scene: what it calls the spacing is the scene's resolution.
fn located(error: InvalidInput, parent: fmt::Arguments<'_>) -> InvalidInput {
    if error.field == "shape.spacing" {
        let allowed = format!("{}, in {parent}", error.allowed);
        return InvalidInput::new("resolution", format_args!("spacing {} m", error.value), allowed);
    }
    error.inside(parent)
}

/// A body with the weights of its samples.
pub(super) fn plan_body(
    body: &Body,
    periodic: &Periodic,
    layer: &WallLayer,
    support_radius: f32,
) -> Result<PlannedBody, InvalidInput> {
    check_crowding(&body.samples, support_radius)?;
    check_width(&body.samples, periodic, support_radius)?;
    let (volumes, own_densities) = match body.sampling {
        BodySampling::SingleLayer => (layer.volumes(&body.samples), Vec::new()),
        BodySampling::QuasiFluid { layers } => {
            let alone = Periodic::default();
            let volumes = quasi_fluid::volumes(&body.samples, layers, layer, &alone);
            let own = quasi_fluid::own_densities(&body.samples, &volumes, layer, &alone);
            (volumes, own)
        }
    };
    let reach = body.samples.iter().map(|sample| sample.length()).fold(0.0, f32::max);
    let (roots, swelling_reach) = swelling::roots(&body.samples, &body.solids, layer.spacing());
    Ok(PlannedBody {
        name: body.name.clone(),
        samples: body.samples.clone(),
        reach,
        volumes,
        solids: body.solids.clone(),
        roots,
        swelling_reach,
        at_once: body.at_once,
        friction: body.friction,
        own_densities,
    })
}
