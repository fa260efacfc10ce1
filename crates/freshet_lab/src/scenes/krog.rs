//! Krog's performance test (Krog 2010, section 8.1.1): a cube of fluid falls into a shallow pool in a closed box of 0.512 m.
//!
//! From the thesis: 26.2 litres at every resolution (table 8.3), a domain of 1,024 units of 0.5 mm, a support of 1.74 spacings,
//! `p = 1.5 m2/s2 (rho - rho0)` (algorithm 7.11), a viscosity of 1 Pa s (table 8.2), gravity.
//!
//! Not in its text, so ours: half of the fluid in either (the pool is 5 cm deep), the cube over the pool's middle. Different in
//! ours: sampled walls on which fluid slips instead of springs, Morris' viscosity, one kernel (spiky) where he has poly6 for
//! density and spiky for pressure, steps from the stability conditions where he has 0.5 ms, density with the particle itself.

use freshet_core::equation_of_state::EquationOfState;
use freshet_core::kernel::KernelKind;
use freshet_core::scene::{Boundary, FluidScene, Support, Volume};
use freshet_core::viscosity::ViscosityModel;
use glam::Vec3;

/// Edge of the box, m.
const BOX: f64 = 0.512;
/// All of the fluid, m3.
const FLUID: f64 = 0.026_214_4;
/// Support over spacing: his smoothing length is 2 x 0.87 of the cube root of a particle's volume.
const SUPPORT: f32 = 1.74;
/// Ideal gas constant, m2/s2.
const STIFFNESS: f32 = 1.5;
/// Dynamic viscosity, Pa s.
const VISCOSITY: f32 = 1.0;

/// Edges in whole spacings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Lattice {
    /// Of the box.
    edge: u32,
    /// Depth of the pool.
    pool: u32,
    /// Of the cube.
    cube: u32,
}

impl Lattice {
    fn of(particles: u32) -> Self {
        let spacing = spacing(particles);
        let edge = (BOX / spacing).round() as u32;
        let pool = (FLUID / 2.0 / BOX.powi(2) / spacing).round().max(1.0) as u32;
        let rest = f64::from(particles) - f64::from(edge * edge * pool);
        Self { edge, pool, cube: rest.max(1.0).cbrt().round() as u32 }
    }
}

fn spacing(particles: u32) -> f64 {
    (FLUID / f64::from(particles)).cbrt()
}

/// The scene with about `particles` particles, within 2 %: pool and cube are whole lattices.
pub fn scene(particles: u32) -> FluidScene {
    let (spacing, lattice) = (spacing(particles) as f32, Lattice::of(particles));
    let [edge, pool, cube] = [lattice.edge, lattice.pool, lattice.cube].map(|cells| cells as f32 * spacing);
    let middle = edge / 2.0;
    let mut scene = FluidScene {
        name: format!("Krog's test with {particles} particles"),
        volumes: vec![
            block(Vec3::new(middle, pool / 2.0, middle), Vec3::new(middle, pool / 2.0, middle)),
            block(Vec3::splat(cube / 2.0), Vec3::splat(middle)),
        ],
        boundaries: vec![Boundary {
            viscous_faces: [false; 6],
            ..Boundary::closed_box(Vec3::splat(edge), Vec3::splat(middle))
        }],
        ..FluidScene::with_spacing(spacing)
    };
    scene.material.dynamic_viscosity = VISCOSITY;
    let settings = &mut scene.settings;
    settings.kernel = KernelKind::Spiky;
    settings.support = Support::Ratio(SUPPORT);
    settings.equation_of_state = Some(EquationOfState::Desbrun { stiffness: STIFFNESS });
    settings.allow_compressible = true;
    settings.artificial_viscosity = 0.0;
    settings.viscosity_model = Some(ViscosityModel::Morris1997);
    scene
}

/// On the plain lattice, as his: so soft a fluid is no longer at its rest density where it stands.
fn block(half_extents: Vec3, center: Vec3) -> Volume {
    Volume { hydrostatic: false, ..Volume::block(half_extents, center) }
}

#[cfg(test)]
mod tests {
    use freshet_core::plan::{Plan, SceneError};

    use super::*;

    #[test]
    fn fluid_and_box_are_as_published() -> Result<(), SceneError> {
        for particles in [32_768, 65_536, 131_072] {
            let plan = Plan::new(&scene(particles))?;
            let found = plan.positions.len() as f64;
            assert!((found / f64::from(particles) - 1.0).abs() < 0.02, "{found} for {particles}");
            // Table 8.3: smoothing lengths.
            let published = 0.016_152_7 * (32_768.0 / particles as f32).cbrt();
            let support = plan.parameters.support_radius;
            assert!((support / published - 1.0).abs() < 2e-3, "support {support} m, not {published}");
            let edge = Lattice::of(particles).edge as f32 * plan.parameters.spacing;
            assert!((edge - 0.512).abs() < plan.parameters.spacing / 2.0, "box of {edge} m");
        }
        Ok(())
    }
}
