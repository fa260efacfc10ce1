//! The forces, as both backends have them.

use std::f64::consts::PI;

use super::{SpringDamper, WallMethod};
use crate::kernel::{Kernel, KernelKind};

/// What is nearer to a sample than this many spacings is pushed as at that distance: the force of Lennard and Jones ends nowhere.
const NEAREST: f32 = 0.5;

/// Steps of the integral along a wall.
const STEPS: u32 = 400;

/// Longest substep over the time constant of a spring, no unit.
const SPRING_FACTOR: f32 = 0.5;

impl WallMethod {
    /// What a plan derives from its speeds, m/s, and the spacing `d`, m: `K` of Lennard-Jones forces, m2/s2; `K d^3` of kernel forcing, m4/s2;
    /// `0.01 c^2` of Monaghan's repulsion, m2/s2; `w` of a spring, rad/s. Zero for others.
    ///
    /// With these what comes at the expected speed is held in all places of a flat wall. Averaged along the wall, kernel forcing takes
    /// `K d/4` of energy up to the samples: twice the expected speed.
    pub fn strength(self, expected_speed: f32, sound_speed: f32, spacing: f32) -> f32 {
        let v_squared = expected_speed * expected_speed;
        match self {
            Self::VolumeWeights | Self::QuasiFluid(_) | Self::Ghosts | Self::Penalty(_) => 0.0,
            Self::LennardJones => v_squared,
            Self::KernelForcing => 8.0 * v_squared * spacing * spacing,
            Self::MonaghanRepulsion => 0.01 * sound_speed * sound_speed,
            Self::SpringDamper(SpringDamper { frequency, .. }) => frequency.unwrap_or(4.0 * expected_speed / spacing),
        }
    }

    /// Acceleration by a sample `r` metres away over that distance, 1/s2, positive away from it; zero for methods without such forces.
    pub fn push_over_r(self, strength: f32, spacing: f32, (kernel, support_radius): (KernelKind, f32), r: f32) -> f32 {
        let held = r.max(NEAREST * spacing);
        match self {
            Self::LennardJones if r < spacing => {
                let sixth = (spacing / held).powi(6);
                strength / (held * held) * (sixth * sixth - sixth)
            }
            Self::KernelForcing if r < support_radius => {
                let value = kernel.normalisation() * kernel.shape(f64::from(r / support_radius));
                strength * (value / f64::from(support_radius).powi(3)) as f32 / held
            }
            Self::MonaghanRepulsion => {
                let q = 2.0 * r / support_radius;
                strength / (held * held) * monaghan_shape(q)
            }
            _ => 0.0,
        }
    }

    /// How far behind the face samples lie, m, of several layers the first; none for volume weights, whose depth follows from them.
    ///
    /// Averaged along a wall, they push what is half a spacing before the face as hard as the foot of a column pushes whose
    /// [expected speed](crate::plan::Parameters::expected_speed) is `v = 2 sqrt(g D)`: `g D/d = v^2/(4 d)`. Springs and collisions are at the face, and their samples half
    /// a spacing behind it.
    ///
    /// It is that of a speed of sound of ten times the expected speed, as plans have by default: expected speeds follow from where samples lie. With
    /// another, [`MonaghanRepulsion`](WallMethod::MonaghanRepulsion), whose force follows the speed of sound, holds fluid at rest farther off the harder it
    /// pushes.
    pub fn depth(self, kernel: &Kernel, spacing: f32) -> Option<f32> {
        let (d, reach) = (f64::from(spacing), kernel.support_radius());
        match self {
            Self::VolumeWeights => None,
            Self::Ghosts => Some(0.0),
            Self::QuasiFluid(_) | Self::SpringDamper(_) | Self::Penalty(_) => Some(0.5 * spacing),
            Self::LennardJones | Self::KernelForcing | Self::MonaghanRepulsion => {
                let strength = self.strength(1.0, 10.0, spacing);
                let push_over_r =
                    |r: f64| f64::from(self.push_over_r(strength, spacing, (kernel.kind(), reach), r as f32));
                // On a circle r from the particle and z below it, of which there is r dr for each dr.
                let mean_push = |z: f64| {
                    let step = (f64::from(reach) - z) / f64::from(STEPS);
                    let radii = (0..STEPS).map(|i| z + (f64::from(i) + 0.5) * step);
                    2.0 * PI * z / (d * d) * step * radii.map(|r| push_over_r(r) * r).sum::<f64>()
                };
                let (mut near, mut far) = (0.5 * d, f64::from(reach));
                for _ in 0..40 {
                    let z = 0.5 * (near + far);
                    if mean_push(z) > 0.25 / d { near = z } else { far = z }
                }
                Some((near - 0.5 * d) as f32)
            }
        }
    }

    /// Longest substep that a spring bears, s, whatever the state of the fluid; infinite for others.
    pub fn substep_limit(self, strength: f32) -> f32 {
        match self {
            Self::SpringDamper(SpringDamper { damping_ratio, .. }) => {
                SPRING_FACTOR / (strength * (1.0 + 2.0 * damping_ratio))
            }
            _ => f32::INFINITY,
        }
    }
}

impl SpringDamper {
    /// Acceleration along the normal, m/s2, with the frequency `w` in rad/s, of what is `nearer` to the face than half a spacing, m, and goes
    /// away from it with `leaving`, m/s.
    pub fn push(&self, w: f32, nearer: f32, leaving: f32) -> f32 {
        if nearer > 0.0 { (w * w * nearer - 2.0 * self.damping_ratio * w * leaving).max(0.0) } else { 0.0 }
    }
}

