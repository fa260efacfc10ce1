//! The tables of cells, and the walls' samples sorted into them once.

use freshet_core::plan::Plan;
use freshet_core::wall_method::Face;

use glam::Vec3;

use crate::fine_grid::FineGrid;
use crate::passes::moving_walls;
use crate::shader::SCAN_BLOCK;

/// Where the sections of the two tables begin, in cells. Each section has an entry more than there are cells: the counts
/// for what falls out, the starts for the end of the last cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct CellTables {
    /// Counts of body samples, after those of particles.
    pub body_counts: u32,
    /// Entries of the table of counts.
    pub counts: u32,
    /// Starts of wall samples, after those of particles.
    pub wall_starts: u32,
    /// Starts of body samples.
    pub body_starts: u32,
    /// Totals of blocks, for the prefix sum.
    pub block_sums: u32,
    /// Entries of the table of starts.
    pub starts: u32,
}

impl CellTables {
    /// The tables of a plan: sections for what it has.
    pub fn of(plan: &Plan) -> Self {
        let section = FineGrid::of(&plan.grid).cells() + 1;
        let walls = if plan.boundary.positions.is_empty() { 0 } else { section };
        let bodies = if plan.bodies.is_empty() { 0 } else { section };
        let block_sums = section + walls + bodies;
        Self {
            body_counts: section,
            counts: section + bodies,
            wall_starts: section,
            body_starts: section + walls,
            block_sums,
            starts: block_sums + section.div_ceil(SCAN_BLOCK),
        }
    }
}

/// What acts along the viscous faces of walls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WallDrag {
    /// Nothing, or there are none.
    None,
    /// The fluid's artificial viscosity.
    Artificial,
    /// Morris' viscosity: fluid sticks to them.
    Morris,
}

impl WallDrag {
    /// That of a plan.
    pub fn of(plan: &Plan) -> Self {
        match &plan.parameters {
            _ if !plan.boundary.viscous.contains(&true) => WallDrag::None,
            p if p.dynamic_viscosity > 0.0 => WallDrag::Morris,
            p if p.artificial_viscosity > 0.0 => WallDrag::Artificial,
            _ => WallDrag::None,
        }
    }
}

/// Set in a cell's start where the rows around it hold samples, as in `freshet::grid`.
const NEAR_WALLS: u32 = 1 << 31;

/// Where the samples of bodies begin: behind those of walls and, if some move, their velocities.
pub(crate) fn first_body_sample(plan: &Plan) -> usize {
    plan.boundary.positions.len() * if moving_walls(plan) { 2 } else { 1 }
}

/// The samples of walls.
pub(crate) struct SortedWalls {
    /// Position, m, and volume, m3.
    pub samples: Vec<[f32; 4]>,
    /// Velocities of their surfaces, m/s; empty if none moves.
    pub velocities: Vec<[f32; 4]>,
    /// Their coefficients of friction; empty if there is none.
    pub frictions: Vec<[f32; 2]>,
    /// Normals of their faces, and how far behind they lie, m; empty if the plan does not need them.
    pub faces: Vec<[f32; 4]>,
    /// What they add to each other's densities, over that at rest, and no pressure; empty but for quasi-fluid.
    pub densities: Vec<[f32; 2]>,
    /// First sample of each cell, with the bit [`NEAR_WALLS`].
    pub starts: Vec<u32>,
}

/// Samples of walls sorted by cell, in the plan's order within a cell, and the first sample of each cell with its bit
/// [`NEAR_WALLS`].
///
/// A sample is its position and its volume; the volume's sign is negative where a viscous face drags the fluid along. Samples
/// that move along their faces have a velocity, in the same order.
pub(crate) fn sort_walls(plan: &Plan) -> SortedWalls {
    let grid = FineGrid::of(&plan.grid);
    let positions: Vec<Vec3> = plan.boundary.positions.iter().map(|&x| plan.grid.periodic.wrap(x)).collect();
    let cells: Vec<u32> = positions.iter().map(|&position| grid.index(position)).collect();
    let mut order: Vec<usize> = (0..cells.len()).collect();
    order.sort_by_key(|&k| cells[k]);
    let mut starts = vec![0; grid.cells() as usize + 1];
    for &cell in &cells {
        starts[cell as usize + 1] += 1;
    }
    for cell in 1..starts.len() {
        starts[cell] += starts[cell - 1];
    }
    for index in 0..order.len() {
        let cell = cells[order[index]];
        if index == 0 || cell != cells[order[index - 1]] {
            grid.around(cell).for_each(|near| starts[near as usize] |= NEAR_WALLS);
        }
    }
    let drags = WallDrag::of(plan) != WallDrag::None;
    let sample = |&k: &usize| {
        let [x, y, z] = positions[k].to_array();
        let volume = plan.boundary.volumes[k];
        [x, y, z, if drags && plan.boundary.viscous[k] { -volume } else { volume }]
    };
    let velocity = |&k: &usize| plan.boundary.velocities[k].extend(0.0).to_array();
    let moving = if moving_walls(plan) { order.iter().map(velocity).collect() } else { Vec::new() };
    let frictions = if plan.boundary.frictions.is_empty() {
        Vec::new()
    } else {
        order.iter().map(|&k| plan.boundary.frictions[k]).collect()
    };
    let face = |&k: &usize| {
        let Face { normal, depth } = plan.boundary.faces[k];
        normal.extend(depth).to_array()
    };
    let faces = if plan.boundary.faces.is_empty() { Vec::new() } else { order.iter().map(face).collect() };
    let density = |&k: &usize| [plan.boundary.own_densities[k], 0.0];
    let densities =
        if plan.boundary.own_densities.is_empty() { Vec::new() } else { order.iter().map(density).collect() };
    SortedWalls { samples: order.iter().map(sample).collect(), velocities: moving, frictions, faces, densities, starts }
}
