//! How bodies float, in figures.

use bevy::prelude::*;
use bevy_freshet::prelude::*;
use bevy_rapier3d::prelude::{Collider, ReadMassProperties};

use crate::bodies::Floater;

/// Points along each edge of the box around a body, by which its volume is counted.
const POINTS: usize = 24;

/// Sums over the ticks that are looked at.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct Record {
    /// Share of the volume below the surface.
    under_water: f32,
    /// Vertical force of the fluid, N.
    force: f32,
    /// Share of the samples that are wetted.
    wetted: f32,
    ticks: f32,
}

/// The surface of the water and whether it is looked at.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct Watch {
    /// Height of the surface, m.
    pub level: f32,
    /// Whether bodies are recorded.
    pub is_on: bool,
    /// The largest speed of the water so far, m/s.
    pub max_speed: f32,
}

/// Height of the surface: the median over columns two spacings wide of their highest particle, and half a spacing.
pub fn level(positions: &[Vec3], spacing: f32) -> Option<f32> {
    let mut columns = std::collections::HashMap::<(i32, i32), f32>::new();
    for position in positions {
        let cell = |x: f32| (x / (2.0 * spacing)).floor() as i32;
        let top = columns.entry((cell(position.x), cell(position.z))).or_insert(f32::NEG_INFINITY);
        *top = top.max(position.y);
    }
    let mut tops: Vec<f32> = columns.into_values().collect();
    tops.sort_by(f32::total_cmp);
    tops.get(tops.len() / 2).map(|top| top + spacing / 2.0)
}

/// Notes where the surface is.
pub fn note_level(read: On<FluidReadbackComplete>, domains: Query<&FluidDomain>, mut watch: ResMut<Watch>) {
    let positions = read.get(FluidField::Position).cloned().and_then(|positions| positions.vectors());
    if let (Some(positions), Ok(domain)) = (positions, domains.get(read.entity))
        && let Some(level) = level(&positions, domain.spacing)
    {
        watch.level = level;
    }
}

/// Sums up how bodies are in this tick.
pub fn record(
    mut watch: ResMut<Watch>,
    stats: Query<&FluidStats>,
    mut bodies: Query<(&Collider, &Transform, &FluidContact, &mut Record), With<Floater>>,
) {
    watch.max_speed = stats.iter().map(|stats| stats.max_speed).fold(watch.max_speed, f32::max);
    if !watch.is_on {
        return;
    }
    for (collider, pose, contact, mut record) in &mut bodies {
        record.under_water += share_below(collider, pose, watch.level);
        record.force += contact.force.y;
        record.wetted += contact.submerged;
        record.ticks += 1.0;
    }
}

/// Share of a body's volume below a height.
fn share_below(collider: &Collider, pose: &Transform, height: f32) -> f32 {
    let bounds = collider.raw.compute_local_aabb();
    let (low, size) = (bounds.mins, bounds.maxs - bounds.mins);
    let along = |index: usize| (index as f32 + 0.5) / POINTS as f32;
    let (mut inside, mut below) = (0, 0);
    for index in 0..POINTS.pow(3) {
        let share = Vec3::new(along(index % POINTS), along(index / POINTS % POINTS), along(index / POINTS.pow(2)));
        let point = low + share * size;
        if collider.raw.contains_local_point(point) {
            inside += 1;
            below += i32::from(pose.transform_point(point).y < height);
        }
    }
    below as f32 / inside.max(1) as f32
}

/// A line of JSON for each body.
pub fn json(bodies: impl Iterator<Item = (Floater, Record, ReadMassProperties, Transform)>) -> String {
    let line = |(floater, record, mass, pose): (Floater, Record, ReadMassProperties, Transform)| {
        let ticks = record.ticks.max(1.0);
        format!(
            "    {{ \"shape\": {:?}, \"density\": {}, \"size_m\": {}, \"under_water\": {:.4}, \"force_over_weight\": {:.4}, \
             \"wetted\": {:.4}, \"height_m\": {:.4} }}",
            floater.shape.name(),
            floater.density,
            floater.size,
            record.under_water / ticks,
            record.force / ticks / (9.81 * mass.mass),
            record.wetted / ticks,
            pose.translation.y,
        )
    };
    bodies.map(line).collect::<Vec<_>>().join(",\n")
}
