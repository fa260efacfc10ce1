//! The shortest program with a fluid: a cubic metre of water collapses in an open box; a ball half as heavy as water drops in its
//! way and floats. It is the one in README, as printed. `cargo run --example hello_fluid` needs a display.

use bevy::prelude::*;
use bevy_freshet::prelude::*;
use bevy_rapier3d::prelude::*;

fn main() {
    App::new().add_plugins((DefaultPlugins, FreshetPlugins::default())).add_systems(Startup, setup).run();
}

#[rustfmt::skip]
fn setup(mut commands: Commands) {
    commands.spawn((Camera3d::default(), Transform::from_xyz(3., 2., 4.).looking_at(Vec3::new(1., 0.4, 0.5), Vec3::Y)));
    commands.spawn((DirectionalLight::default(), Transform::default().looking_to(-Vec3::ONE, Vec3::Y)));
    commands.spawn(FluidDomain::with_spacing(0.05));
    commands.spawn((Fluid::water(), FluidVolume::from(Cuboid::new(1., 1., 1.)), Transform::from_xyz(0.5, 0.5, 0.5)));
    commands.spawn((FluidContainer::open_box(2., 1.5, 1.), Transform::from_xyz(1., 0.75, 0.5)));
    commands.spawn((RigidBody::Dynamic, Collider::ball(0.15), ColliderMassProperties::Density(500.), FluidBody::default(), Transform::from_xyz(1.6, 1., 0.5)));
}
