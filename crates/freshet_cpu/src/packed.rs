//! Candidates packed: all particles of a cell share them.
//!
//! Packing them once for a cell and then taking the cell's particles in the innermost loop fills every lane, loads each
//! candidate once for all of them and leaves no loop with a length the processor cannot predict.

use freshet_core::grid::Grid;
use pulp::Simd;

use crate::candidates::Stretch;
#[cfg(target_arch = "x86_64")]
use crate::lanes::avx512;
use crate::lanes::{PADDING, load, store};

/// `N` quantities of the candidates around a cell; the first three are the position.
#[derive(Default)]
pub struct Packed<const N: usize> {
    /// A run of `room` values of each quantity.
    values: Vec<f32>,
    room: usize,
    len: usize,
    /// Support radius, m.
    reach: f32,
    /// Lengths of the domain's periods, m; zero along axes that do not repeat.
    periods: [f32; 3],
}

impl<const N: usize> Packed<N> {
    /// Forgets the candidates; those to come are in this grid.
    pub fn begin(&mut self, grid: &Grid) {
        self.len = 0;
        self.reach = grid.cell_size;
        self.periods = grid.periodic.lengths().into();
    }

    /// Bytes allocated.
    pub fn bytes(&self) -> u64 {
        4 * self.values.capacity() as u64
    }

    /// Number of candidates.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Copies candidates from `sources`, in order; the last lanes are filled up with particles far away from `x`, where one of
    /// the cell's particles is. Images of a domain that repeats itself are copied to where they are seen.
    #[inline(always)]
    pub fn pack<S: Simd>(&mut self, simd: S, stretches: &[Stretch], sources: [&[f32]; N], x: f32) {
        let most = S::F32_LANES * stretches.len() + 2 * PADDING;
        if self.room < most {
            self.room = 2 * most;
            self.values.resize(N * self.room, 0.0);
        }
        self.len = self.copy(simd, stretches, sources);
        if self.periods != [0.0; 3] {
            self.shift_images(stretches);
        }
        // Beyond the kernel's support along x; finite, so that factors of zero stay zero.
        let far = x + 100.0 * self.reach;
        for quantity in 0..N {
            let filler = if quantity == 0 { far } else { 1.0 };
            store::<S>(&mut self.values, quantity * self.room + self.len, simd.splat_f32s(filler));
        }
    }

    /// Returns the number of candidates copied.
    #[inline(always)]
    fn copy<S: Simd>(&mut self, simd: S, stretches: &[Stretch], sources: [&[f32]; N]) -> usize {
        // Of one length, so that it is compared once for all of them.
        let mut cut = sources;
        for source in &mut cut {
            *source = &source[..sources[0].len()];
        }
        let sources = cut;
        // The runs one by one, as to cut them off anew for every stretch takes as long as to copy it.
        let mut runs: [&mut [f32]; N] = std::array::from_fn(|_| Default::default());
        let mut rest = &mut *self.values;
        for run in &mut runs {
            let (first, others) = rest.split_at_mut(self.room);
            (*run, rest) = (first, others);
        }
        let mut at = 0;
        #[cfg(target_arch = "x86_64")]
        if let Some(avx512) = avx512(simd) {
            let places = bytemuck::cast([0u32, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15]);
            for stretch in stretches {
                // One permutation for all quantities: to compress each takes twice as long. What is stored beyond the kept is
                // overwritten by the next.
                let order = avx512.avx512f._mm512_maskz_compress_epi32(stretch.kept, places);
                for (values, source) in runs.iter_mut().zip(sources) {
                    let value = bytemuck::cast(load::<S>(source, stretch.first as usize));
                    let kept = avx512.avx512f._mm512_permutexvar_ps(order, value);
                    store::<S>(values, at, bytemuck::cast(kept));
                }
                at += stretch.kept.count_ones() as usize;
            }
            return at;
        }
        for stretch in stretches {
            let mut kept = stretch.kept;
            while kept != 0 {
                let i = stretch.first as usize + kept.trailing_zeros() as usize;
                for (values, source) in runs.iter_mut().zip(sources) {
                    values[at] = source[i];
                }
                at += 1;
                kept &= kept - 1;
            }
        }
        at
    }

