//! Stage `sort`: particles by cell, by id within a cell; the retired and the removed fall out.

use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use freshet_core::grid::Grid;
use glam::{UVec3, Vec3};
use pulp::{Arch, Simd, WithSimd};

use crate::particles::Particles;
use crate::tasks::{Tasks, Total};
use crate::workers::{Chunk, Workers, cut_into_chunks};

/// Memory of the sort, kept between substeps.
#[derive(Default)]
pub struct Sorter {
    /// First particle of each cell, and the number of particles.
    pub starts: Vec<u32>,
    /// Runs of cells that share the work of the next passes.
    pub chunks: Vec<Chunk>,
    /// Particles of each histogram.
    blocks: Vec<Range<usize>>,
    keys: Vec<u32>,
    order: Vec<AtomicU32>,
    cursors: Vec<Vec<u32>>,
}

/// Particles that fell out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dropped {
    /// Their lifetime was over or a command said so.
    pub retired: u32,
    /// They were not finite or out of bounds.
    pub removed: u32,
    /// Those of the removed that were not finite.
    pub not_finite: u32,
}

impl Total for Dropped {
    fn and(self, other: Self) -> Self {
        Self {
            retired: self.retired + other.retired,
            removed: self.removed + other.removed,
            not_finite: self.not_finite + other.not_finite,
        }
    }
}

/// Bounds and grid, as the keys need them.
struct KeyRule {
    origin: Vec3,
    inverse_edges: Vec3,
    mask: UVec3,
    shift: [u32; 3],
    trash: u32,
    bounds: [Vec3; 2],
    repeats: [bool; 3],
}

impl KeyRule {
    fn new(grid: &Grid, bounds: [Vec3; 2]) -> Self {
        Self {
            origin: grid.origin(),
            inverse_edges: 1.0 / grid.cell_edges(),
            mask: grid.dimensions() - UVec3::ONE,
            shift: [0, grid.log_cells.x, grid.log_cells.x + grid.log_cells.y],
            trash: grid.cells(),
            bounds,
            repeats: [0, 1, 2].map(|axis| grid.periodic.along(axis).is_some()),
        }
    }

    /// The key of a particle: its cell, or for one that falls out the one after all cells; and what it falls out as.
    /// Without branches, so that the compiler makes lanes of a loop over it.
    #[inline(always)]
    fn key<const PERIODIC: bool>(&self, position: [f32; 3], velocity: [f32; 3], life: f32) -> (u32, Dropped) {
        let [min, max] = self.bounds;
        let is_retired = life <= 0.0;
        let (mut is_finite, mut is_inside) = (true, true);
        let mut key = 0;
        for axis in 0..3 {
            // Comparisons with NaN are false.
            is_finite &= (position[axis].abs() < f32::INFINITY) & (velocity[axis].abs() < f32::INFINITY);
            is_inside &= (position[axis] >= min[axis]) & (position[axis] <= max[axis]);
            let along = position[axis] * self.inverse_edges[axis];
            let cell = if PERIODIC && self.repeats[axis] {
                // What rounding puts beyond the last cell of a period is in it.
                let along = (position[axis] - self.origin[axis]) * self.inverse_edges[axis];
                floor(along).clamp(0, self.mask[axis] as i32) as u32
            } else {
                floor(along) as u32 & self.mask[axis]
            };
            key |= cell << self.shift[axis];
        }
        let is_fine = is_finite & is_inside;
        let key = if is_retired | !is_fine { self.trash } else { key };
        let dropped = Dropped {
            retired: u32::from(is_retired),
            removed: u32::from(!is_retired & !is_fine),
            not_finite: u32::from(!is_retired & !is_finite),
        };
        (key, dropped)
    }
}

