//! The pool: water in a glass tank.

use bevy::prelude::*;
use bevy_freshet::prelude::*;
use freshet_examples::tank;

/// Inside of the tank, m.
pub const SIZE: Vec3 = Vec3::new(2.4, 1.2, 1.6);
/// How deep the water is without bodies, m.
const DEPTH: f32 = 0.7;

/// How the pool is simulated.
#[derive(Resource, Clone, Copy, Debug)]
pub struct Pool {
    /// Distance of particles, m.
    pub spacing: f32,
    /// How deep the water is without bodies, in whole layers, m.
    pub depth: f32,
    /// What simulates.
    pub backend: FluidBackend,
    /// Whether ticks wait for it.
    pub mode: FluidMode,
}

impl Pool {
    /// A pool with about so many particles.
    pub fn new(particles: u32, backend: FluidBackend, mode: FluidMode) -> Self {
        let spacing = (SIZE.x * DEPTH * SIZE.z / particles as f32).cbrt();
        let depth = (DEPTH / spacing).round() * spacing;
        Self { spacing, depth, backend, mode }
    }

    /// The smallest body, m: fewer than four particles across know little of its shape.
    pub fn least_size(&self) -> f32 {
        (4.0 * self.spacing).max(0.2)
    }
}

/// Corners of what is to be seen, m.
pub fn bounds() -> (Vec3, Vec3) {
    let half = SIZE / 2.0;
    (Vec3::new(-half.x, -0.15, -half.z), Vec3::new(half.x, SIZE.y, half.z))
}

/// Spawns tank and water. What it spawns goes with the domain.
pub fn spawn(
    commands: &mut Commands,
    meshes: &mut Assets<Mesh>,
    materials: &mut Assets<StandardMaterial>,
    pool: &Pool,
) -> Entity {
    let mut domain = FluidDomain::with_spacing(pool.spacing).on(pool.backend).in_mode(pool.mode);
    domain.settings.pressure_solver = FluidPressureSolver::divergence_free();
    // What is heavy squeezes water out from under it as it lands, faster than the step before could know.
    domain.settings.redo_substeps = true;
    let appearance = FluidAppearance { style: FluidStyle::water(), ..default() };
    let domain = commands.spawn((domain, appearance, Transform::IDENTITY)).id();
    let member = (ChildOf(domain), FluidInDomain(domain));
    let middle = Vec3::Y * SIZE.y / 2.0;
    commands.spawn((
        FluidContainer::open_box(SIZE.x, SIZE.y, SIZE.z),
        Transform::from_translation(middle),
        member.clone(),
    ));
    commands.spawn((
        FluidVolume::from(Cuboid::new(SIZE.x, pool.depth, SIZE.z)),
        Transform::from_xyz(0.0, pool.depth / 2.0, 0.0),
        member,
    ));
    for piece in tank::pieces(meshes, materials, middle, SIZE) {
        commands.spawn((piece, ChildOf(domain)));
    }
    domain
}