    /// Moves candidates beyond the end of a period to where they are seen.
    fn shift_images(&mut self, stretches: &[Stretch]) {
        let mut first = 0;
        for stretch in stretches {
            let end = first + stretch.kept.count_ones() as usize;
            for ((values, period), wraps) in
                self.values.chunks_exact_mut(self.room).zip(self.periods).zip(stretch.wraps())
            {
                if period * wraps != 0.0 {
                    for value in &mut values[first..end] {
                        *value += period * wraps;
                    }
                }
            }
            first = end;
        }
    }

    /// One quantity of the candidates.
    pub fn values(&self, quantity: usize) -> &[f32] {
        &self.values[quantity * self.room..][..self.len]
    }

    /// Lanes of candidates from `first` on.
    #[inline(always)]
    pub fn lanes<S: Simd>(&self, first: usize) -> [S::f32s; N] {
        let mut lanes = [load::<S>(&self.values, first); N];
        for (quantity, lanes) in lanes.iter_mut().enumerate() {
            *lanes = load::<S>(&self.values, quantity * self.room + first);
        }
        lanes
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use pulp::{Arch, WithSimd};

    use super::*;
    use crate::candidates::{Candidates, Near};
    use crate::neighbours::Rows;
    use crate::samples::SortedSamples;

    struct Pack<'a>(&'a SortedSamples, &'a Rows, Near, &'a Grid);

    impl WithSimd for Pack<'_> {
        type Output = Vec<[f32; 4]>;

        fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
            let mut packed = Packed::<4>::default();
            packed.begin(self.3);
            let [x, y, z] = &self.0.position;
            let mut candidates = Candidates::default();
            candidates.begin(self.3);
            let stretches = candidates.add(simd, self.1, &self.2, [x, y, z]);
            packed.pack(simd, stretches, [x, y, z, &self.0.volume], 3.0);
            let last = packed.lanes::<S>(packed.len());
            assert!(simd.reduce_min_f32s(last[0]) > 6.0 + 10.0 * self.3.cell_size);
            (0..packed.len()).map(|i| [0, 1, 2, 3].map(|k: usize| packed.values[k * packed.room + i])).collect()
        }
    }

    #[test]
    fn exactly_what_is_near_is_kept_in_order() {
        let grid = Grid::fitting(1.0, Vec3::splat(6.0), 1 << 20);
        let mut state = 1u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / 16_777_216.0
        };
        let positions: Vec<Vec3> = (0..3000).map(|_| Vec3::new(random(), random(), random()) * 6.0).collect();
        let volumes: Vec<f32> = (0..3000).map(|i| i as f32).collect();
        let mut sorted = SortedSamples::default();
        sorted.sort(&grid, &positions, &volumes);
        for at in [Vec3::splat(2.5), Vec3::new(0.1, 5.9, 3.0), Vec3::new(4.0, 4.0, 0.0)] {
            let cell = grid.index(grid.coordinates(at)) as usize;
            let rows = Rows::around(&grid, &sorted.starts, cell);
            let own = sorted.starts[cell] as usize..sorted.starts[cell + 1] as usize;
            let (low, high) = own.clone().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), slot| {
                (low.min(sorted.position_of(slot)), high.max(sorted.position_of(slot)))
            });
            let expected: Vec<f32> = rows
                .all()
                .iter()
                .flat_map(|&(start, end)| start as usize..end as usize)
                .filter(|&slot| {
                    let point = sorted.position_of(slot);
                    point.distance_squared(point.clamp(low, high)) <= 1.0
                })
                .map(|slot| sorted.volume[slot])
                .collect();
            let [x, y, z] = &sorted.position;
            let near = Near::around([x, y, z], own, 1.0);
            for arch in [Arch::new(), Arch::Scalar] {
                let found = arch.dispatch(Pack(&sorted, &rows, near, &grid));
                assert!(found.len() > 100);
                assert_eq!(found.iter().map(|value| value[3]).collect::<Vec<_>>(), expected, "around {at}");
                for [x, y, z, volume] in found {
                    assert_eq!(positions[volume as usize], Vec3::new(x, y, z));
                }
            }
        }
    }
}
