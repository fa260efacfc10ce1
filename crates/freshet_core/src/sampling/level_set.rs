//! Layers at a depth behind a surface: the points that are so far from it, on one side.
//!
//! Candidates come from a grid: each of its nodes near the depth moves to it along the way from the nearest point of the surface. So
//! convex edges stay sharp and concave ones are rounded without anyone asking for them, and it does not matter how the triangles of
//! a mesh hang together. Where a part is thinner than twice the depth no point is that deep; there the layer is one in the middle,
//! of the centres of balls that touch the surface on both sides (Ma et al. 2012).

use std::collections::HashMap;
use std::hash::BuildHasherDefault;

use glam::{DVec3, I64Vec3, Vec3};

use super::poisson::{CellHasher, DISTANCES, LEAST, Samples};
use super::surface::{check_mesh, visit_triangle};
use super::{MAX_CURVED_SAMPLES, check_estimate, too_many};
use crate::error::InvalidInput;
use crate::geometry::round::Profile;
use crate::geometry::{HeightField, TriangleMesh};

/// Nodes of the grid along each edge of a cell, which is half a spacing long.
const NODES: u32 = 3;

/// Most cells that the layer may pass, a multiple of what the most samples lie in.
const MAX_CELLS: usize = 16 * MAX_CURVED_SAMPLES;

/// How far from the depth a sample may be, over the spacing.
const TOLERANCE: f64 = 0.01;

/// Distance between points of triangles in the search for thin parts, over the spacing.
const THIN_STEP: f64 = 0.1;

