//! The laboratory's scenes. All use [`Settings::default`](freshet_core::scene::Settings): one set of numbers.

pub mod ball;
pub mod channel;
pub mod column;
pub mod krog;
pub mod pirovano;
pub mod slab;
pub mod tank;
pub mod vortices;
pub mod wave;

/// Standard gravity as the scenes have it, m/s2.
pub const GRAVITY: f64 = 9.81;
