//! Fluid volumes filled with the cell centres of a cubic lattice.
//!
//! Each sample stands for a cube of `d^3` around it, so that its mass is `rho0 d^3` and a box of a whole number of cells
//! weighs exactly what it should. (P listing 4.1 puts nodes at both ends, which makes the spacing `L / (n - 1)` and the mass
//! too large.)

use std::f64::consts::PI;

use glam::{DVec3, Vec3};

use super::{ROUNDING, check_count, check_extent, check_half_extents, check_spacing, too_thin};
use crate::error::InvalidInput;

/// How many lattice cells of `spacing` metres fit along each axis of a box: its length over the spacing, rounded.
///
/// # Errors
/// If a half extent is not within 1e-6..=1e6 m or the spacing not within 1e-6..=1e4 m; if along an axis the box is shorter than
/// half the spacing, so that no cell is left; if there are more cells than [`super::MAX_SAMPLES`].
pub fn box_cells(half_extents: Vec3, spacing: f32) -> Result<[usize; 3], InvalidInput> {
    let half_extents = check_half_extents(half_extents)?;
    let d = check_spacing(spacing)?;
    let cells = half_extents.map(|half| (2.0 * half / d * (1.0 + ROUNDING)).round());
    for (axis, field) in ["half_extents.x", "half_extents.y", "half_extents.z"].into_iter().enumerate() {
        if cells[axis] < 1.0 {
            return Err(too_thin(field, half_extents[axis], 0.25 * d));
        }
    }
    check_count(d, cells.iter().product())?;
    Ok(cells.map(|n| n as usize))
}

/// How many samples [`sample_box`] makes.
///
/// # Errors
/// As [`box_cells`].
pub fn count_box(half_extents: Vec3, spacing: f32) -> Result<usize, InvalidInput> {
    Ok(box_cells(half_extents, spacing)?.iter().product())
}

/// Fills a box, centred at the origin, with the cell centres of a lattice of `spacing` metres.
///
/// Along each axis there are `round(2 half / d)` samples, exactly `d` apart and centred: where the box is no whole number of
/// cells long, the outer cells end up to `d/4` inside or outside of its faces. x runs fastest, then y, then z.
///
/// # Errors
/// As [`box_cells`].
pub fn sample_box(half_extents: Vec3, spacing: f32) -> Result<Vec<Vec3>, InvalidInput> {
    let cells = box_cells(half_extents, spacing)?;
    let at = |axis: usize, index: usize| centre(index, cells[axis], f64::from(spacing)) as f32;
    let mut positions = Vec::with_capacity(cells.iter().product());
    for k in 0..cells[2] {
        for j in 0..cells[1] {
            positions.extend((0..cells[0]).map(|i| Vec3::new(at(0, i), at(1, j), at(2, k))));
        }
    }
    Ok(positions)
}

/// Fills a ball, centred at the origin, with those cell centres of a lattice of `spacing` metres that lie in it.
///
/// The lattice has either a cell's centre or a cell's corner at the origin, whichever brings the number of samples times `d^3`
/// closer to the ball's volume (at a tie the former). What is left is up to 26 % at a radius of 2 to
/// 3 d, 10 % at 3 to 5 d, 6 % at 5 to 10 d and 2 % at 10 to 20 d; the mass of the fluid is off by as much. x runs fastest, then y, then z.
///
/// # Errors
/// If the radius is not within 1e-6..=1e6 m or the spacing not within 1e-6..=1e4 m; if the radius is less than `d/2`, when the
/// ball is closer to no sample than to one; if there are more samples than [`super::MAX_SAMPLES`].
pub fn sample_sphere(radius: f32, spacing: f32) -> Result<Vec<Vec3>, InvalidInput> {
    let r = check_extent("radius", radius)?;
    let d = check_spacing(spacing)?;
    if r < 0.5 * d * (1.0 - ROUNDING) {
        return Err(too_thin("radius", r, 0.5 * d));
    }
    let volume = 4.0 / 3.0 * PI * (r / d).powi(3);
    // Count and volume differ by far less than this where it matters; the exact check follows.
    check_count(d, 0.5 * volume)?;
    let counts = [0.0, 0.5].map(|shift| {
        let mut count = 0.0;
        visit_ball(r / d, shift, |_| count += 1.0);
        count
    });
    let miss = counts.map(|count| (count - volume).abs());
    let (shift, count) = if miss[0] <= miss[1] { (0.0, counts[0]) } else { (0.5, counts[1]) };
    let mut positions = Vec::with_capacity(check_count(d, count)?);
    visit_ball(r / d, shift, |x| positions.push((x * d).as_vec3()));
    Ok(positions)
}

/// Calls `f` for each point of the unit lattice, moved by `shift` along each axis, within `radius` of the origin.
fn visit_ball(radius: f64, shift: f64, mut f: impl FnMut(DVec3)) {
    let limit = (radius * (1.0 + ROUNDING)).powi(2);
    let reach = (radius + 1.0).ceil() as i32;
    let along = || (-reach..=reach).map(|index| f64::from(index) + shift);
    for z in along() {
        for y in along().filter(|y| y * y + z * z <= limit) {
            for x in along().filter(|x| x * x + y * y + z * z <= limit) {
                f(DVec3::new(x, y, z));
            }
        }
    }
}

/// The centre of cell `index` of `cells`, of which the row is centred at 0.
fn centre(index: usize, cells: usize, d: f64) -> f64 {
    (index as f64 - 0.5 * (cells as f64 - 1.0)) * d
}