/// A surface with an inside.
#[derive(Clone, Copy)]
pub(super) enum Surface<'a> {
    Mesh(&'a TriangleMesh),
    Round(&'a Profile),
    /// The surface alone, with no side: for layers of no depth.
    Sheet(&'a Profile),
    /// The ground is inside.
    Ground(&'a HeightField),
}

impl Surface<'_> {
    fn bounds(&self) -> (DVec3, DVec3) {
        match self {
            Self::Mesh(mesh) => mesh.bounds(),
            Self::Ground(field) => field.surface().bounds(),
            Self::Round(profile) | Self::Sheet(profile) => {
                let reach = profile.reach();
                let high = DVec3::new(reach.x, reach.y, reach.x);
                return (-high, high);
            }
        }
        .into_double()
    }

    fn mesh(&self) -> Option<&TriangleMesh> {
        match self {
            Self::Mesh(mesh) => Some(mesh),
            Self::Ground(field) => Some(field.surface()),
            Self::Round(_) | Self::Sheet(_) => None,
        }
    }

    /// The nearest point, which is known to be nearer than `limit`.
    fn nearest(&self, point: DVec3, limit: f64) -> DVec3 {
        match self {
            Self::Round(profile) | Self::Sheet(profile) => profile.nearest(point),
            // A mesh has a triangle.
            _ => self.mesh().and_then(|mesh| mesh.nearest(point, limit)).unwrap_or(DVec3::INFINITY),
        }
    }

    /// Whether a point is on the side of the layer.
    fn has_layer_at(&self, point: DVec3, inside: bool, margin: f64) -> bool {
        match self {
            Self::Mesh(mesh) => mesh.encloses(point) == inside,
            Self::Round(profile) => profile.encloses(point) == inside,
            Self::Sheet(_) => true,
            Self::Ground(field) => {
                let [x, y, z] = point.as_vec3().to_array();
                field.covers(x, z, margin as f32) && (y < field.height(x, z)) == inside
            }
        }
    }
}

trait IntoDouble {
    fn into_double(self) -> (DVec3, DVec3);
}

impl IntoDouble for (Vec3, Vec3) {
    fn into_double(self) -> (DVec3, DVec3) {
        (self.0.as_dvec3(), self.1.as_dvec3())
    }
}

/// Samples the points `depth` metres from a surface on its inside, or else outside, no two nearer than two thirds of a spacing, no
/// point of the layer farther than 0.75 from one.
///
/// # Errors
/// If there would be more than [`MAX_CURVED_SAMPLES`].
pub(super) fn sample_level_set(
    surface: Surface<'_>,
    depth: f64,
    inside: bool,
    spacing: f64,
) -> Result<Vec<Vec3>, InvalidInput> {
    match surface {
        Surface::Mesh(mesh) => check_mesh(mesh, spacing)?,
        Surface::Ground(field) => {
            let [x, z] = field.size().map(f64::from);
            // Before its surface is made.
            check_estimate(x * z / (spacing * spacing), spacing)?;
            check_mesh(field.surface(), spacing)?;
        }
        Surface::Round(profile) | Surface::Sheet(profile) => {
            check_estimate(profile.area() / (spacing * spacing), spacing)?
        }
    }
    let level = Level { surface, depth, inside, spacing };
    let cells = level.cells()?;
    let mut samples = Samples::new(spacing);
    for distance in DISTANCES {
        for cell in &cells {
            level.sample_cell(cell, distance * spacing, &mut samples);
        }
    }
    if let Some(mesh) = surface.mesh() {
        level.sample_thin_parts(mesh, &mut samples);
    }
    Ok(samples.into_positions())
}

/// A cell of the grid.
struct Cell {
    /// Its lowest corner, in edges.
    corner: I64Vec3,
    /// Distance of its middle from the surface, m.
    away: f64,
}

struct Level<'a> {
    surface: Surface<'a>,
    depth: f64,
    inside: bool,
    spacing: f64,
}

impl Level<'_> {
    /// Edge of a cell, m.
    fn edge(&self) -> f64 {
        0.5 * self.spacing
    }

    /// Half the diagonal of a cube of an edge.
    fn half_diagonal(edge: f64) -> f64 {
        0.5 * 3.0f64.sqrt() * edge
    }

    /// Cells that the layer passes, in rows: each goes on where another ended.
    fn cells(&self) -> Result<Vec<Cell>, InvalidInput> {
        let (low, high) = self.surface.bounds();
        let edge = self.edge();
        let first = ((low - self.depth) / edge).floor().as_i64vec3() - 1;
        let last = ((high + self.depth) / edge).floor().as_i64vec3() + 1;
        let size = ((last - first).max_element().max(1) as u64 + 1).next_power_of_two() as i64;
        let mut cells = Vec::new();
        let mut stack = vec![(first, size, f64::INFINITY)];
        while let Some((corner, size, limit)) = stack.pop() {
            let middle = (corner.as_dvec3() + 0.5 * size as f64) * edge;
            let away = self.surface.nearest(middle, limit).distance(middle);
            let reach = Self::half_diagonal(edge * size as f64);
            if (away - self.depth).abs() > reach + 1e-9 * away {
                continue;
            }
            if size > 1 {
                let half = size / 2;
                let child = |index: i64| corner + half * I64Vec3::new(index & 1, index >> 1 & 1, index >> 2);
                // The way from the middle of a cube to that of its eighth.
                stack.extend((0..8).map(|index| (child(index), half, (away + 0.5 * reach) * 1.000_001)));
            } else {
                cells.push(Cell { corner, away });
                if cells.len() > MAX_CELLS {
                    return Err(too_many(self.spacing, cells.len() as f64 / 16.0));
                }
            }
        }
        cells.sort_unstable_by_key(|cell| [cell.corner.z, cell.corner.y, cell.corner.x]);
        Ok(self.on_the_side(cells))
    }

    /// Of cells those on the side of the layer.
    ///
    /// The surface does not pass between neighbours whose middles are farther from it than half their edge, so they are on one side.
    /// One in [`VOTES`] of a connected piece is asked; where a mesh has holes and answers differ, each is.
    fn on_the_side(&self, cells: Vec<Cell>) -> Vec<Cell> {
        const VOTES: usize = 64;
        const STEPS: [I64Vec3; 6] =
            [I64Vec3::X, I64Vec3::Y, I64Vec3::Z, I64Vec3::NEG_X, I64Vec3::NEG_Y, I64Vec3::NEG_Z];
        let middle = |cell: &Cell| (cell.corner.as_dvec3() + 0.5) * self.edge();
        let has_layer = |cell: &Cell| self.surface.has_layer_at(middle(cell), self.inside, self.edge());
        let is_clear = |cell: &Cell| cell.away > 0.55 * self.edge();
        if self.surface.mesh().is_none() {
            // As fast to ask as to find out.
            return cells
                .into_iter()
                .filter(|cell| cell.away <= Self::half_diagonal(self.edge()) || has_layer(cell))
                .collect();
        }
        let mut unknown: HashMap<I64Vec3, u32, BuildHasherDefault<CellHasher>> =
            (0..).zip(&cells).filter(|(_, cell)| is_clear(cell)).map(|(index, cell)| (cell.corner, index)).collect();
        let mut keeps: Vec<bool> = cells.iter().map(|cell| !is_clear(cell)).collect();
        for (first, cell) in (0..).zip(&cells) {
            if unknown.remove(&cell.corner).is_none() {
                continue;
            }
            let mut piece: Vec<u32> = vec![first];
            let mut asked = 0;
            while let Some(&index) = piece.get(asked) {
                asked += 1;
                piece.extend(STEPS.iter().filter_map(|&step| unknown.remove(&(cells[index as usize].corner + step))));
            }
            let vote = |index: &u32| has_layer(&cells[*index as usize]);
            let votes: Vec<bool> = piece.iter().step_by(VOTES).map(vote).collect();
            let agreed = votes.iter().all(|vote| *vote == votes[0]);
            for index in &piece {
                keeps[*index as usize] = if agreed { votes[0] } else { vote(index) };
            }
        }
        cells.into_iter().zip(keeps).filter(|(_, keep)| *keep).map(|(cell, _)| cell).collect()
    }

    /// Adds samples on the layer in a cell that are as far from all others.
    fn sample_cell(&self, cell: &Cell, distance: f64, samples: &mut Samples) {
        let edge = self.edge();
        let step = edge / f64::from(NODES);
        // From a node to the layer, at most.
        let off = Self::half_diagonal(step) * 1.001;
        let middle = (cell.corner.as_dvec3() + 0.5) * edge;
        let half = Self::half_diagonal(edge);
        let mut near = samples.near(middle, distance + half + off);
        let limit = cell.away + 2.0 * (half + off);
        let mut triangles: Option<Option<Vec<[DVec3; 3]>>> = None;
        for node in 0..NODES.pow(3) {
            let index = [node % NODES, node / NODES % NODES, node / NODES / NODES].map(|i| f64::from(i) + 0.5);
            let point = cell.corner.as_dvec3() * edge + DVec3::from(index) * step;
            if near.iter().any(|sample| sample.distance_squared(point) < (distance - off).powi(2)) {
                continue;
            }
            let triangles =
                triangles.get_or_insert_with(|| self.surface.mesh().and_then(|mesh| mesh.near(middle, limit, 24)));
            let nearest = |point: DVec3| match &*triangles {
                Some(list) => nearest_of(list, point).unwrap_or_else(|| self.surface.nearest(point, f64::INFINITY)),
                None => self.surface.nearest(point, limit),
            };
            let mut foot = nearest(point);
            let mut away = foot.distance(point);
            if (away - self.depth).abs() > off || (away == 0.0 && self.depth > 0.0) {
                continue;
            }
            let mut sample = point;
            // At a sharp edge of the layer what is behind one face is before another; in turns it comes to both.
            for _ in 0..6 {
                sample = if self.depth > 0.0 { foot + (sample - foot) * (self.depth / away) } else { foot };
                if near.iter().any(|other| other.distance_squared(sample) < distance * distance) {
                    break;
                }
                foot = nearest(sample);
                away = foot.distance(sample);
                if (away - self.depth).abs() <= TOLERANCE * self.spacing {
                    if self.surface.has_layer_at(sample, self.inside, 0.0) {
                        samples.add(sample);
                        near.push(sample);
                    }
                    break;
                }
                if away == 0.0 {
                    break;
                }
            }
        }
    }

    /// Adds samples where the surface has none behind it because there is no room for the depth.
    fn sample_thin_parts(&self, mesh: &TriangleMesh, samples: &mut Samples) {
        let d = self.spacing;
        // The diagonal of a cube of the depth, and as far as the next sample may be: the corner of a box needs none.
        let tips = 3.0f64.sqrt() * self.depth + 0.75 * d;
        let mut left_over = Vec::new();
        for (distance, corners) in
            DISTANCES.into_iter().flat_map(|far| mesh.corners().map(move |corners| (far, corners)))
        {
            let corners = corners.map(|corner| corner.as_dvec3());
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
            let behind = normal * if self.inside { -self.depth } else { self.depth };
            let is_plain = |samples: &Samples, point: DVec3| !samples.is_free(point + behind, 0.7 * d);
            // Most triangles have the whole layer behind them: a look here and there is enough.
            let mut is_whole = normal != DVec3::ZERO;
            visit_triangle(corners, 3.0 * THIN_STEP * d, |point| is_whole = is_whole && is_plain(samples, point));
            if is_whole {
                continue;
            }
            visit_triangle(corners, THIN_STEP * d, |point| {
                // Behind a plate's face: in line with it, whatever is beside.
                let is_served = normal != DVec3::ZERO
                    && (is_plain(samples, point)
                        || samples.any(point, 1.3 * d, |sample| {
                            let way = sample - point;
                            (way - normal * way.dot(normal)).length() < 0.5 * d
                        }));
                if is_served {
                    return;
                }
                match self.middle_behind(point, normal) {
                    Some((sample, true)) if samples.is_free(sample, distance * d) => samples.add(sample),
                    Some((sample, false)) if distance == LEAST && samples.is_free(point, tips) => {
                        left_over.push((point, sample));
                    }
                    _ => {}
                }
            });
        }
        // Then tips and slivers, what all else has left out. A whole layer leaves nothing as far as this, but behind edges sharper
        // than those of a box.
        for (point, sample) in left_over {
            if samples.is_free(point, tips) && samples.is_free(sample, 0.55 * d) {
                samples.add(sample);
            }
        }
    }

    /// Centre of the largest ball up to the depth behind a point of the surface, that touches it there, and whether the ball is as
    /// large as that or wedged between two sides.
    fn middle_behind(&self, point: DVec3, normal: DVec3) -> Option<(DVec3, bool)> {
        let margin = 0.05 * self.spacing;
        let step = 1e-3 * self.spacing;
        let is_layer = |way: DVec3| self.surface.has_layer_at(point + way * step, self.inside, margin);
        // Triangles of ground miss its bilinear surface by more than this step, but all face up.
        let is_ground = matches!(self.surface, Surface::Ground(_));
        let way = match (normal != DVec3::ZERO).then(|| [is_layer(normal), is_layer(-normal)]) {
            Some(_) if is_ground => -normal,
            Some([true, false]) => normal,
            Some([false, true]) => -normal,
            // Between two parts of the inside there is no wall to be kept.
            Some([true, true]) => return None,
            // A flap without an inside, or a triangle without a normal, holds fluid as what it is.
            Some([false, false]) | None => return Some((point, false)),
        };
        let mut radius = self.depth;
        let mut touched = point;
        for _ in 0..30 {
            let center = point + way * radius;
            let foot = self.surface.nearest(center, 1.001 * radius);
            // None is nearer, or only what it touches already.
            if foot.distance(center) >= radius * (1.0 - 1e-6) {
                break;
            }
            let chord = foot - point;
            let along = 2.0 * chord.dot(way);
            if along <= 0.0 {
                break;
            }
            (radius, touched) = (chord.length_squared() / along, foot);
        }
        let center = point + way * radius;
        if let Surface::Ground(field) = self.surface
            && !field.covers(center.x as f32, center.z as f32, 0.0)
        {
            return None;
        }
        // On an edge the ball has no size, and touches nothing in particular.
        let is_wedged =
            radius > step && (point - center).normalize_or_zero().dot((touched - center).normalize_or_zero()) < -0.3;
        Some((center, is_wedged || touched == point))
    }
}

fn nearest_of(triangles: &[[DVec3; 3]], point: DVec3) -> Option<DVec3> {
    let feet = triangles.iter().map(|&triangle| crate::geometry::nearest_on_triangle(point, triangle));
    feet.min_by(|a, b| a.distance_squared(point).total_cmp(&b.distance_squared(point)))
}