/// The keys of a block of particles.
struct Keys<'a, const PERIODIC: bool> {
    rule: &'a KeyRule,
    position: [&'a [f32]; 3],
    velocity: [&'a [f32]; 3],
    life: &'a [f32],
    keys: &'a mut [u32],
}

impl<const PERIODIC: bool> WithSimd for Keys<'_, PERIODIC> {
    type Output = Dropped;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Dropped {
        let Self { rule, position, velocity, life, keys } = self;
        let len = keys.len();
        let ([x, y, z], [u, v, w]) = (position, velocity);
        let (x, y, z, u, v, w, life) = (&x[..len], &y[..len], &z[..len], &u[..len], &v[..len], &w[..len], &life[..len]);
        let mut dropped = Dropped::default();
        for i in 0..len {
            let (key, falls) = rule.key::<PERIODIC>([x[i], y[i], z[i]], [u[i], v[i], w[i]], life[i]);
            keys[i] = key;
            dropped = dropped.and(falls);
        }
        dropped
    }
}

/// `x.floor() as i32`; without the newer instructions of a processor `f32::floor` is a call.
#[inline(always)]
fn floor(x: f32) -> i32 {
    let toward_zero = x as i32;
    toward_zero.wrapping_sub(i32::from(x < toward_zero as f32))
}

/// Particles in a chunk: few enough that threads which wait for the last one of a pass wait for little, many enough that handing
/// it out costs nothing beside it.
const CHUNK_PARTICLES: usize = 512;
/// Chunks of a thread, at least and at most.
const CHUNKS_PER_THREAD: [usize; 2] = [16, 64];

impl Sorter {
    /// Sorts `particles` (through `scratch`, which ends up with the old order).
    pub fn sort(
        &mut self,
        workers: &Workers,
        arch: Arch,
        grid: &Grid,
        bounds: [Vec3; 2],
        particles: &mut Particles,
        scratch: &mut Particles,
    ) -> Dropped {
        let cells = grid.cells() as usize;
        let rule = KeyRule::new(grid, bounds);
        let dropped = if grid.periodic.any() {
            self.count::<true>(workers, arch, &rule, particles)
        } else {
            self.count::<false>(workers, arch, &rule, particles)
        };
        self.scan(cells);
        self.scatter(workers);
        let live = self.starts[cells] as usize;
        let [least, most] = CHUNKS_PER_THREAD.map(|chunks| chunks * workers.active());
        cut_into_chunks(&mut self.chunks, &self.starts, (live / CHUNK_PARTICLES).clamp(least, most));
        scratch.keep_pressures(particles.keeps_pressures());
        scratch.carry_densities(!particles.excess.is_empty());
        scratch.keep_histories_of(particles);
        scratch.resize(live);
        self.reorder(workers, particles, scratch);
        std::mem::swap(particles, scratch);
        dropped
    }

    /// Bytes allocated.
    pub fn bytes(&self) -> u64 {
        let cursors: usize = self.cursors.iter().map(Vec::capacity).sum();
        let lists = size_of::<Chunk>() * self.chunks.capacity()
            + size_of::<Range<usize>>() * self.blocks.capacity()
            + size_of::<Vec<u32>>() * self.cursors.capacity();
        let numbers = self.starts.capacity() + self.keys.capacity() + self.order.capacity() + cursors;
        (4 * numbers + lists) as u64
    }

    /// Keys, and a histogram for each block of particles.
    fn count<const PERIODIC: bool>(
        &mut self,
        workers: &Workers,
        arch: Arch,
        rule: &KeyRule,
        particles: &Particles,
    ) -> Dropped {
        let blocks = workers.active().min(16);
        let size = particles.len.div_ceil(blocks).max(1);
        self.keys.resize(particles.len, 0);
        self.cursors.resize_with(blocks, Vec::new);
        self.order.resize_with(particles.len, AtomicU32::default);
        self.blocks.clear();
        let end = |block: usize| (block * size).min(particles.len);
        self.blocks.extend((0..blocks).map(|block| end(block)..end(block + 1)));
        let tasks = Tasks::new(&self.blocks, &mut *self.cursors, &mut *self.keys);
        workers.share(tasks, |(range, histogram, keys)| {
            let (position, velocity) = (&particles.position, &particles.velocity);
            let dropped = arch.dispatch(Keys::<PERIODIC> {
                rule,
                position: [0, 1, 2].map(|axis| &position[axis][range.clone()]),
                velocity: [0, 1, 2].map(|axis| &velocity[axis][range.clone()]),
                life: &particles.life[range.clone()],
                keys,
            });
            histogram.clear();
            histogram.resize(rule.trash as usize + 1, 0);
            for &key in &*keys {
                histogram[key as usize] += 1;
            }
            dropped
        })
    }

