//! What to drop, and readings of the body that is picked.

use bevy::prelude::*;
use bevy_egui::{EguiContexts, egui};
use bevy_freshet::prelude::*;
use bevy_rapier3d::prelude::ReadMassProperties;

use crate::bodies::{DENSITIES, Floater, LARGEST};
use crate::pointer::Picked;
use crate::pool::{self, Pool};
use crate::shape::Shape;

/// What is chosen in the panel.
#[derive(Resource)]
pub struct Wishes {
    /// What is dropped next.
    pub floater: Floater,
    /// To take all bodies out and fill the pool anew.
    starts_again: bool,
}

impl Default for Wishes {
    fn default() -> Self {
        Self { floater: Floater { shape: Shape::Ball, size: 0.36, density: 400.0 }, starts_again: false }
    }
}

/// Draws the panel.
pub fn show(
    mut contexts: EguiContexts,
    mut wishes: ResMut<Wishes>,
    (picked, pool): (Res<Picked>, Res<Pool>),
    bodies: Query<(&Floater, &FluidContact, &ReadMassProperties)>,
    stats: Query<&FluidStats>,
) -> Result {
    let context = contexts.ctx_mut()?;
    egui::Window::new("Drop").anchor(egui::Align2::LEFT_TOP, (12.0, 12.0)).resizable(false).show(context, |ui| {
        let Wishes { floater, starts_again } = wishes.bypass_change_detection();
        ui.horizontal_wrapped(|ui| {
            for shape in Shape::ALL {
                ui.selectable_value(&mut floater.shape, shape, shape.name());
            }
        });
        ui.add(
            egui::Slider::new(&mut floater.density, DENSITIES)
                .logarithmic(true)
                .fixed_decimals(0)
                .text("density, kg/m3"),
        );
        let sizes = pool.least_size()..=LARGEST;
        ui.add(egui::Slider::new(&mut floater.size, sizes).fixed_decimals(2).text("size, m"));
        ui.small(fate(floater));
        *starts_again |= ui.button("Start again").clicked();
        if let Some((floater, contact, mass)) = picked.0.and_then(|body| bodies.get(body).ok()) {
            ui.separator();
            ui.strong(format!("{} of {:.0} kg/m3", floater.shape.name(), floater.density));
            egui::Grid::new("readings").num_columns(2).show(ui, |ui| {
                for (name, value) in readings(contact, mass.mass) {
                    ui.label(name);
                    ui.monospace(value);
                    ui.end_row();
                }
            });
        }
        ui.separator();
        for stats in &stats {
            ui.small(format!(
                "{:?}: {} particles, {:.1} ms a tick, time x{:.2}",
                stats.backend, stats.particles, stats.milliseconds, stats.time_scale
            ));
        }
        ui.small("left: drop, or drag a body; right: turn; wheel: closer");
    });
    Ok(())
}

/// What Archimedes says.
fn fate(floater: &Floater) -> String {
    let ratio = floater.density / 1000.0;
    if floater.shape.is_hollow() {
        "floats by its hollow, unless water gets in".to_owned()
    } else if ratio < 1.0 {
        format!("floats with {:.0} % of its volume under water", 100.0 * ratio)
    } else {
        format!("sinks with {:.0} % of its weight", 100.0 * (1.0 - 1.0 / ratio))
    }
}

fn readings(contact: &FluidContact, mass: f32) -> [(&'static str, String); 5] {
    [
        ("in the water", format!("{:3.0} % of its surface", 100.0 * contact.submerged)),
        ("wetted samples", format!("{} of {}", contact.wetted, contact.samples)),
        ("force, upwards", format!("{:7.1} N", contact.force.y)),
        ("force, sideways", format!("{:7.1} N", contact.force.with_y(0.0).length())),
        ("weight", format!("{:7.1} N", 9.81 * mass)),
    ]
}

/// Starts again.
pub fn carry_out(
    mut commands: Commands,
    mut wishes: ResMut<Wishes>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    pool: Res<Pool>,
    old: Query<Entity, Or<(With<FluidDomain>, With<Floater>)>>,
) {
    if !std::mem::take(&mut wishes.bypass_change_detection().starts_again) {
        return;
    }
    for entity in &old {
        commands.entity(entity).despawn();
    }
    pool::spawn(&mut commands, &mut meshes, &mut materials, &pool);
}
