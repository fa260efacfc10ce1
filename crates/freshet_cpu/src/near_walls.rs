//! What samples of walls are around a particle, of plans whose walls push by themselves.

use freshet_core::grid::Grid;
use freshet_core::plan::Plan;
use freshet_core::wall_method::ghosts::{self, Image};
use freshet_core::wall_method::{MOST_PLANES, Plane};
use glam::Vec3;

use crate::neighbours::Rows;
use crate::particles::Particles;
use crate::samples::SortedSamples;

/// Walls that push by themselves, sorted by cell.
#[derive(Default)]
pub struct PushingWalls {
    samples: SortedSamples,
    /// Of each cell, whether there are samples in it or next to it.
    near: Vec<bool>,
}

impl PushingWalls {
    /// Those of a plan; none if its walls are in the sums.
    pub fn of(plan: &Plan) -> Self {
        let mut walls = Self::default();
        let (grid, boundary) = (&plan.grid, &plan.boundary);
        if !boundary.positions.is_empty() && !plan.sums_walls() {
            walls.samples.sort(grid, &boundary.positions, &boundary.volumes);
            let starts = &walls.samples.starts;
            let is_near = |cell: u32| !Rows::around(grid, starts, cell as usize).all().is_empty();
            walls.near = (0..grid.cells()).map(is_near).collect();
        }
        walls
    }

    /// Bytes allocated.
    pub fn bytes(&self) -> u64 {
        self.samples.bytes() + self.near.capacity() as u64
    }
}

/// Walls, seen from particles.
#[derive(Clone, Copy)]
pub struct NearWalls<'a> {
    /// The walls.
    pub walls: &'a PushingWalls,
    /// What they are of.
    pub plan: &'a Plan,
}

/// The rows of samples around a place.
pub struct Around<'a> {
    at: Vec3,
    rows: Rows,
    samples: &'a SortedSamples,
    periods: Vec3,
}

impl<'a> NearWalls<'a> {
    /// The samples around a place, if there are any.
    pub fn around(&self, at: Vec3) -> Option<Around<'a>> {
        let grid = &self.plan.grid;
        let cell = grid.index(grid.coordinates(at)) as usize;
        let samples = &self.walls.samples;
        self.walls.near[cell].then(|| Around {
            at,
            rows: Rows::around(grid, &samples.starts, cell),
            samples,
            periods: grid.periodic.lengths(),
        })
    }

    /// The planes of a particle; `samples` is memory.
    pub fn planes(&self, around: &Around<'_>, samples: &mut Vec<(usize, Vec3)>) -> ([Plane; MOST_PLANES], usize) {
        let parameters = &self.plan.parameters;
        let [reach, beside] = parameters.wall_method.reach_of_planes(parameters.spacing, parameters.support_radius);
        samples.clear();
        around.each(reach, |slot, x, _| samples.push((slot, x)));
        Plane::among(samples, |slot| self.plan.boundary.faces[self.source(slot)], [reach, beside])
    }

    /// The images behind the planes of a particle; `samples` is memory.
    pub fn images(&self, around: &Around<'_>, samples: &mut Vec<(usize, Vec3)>) -> Images {
        let (planes, count) = self.planes(around, samples);
        let sticks = planes.map(|plane| self.plan.boundary.viscous[self.source(plane.sample)]);
        Images { planes, sticks, count, reach: self.plan.grid.support_radius }
    }

    /// The number in the plan of the sample in a slot.
    pub fn source(&self, slot: usize) -> usize {
        self.walls.samples.source[slot] as usize
    }
}

/// Planes of a particle in which the fluid has images.
pub struct Images {
    planes: [Plane; MOST_PLANES],
    sticks: [bool; MOST_PLANES],
    count: usize,
    reach: f32,
}

impl Images {
    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = Image> {
        ghosts::images(&self.planes[..self.count], &self.sticks, self.reach)
    }
}

/// Calls `look` with each particle that is within the support of a place, the way from it to the place, m, and the square of that, m2.
#[inline(always)]
pub fn each_particle(
    grid: &Grid,
    starts: &[u32],
    particles: &Particles,
    at: Vec3,
    mut look: impl FnMut(usize, Vec3, f32),
) {
    let rows = Rows::around(grid, starts, grid.index(grid.coordinates(at)) as usize);
    let reach = grid.support_radius * grid.support_radius;
    for b in rows.all().iter().flat_map(|&(first, end)| first as usize..end as usize) {
        let apart = grid.periodic.nearest(at - particles.position_of(b));
        let squared = apart.length_squared();
        if squared < reach {
            look(b, apart, squared);
        }
    }
}

impl Around<'_> {
    /// Calls `look` with the slot of each sample that is nearer than `reach` metres, the way from it to the place, m, and the square of that, m2.
    #[inline(always)]
    pub fn each(&self, reach: f32, mut look: impl FnMut(usize, Vec3, f32)) {
        let [x, y, z] = &self.samples.position;
        for (&(first, end), &wraps) in self.rows.all().iter().zip(self.rows.wraps()) {
            let image = self.at - self.periods * Vec3::from(wraps.map(f32::from));
            let range = first as usize..end as usize;
            let places = x[range.clone()].iter().zip(&y[range.clone()]).zip(&z[range.clone()]);
            for (slot, ((&x, &y), &z)) in range.zip(places) {
                let apart = image - Vec3::new(x, y, z);
                let squared = apart.length_squared();
                if squared < reach * reach {
                    look(slot, apart, squared);
                }
            }
        }
    }
}