    /// Turns the histograms into the first slot of each cell and block.
    fn scan(&mut self, cells: usize) {
        // Most cells are empty: those are passed over many at a time, as the other threads wait.
        const RUN: usize = 32;
        self.starts.resize(cells + 1, 0);
        let mut total = 0;
        for (run, starts) in self.starts.chunks_mut(RUN).enumerate() {
            let range = RUN * run..RUN * run + starts.len();
            let found =
                self.cursors.iter().flat_map(|histogram| &histogram[range.clone()]).fold(0, |all, count| all | count);
            if found == 0 {
                starts.fill(total);
                continue;
            }
            for (cell, start) in range.zip(starts) {
                *start = total;
                for histogram in &mut self.cursors {
                    total += std::mem::replace(&mut histogram[cell], total);
                }
            }
        }
    }

    /// Writes the index of each particle to its slot; slots of different blocks differ.
    fn scatter(&mut self, workers: &Workers) {
        let (keys, order) = (&self.keys, &self.order);
        workers.share(Tasks::new(&self.blocks, &mut *self.cursors, ()), |(block, cursors, ())| {
            for (i, &key) in block.clone().zip(&keys[block.clone()]) {
                let cursor = &mut cursors[key as usize];
                order[*cursor as usize].store(i as u32, Relaxed);
                *cursor += 1;
            }
        });
    }

    /// Copies particles to their slots, each cell in the order of ids.
    fn reorder(&mut self, workers: &Workers, from: &Particles, to: &mut Particles) {
        let starts = &self.starts;
        let Particles { id, position: [x, y, z], velocity: [u, v, w], life, pressure, .. } = to;
        let reals = [x, y, z, u, v, w, life].map(Vec::as_mut_slice);
        let [x, y, z] = &from.position;
        let [u, v, w] = &from.velocity;
        let sources = [x, y, z, u, v, w, &from.life].map(Vec::as_slice);
        let pressures = Some(&mut **pressure).filter(|_| from.keeps_pressures());
        let tasks = Tasks::new(&self.chunks, (), (&mut **id, &mut *self.order, (reals, pressures)));
        workers.share(tasks, |(chunk, (), (ids, order, (reals, pressures)))| {
            for (id, slot) in ids.iter_mut().zip(&mut *order) {
                *id = from.id[*slot.get_mut() as usize];
            }
            let base = chunk.particles.start;
            for cell in chunk.cells.clone() {
                let range = starts[cell] as usize - base..starts[cell + 1] as usize - base;
                sort_short(&mut ids[range.clone()], &mut order[range], &from.id);
            }
            let pressures = pressures.into_iter().zip([&*from.pressure]);
            for (target, source) in reals.into_iter().zip(sources).chain(pressures) {
                for (value, slot) in target.iter_mut().zip(&mut *order) {
                    *value = source[*slot.get_mut() as usize];
                }
            }
        });
        let targets = to.history.iter_mut().chain([&mut to.excess]);
        let sources = from.history.iter().chain([&from.excess]);
        for (target, source) in targets.zip(sources).filter(|(_, source)| !source.is_empty()) {
            let tasks = Tasks::new(&self.chunks, (), (&mut **target, &mut *self.order));
            workers.share(tasks, |(_, (), (target, order))| {
                for (value, slot) in target.iter_mut().zip(order) {
                    *value = source[*slot.get_mut() as usize];
                }
            });
        }
    }
}

