//! The mill wheel: one body on a joint, which the stream turns.

use std::f32::consts::{PI, TAU};

use bevy::prelude::*;
use bevy_freshet::prelude::*;
use bevy_rapier3d::prelude::*;

use crate::level::{DEPTH, Wheel};
use crate::paint::Paints;
use crate::site::OnSite;

/// Density of its wood, kg/m3.
const DENSITY: f32 = 400.0;
/// Its width; the rest of the channel's is air beside it, m.
const WIDTH: f32 = DEPTH - 0.06;
/// Radius of the hub over that of the wheel.
const HUB: f32 = 0.26;

/// How far it has turned.
#[derive(Component, Default)]
pub struct Turning {
    /// With the stream, which flows to the right below it.
    pub turns: f32,
}

/// Spawns wheel and axle.
pub fn spawn(
    commands: &mut Commands,
    meshes: &mut Assets<Mesh>,
    paints: &Paints,
    domain: Entity,
    wheel: &Wheel,
    spacing: f32,
) {
    let Wheel { center, radius, blades, drag } = *wheel;
    let place = Transform::from_translation(center.extend(0.0));
    let axle = commands.spawn((OnSite, RigidBody::Fixed, place)).id();
    let joint = RevoluteJointBuilder::new(Vec3::Z).motor_model(MotorModel::ForceBased).motor_velocity(0.0, drag);
    // What is thinner than a particle is no obstacle.
    let thickness = (0.06f32).max(spacing);
    let blade = Vec3::new(radius, thickness, WIDTH) / 2.0;
    let turned = |index: u32| Quat::from_rotation_z(TAU * index as f32 / blades as f32);
    let board = |index| (turned(index) * Vec3::X * blade.x, turned(index));
    let mut parts = vec![(Vec3::ZERO, Quat::from_rotation_x(PI / 2.0), Collider::cylinder(WIDTH / 2.0, HUB * radius))];
    parts.extend((0..blades).map(|index| {
        let (place, turn) = board(index);
        (place, turn, Collider::cuboid(blade.x, blade.y, blade.z))
    }));
    let body = (
        RigidBody::Dynamic,
        Collider::compound(parts),
        ColliderMassProperties::Density(DENSITY),
        ImpulseJoint::new(axle, joint),
        // A mill that stands still shall begin to turn.
        Sleeping::disabled(),
    );
    let wheel = commands
        .spawn((OnSite, Turning::default(), body, FluidBody::default(), FluidInDomain(domain), place))
        .insert(Visibility::default())
        .id();
    let mut draw = |mesh: Mesh, paint: &Handle<StandardMaterial>, pose: Transform| {
        commands.spawn((Mesh3d(meshes.add(mesh)), MeshMaterial3d(paint.clone()), pose, ChildOf(wheel)));
    };
    let upright = Quat::from_rotation_x(PI / 2.0);
    let along = |z: f32| Transform::from_xyz(0.0, 0.0, z).with_rotation(upright);
    draw(Cylinder::new(HUB * radius, WIDTH).into(), &paints.dark_wood, along(0.0));
    draw(Cylinder::new(0.3 * HUB * radius, 1.35 * DEPTH).into(), &paints.iron, along(0.0));
    for index in 0..blades {
        let (place, turn) = board(index);
        let pose = Transform::from_translation(place).with_rotation(turn);
        draw(Cuboid::from_size(2.0 * blade * Vec3::new(1.0, 1.0, 0.94)).into(), &paints.wood, pose);
    }
    for side in [-0.5, 0.5] {
        let rim = Torus { minor_radius: 0.028, major_radius: 0.86 * radius };
        draw(rim.mesh().minor_resolution(12).major_resolution(64).build(), &paints.dark_wood, along(side * WIDTH));
    }
}

/// Counts turns; in fixed ticks.
pub fn count(time: Res<Time>, mut wheels: Query<(&Velocity, &mut Turning)>) {
    for (velocity, mut turning) in &mut wheels {
        turning.turns += velocity.angular.z * time.delta_secs() / TAU;
    }
}
