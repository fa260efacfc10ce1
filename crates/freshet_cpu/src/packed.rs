//! The candidates around a cell, packed: all particles of a cell share them.
//!
//! A particle has about 30 neighbours among about 216 candidates in nine short ranges. Those that no particle of the cell can
//! reach are left out, about half of them in water at rest; packing what remains once for a cell and then taking the cell's
//! particles in the innermost loop fills every lane, loads each candidate once for all of them and leaves no loop with a
//! length the processor cannot predict.

use std::ops::Range;

use freshet_core::grid::Grid;
use pulp::Simd;

#[cfg(target_arch = "x86_64")]
use crate::lanes::avx512;
use crate::lanes::{PADDING, load, store};
use crate::neighbours::Rows;

/// What is within reach of at least one corner, edge or face of the box around some particles.
#[derive(Clone, Copy, Debug)]
pub struct Near {
    low: [f32; 3],
    high: [f32; 3],
    squared_reach: f32,
}

impl Near {
    /// Around the particles of `range`, of which there is at least one.
    #[inline(always)]
    pub fn around(position: [&[f32]; 3], range: Range<usize>, reach: f32) -> Self {
        let mut near = Self { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3], squared_reach: reach * reach };
        for (axis, values) in position.iter().enumerate() {
            for &value in &values[range.clone()] {
                near.low[axis] = near.low[axis].min(value);
                near.high[axis] = near.high[axis].max(value);
            }
        }
        near
    }

    /// The box, moved.
    #[inline(always)]
    fn moved(mut self, by: [f32; 3]) -> Self {
        for ((low, high), by) in self.low.iter_mut().zip(&mut self.high).zip(by) {
            *low += by;
            *high += by;
        }
        self
    }

    /// The square of the distance from the box.
    #[inline(always)]
    fn squared_gap<S: Simd>(&self, simd: S, position: [S::f32s; 3]) -> S::f32s {
        let mut squared = simd.splat_f32s(0.0);
        for (axis, &value) in position.iter().enumerate() {
            let below = simd.sub_f32s(simd.splat_f32s(self.low[axis]), value);
            let above = simd.sub_f32s(value, simd.splat_f32s(self.high[axis]));
            let gap = simd.max_f32s(simd.max_f32s(below, above), simd.splat_f32s(0.0));
            squared = simd.mul_add_f32s(gap, gap, squared);
        }
        squared
    }
}

/// `N` quantities of the candidates around a cell; the first three are the position.
pub struct Packed<const N: usize> {
    values: [Vec<f32>; N],
    chosen: Vec<u32>,
    len: usize,
    /// Lengths of the domain's periods, m; zero along axes that do not repeat.
    periods: [f32; 3],
}

impl<const N: usize> Packed<N> {
    /// Without candidates, for a grid.
    pub fn new(grid: &Grid) -> Self {
        let values = std::array::from_fn(|_| Vec::new());
        Self { values, chosen: Vec::new(), len: 0, periods: grid.periodic.lengths().into() }
    }

    /// Number of candidates.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Copies what is `near` of the ranges of `sources`, in order; the last lanes are filled up with particles far away. Ranges
    /// beyond the end of a period are copied as their nearest images.
    #[inline(always)]
    pub fn pack<S: Simd>(&mut self, simd: S, rows: &Rows, near: &Near, sources: [&[f32]; N]) {
        let total: usize = rows.all().iter().map(|&(start, end)| (end - start) as usize).sum();
        if self.values[0].len() < total + 2 * PADDING {
            for values in &mut self.values {
                values.resize(2 * total + 2 * PADDING, 0.0);
            }
            self.chosen.resize(2 * total + 2 * PADDING, 0);
        }
        self.len = self.copy(simd, rows, near, &sources);
        // Beyond the kernel's support along x; finite, so that factors of zero stay zero.
        let far = near.high[0] + 100.0 * near.squared_reach.sqrt();
        for (axis, values) in self.values.iter_mut().enumerate() {
            let filler = if axis == 0 { far } else { 1.0 };
            store::<S>(values, self.len, simd.splat_f32s(filler));
        }
    }

