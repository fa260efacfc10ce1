//! Help and figures on the screen.

use bevy::prelude::*;
use bevy_egui::{EguiContexts, egui};
use bevy_freshet::prelude::*;

use crate::controls::{Help, KEY_LINE, KEYS};
use crate::stage::Stage;

/// The keys and a line of figures at the top, and the help below them.
pub fn show(
    mut contexts: EguiContexts,
    stats: Query<&FluidStats>,
    help: Res<Help>,
    stage: Res<Stage>,
    time: Res<Time<Virtual>>,
) -> Result {
    let context = contexts.ctx_mut()?;
    egui::Area::new("figures".into()).fixed_pos((12.0, 10.0)).show(context, |ui| {
        egui::Frame::window(ui.style()).show(ui, |ui| {
            // As wide as the longest line, not as the first.
            ui.style_mut().wrap_mode = Some(egui::TextWrapMode::Extend);
            // Also where there is no fluid.
            ui.label(KEY_LINE);
            for stats in &stats {
                ui.label(line(stats, &stage.coloring, time.is_paused()));
            }
            if help.0 {
                egui::Grid::new("keys").show(ui, |ui| {
                    for (key, what) in KEYS {
                        ui.strong(key);
                        ui.label(what);
                        ui.end_row();
                    }
                });
                for stats in &stats {
                    ui.separator();
                    for pass in &stats.passes {
                        ui.monospace(format!("{:<22}{:>8.2} ms", pass.pass, pass.milliseconds));
                    }
                    for note in &stats.notes {
                        ui.small(note);
                    }
                }
            }
        });
    });
    Ok(())
}

fn line(stats: &FluidStats, coloring: &FluidColoring, paused: bool) -> String {
    format!(
        "{}{:?} | {} particles | {:.2} s | {} substeps, {:.1} ms a tick | time x{:.2} | {:.2} m/s | colour: {:?}",
        if paused { "PAUSED | " } else { "" },
        stats.backend,
        stats.particles,
        stats.time,
        stats.substeps,
        stats.milliseconds,
        stats.time_scale,
        stats.max_speed,
        coloring.field,
    )
}
