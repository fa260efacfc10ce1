//! The candidates around a cell, packed: all particles of a cell share them.
//!
//! A particle has about 30 neighbours among about 216 candidates in nine short ranges. Packing the ranges once for a cell
//! and then taking the cell's particles in the innermost loop fills every lane, loads each candidate once for all of
//! them and leaves no loop with a length the processor cannot predict. Measured at 64,000 particles: 2.2 times as fast as
//! each particle walking the ranges by itself.

use pulp::Simd;

use crate::lanes::{PADDING, load, store};
use crate::neighbours::Rows;

/// `N` quantities of the candidates around a cell; the first three are the position.
pub struct Packed<const N: usize> {
    values: [Vec<f32>; N],
    len: usize,
}

impl<const N: usize> Packed<N> {
    /// Without candidates.
    pub fn new() -> Self {
        Self { values: std::array::from_fn(|_| Vec::new()), len: 0 }
    }

    /// Number of candidates.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Copies the ranges of `sources` one after the other; the last lanes are filled up with `filler`.
    #[inline(always)]
    pub fn pack<S: Simd>(&mut self, simd: S, rows: &Rows, sources: [&[f32]; N], filler: [f32; N]) {
        let total: usize = rows.all().iter().map(|&(start, end)| (end - start) as usize).sum();
        if self.values[0].len() < total + 2 * PADDING {
            for values in &mut self.values {
                values.resize(2 * total + 2 * PADDING, 0.0);
            }
        }
        self.len = total;
        let mut at = 0;
        for &(start, end) in rows.all() {
            let (start, count) = (start as usize, (end - start) as usize);
            // A range's last store runs over into the next range's place, which is written next.
            let mut offset = 0;
            while offset < count {
                for (values, source) in self.values.iter_mut().zip(sources) {
                    store::<S>(values, at + offset, load::<S>(source, start + offset));
                }
                offset += S::F32_LANES;
            }
            at += count;
        }
        for (values, fill) in self.values.iter_mut().zip(filler) {
            store::<S>(values, total, simd.splat_f32s(fill));
        }
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
