//! Layers at a depth behind a surface: the points that are so far from it, on one side.
//!
//! Candidates come from a grid: each of its nodes near the depth moves to it along the way from the nearest point of the surface. So
//! convex edges stay sharp and concave ones are rounded without anyone asking for them, and it does not matter how the triangles of
//! a mesh hang together. Where a part is thinner than twice the depth no point is that deep; there the layer is one in the middle,
//! see [`thin_parts`](super::thin_parts).

use std::collections::HashMap;
use std::hash::BuildHasherDefault;

use glam::{DVec3, I64Vec3, Vec3};

use super::poisson::{CellHasher, DISTANCES, Samples};
use super::surface::check_mesh;
use super::{MAX_CURVED_SAMPLES, check_estimate, too_many};
use crate::error::InvalidInput;
use crate::geometry::mesh_tree::Near;
use crate::geometry::round::Profile;
use crate::geometry::{HeightField, TriangleMesh};

/// Nodes of the grid along each edge of a cell, which is half a spacing long.
const NODES: u32 = 3;

/// Most cells that the layer may pass, a multiple of what the most samples lie in.
const MAX_CELLS: usize = 16 * MAX_CURVED_SAMPLES;

/// How far from the depth a sample may be, over the spacing.
const TOLERANCE: f64 = 0.01;

/// Most triangles of a cube's list, and edge over a cell's of the largest cubes that have one.
const LONGEST: usize = 32;
const FIRST_LIST: i64 = 4;

/// Most triangles of all lists together, 8 bytes each; cells beyond ask the tree.
const MAX_NEAR: usize = 1 << 26;

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
    pub fn nearest(&self, point: DVec3, limit: f64) -> DVec3 {
        match self {
            Self::Round(profile) | Self::Sheet(profile) => profile.nearest(point),
            // A mesh has a triangle.
            _ => self.mesh().and_then(|mesh| mesh.nearest(point, limit)).unwrap_or(DVec3::INFINITY),
        }
    }

    /// Whether a point is on the side of the layer.
    pub fn has_layer_at(&self, point: DVec3, inside: bool, margin: f64) -> bool {
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
    let grid = level.grid()?;
    let mut samples = Samples::new(spacing);
    for distance in DISTANCES {
        for cell in &grid.cells {
            level.sample_cell(cell, grid.list(cell.near), distance * spacing, &mut samples);
        }
    }
    drop(grid);
    if let Some(mesh) = surface.mesh() {
        level.sample_thin_parts(mesh, &mut samples);
    }
    Ok(samples.into_positions())
}

/// A cell of the grid.
struct Cell {
    /// Its lowest corner, in edges.
    corner: I64Vec3,
    /// The point of the surface that is nearest to its middle, and how far that is, m.
    foot: DVec3,
    away: f64,
    /// Which of the grid's triangles are near it; none if they are too many.
    near: List,
}

/// A part of the grid's list of triangles.
type List = Option<(u32, u32)>;

/// Cells that the layer passes, with the triangles near to them.
struct Grid {
    cells: Vec<Cell>,
    near: Vec<Near>,
}

impl Grid {
    fn list(&self, list: List) -> Option<&[Near]> {
        list.map(|(first, end)| &self.near[first as usize..end as usize])
    }
}

