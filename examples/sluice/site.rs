//! The site of a level: water, walls, gates, wheel and basin.

use bevy::prelude::*;
use bevy_freshet::prelude::*;
use bevy_rapier3d::prelude::{Collider, RigidBody};

use crate::level::{Area, DEPTH, Level, Wall};
use crate::paint::Paints;
use crate::{gates, wheel};

/// How far stone reaches beyond the water in front and behind, m.
const CHEEK: f32 = 0.12;

/// What goes when the level begins anew.
#[derive(Component)]
pub struct OnSite;

/// How levels are simulated.
#[derive(Resource, Clone, Copy, Debug)]
pub struct Method {
    /// Particles, about.
    pub particles: u32,
    /// What simulates.
    pub backend: FluidBackend,
}

impl Method {
    /// Distance of particles in a level, m.
    pub fn spacing(&self, level: &Level) -> f32 {
        (level.volume() / self.particles as f32).cbrt()
    }
}

/// Corners of what is to be seen, m.
pub fn bounds(level: &Level) -> (Vec3, Vec3) {
    let half = DEPTH / 2.0 + CHEEK;
    (Vec3::new(-0.1, -0.1, -half), level.size.extend(half))
}

/// Spawns all of it; returns the domain.
pub fn spawn(
    commands: &mut Commands,
    meshes: &mut Assets<Mesh>,
    paints: &Paints,
    method: &Method,
    level: &Level,
) -> Entity {
    let spacing = method.spacing(level);
    // A wheel on a joint answers late impulses too late: see docs/coupling.md.
    let mut domain = FluidDomain::with_spacing(spacing).on(method.backend).in_mode(FluidMode::Lockstep);
    domain.settings.pressure_solver = FluidPressureSolver::divergence_free();
    // What falls out below is lost.
    let bounds = (Vec3::new(-0.6, -0.5, -DEPTH), (level.size + Vec2::new(0.6, 1.0)).extend(DEPTH));
    domain.settings.bounds = Some(bounds);
    if !level.springs.is_empty() {
        domain.max_particles = Some((1.2 * level.volume() / spacing.powi(3)) as u32);
    }
    // How much is in the basin is counted six times a second.
    let readback = FluidReadback { fields: vec![FluidField::Position], every: 10 };
    let appearance = FluidAppearance { style: FluidStyle::Surface { clarity: 0.14, smoothing: 3.0 }, ..default() };
    let domain = commands.spawn((OnSite, domain, readback, appearance, Transform::default())).id();
    let member = FluidInDomain(domain);

    // Panes in front and behind; no floor, and nothing at the sides.
    let panes = FluidContainer {
        open: [true, true, true, true, false, false],
        ..FluidContainer::closed_box(level.size.x + 0.4, level.size.y + 0.6, DEPTH)
    };
    commands.spawn((OnSite, panes, member, Transform::from_translation((level.size / 2.0).extend(0.0))));
    for area in &level.water {
        let size = area.size();
        commands.spawn((
            OnSite,
            FluidVolume::from(Cuboid::new(size.x, size.y, DEPTH)),
            member,
            Transform::from_translation(area.center().extend(0.0)),
        ));
    }
    for wall in &level.walls {
        let (size, pose) = match *wall {
            Wall::Block { low, high } => {
                let area = Area { low, high };
                (area.size(), Transform::from_translation(area.center().extend(0.0)))
            }
            Wall::Ramp { from, to, thickness } => {
                let along = to - from;
                let turn = along.to_angle();
                let center = (from + to) / 2.0 - along.perp().normalize() * thickness / 2.0;
                let pose = Transform::from_translation(center.extend(0.0)).with_rotation(Quat::from_rotation_z(turn));
                (Vec2::new(along.length(), thickness), pose)
            }
        };
        let size = size.extend(DEPTH + 2.0 * CHEEK);
        commands.spawn((
            OnSite,
            FluidBoundary::cuboid(size.x, size.y, size.z),
            member,
            RigidBody::Fixed,
            Collider::cuboid(size.x / 2.0, size.y / 2.0, size.z / 2.0),
            Mesh3d(meshes.add(Cuboid::from_size(size))),
            MeshMaterial3d(paints.stone.clone()),
            pose,
        ));
    }
    for area in &level.gratings {
        let size = area.size();
        let bars = (size.x / 0.09).round().max(2.0);
        for bar in 0..=bars as u32 {
            let x = area.low.x + size.x * bar as f32 / bars;
            commands.spawn((
                OnSite,
                RigidBody::Fixed,
                Collider::cuboid(0.012, size.y / 2.0, DEPTH / 2.0),
                Mesh3d(meshes.add(Cuboid::new(0.024, size.y, DEPTH))),
                MeshMaterial3d(paints.iron.clone()),
                Transform::from_xyz(x, area.center().y, 0.0),
            ));
        }
    }
    for spring in &level.springs {
        let mouth = Transform::from_translation(spring.at.extend(0.0)).looking_to(Vec3::X, Vec3::Y);
        commands.spawn((OnSite, FluidEmitter::disc(spring.radius, spring.speed, f32::INFINITY), member, mouth));
        let pipe = Transform::from_translation((spring.at - Vec2::X * 0.3).extend(0.0));
        commands.spawn((
            OnSite,
            Mesh3d(meshes.add(Cylinder::new(1.25 * spring.radius, 0.6))),
            MeshMaterial3d(paints.iron.clone()),
            pipe.with_rotation(Quat::from_rotation_z(std::f32::consts::FRAC_PI_2)),
        ));
    }
    for gate in level.gates.iter().enumerate() {
        gates::spawn(commands, meshes, paints, domain, gate);
    }
    wheel::spawn(commands, meshes, paints, domain, &level.wheel, spacing);
    spawn_backdrop(commands, meshes, paints, level);
    domain
}

/// The wall behind, the basin's tiles, and a mark at the height that the goal has in it.
fn spawn_backdrop(commands: &mut Commands, meshes: &mut Assets<Mesh>, paints: &Paints, level: &Level) {
    let mut draw = |size: Vec3, center: Vec3, paint: &Handle<StandardMaterial>| {
        commands.spawn((
            OnSite,
            Mesh3d(meshes.add(Cuboid::from_size(size))),
            MeshMaterial3d(paint.clone()),
            Transform::from_translation(center),
        ));
    };
    let back = -(DEPTH / 2.0 + CHEEK);
    let size = level.size + Vec2::new(0.2, 0.1);
    draw(size.extend(0.06), (level.size / 2.0 - Vec2::Y * 0.05).extend(back - 0.03), &paints.plaster);
    let basin = &level.basin;
    draw(basin.size().extend(0.02), basin.center().extend(back + 0.005), &paints.tiles);
    let height = basin.low.y + level.goal.litres / 1000.0 / (basin.size().x * DEPTH);
    let mark = Vec3::new(basin.size().x, 0.018, 0.02);
    draw(mark, Vec3::new(basin.center().x, height, back + 0.02), &paints.mark);
}
