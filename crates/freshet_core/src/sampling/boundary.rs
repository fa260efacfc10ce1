//! Single layers of samples for walls and bodies, half a spacing behind a surface: outside of a tank, inside of a body.
//!
//! How deep a layer has to lie behind the face that the fluid touches, and what it has to weigh, is decided in
//! [`super::wall_layer`], which moves the surface that it gives to these functions: scenes use [`WallLayer`](super::wall_layer::WallLayer).

use std::f64::consts::PI;

use glam::{DVec3, Vec3};

use super::{ROUNDING, check_count, check_extent, check_half_extents, check_spacing, too_thin};
use crate::error::{InvalidInput, check_finite};

/// Samples the walls of a box-shaped tank, centred at the origin, with the fluid inside.
///
/// The layer is the surface of the box enlarged by `d/2`. Along each edge the step divides the length evenly and is the one
/// closest to `d` (never above 4/3 d); edges and corners are sampled once.
///
/// `open` takes away the faces -x, +x, -y, +y, -z, +z in turn. The walls next to an open face end flush with its rim: their
/// last row lies `d/2` within, for it stands for `d/2` on either side. With no face left there are no samples.
/// x runs fastest, then y, then z.
///
/// # Errors
/// If a half extent is not within 1e-6..=1e6 m or the spacing not within 1e-6..=1e4 m; if along an axis the tank is shorter than
/// half the spacing; if there are more samples than [`super::MAX_SAMPLES`].
pub fn sample_container(half_extents: Vec3, open: [bool; 6], spacing: f32) -> Result<Vec<Vec3>, InvalidInput> {
    let half_extents = check_half_extents(half_extents)?;
    let d = check_spacing(spacing)?;
    require_thickness(half_extents, 0.25 * d)?;
    let offset = |open: bool| if open { -0.5 * d } else { 0.5 * d };
    let row = |axis: usize| {
        let (low_open, high_open) = (open[2 * axis], open[2 * axis + 1]);
        let half = half_extents[axis];
        Row::new(-half - offset(low_open), half + offset(high_open), d, [!low_open, !high_open])
    };
    shell([row(0), row(1), row(2)], d)
}

/// Samples the surface of a box-shaped body, centred at the origin, with the fluid outside.
///
/// The layer is the surface of the box shrunk by `d/2`, sampled as that of [`sample_container`]. Where less than `d/2` is left
/// between two opposite faces of it (a plate thinner than 1.5 d), they are one layer in the middle. x runs fastest.
///
/// # Errors
/// If a half extent is not within 1e-6..=1e6 m or the spacing not within 1e-6..=1e4 m; if a half extent is less than `d/2`, so that
/// no layer fits in; if there are more samples than [`super::MAX_SAMPLES`].
pub fn sample_box_surface(half_extents: Vec3, spacing: f32) -> Result<Vec<Vec3>, InvalidInput> {
    let half_extents = check_half_extents(half_extents)?;
    let d = check_spacing(spacing)?;
    require_thickness(half_extents, 0.5 * d)?;
    let row = |axis: usize| {
        let half = (half_extents[axis] - 0.5 * d).max(0.0);
        Row::new(-half, half, d, [true, true])
    };
    shell([row(0), row(1), row(2)], d)
}

/// Samples the surface of a ball-shaped body, centred at the origin, with the fluid outside.
///
/// The layer is a sphere of radius `R = radius - d/2` with `4 pi R^2 / d^2` samples, rounded, on a Fibonacci spiral
/// (Swinbank & Purser 2006, shifted by 0.36 of a turn's step, which evens out the poles): no two are nearer than 0.5 d, and no
/// point of the sphere is farther than 0.75 d from one. A ball with room for one sample only has it in its centre.
///
/// # Errors
/// If the radius is not within 1e-6..=1e6 m or the spacing not within 1e-6..=1e4 m; if the radius is less than `d/2`; if there are
/// more samples than [`super::MAX_SAMPLES`].
pub fn sample_sphere_surface(radius: f32, spacing: f32) -> Result<Vec<Vec3>, InvalidInput> {
    const SHIFT: f64 = 0.36;
    let r = check_extent("radius", radius)?;
    let d = check_spacing(spacing)?;
    if r < 0.5 * d * (1.0 - ROUNDING) {
        return Err(too_thin("radius", r, 0.5 * d));
    }
    let layer = (r - 0.5 * d).max(0.0);
    let count = check_count(d, (4.0 * PI * (layer / d).powi(2)).round())?;
    if count <= 1 {
        return Ok(vec![Vec3::ZERO]);
    }
    let golden_angle = PI * (3.0 - 5.0_f64.sqrt());
    let sample = |index: usize| {
        let y = 1.0 - 2.0 * (index as f64 + SHIFT) / (count as f64 - 1.0 + 2.0 * SHIFT);
        let (sin, cos) = (golden_angle * index as f64).sin_cos();
        let ring = (1.0 - y * y).max(0.0).sqrt();
        (layer * DVec3::new(ring * cos, y, ring * sin)).as_vec3()
    };
    Ok((0..count).map(sample).collect())
}

