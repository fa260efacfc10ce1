//! Artificial repulsion against the tensile instability (Monaghan 2000, J. Comput. Phys. 159, 290, section 3).
//!
//! Where pressure is negative the pressure force pulls, most at middle distances, and particles meet in clumps. Against it `P_a + P_b`, `P = p/rho^2`, of a pair of fluid particles gets
//! `R f^4`, with `f = W(r)/W(d)`: next to nothing at two spacings, and more than one below one. `R = epsilon (max(-P_a, 0) + max(-P_b, 0))`, and where both pressures are positive
//! `R = 0.01 (P_a + P_b)`, which keeps particles from lining up. Walls and bodies exert none. Unlike a [near pressure](crate::near_pressure) it acts in proportion to the tension that it is
//! for, and leaves a fluid without pressure alone.
//! A column under tension keeps its particles apart with it at Courant numbers of up to 0.64, where it clumps without (`freshet_lab stability --options tensile-correction,unclamped`); a dam that breaks
//! under tension gains energy with it as without.

use crate::kernel::Kernel;

/// Share of the pressures of a pair that are both positive.
pub const POSITIVE: f32 = 0.01;

/// `1 / f(d/H)` of `W = A/H^3 f(q)`: what makes `W(r)/W(d)` of a kernel's shape.
pub fn inverse_shape(kernel: &Kernel, spacing: f32) -> f32 {
    let radius = f64::from(kernel.support_radius());
    (kernel.kind().normalisation() / (radius.powi(3) * kernel.value(f64::from(spacing)))) as f32
}