/// Sorts slots and the ids of what is in them by id; cells are short and nearly sorted, so insertion wins.
fn sort_short(ids: &mut [u32], slots: &mut [AtomicU32], id_of: &[u32]) {
    if ids.len() > 64 {
        slots.sort_unstable_by_key(|slot| id_of[slot.load(Relaxed) as usize]);
        for (id, slot) in ids.iter_mut().zip(slots) {
            *id = id_of[*slot.get_mut() as usize];
        }
        return;
    }
    for end in 1..ids.len() {
        let mut at = end;
        while at > 0 && ids[at - 1] > ids[at] {
            ids.swap(at - 1, at);
            slots.swap(at - 1, at);
            at -= 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scattered(count: usize) -> Particles {
        let mut particles = Particles::default();
        let mut state = 1u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / 16_777_216.0
        };
        for i in 0..count {
            let position = Vec3::new(random() * 9.0 - 3.0, random() * 5.0 - 1.0, random() * 4.0);
            particles.push((i * 7919 % count) as u32, position, Vec3::splat(random()), f32::INFINITY);
        }
        particles
    }

    #[test]
    fn order_is_by_cell_then_id_and_nothing_is_lost() {
        let grid = Grid::fitting(0.5, Vec3::new(9.0, 5.0, 4.0), 1 << 12);
        for threads in [1, 2, 3] {
            let workers = Workers::new(Some(threads)).unwrap();
            let mut particles = scattered(5000);
            let mut expected: Vec<(u32, u32, Vec3, Vec3)> = (0..5000)
                .map(|i| {
                    let position = particles.position_of(i);
                    let cell = grid.index(grid.coordinates(position));
                    (cell, particles.id[i], position, particles.velocity_of(i))
                })
                .collect();
            expected.sort_by_key(|&(cell, id, ..)| (cell, id));
            let mut sorter = Sorter::default();
            let mut scratch = Particles::default();
            let bounds = [Vec3::splat(-100.0), Vec3::splat(100.0)];
            let dropped = workers.enter(particles.len, || {
                assert_eq!(workers.active(), threads);
                sorter.sort(&workers, Arch::new(), &grid, bounds, &mut particles, &mut scratch)
            });
            assert_eq!(dropped, Dropped::default());
            assert_eq!(particles.len, 5000);
            for (i, &(cell, id, position, velocity)) in expected.iter().enumerate() {
                assert_eq!(
                    (particles.id[i], particles.position_of(i), particles.velocity_of(i)),
                    (id, position, velocity)
                );
                let range = sorter.starts[cell as usize]..sorter.starts[cell as usize + 1];
                assert!(range.contains(&(i as u32)));
            }
        }
    }

    #[test]
    fn dead_and_broken_particles_fall_out() {
        let grid = Grid::fitting(0.5, Vec3::new(9.0, 5.0, 4.0), 1 << 12);
        let workers = Workers::new(Some(2)).unwrap();
        let mut particles = scattered(100);
        particles.life[3] = 0.0;
        particles.life[40] = -1.0;
        particles.position[1][7] = f32::NAN;
        particles.velocity[2][8] = f32::INFINITY;
        particles.position[0][99] = 1e9;
        // One that is both retired and not finite is retired.
        particles.life[50] = 0.0;
        particles.position[2][50] = f32::NEG_INFINITY;
        // The sum of its components is more than a number can be; each of them is finite.
        particles.velocity.iter_mut().for_each(|component| component[60] = 3e38);
        let gone = [3, 40, 50, 7, 8, 99].map(|i: usize| particles.id[i]);
        let bounds = [Vec3::splat(-100.0), Vec3::splat(100.0)];
        let (sorter, scratch) = (&mut Sorter::default(), &mut Particles::default());
        let dropped = sorter.sort(&workers, Arch::new(), &grid, bounds, &mut particles, scratch);
        assert_eq!(dropped, Dropped { retired: 3, removed: 3, not_finite: 2 });
        assert_eq!(particles.len, 94);
        assert!(particles.id.iter().all(|id| !gone.contains(id)));
    }
}
