//! Who may be a neighbour of a cell's particles: found by the density pass, used again by the acceleration pass.
//!
//! A particle has about 30 neighbours among about 216 candidates in nine short ranges. About half of these no particle of the
//! cell can reach, in water at rest; they are left out.

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
            // Not f32::min, which takes four instructions for the sake of what is not a number: no particle's place is.
            let (mut low, mut high) = (near.low[axis], near.high[axis]);
            for &value in &values[range.clone()] {
                low = if value < low { value } else { low };
                high = if value > high { value } else { high };
            }
            (near.low[axis], near.high[axis]) = (low, high);
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

    /// A bit for each lane within reach of the box.
    #[inline(always)]
    fn reaches<S: Simd>(&self, simd: S, position: [S::f32s; 3]) -> u16 {
        let squared = self.squared_gap(simd, position);
        #[cfg(target_arch = "x86_64")]
        if let Some(avx512) = avx512(simd) {
            let limit = simd.splat_f32s(self.squared_reach);
            return avx512.avx512f._mm512_cmple_ps_mask(bytemuck::cast(squared), bytemuck::cast(limit));
        }
        let mut gaps = [0.0f32; PADDING];
        store::<S>(&mut gaps, 0, squared);
        let mut bits = 0;
        for (lane, &gap) in gaps[..S::F32_LANES].iter().enumerate() {
            bits |= u16::from(gap <= self.squared_reach) << lane;
        }
        bits
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

/// Up to 16 sorted particles or samples in a row, and which of them are candidates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stretch {
    /// The first.
    pub first: u32,
    /// A bit for each that is within reach; at least one.
    pub kept: u16,
    /// How often they are wrapped along x, y and z, see [`Stretch::wraps`].
    wraps: u16,
}

impl Stretch {
    /// How often they are wrapped along x, y and z: -1, 0 or 1.
    #[inline(always)]
    pub fn wraps(self) -> [f32; 3] {
        [self.wraps & 3, self.wraps >> 2 & 3, self.wraps >> 4].map(|code| f32::from(code) - 1.0)
    }

    #[inline(always)]
    fn code(wraps: [i8; 3]) -> u16 {
        let [x, y, z] = wraps;
        (x + 1) as u16 | ((y + 1) as u16) << 2 | ((z + 1) as u16) << 4
    }
}

/// Lists of candidates, one after the other.
#[derive(Default)]
pub struct Candidates {
    /// Those of the lists, then room for more.
    stretches: Vec<Stretch>,
    ends: Vec<u32>,
    /// Lengths of the domain's periods, m; zero along axes that do not repeat.
    periods: [f32; 3],
}

impl Candidates {
    /// Forgets all lists; those to come are in this grid.
    pub fn begin(&mut self, grid: &Grid) {
        self.ends.clear();
        self.periods = grid.periodic.lengths().into();
    }

    /// Gives back what is far more than the lists take.
    pub fn shrink(&mut self) {
        let used = self.ends.last().map_or(0, |&end| end as usize);
        if self.stretches.len() > 4 * used {
            self.stretches.truncate(2 * used);
            self.stretches.shrink_to_fit();
        }
    }

    /// Bytes allocated.
    pub fn bytes(&self) -> u64 {
        (size_of::<Stretch>() * self.stretches.capacity() + 4 * self.ends.capacity()) as u64
    }

    /// The lists, in the order they were added.
    pub fn lists(&self) -> impl Iterator<Item = &[Stretch]> {
        let begins = std::iter::once(0).chain(self.ends.iter().copied());
        begins.zip(&self.ends).map(|(begin, &end)| &self.stretches[begin as usize..end as usize])
    }

    /// Adds the list of what is `near` of the ranges of sorted positions; returns it.
    #[inline(always)]
    pub fn add<S: Simd>(&mut self, simd: S, rows: &Rows, near: &Near, [x, y, z]: [&[f32]; 3]) -> &[Stretch] {
        let begin = self.ends.last().map_or(0, |&end| end as usize);
        let most: usize = rows.all().iter().map(|&(start, end)| ((end - start) as usize).div_ceil(S::F32_LANES)).sum();
        if self.stretches.len() < begin + most {
            self.stretches.resize(2 * (begin + most), Stretch::default());
        }
        let room = &mut self.stretches[begin..];
        let mut len = 0;
        let periods = self.periods;
        let is_periodic = periods != [0.0; 3];
        let (y, z) = (&y[..x.len()], &z[..x.len()]);
        for (&(start, end), &row_wraps) in rows.all().iter().zip(rows.wraps()) {
            let wraps = Stretch::code(row_wraps);
            let near = if is_periodic { near.moved(shift(periods, row_wraps)) } else { *near };
            let (mut first, end) = (start as usize, end as usize);
            while first < end {
                let position = [load::<S>(x, first), load::<S>(y, first), load::<S>(z, first)];
                let all = u16::MAX >> (16 - (end - first).min(S::F32_LANES));
                let kept = near.reaches(simd, position) & all;
                room[len] = Stretch { first: first as u32, kept, wraps };
                len += usize::from(kept != 0);
                first += S::F32_LANES;
            }
        }
        self.ends.push((begin + len) as u32);
        &self.stretches[begin..begin + len]
    }
}

/// From the images of what is wrapped so often back to the originals.
#[inline(always)]
fn shift(periods: [f32; 3], wraps: [i8; 3]) -> [f32; 3] {
    let mut shift = periods;
    for (length, wraps) in shift.iter_mut().zip(wraps) {
        *length *= -f32::from(wraps);
    }
    shift
}