/// Samples a rectangular patch of wall, centred at the origin, with the fluid on the side that `normal` points to.
///
/// The layer lies `d/2` behind the patch. `u` and `v` are the two vectors of glam's `any_orthonormal_pair` for the unit normal.
/// Along each, the samples are the centres of equal parts of the length, of the size closest to `d`, so that patches side by
/// side go on without a seam. u runs fastest.
///
/// # Errors
/// If the normal is not finite or too short to have a direction; if a half extent is not within 1e-6..=1e6 m or the spacing
/// not within 1e-6..=1e4 m; if the patch is narrower than half the spacing; if there are more samples than [`super::MAX_SAMPLES`].
pub fn sample_plane(
    normal: Vec3,
    half_extent_u: f32,
    half_extent_v: f32,
    spacing: f32,
) -> Result<Vec<Vec3>, InvalidInput> {
    check_finite("normal", normal)?;
    let unit = normal.as_dvec3().normalize_or_zero();
    if unit == DVec3::ZERO {
        return Err(InvalidInput::new("normal", normal, "a vector longer than zero"));
    }
    let extents = [("half_extent_u", half_extent_u), ("half_extent_v", half_extent_v)];
    let mut halves = [0.0; 2];
    for (half, (field, value)) in halves.iter_mut().zip(extents) {
        *half = check_extent(field, value)?;
    }
    let d = check_spacing(spacing)?;
    for (half, (field, _)) in halves.iter().zip(extents) {
        if *half < 0.25 * d * (1.0 - ROUNDING) {
            return Err(too_thin(field, *half, 0.25 * d));
        }
    }
    let parts = halves.map(|half| closest_parts(2.0 * half, d));
    let count = check_count(d, parts[0] * parts[1])?;
    let (u, v) = unit.any_orthonormal_pair();
    let along = |axis: usize, index: usize| halves[axis] * ((2.0 * index as f64 + 1.0) / parts[axis] - 1.0);
    let mut positions = Vec::with_capacity(count);
    for j in 0..parts[1] as usize {
        let row = v * along(1, j) - unit * (0.5 * d);
        positions.extend((0..parts[0] as usize).map(|i| (u * along(0, i) + row).as_vec3()));
    }
    Ok(positions)
}

/// The nodes of a box's layer along one axis.
struct Row {
    first: f64,
    step: f64,
    /// Number of steps, as the number that the count is checked with.
    steps: f64,
    /// Whether there is a face at the first and at the last node.
    faces: [bool; 2],
}

impl Row {
    fn new(first: f64, last: f64, d: f64, faces: [bool; 2]) -> Self {
        let length = last - first;
        if length < 0.5 * d * (1.0 - ROUNDING) {
            return Self { first: 0.5 * (first + last), step: 0.0, steps: 0.0, faces };
        }
        let steps = closest_parts(length, d);
        Self { first, step: length / steps, steps, faces }
    }

    fn last(&self) -> usize {
        self.steps as usize
    }

    fn at(&self, index: usize) -> f32 {
        (self.first + self.step * index as f64) as f32
    }

    /// Whether the node belongs to one of the two faces across this axis.
    fn on_face(&self, index: usize) -> bool {
        (index == 0 && self.faces[0]) || (index == self.last() && self.faces[1])
    }

    fn face_nodes(&self) -> f64 {
        if self.steps == 0.0 {
            f64::from(u8::from(self.faces[0] || self.faces[1]))
        } else {
            f64::from(u8::from(self.faces[0]) + u8::from(self.faces[1]))
        }
    }

    /// Calls `f` for every node, or, unless `all`, for those on a face: without passing the others, which may be very many.
    fn visit(&self, all: bool, mut f: impl FnMut(usize)) {
        if all {
            (0..=self.last()).for_each(f);
        } else {
            if self.faces[0] || (self.last() == 0 && self.faces[1]) {
                f(0);
            }
            if self.faces[1] && self.last() > 0 {
                f(self.last());
            }
        }
    }
}

/// The nodes that lie on a face, each once.
fn shell(rows: [Row; 3], d: f64) -> Result<Vec<Vec3>, InvalidInput> {
    let all: f64 = rows.iter().map(|row| row.steps + 1.0).product();
    let off_faces: f64 = rows.iter().map(|row| row.steps + 1.0 - row.face_nodes()).product();
    let mut positions = Vec::with_capacity(check_count(d, all - off_faces)?);
    let [x, y, z] = rows;
    let any_x = x.face_nodes() > 0.0;
    let any_xy = any_x || y.face_nodes() > 0.0;
    z.visit(any_xy, |k| {
        let on_z = z.on_face(k);
        y.visit(on_z || any_x, |j| {
            x.visit(on_z || y.on_face(j), |i| positions.push(Vec3::new(x.at(i), y.at(j), z.at(k))));
        });
    });
    Ok(positions)
}

/// Into how many equal parts, at least one, a length is cut so that a part is closest to `d`.
fn closest_parts(length: f64, d: f64) -> f64 {
    let fewer = (length / d).floor().max(1.0);
    let more = fewer + 1.0;
    if (length / fewer - d).abs() <= (length / more - d).abs() { fewer } else { more }
}

fn require_thickness(half_extents: [f64; 3], least: f64) -> Result<(), InvalidInput> {
    for (half, field) in half_extents.into_iter().zip(["half_extents.x", "half_extents.y", "half_extents.z"]) {
        if half < least * (1.0 - ROUNDING) {
            return Err(too_thin(field, half, least));
        }
    }
    Ok(())
}
