//! What integrators should do with an oscillator: limits derived by hand or by other programs, and the motion itself.

use freshet_core::integrator::Integrator;

/// What is known of an integrator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known {
    /// Which.
    pub integrator: Integrator,
    /// Largest stable `omega h` without damping; with critical damping.
    pub limits: [f64; 2],
    /// Order of convergence of positions without damping; with critical damping.
    pub orders: [f64; 2],
}

/// Closed forms where there are any: `2 (sqrt 2 - 1)`, `sqrt 3 - 1`, `2 / sqrt 3`; three digits for the Beemans.
///
/// Orders are one less than that of the position's error in a step, and with damping no more than that of the velocity that the
/// acceleration sees.
pub static KNOWN: [Known; 10] = [
    Known { integrator: Integrator::ForwardEuler, limits: [0.0, 2.0], orders: [1.0, 1.0] },
    Known { integrator: Integrator::SemiImplicitEuler, limits: [2.0, 0.828427], orders: [1.0, 1.0] },
    Known { integrator: Integrator::Verlet, limits: [2.0, 0.732051], orders: [2.0, 1.0] },
    Known { integrator: Integrator::VelocityVerlet, limits: [2.0, 0.732051], orders: [2.0, 1.0] },
    Known { integrator: Integrator::ModifiedVelocityVerlet, limits: [2.0, 0.828427], orders: [2.0, 1.0] },
    Known { integrator: Integrator::Leapfrog, limits: [2.0, 0.828427], orders: [2.0, 1.0] },
    Known { integrator: Integrator::Clavet, limits: [1.154701, 0.666667], orders: [1.0, 1.0] },
    Known { integrator: Integrator::Beeman, limits: [2.0, 0.534], orders: [2.0, 1.0] },
    Known { integrator: Integrator::VelocityCorrectedBeeman, limits: [2.0, 0.294], orders: [2.0, 2.0] },
    Known { integrator: Integrator::PositionCorrectedBeeman, limits: [0.0, 0.260], orders: [3.0, 2.0] },
];

/// An oscillator, `x'' = -omega^2 x - 2 damping omega x'`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillator {
    /// omega, rad/s.
    pub frequency: f64,
    /// Whether it is critically damped, with a damping of 1; otherwise it has none.
    pub damped: bool,
}

impl Oscillator {
    /// Damping over the critical one.
    pub fn damping(self) -> f64 {
        if self.damped { 1.0 } else { 0.0 }
    }

    /// m/s2.
    pub fn acceleration(self, x: f64, v: f64) -> f64 {
        -self.frequency * self.frequency * x - 2.0 * self.damping() * self.frequency * v
    }

    /// Position and velocity at a time, s, from rest at a distance of 1 m (Pirovano 2011, eq. 2.39 and 2.40 put right).
    pub fn exact(self, time: f64) -> (f64, f64) {
        let phase = self.frequency * time;
        match self.damped {
            false => (phase.cos(), -self.frequency * phase.sin()),
            true => ((1.0 + phase) * (-phase).exp(), -self.frequency * phase * (-phase).exp()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_motion_obeys_its_equation() {
        for damped in [false, true] {
            let oscillator = Oscillator { frequency: 3.0, damped };
            let step = 1e-4;
            let [before, now, after] = [-1.0, 0.0, 1.0].map(|n| oscillator.exact(0.4 + n * step));
            let (velocity, change) = ((after.0 - before.0) / (2.0 * step), (after.1 - before.1) / (2.0 * step));
            assert!((velocity - now.1).abs() < 1e-6, "{velocity} {now:?}");
            assert!((change - oscillator.acceleration(now.0, now.1)).abs() < 1e-5, "{change} {now:?}");
            assert_eq!(oscillator.exact(0.0), (1.0, -0.0));
        }
    }

    #[test]
    fn every_integrator_is_known_once() {
        assert_eq!(KNOWN.map(|known| known.integrator), Integrator::ALL);
    }
}
