//! What boundaries and containers have in common.

use bevy::prelude::*;
use freshet_core::scene::Friction;

/// Coulomb's friction between a wall and the fluid that presses on it; formulas stand at [`Friction`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Default, Clone, Debug, PartialEq)]
pub struct FluidFriction {
    /// Coefficient of what sticks, from that of what slides to 10.
    pub at_rest: f32,
    /// Coefficient of what slides, 0 to 10.
    pub sliding: f32,
}

impl FluidFriction {
    /// Both coefficients the same.
    pub fn coulomb(coefficient: f32) -> Self {
        Self { at_rest: coefficient, sliding: coefficient }
    }
}

impl From<FluidFriction> for Friction {
    fn from(FluidFriction { at_rest, sliding }: FluidFriction) -> Self {
        Self { at_rest, sliding }
    }
}

impl From<Friction> for FluidFriction {
    fn from(Friction { at_rest, sliding }: Friction) -> Self {
        Self { at_rest, sliding }
    }
}

/// What follows from a [`Transform`] that changes in its domain's frame.
///
/// A wall that moves pushes the fluid with the velocity of its surface: in each fixed tick it goes from where it was in the tick before
/// to where it is, straight and turning evenly, and when it stands still it pushes no more. Move it in `FixedUpdate`, before
/// [`FreshetSystems::Plan`](crate::simulation::sets::FreshetSystems::Plan), or in `FixedPreUpdate`: what is moved once a frame stands still in the frame's other ticks. It is not sampled
/// anew; its samples are sorted in each substep. Its friction drags fluid along; without, fluid slips along it if there is no
/// [viscosity model](super::settings::FluidSettings::viscosity_model).
///
/// Fluid that leaves the domain's bounds is removed. Unless [`FluidSettings::bounds`](super::settings::FluidSettings::bounds) says otherwise they reach
/// four times a wall's size around the place where it was planned; a wall that goes out of them is a
/// [`FluidProblem`](super::problem::FluidProblem).
///
/// A wave maker, a plate hinged at the bottom of a flume that swings by 0.2 radians once in two seconds:
///
/// ```no_run
/// use std::f32::consts::TAU;
///
/// use bevy::prelude::*;
/// use bevy_freshet::prelude::*;
///
/// #[derive(Component)]
/// struct Flap;
///
/// fn main() {
///     App::new()
///         .add_plugins((DefaultPlugins, FreshetPlugins::default()))
///         .add_systems(Startup, setup)
///         .add_systems(FixedUpdate, swing.before(FreshetSystems::Plan))
///         .run();
/// }
///
/// fn setup(mut commands: Commands) {
///     let mut domain = FluidDomain::with_spacing(0.05);
///     domain.settings.bounds = Some((Vec3::new(-1.0, -1.0, -1.0), Vec3::new(5.0, 3.0, 1.5)));
///     commands.spawn(domain);
///     commands.spawn((FluidContainer::open_box(4.0, 1.0, 0.5), Transform::from_xyz(2.0, 0.5, 0.25)));
///     commands.spawn((FluidVolume::from(Cuboid::new(3.4, 0.5, 0.5)), Transform::from_xyz(2.3, 0.25, 0.25)));
///     // The hinge is an entity of its own; the plate is its child.
///     let flap = commands.spawn((Flap, Transform::from_xyz(0.5, 0.0, 0.25), Visibility::default())).id();
///     let plate = FluidBoundary::cuboid(0.05, 0.9, 0.5).moving();
///     commands.spawn((plate, Transform::from_xyz(0.0, 0.45, 0.0), ChildOf(flap)));
/// }
///
/// fn swing(time: Res<Time>, mut flaps: Query<&mut Transform, With<Flap>>) {
///     for mut flap in &mut flaps {
///         flap.rotation = Quat::from_rotation_z(0.2 * (TAU * time.elapsed_secs() / 2.0).sin());
///     }
/// }
/// ```
///
/// One that is put elsewhere is there at once and pushes nothing on its way: while time stands still ([`Time<Virtual>`](Time) is paused), while its
/// domain waits for a mesh, or if it goes farther in a tick than four times the expected speed allows (its surface, where it turns) and than a support
/// radius, 13 m/s with a spacing of 0.1 m and 64 ticks a second. A scale that changes makes another shape of it, which is sampled anew.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Default, Clone, Debug, PartialEq)]
pub enum FluidWallMotion {
    /// It stands until it is moved for the first time, other than while time stands still. Then the domain is planned anew, once, and from there on it
    /// is one that moves, for as long as the entity has the component: fluid that only artificial viscosity dragged along slips from there on.
    /// [`FluidStats::notes`](super::stats::FluidStats::notes) name it.
    #[default]
    Auto,
    /// It stands: to move it is to put it elsewhere, for which the domain is planned anew each time. It pushes nothing.
    Still,
    /// It moves, from the start.
    Moving,
}