    /// Returns the number of candidates copied.
    #[inline(always)]
    fn copy<S: Simd>(&mut self, simd: S, rows: &Rows, near: &Near, sources: &[&[f32]; N]) -> usize {
        // Asked once a row: a copy of all this for either answer would be one for every kernel and instruction set.
        let is_periodic = self.periods != [0.0; 3];
        let limit = simd.splat_f32s(near.squared_reach);
        let mut at = 0;
        let mut ends = [0; 18];
        for (row, &(start, end)) in rows.all().iter().enumerate() {
            let near = if is_periodic { near.moved(self.shift(rows.wraps()[row], -1.0)) } else { *near };
            let (mut first, end) = (start as usize, end as usize);
            while first < end {
                let [x, y, z] = [sources[0], sources[1], sources[2]];
                let position = [load::<S>(x, first), load::<S>(y, first), load::<S>(z, first)];
                let squared = near.squared_gap(simd, position);
                #[cfg(target_arch = "x86_64")]
                if let Some(avx512) = avx512(simd) {
                    let all = u16::MAX >> (16 - (end - first).min(16));
                    let near = avx512.avx512f._mm512_cmple_ps_mask(bytemuck::cast(squared), bytemuck::cast(limit));
                    let kept = near & all;
                    // What is stored beyond the kept is overwritten by the next.
                    for (values, source) in self.values.iter_mut().zip(sources) {
                        let value = bytemuck::cast(load::<S>(source, first));
                        let kept = avx512.avx512f._mm512_maskz_compress_ps(kept, value);
                        store::<S>(values, at, bytemuck::cast(kept));
                    }
                    at += kept.count_ones() as usize;
                    first += S::F32_LANES;
                    continue;
                }
                let mut gaps = [0.0f32; PADDING];
                store::<S>(&mut gaps, 0, squared);
                for (i, &gap) in (first..end).zip(&gaps[..S::F32_LANES]) {
                    self.chosen[at] = i as u32;
                    at += usize::from(gap <= near.squared_reach);
                }
                first += S::F32_LANES;
            }
            ends[row] = at;
        }
        if !is_avx512(simd) {
            for (values, source) in self.values.iter_mut().zip(sources) {
                for (value, &i) in values.iter_mut().zip(&self.chosen[..at]) {
                    *value = source[i as usize];
                }
            }
        }
        if is_periodic {
            self.shift_images(rows, &ends);
        }
        at
    }

    /// Moves the ranges beyond the end of a period to where they are seen; `ends` is one past the last candidate of each.
    fn shift_images(&mut self, rows: &Rows, ends: &[usize; 18]) {
        let mut first = 0;
        for (wraps, &end) in rows.wraps().iter().zip(ends) {
            let shift = self.shift(*wraps, 1.0);
            for (values, shift) in self.values.iter_mut().zip(shift) {
                if shift != 0.0 {
                    for value in &mut values[first..end] {
                        *value += shift;
                    }
                }
            }
            first = end;
        }
    }

    #[inline(always)]
    fn shift(&self, wraps: [i8; 3], sign: f32) -> [f32; 3] {
        let mut shift = self.periods;
        for (length, wraps) in shift.iter_mut().zip(wraps) {
            *length *= sign * f32::from(wraps);
        }
        shift
    }

    /// Lanes of candidates from `first` on.
    #[inline(always)]
    pub fn lanes<S: Simd>(&self, first: usize) -> [S::f32s; N] {
        let mut lanes = [load::<S>(&self.values[0], first); N];
        for (lanes, values) in lanes.iter_mut().zip(&self.values) {
            *lanes = load::<S>(values, first);
        }
        lanes
    }
}

#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn is_avx512<S: Simd>(simd: S) -> bool {
    avx512(simd).is_some()
}

#[cfg(not(target_arch = "x86_64"))]
#[inline(always)]
fn is_avx512<S: Simd>(_: S) -> bool {
    false
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use pulp::{Arch, WithSimd};

    use super::*;
    use crate::samples::SortedSamples;

    struct Pack<'a>(&'a SortedSamples, &'a Rows, Near, &'a Grid);

    impl WithSimd for Pack<'_> {
        type Output = Vec<[f32; 4]>;

        fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
            let mut packed = Packed::<4>::new(self.3);
            let [x, y, z] = &self.0.position;
            packed.pack(simd, self.1, &self.2, [x, y, z, &self.0.volume]);
            let last = packed.lanes::<S>(packed.len());
            assert!(simd.reduce_min_f32s(last[0]) > self.2.high[0] + 10.0 * self.2.squared_reach.sqrt());
            (0..packed.len()).map(|i| [0, 1, 2, 3].map(|k: usize| packed.values[k][i])).collect()
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