pub(super) struct Level<'a> {
    pub surface: Surface<'a>,
    pub depth: f64,
    pub inside: bool,
    pub spacing: f64,
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

    /// From a node to the layer, at most, m.
    fn off(&self) -> f64 {
        Self::half_diagonal(self.edge() / f64::from(NODES)) * 1.001
    }

    /// How much farther than the surface a triangle may be from the middle of a cube that is nearest to a point of it, m.
    fn slack(&self, half_diagonal: f64) -> f64 {
        2.0 * (half_diagonal + self.off()) * 1.000_001
    }

    /// Cells that the layer passes, in rows: each goes on where another ended.
    ///
    /// A cube that is cut into eight hands down the triangles near it, as soon as they are few.
    fn grid(&self) -> Result<Grid, InvalidInput> {
        let (low, high) = self.surface.bounds();
        let edge = self.edge();
        let first = ((low - self.depth) / edge).floor().as_i64vec3() - 1;
        let last = ((high + self.depth) / edge).floor().as_i64vec3() + 1;
        let size = ((last - first).max_element().max(1) as u64 + 1).next_power_of_two() as i64;
        let tree = self.surface.mesh().map(TriangleMesh::tree);
        let mut grid = Grid { cells: Vec::new(), near: Vec::new() };
        let mut own = Vec::new();
        let mut stack = vec![(first, size, f64::INFINITY, List::None, 0.0)];
        while let Some((corner, size, limit, list, mut off)) = stack.pop() {
            let middle = (corner.as_dvec3() + 0.5 * size as f64) * edge;
            let reach = Self::half_diagonal(edge * size as f64);
            let foot = match (tree, grid.list(list)) {
                (Some(tree), Some(near)) => tree.nearest_of(near, off, middle),
                _ => None,
            };
            let foot = foot.unwrap_or_else(|| self.surface.nearest(middle, limit));
            let away = foot.distance(middle);
            if (away - self.depth).abs() > reach + 1e-9 * away {
                continue;
            }
            let mut near = list;
            if let Some(tree) = tree
                && grid.near.len() < MAX_NEAR
            {
                own.clear();
                let is_short = match grid.list(list) {
                    Some(before) => {
                        tree.list_again(before, off, middle, away + self.slack(reach), &mut own);
                        own.len() < before.len()
                    }
                    None => size <= FIRST_LIST && tree.list_near(middle, away + self.slack(reach), LONGEST, &mut own),
                };
                // What all of a list is near to needs none of its own, until cells look for samples with it.
                if is_short || (size == 1 && list.is_some()) {
                    let start = grid.near.len() as u32;
                    grid.near.append(&mut own);
                    (near, off) = (Some((start, grid.near.len() as u32)), 0.0);
                }
            }
            if size > 1 {
                let half = size / 2;
                let child = |index: i64| corner + half * I64Vec3::new(index & 1, index >> 1 & 1, index >> 2);
                // The way from the middle of a cube to that of its eighth.
                let way = 0.5 * reach * 1.000_001;
                stack.extend((0..8).map(|index| (child(index), half, (away + way) * 1.000_001, near, off + way)));
            } else {
                grid.cells.push(Cell { corner, foot, away, near: near.filter(|_| off == 0.0) });
                if grid.cells.len() > MAX_CELLS {
                    return Err(too_many(self.spacing, grid.cells.len() as f64 / 16.0));
                }
            }
        }
        grid.cells.sort_unstable_by_key(|cell| [cell.corner.z, cell.corner.y, cell.corner.x]);
        grid.cells = self.on_the_side(grid.cells);
        Ok(grid)
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
            HashMap::with_capacity_and_hasher(cells.len(), BuildHasherDefault::default());
        unknown.extend((0..).zip(&cells).filter(|(_, cell)| is_clear(cell)).map(|(index, cell)| (cell.corner, index)));
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
    fn sample_cell(&self, cell: &Cell, triangles: Option<&[Near]>, distance: f64, samples: &mut Samples) {
        let edge = self.edge();
        let step = edge / f64::from(NODES);
        let off = self.off();
        let middle = (cell.corner.as_dvec3() + 0.5) * edge;
        let half = Self::half_diagonal(edge);
        let mut near = Vec::new();
        samples.near(middle, distance + half + off, &mut near);
        let limit = cell.away + self.slack(half);
        let nearest = |point: DVec3| {
            match (triangles, self.surface.mesh()) {
                (Some(list), Some(mesh)) => mesh.tree().nearest_of(list, point.distance(middle), point),
                _ => None,
            }
            .unwrap_or_else(|| self.surface.nearest(point, limit))
        };
        let mut foot = cell.foot;
        for node in 0..NODES.pow(3) {
            let index = [node % NODES, node / NODES % NODES, node / NODES / NODES].map(|i| f64::from(i) + 0.5);
            let point = cell.corner.as_dvec3() * edge + DVec3::from(index) * step;
            if near.iter().any(|sample| sample.distance_squared(point) < (distance - off).powi(2)) {
                continue;
            }
            // The surface is at least as near as any point of it.
            if foot.distance_squared(point) < (self.depth - off).max(0.0).powi(2) {
                continue;
            }
            foot = nearest(point);
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::mesh_tree::work;
    use std::f32::consts::PI;

    const D: f64 = 0.1;

    /// Rows of quads from pole to pole.
    fn ball(radius: f32, rows: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let columns = 2 * rows;
        let at = |i: u32, j: u32| {
            let (theta, phi) = (PI * i as f32 / rows as f32, PI * j as f32 / rows as f32);
            let ring = if i == rows { 0.0 } else { theta.sin() };
            radius * Vec3::new(ring * phi.cos(), theta.cos(), -ring * phi.sin())
        };
        let vertices = (0..=rows).flat_map(|i| (0..columns).map(move |j| at(i, j))).collect();
        let quads = (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j)));
        let triangles = quads.flat_map(|(i, j)| {
            let (a, next) = (i * columns, (j + 1) % columns);
            let b = a + columns;
            [[a + j, b + j, b + next], [a + j, b + next, a + next]]
        });
        (vertices, triangles.collect())
    }

    /// Samples, and triangles looked at for each.
    fn cost(vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> (usize, f64) {
        let mesh = TriangleMesh::new(vertices, triangles).unwrap();
        work::take();
        let samples = sample_level_set(Surface::Mesh(&mesh), 0.92 * D, true, D).unwrap().len();
        (samples, work::take() as f64 / samples as f64)
    }

    fn plate(half: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let corner = |i: u32| {
            Vec3::new(half, 0.05, half) * Vec3::from([i & 1, i >> 1 & 1, i >> 2].map(|bit| 2.0 * bit as f32 - 1.0))
        };
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        ((0..8).map(corner).collect(), triangles)
    }

    /// What a sample costs does not grow with the number of samples, and hardly with that of triangles, nor where a solid is thin.
    #[test]
    fn the_cost_of_a_sample_is_bounded() {
        let of = |(vertices, triangles)| cost(vertices, triangles);
        let (small, large) = (of(ball(1.0, 20)), of(ball(2.0, 20)));
        let (coarse, fine) = (of(ball(1.0, 40)), of(ball(1.0, 160)));
        let (short, wide) = (of(plate(1.0)), of(plate(2.0)));
        println!("balls {small:?} {large:?}, finer {coarse:?} {fine:?}, plates {short:?} {wide:?}");
        assert!(large.0 > 3 * small.0 && wide.0 > 3 * short.0);
        assert!(large.1 < 1.2 * small.1, "four times as many samples: {small:?} {large:?}");
        assert!(wide.1 < 1.2 * short.1, "four times as wide a plate: {short:?} {wide:?}");
        // 2.5 times as many: those that are about equally near to a point are on one side of it, and only they are looked at.
        assert!(fine.1 < 4.0 * coarse.1, "16 times as many triangles: {coarse:?} {fine:?}");
        // 700 to 1650. All pairs would be 10 thousands for the balls.
        for each in [small, large, short, wide] {
            assert!(each.1 < 2500.0, "{each:?}");
        }
    }
}
