//! What Pirovano 2011 (see [`pirovano_2011`](super::pirovano_2011)) finds of integrators in section 2.3: an oscillator of 250 kg, 0.5 m from rest, in
//! 300 steps of 0.1 s, with springs that are stiffer and stiffer.

use freshet_core::integrator::Integrator;

/// kg.
pub const MASS: f64 = 250.0;
/// Position at the start, at rest, m.
pub const START: f64 = 0.5;
/// s.
pub const STEP: f64 = 0.1;
/// In 30 s.
pub const STEPS: u32 = 300;
/// Stiffnesses without damping, N/m: `omega h` is 0.063, 0.632 and 2.
pub static UNDAMPED: [f64; 3] = [100.0, 1e4, 1e5];
/// With critical damping: 0.063, 0.632, 0.775 and 0.894.
pub static DAMPED: [f64; 4] = [100.0, 1e4, 1.5e4, 2e4];

/// What the text says of an integrator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Claim {
    /// Which.
    pub integrator: Integrator,
    /// The stiffness, N/m, at which its undamped position was taken out, for growing; none if it stayed (table 2.1).
    pub position: Option<f64>,
    /// The same of its undamped velocity (table 2.2).
    pub velocity: Option<f64>,
    /// The same with critical damping, of both (table 2.3).
    pub damped: Option<f64>,
    /// Orders of position and velocity (table 2.4).
    pub orders: Option<[u32; 2]>,
}

/// Nothing is said of Clavet's method, which "is assumed to behave like the leapfrog", and of the modified velocity Verlet without damping. For the
/// velocity-corrected Beeman the text once has "position corrected", which had been taken out before; the tables have it right.
pub static CLAIMS: [Claim; 9] = [
    Claim {
        integrator: Integrator::ForwardEuler,
        position: Some(100.0),
        velocity: Some(100.0),
        damped: None,
        orders: Some([1, 1]),
    },
    Claim {
        integrator: Integrator::SemiImplicitEuler,
        position: Some(1e5),
        velocity: Some(1e5),
        damped: Some(2e4),
        orders: Some([1, 1]),
    },
    Claim {
        integrator: Integrator::Verlet,
        position: Some(1e5),
        velocity: None,
        damped: Some(1.5e4),
        orders: Some([4, 2]),
    },
    Claim {
        integrator: Integrator::VelocityVerlet,
        position: None,
        velocity: None,
        damped: Some(1.5e4),
        orders: Some([4, 2]),
    },
    Claim {
        integrator: Integrator::ModifiedVelocityVerlet,
        position: None,
        velocity: None,
        damped: Some(2e4),
        orders: Some([4, 4]),
    },
    Claim {
        integrator: Integrator::Leapfrog,
        position: Some(1e4),
        velocity: Some(1e4),
        damped: Some(1.5e4),
        orders: Some([4, 3]),
    },
    Claim { integrator: Integrator::Beeman, position: None, velocity: None, damped: Some(1e4), orders: Some([4, 3]) },
    Claim {
        integrator: Integrator::VelocityCorrectedBeeman,
        position: None,
        velocity: None,
        damped: Some(1e4),
        orders: None,
    },
    Claim {
        integrator: Integrator::PositionCorrectedBeeman,
        position: Some(1e4),
        velocity: Some(1e4),
        damped: Some(1e4),
        orders: None,
    },
];
