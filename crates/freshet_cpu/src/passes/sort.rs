//! Stage `sort`: particles by cell, by id within a cell; the retired and the removed fall out.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use freshet_core::grid::Grid;
use glam::{UVec3, Vec3};
use pulp::{Arch, Simd, WithSimd};

use crate::lanes::PADDING;
use crate::particles::Particles;
use crate::workers::{Chunk, Workers, chunks, split};

/// Memory of the sort, kept between substeps.
#[derive(Default)]
pub struct Sorter {
    /// First particle of each cell, and the number of particles.
    pub starts: Vec<u32>,
    /// Runs of cells that share the work of the next passes.
    pub chunks: Vec<Chunk>,
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

    /// The key of a particle: its cell, or for one that falls out the one after all cells; then whether it is retired and
    /// whether it is removed. Without branches, so that the compiler makes lanes of a loop over it.
    #[inline(always)]
    fn key<const PERIODIC: bool>(&self, position: [f32; 3], velocity: [f32; 3], life: f32) -> (u32, bool, bool) {
        let [min, max] = self.bounds;
        let is_retired = life <= 0.0;
        // Comparisons with NaN are false: what is not finite is not inside.
        let mut is_fine = (velocity[0] + velocity[1] + velocity[2]).abs() < f32::INFINITY;
        let mut key = 0;
        for axis in 0..3 {
            is_fine &= (position[axis] >= min[axis]) & (position[axis] <= max[axis]);
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
        let key = if is_retired | !is_fine { self.trash } else { key };
        (key, is_retired, !is_retired & !is_fine)
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
            let (key, retired, removed) = rule.key::<PERIODIC>([x[i], y[i], z[i]], [u[i], v[i], w[i]], life[i]);
            keys[i] = key;
            dropped.retired += u32::from(retired);
            dropped.removed += u32::from(removed);
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
const CHUNKS_PER_THREAD: [usize; 2] = [4, 64];

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
        let blocks = if grid.periodic.any() {
            self.count::<true>(workers, arch, &rule, particles)
        } else {
            self.count::<false>(workers, arch, &rule, particles)
        };
        let dropped = blocks.iter().fold(Dropped::default(), |sum, block| Dropped {
            retired: sum.retired + block.retired,
            removed: sum.removed + block.removed,
        });
        self.scan(cells);
        self.scatter(workers, particles.len);
        let live = self.starts[cells] as usize;
        let [least, most] = CHUNKS_PER_THREAD.map(|chunks| chunks * workers.active());
        self.chunks = chunks(&self.starts, (live / CHUNK_PARTICLES).clamp(least, most));
        scratch.resize(live);
        self.reorder(workers, particles, scratch);
        std::mem::swap(particles, scratch);
        dropped
    }

    /// Bytes allocated.
    pub fn bytes(&self) -> u64 {
        let cursors: usize = self.cursors.iter().map(Vec::capacity).sum();
        let lists = size_of::<Chunk>() * self.chunks.capacity() + size_of::<Vec<u32>>() * self.cursors.capacity();
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
    ) -> Vec<Dropped> {
        let blocks = workers.active().min(16);
        let size = particles.len.div_ceil(blocks).max(1);
        self.keys.resize(particles.len, 0);
        self.cursors.resize_with(blocks, Vec::new);
        self.order.resize_with(particles.len, AtomicU32::default);
        let mut tasks = Vec::with_capacity(blocks);
        let mut keys = self.keys.chunks_mut(size);
        for (block, histogram) in self.cursors.iter_mut().enumerate() {
            tasks.push((block * size, keys.next().unwrap_or(&mut []), histogram));
        }
        workers.map(tasks, |(first, keys, histogram)| {
            let range = first.min(particles.len)..first.min(particles.len) + keys.len();
            let (position, velocity) = (&particles.position, &particles.velocity);
            let dropped = arch.dispatch(Keys::<PERIODIC> {
                rule,
                position: [0, 1, 2].map(|axis| &position[axis][range.clone()]),
                velocity: [0, 1, 2].map(|axis| &velocity[axis][range.clone()]),
                life: &particles.life[range],
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
    fn scatter(&mut self, workers: &Workers, len: usize) {
        let size = len.div_ceil(self.cursors.len()).max(1);
        let order = &self.order;
        let mut keys = self.keys.chunks(size);
        let mut tasks = Vec::with_capacity(self.cursors.len());
        for (block, cursors) in self.cursors.iter_mut().enumerate() {
            tasks.push((block * size, keys.next().unwrap_or(&[]), cursors));
        }
        workers.map(tasks, |(first, keys, cursors)| {
            for (offset, &key) in keys.iter().enumerate() {
                let cursor = &mut cursors[key as usize];
                order[*cursor as usize].store((first + offset) as u32, Relaxed);
                *cursor += 1;
            }
        });
    }

    /// Copies particles to their slots, each cell in the order of ids.
    fn reorder(&mut self, workers: &Workers, from: &Particles, to: &mut Particles) {
        let (starts, order) = (&self.starts, &self.order);
        let live = to.len;
        let Particles { id, position, velocity, life, .. } = to;
        let [px, py, pz] = position;
        let [vx, vy, vz] = velocity;
        let mut parts: Vec<_> = [px, py, pz, vx, vy, vz, life]
            .map(|values| split(&mut values[..live + PADDING], &self.chunks).into_iter())
            .into();
        let ids = split(id, &self.chunks);
        let mut tasks = Vec::with_capacity(ids.len());
        for (chunk, ids) in self.chunks.iter().zip(ids) {
            let reals: Vec<&mut [f32]> = parts.iter_mut().filter_map(Iterator::next).collect();
            tasks.push((chunk.clone(), ids, reals));
        }
        let sources: [&[f32]; 7] = [
            &from.position[0],
            &from.position[1],
            &from.position[2],
            &from.velocity[0],
            &from.velocity[1],
            &from.velocity[2],
            &from.life,
        ];
        workers.map(tasks, |(chunk, ids, mut reals)| {
            let base = chunk.particles.start;
            let mut sorted: Vec<(u32, u32)> = order[chunk.particles]
                .iter()
                .map(|slot| slot.load(Relaxed))
                .map(|i| (from.id[i as usize], i))
                .collect();
            for cell in chunk.cells {
                sort_short(&mut sorted[starts[cell] as usize - base..starts[cell + 1] as usize - base]);
            }
            for (target, &(id, _)) in ids.iter_mut().zip(&sorted) {
                *target = id;
            }
            for (target, source) in reals.iter_mut().zip(sources) {
                for (value, &(_, i)) in target.iter_mut().zip(&sorted) {
                    *value = source[i as usize];
                }
            }
        });
    }
}

/// Sorts by id; cells are short and nearly sorted, so insertion wins.
fn sort_short(slots: &mut [(u32, u32)]) {
    if slots.len() > 64 {
        slots.sort_unstable();
        return;
    }
    for end in 1..slots.len() {
        let mut at = end;
        while at > 0 && slots[at - 1].0 > slots[at].0 {
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
        let gone = [3, 40, 7, 8, 99].map(|i: usize| particles.id[i]);
        let bounds = [Vec3::splat(-100.0), Vec3::splat(100.0)];
        let (sorter, scratch) = (&mut Sorter::default(), &mut Particles::default());
        let dropped = sorter.sort(&workers, Arch::new(), &grid, bounds, &mut particles, scratch);
        assert_eq!(dropped, Dropped { retired: 2, removed: 3 });
        assert_eq!(particles.len, 95);
        assert!(particles.id.iter().all(|id| !gone.contains(id)));
    }
}
