//! Whether walls hold the fluid.
//!
//! Unlike [`LeakWatch`](freshet_core::leaks::LeakWatch), which has to see the ways of all particles, this looks once, at the end: it costs a run that is
//! timed nothing, and knows no more of walls than the faces of the tank.

use glam::Vec3;

/// Particles whose centre is beyond a face of the box from `min` to `max`; its top does not count, tanks may be open there.
///
/// A particle belongs half a spacing in front of a face, so one that has crossed it is through the wall.
pub fn escaped(positions: &[Vec3], min: Vec3, max: Vec3) -> usize {
    let outside = |p: &&Vec3| p.cmplt(min).any() || p.x > max.x || p.z > max.z;
    positions.iter().filter(outside).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn particles_beyond_a_wall_count_and_those_above_the_rim_do_not() {
        let inside = Vec3::splat(0.5);
        let beyond = [Vec3::new(-0.01, 0.5, 0.5), Vec3::new(0.5, -0.01, 0.5), Vec3::new(0.5, 0.5, 1.01)];
        let above = Vec3::new(0.5, 2.0, 0.5);
        let all: Vec<Vec3> = beyond.into_iter().chain([inside, above]).collect();
        assert_eq!(escaped(&all, Vec3::ZERO, Vec3::ONE), 3);
        assert_eq!(escaped(&[inside, above], Vec3::ZERO, Vec3::ONE), 0);
    }
}
