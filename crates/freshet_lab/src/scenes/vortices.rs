//! Taylor-Green vortices: a square that repeats itself, four support radii thick.

use freshet_core::equation_of_state::EquationOfState;
use freshet_core::periodic::Periodic;
use freshet_core::scene::{FluidScene, Support, Volume};
use freshet_core::viscosity::ViscosityModel;
use glam::Vec3;

/// Edge of the square, m.
pub const EDGE: f64 = 1.0;
/// Largest speed at the start, m/s.
pub const SPEED: f64 = 1.0;
/// `SPEED * EDGE / nu`.
pub const REYNOLDS: f64 = 100.0;
/// Speed of sound over [`SPEED`].
const SOUND: f32 = 10.0;
/// Pressure at rest density over `rho SPEED^2`. The vortices' own goes down to a half below it: what is under tension comes
/// apart into voids.
const REFERENCE_PRESSURE: f32 = 1.0;
/// Support radius over the spacing. It grows with the resolution: with as many neighbours at any the sums stay as noisy as they
/// are, and the error stops falling (Zhu, Hernquist & Li 2015, Astrophys. J. 800, 6).
fn support(resolution: u32) -> f32 {
    4.0 * (resolution as f32 / 64.0).powf(1.0 / 6.0)
}

/// The square from the origin on with `resolution` particles along an edge, at rest.
pub fn scene(resolution: u32) -> FluidScene {
    let spacing = (EDGE / f64::from(resolution)) as f32;
    let thickness = (4.0 * support(resolution)).ceil();
    let (size, speed) = (Vec3::new(EDGE as f32, EDGE as f32, thickness * spacing), SPEED as f32);
    let mut scene = FluidScene {
        name: format!("vortices of {resolution} spacings"),
        gravity: Vec3::ZERO,
        volumes: vec![Volume::block(size / 2.0, size / 2.0)],
        periodic: Periodic { x: Some((0.0, size.x)), y: Some((0.0, size.y)), z: Some((0.0, size.z)) },
        ..FluidScene::with_spacing(spacing)
    };
    let density = scene.material.rest_density;
    scene.material.dynamic_viscosity = (SPEED * EDGE / REYNOLDS) as f32 * density;
    scene.settings.viscosity_model = Some(ViscosityModel::Morris1997);
    scene.settings.artificial_viscosity = 0.0;
    scene.settings.support = Support::Ratio(support(resolution));
    scene.settings.expected_speed = Some(speed);
    scene.settings.equation_of_state = Some(EquationOfState::Harada {
        reference_pressure: REFERENCE_PRESSURE * density * speed * speed,
        stiffness: (SOUND * speed).powi(2),
    });
    scene
}
