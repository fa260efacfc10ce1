//! A box that holds fluid.

use bevy::prelude::*;

use super::wall::{FluidFriction, FluidWallMotion};

/// A hollow box that holds fluid, and bodies: it is also a fixed rapier collider made of its walls.
///
/// [`Transform`] is the centre of the inside; its scale must be 1. It may change, move and turn ([`motion`](Self::motion)) and be despawned.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component, Clone, Debug, PartialEq)]
#[require(Transform, Visibility)]
pub struct FluidContainer {
    /// Inner edge lengths, m, 2e-5 to 2e6.
    pub size: Vec3,
    /// Which faces are missing: -x, +x, -y, +y, -z, +z. At least one must be there.
    pub open: [bool; 6],
    /// Faces that drag the fluid along: -x, +x, -y, +y, -z, +z. Along the others it slips freely, and along a container that moves, unless there is a viscosity
    /// model or friction.
    pub viscous_faces: [bool; 6],
    /// Coulomb's friction of all walls, whether they stand, move, or have a [`velocity`](Self::velocity); none by default.
    pub friction: FluidFriction,
    /// Velocity of the walls' surfaces as of belts, in the container's own axes: see [`FluidBoundary::velocity`](super::boundary::FluidBoundary::velocity).
    pub velocity: Vec3,
    /// What follows from a [`Transform`] that changes.
    pub motion: FluidWallMotion,
    /// Whether it is a rapier collider too.
    pub collider: bool,
}

impl FluidContainer {
    /// A box without a lid, of these inner edge lengths in metres.
    pub fn open_box(x: f32, y: f32, z: f32) -> Self {
        let open = [false, false, false, true, false, false];
        Self { open, ..Self::closed_box(x, y, z) }
    }

    /// A box with all six walls, of these inner edge lengths in metres.
    pub fn closed_box(x: f32, y: f32, z: f32) -> Self {
        Self {
            size: Vec3::new(x, y, z),
            open: [false; 6],
            viscous_faces: [true; 6],
            friction: FluidFriction::default(),
            velocity: Vec3::ZERO,
            motion: FluidWallMotion::default(),
            collider: true,
        }
    }

    /// The same with friction, see [`friction`](Self::friction).
    #[must_use]
    pub fn with_friction(self, friction: FluidFriction) -> Self {
        Self { friction, ..self }
    }

    /// The same with walls as of belts, see [`velocity`](Self::velocity).
    #[must_use]
    pub fn with_velocity(self, velocity: Vec3) -> Self {
        Self { velocity, ..self }
    }

    /// The same as a container that moves from the start: nothing is planned anew when it begins to.
    ///
    /// ```
    /// # use bevy::prelude::*;
    /// # use bevy_freshet::prelude::*;
    /// #[derive(Component)]
    /// struct Tank;
    ///
    /// fn spawn_tank(mut commands: Commands) {
    ///     commands.spawn((Tank, FluidContainer::open_box(1.0, 0.5, 0.5).moving(), Transform::from_xyz(0.0, 0.25, 0.0)));
    /// }
    ///
    /// /// Sloshes. In `FixedUpdate`, before `FreshetSystems::Plan`.
    /// fn shake_tank(time: Res<Time>, mut tanks: Query<&mut Transform, With<Tank>>) {
    ///     for mut pose in &mut tanks {
    ///         pose.translation.x = 0.1 * (5.0 * time.elapsed_secs()).sin();
    ///     }
    /// }
    /// ```
    #[must_use]
    pub fn moving(self) -> Self {
        Self { motion: FluidWallMotion::Moving, ..self }
    }
}
