//! A pass in pieces, each with its part of the arrays that the pass writes. A piece is cut off when it is taken: a list of all
//! would have to be allocated for every pass.

use std::ops::Range;

use crate::workers::Chunk;

/// What a task is about.
pub trait Piece: Sync {
    /// Its particles, or whatever the pass counts.
    fn particles(&self) -> Range<usize>;
}

impl Piece for Chunk {
    fn particles(&self) -> Range<usize> {
        self.particles.clone()
    }
}

impl Piece for Range<usize> {
    fn particles(&self) -> Range<usize> {
        self.clone()
    }
}

/// What can be cut: arrays with a value for each particle, and several of them together.
pub trait Cut: Send {
    /// Cuts off the first `count` values and returns them.
    fn cut(&mut self, count: usize) -> Self;
}

impl Cut for () {
    fn cut(&mut self, _: usize) {}
}

impl<T: Send> Cut for &mut [T] {
    fn cut(&mut self, count: usize) -> Self {
        let (first, rest) = std::mem::take(self).split_at_mut(count);
        *self = rest;
        first
    }
}

impl<V: Cut, const N: usize> Cut for [V; N] {
    fn cut(&mut self, count: usize) -> Self {
        self.each_mut().map(|values| values.cut(count))
    }
}

impl<V: Cut> Cut for Option<V> {
    fn cut(&mut self, count: usize) -> Self {
        self.as_mut().map(|values| values.cut(count))
    }
}

impl<A: Cut, B: Cut> Cut for (A, B) {
    fn cut(&mut self, count: usize) -> Self {
        (self.0.cut(count), self.1.cut(count))
    }
}

impl<A: Cut, B: Cut, C: Cut> Cut for (A, B, C) {
    fn cut(&mut self, count: usize) -> Self {
        (self.0.cut(count), self.1.cut(count), self.2.cut(count))
    }
}

/// One value for each piece, or none.
pub trait Each: Cut {
    /// That of one piece.
    type One: Send;

    /// Cuts off the first.
    fn one(&mut self) -> Option<Self::One>;
}

impl Each for () {
    type One = ();

    fn one(&mut self) -> Option<()> {
        Some(())
    }
}

impl<'a, T: Send> Each for &'a mut [T] {
    type One = &'a mut T;

    fn one(&mut self) -> Option<&'a mut T> {
        self.split_off_first_mut()
    }
}

impl<A: Each, B: Each> Each for (A, B) {
    type One = (A::One, B::One);

    fn one(&mut self) -> Option<(A::One, B::One)> {
        Some((self.0.one()?, self.1.one()?))
    }
}

/// The pieces that are left, and what is left of the arrays.
pub struct Tasks<'a, P, E, V> {
    pieces: &'a [P],
    each: E,
    values: V,
}

impl<'a, P: Piece, E: Each, V: Cut> Tasks<'a, P, E, V> {
    /// Consecutive `pieces` from 0 on, with a value of `each` for each piece and of `values` for each particle.
    pub fn new(pieces: &'a [P], each: E, values: V) -> Self {
        Self { pieces, each, values }
    }

    /// Number of pieces.
    pub fn len(&self) -> usize {
        self.pieces.len()
    }

    /// Cuts off the first `count` pieces.
    pub fn cut(&mut self, count: usize) -> Self {
        let (pieces, rest) = self.pieces.split_at(count);
        self.pieces = rest;
        let particles = match pieces {
            [] => 0,
            [first, ..] => pieces[count - 1].particles().end - first.particles().start,
        };
        Self { pieces, each: self.each.cut(count), values: self.values.cut(particles) }
    }
}

impl<'a, P: Piece, E: Each, V: Cut> Iterator for Tasks<'a, P, E, V> {
    type Item = (&'a P, E::One, V);

    fn next(&mut self) -> Option<Self::Item> {
        let piece = self.pieces.split_off_first()?;
        Some((piece, self.each.one()?, self.values.cut(piece.particles().len())))
    }
}

/// The result of a task, and of all tasks of a pass together.
pub trait Total: Default + Send {
    /// Of both. Which come first and which are added to which is different every time: it must make no difference.
    fn and(self, other: Self) -> Self;
}

impl Total for () {
    fn and(self, (): ()) {}
}

impl Total for u64 {
    fn and(self, other: Self) -> Self {
        self + other
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_task_has_its_own_values_however_the_tasks_are_cut() {
        let pieces = [0..3, 3..3, 3..10, 10..11];
        for count in 0..=pieces.len() {
            let (mut ordinals, mut values): (Vec<usize>, Vec<usize>) = ((0..4).collect(), (0..13).collect());
            let (mut doubled, mut places) = (values.clone(), values.clone());
            let mut rest = Tasks::new(&pieces, &mut *ordinals, (&mut *values, [&mut *doubled, &mut *places]));
            let first = rest.cut(count);
            assert_eq!((first.len(), rest.len()), (count, 4 - count));
            for (ordinal, (piece, own, (values, [doubled, places]))) in first.chain(rest).enumerate() {
                assert_eq!((piece, &*own), (&pieces[ordinal], &ordinal));
                assert_eq!(values, piece.clone().collect::<Vec<_>>());
                assert_eq!((&*doubled, &*places), (&*values, &*values));
            }
        }
    }
}
