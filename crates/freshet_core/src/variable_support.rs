//! A support radius of its own for each particle, so that a fluid that thins out keeps its neighbours (Pirovano 2011, section 4.2;
//! Monaghan 1992, section 5; Hernquist & Katz 1989, Astrophys. J. Suppl. 70, 419, section II).
//!
//! `H_a = w_a H`, `w_a = (rho0 / rho_a)^(1/3)` limited to 1 and to [`widest_support`](crate::scene::Settings::widest_support): a
//! ball of it holds as much mass as a ball of `H` at rest. (Pirovano prints a square root, which is right in two dimensions.) `rho_a`
//! is the sum with `H_a` itself,
//! `(1/S) (m sum_b W(r_ab, w_a H) + rho0 sum_k V_k W(r_ak, H))`; `w_a` begins with 1 in every substep and is put right
//! [`EVALUATIONS`] times. So it depends on nothing but where particles are: there is no state to keep, and a snapshot has none.
//! A particle without a neighbour sees its own mass alone, its width grows by a third in each evaluation (Wendland, `H = 2d`), and
//! four of them take it to the limit.
//!
//! A pair has the mean of both, `H_ab = (w_a + w_b) H / 2` (Monaghan 1992; Hernquist & Katz 1989 have the mean of the kernels), in
//! densities and in forces: these stay equal and opposite. What changes of `H` add to the gradient of the density is left out, so
//! that the energy is not kept exactly. Samples of walls and bodies weigh what they do at `H`, and pairs with them have `H`; so have
//! XSPH and the near pressure, and `h` in viscosities and in the limits of the substep is `H/2`.
//!
//! No support is smaller than `H`: a compressed fluid has as many neighbours as without, and the substep's limits hold. At a free
//! surface, where half of the neighbours are missing, supports are wider too.

/// How often a particle's width is put right in a substep.
pub const EVALUATIONS: u32 = 4;

/// Most that [`widest_support`](crate::scene::Settings::widest_support) can be: a density of a 27th. Cells are as long as the widest
/// support, so that a particle at rest has up to 27 times as many candidates.
pub const MOST: f32 = 3.0;
