//! Samples that keep their distance.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use glam::{DVec3, I64Vec3, Vec3};

/// Distances between samples over the spacing, in the order in which they are asked of all candidates. The first makes rows about a
/// spacing apart, the second fills what they leave.
pub(super) const DISTANCES: [f64; 2] = [1.03, LEAST];

/// Least distance between samples over the spacing. With what candidates miss of a surface no point of it is farther than 0.75 from
/// a sample.
pub(super) const LEAST: f64 = 0.67;

/// Samples accepted so far, by cell.
pub(super) struct Samples {
    points: Vec<DVec3>,
    cells: HashMap<I64Vec3, Vec<u32>, BuildHasherDefault<CellHasher>>,
    /// Edge of a cell, m: searches reach from one to three spacings.
    cell: f64,
}

impl Samples {
    /// None yet, for particles `spacing` metres apart.
    pub fn new(spacing: f64) -> Self {
        Self { points: Vec::new(), cells: HashMap::default(), cell: 2.0 * spacing }
    }

    pub fn add(&mut self, point: DVec3) {
        let cell = self.cell_of(point);
        self.cells.entry(cell).or_default().push(self.points.len() as u32);
        self.points.push(point);
    }

    /// Whether any sample nearer than `reach` is of interest.
    pub fn any(&self, point: DVec3, reach: f64, mut is_of_interest: impl FnMut(DVec3) -> bool) -> bool {
        let (low, high) = (self.cell_of(point - reach), self.cell_of(point + reach));
        for z in low.z..=high.z {
            for y in low.y..=high.y {
                for x in low.x..=high.x {
                    let Some(cell) = self.cells.get(&I64Vec3::new(x, y, z)) else { continue };
                    let mut near = cell.iter().map(|&index| self.points[index as usize]);
                    if near.any(|other| other.distance_squared(point) < reach * reach && is_of_interest(other)) {
                        return true;
                    }
                }
            }
        }
        false
    }

    /// Whether no sample is nearer than `distance`.
    pub fn is_free(&self, point: DVec3, distance: f64) -> bool {
        !self.any(point, distance, |_| true)
    }

    /// All samples nearer than `reach`, instead of what was found before.
    pub fn near(&self, point: DVec3, reach: f64, found: &mut Vec<DVec3>) {
        found.clear();
        self.any(point, reach, |other| {
            found.push(other);
            false
        });
    }

    /// Rounded once.
    pub fn into_positions(self) -> Vec<Vec3> {
        self.points.into_iter().map(|point| point.as_vec3()).collect()
    }

    fn cell_of(&self, point: DVec3) -> I64Vec3 {
        (point / self.cell).floor().as_i64vec3()
    }
}

/// The standard one takes a third of the sampler's time.
#[derive(Default)]
pub(super) struct CellHasher(u64);

impl Hasher for CellHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.write_i64(i64::from(byte)));
    }

    fn write_i64(&mut self, value: i64) {
        self.0 = (self.0.rotate_left(26) ^ value as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    }
}