/// Enneking 2018, eq. 12, with the middle branch that meets its neighbours: `2 q - 3/2 q^2`, 2/3 at 2/3 and 1/2 at 1.
fn monaghan_shape(q: f32) -> f32 {
    if q < 2.0 / 3.0 {
        2.0 / 3.0
    } else if q < 1.0 {
        q * (2.0 - 1.5 * q)
    } else {
        0.5 * (2.0 - q).max(0.0).powi(2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::InvalidInput;

    const D: f32 = 0.1;

    fn push(method: WallMethod, r: f32) -> f32 {
        r * method.push_over_r(method.strength(2.0, 20.0, D), D, (KernelKind::WendlandC2, 2.0 * D), r)
    }

    #[test]
    fn monaghans_shape_has_no_jump_and_its_slope_none_within() {
        for (at, value) in [(2.0 / 3.0, 2.0 / 3.0), (1.0, 0.5), (2.0, 0.0)] {
            let [below, above] = [at - 1e-4, at + 1e-4].map(monaghan_shape);
            assert!((below - value).abs() < 2e-4 && (above - value).abs() < 2e-4, "{at}: {below} {above}");
        }
        let slope = |q: f32| (monaghan_shape(q + 1e-3) - monaghan_shape(q - 1e-3)) / 2e-3;
        assert!((slope(0.999 - 1e-3) - slope(1.001 + 1e-3)).abs() < 0.02, "{} {}", slope(0.998), slope(1.002));
        assert!(slope(0.67).abs() < 0.03);
    }

    #[test]
    fn all_push_away_within_their_reach_and_nothing_beyond() {
        for (method, reach) in [
            (WallMethod::LennardJones, D),
            (WallMethod::KernelForcing, 2.0 * D),
            (WallMethod::MonaghanRepulsion, 2.0 * D),
        ] {
            let mut last = f32::INFINITY;
            for step in 10..40 {
                let r = 0.05 * step as f32 * D;
                let found = push(method, r);
                assert!(found <= last && (found > 0.0) == (r < 0.999 * reach), "{method:?} at {r}: {found}");
                last = found;
            }
        }
        assert_eq!(push(WallMethod::VolumeWeights, 0.5 * D), 0.0);
        assert_eq!(push(WallMethod::SpringDamper(SpringDamper::DEFAULT), 0.5 * D), 0.0);
    }

    /// `K/12 ((d/r)^6 - 1)^2` is what a particle has lost that comes so near.
    #[test]
    fn lennard_jones_is_the_slope_of_its_potential() {
        let potential = |r: f64| 4.0 / 12.0 * ((f64::from(D) / r).powi(6) - 1.0).powi(2);
        for r in [0.06f64, 0.08, 0.095] {
            let slope = (potential(r - 1e-6) - potential(r + 1e-6)) / 2e-6;
            let found = f64::from(push(WallMethod::LennardJones, r as f32));
            assert!((found / slope - 1.0).abs() < 1e-3, "{r}: {found}, not {slope}");
        }
    }

    /// Along the mean of a plane of samples at distance z: `K d 2 pi z int_z W dr`, whose integral over z is `K d/4`, as that of W over
    /// space is one.
    #[test]
    fn kernel_forcing_holds_twice_the_expected_speed() {
        let steps = 400;
        let h = f64::from(2.0 * D) / f64::from(steps);
        let mut energy = 0.0;
        for z in (0..steps).map(|i| (f64::from(i) + 0.5) * h) {
            for rho in (0..steps).map(|i| (f64::from(i) + 0.5) * h) {
                let r = (z * z + rho * rho).sqrt();
                // Beyond the distance from which on nothing gets harder.
                if r > f64::from(NEAREST * D) {
                    let along = f64::from(push(WallMethod::KernelForcing, r as f32)) * z / r;
                    energy += along * 2.0 * std::f64::consts::PI * rho * h * h / f64::from(D).powi(2);
                }
            }
        }
        let most = 0.5 * 4.0f64.powi(2);
        assert!(energy > 0.5 * most && energy < most, "{energy} of {most} m2/s2");
    }

    #[test]
    fn samples_lie_behind_the_face_whatever_the_kernel() -> Result<(), InvalidInput> {
        for (kind, ratio) in [(KernelKind::WendlandC2, 2.0), (KernelKind::CubicSpline, 2.5), (KernelKind::Spiky, 1.6)] {
            let kernel = Kernel::new(kind, ratio * D)?;
            for method in [WallMethod::LennardJones, WallMethod::KernelForcing, WallMethod::MonaghanRepulsion] {
                let depth = method.depth(&kernel, D).map(|depth| depth / D);
                assert!(
                    depth.is_some_and(|depth| (0.1..ratio - 0.5).contains(&depth)),
                    "{method:?}, {kind:?}: {depth:?}"
                );
            }
            assert_eq!(WallMethod::SpringDamper(SpringDamper::DEFAULT).depth(&kernel, D), Some(0.5 * D));
            assert_eq!(WallMethod::VolumeWeights.depth(&kernel, D), None);
        }
        Ok(())
    }

    #[test]
    fn a_spring_never_pulls() {
        let spring = SpringDamper { frequency: None, damping_ratio: 0.5 };
        assert_eq!(spring.push(10.0, -0.1, -5.0), 0.0);
        assert_eq!(spring.push(10.0, 0.1, 5.0), 0.0);
        assert!((spring.push(10.0, 0.1, -1.0) - 20.0).abs() < 1e-5);
    }
}
