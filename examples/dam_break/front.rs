//! Where the water's front is: the figure a dam break is measured by.

use bevy::math::Vec3;

/// The 99.5th percentile of x plus half a spacing, m: the same definition as in Freshet's laboratory.
pub fn front(positions: &[Vec3], spacing: f32) -> Option<f32> {
    let mut x: Vec<f32> = positions.iter().map(|position| position.x).collect();
    let rank = (x.len() as f32 * 0.995) as usize;
    let index = rank.min(x.len().checked_sub(1)?);
    let (_, value, _) = x.select_nth_unstable_by(index, f32::total_cmp);
    Some(*value + spacing / 2.0)
}
