//! What is written on the screen.

use bevy::prelude::*;
use bevy_egui::{EguiContexts, egui};
use bevy_freshet::prelude::*;

use crate::game::{Builder, Game, Levels, Phase};
use crate::gates::Gate;
use crate::level::Level;

/// What a button or key asks for.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wish {
    /// Nothing.
    #[default]
    None,
    /// The time shall run.
    Begin,
    /// The same level again.
    Again,
    /// The next level, or the first.
    Next,
}

/// The goal and how far it is reached, at the top; before and after a level, what there is to say about it.
pub fn show(
    mut contexts: EguiContexts,
    (game, levels): (Res<Game>, Res<Levels>),
    stats: Query<&FluidStats>,
    mut wish: ResMut<Wish>,
) -> Result {
    let context = contexts.ctx_mut()?;
    let level = &levels.0[game.level];
    egui::Area::new("goal".into()).anchor(egui::Align2::CENTER_TOP, (0.0, 10.0)).show(context, |ui| {
        egui::Frame::window(ui.style()).show(ui, |ui| {
            ui.style_mut().wrap_mode = Some(egui::TextWrapMode::Extend);
            ui.horizontal(|ui| {
                ui.strong(format!("{}. {}", game.level + 1, level.name));
                ui.separator();
                let left = (level.goal.seconds - game.time).max(0.0);
                let color = if left < 8.0 { egui::Color32::LIGHT_RED } else { ui.visuals().strong_text_color() };
                ui.label(egui::RichText::new(format!("{left:4.1} s")).monospace().size(18.0).color(color));
                ui.separator();
                bar(ui, "basin", (game.litres, level.goal.litres), 0, "l");
                bar(ui, "mill", (game.turns, level.goal.turns), 1, "turns");
                ui.label(format!("crates: {}", game.crates));
            });
            for stats in &stats {
                ui.small(format!(
                    "{:?}: {} particles, {:.1} ms a tick, time x{:.2}",
                    stats.backend, stats.particles, stats.milliseconds, stats.time_scale
                ));
            }
        });
    });
    if game.phase != Phase::Playing {
        let window = egui::Window::new(title(game.phase)).collapsible(false).resizable(false);
        window.anchor(egui::Align2::CENTER_CENTER, (0.0, 0.0)).show(context, |ui| {
            ui.set_min_width(320.0);
            let is_last = game.level + 1 == levels.0.len();
            ending(ui, &game, level, is_last, &mut wish);
        });
    }
    Ok(())
}

fn title(phase: Phase) -> &'static str {
    match phase {
        Phase::Waiting | Phase::Playing => "Sluice",
        Phase::Won => "The mill runs!",
        Phase::TimeIsOver => "The time is over",
        Phase::WaterIsLost => "Too little water is left",
    }
}

fn ending(ui: &mut egui::Ui, game: &Game, level: &Level, is_last: bool, wish: &mut Wish) {
    let button =
        |ui: &mut egui::Ui, text: &str| ui.add(egui::Button::new(egui::RichText::new(text).size(16.0))).clicked();
    ui.add_space(4.0);
    match game.phase {
        Phase::Waiting | Phase::Playing => {
            ui.label(egui::RichText::new(&level.name).size(22.0).strong());
            ui.label(&level.hint);
            ui.add_space(6.0);
            ui.label(format!(
                "Bring {:.0} l into the basin and turn the mill {:.1} times within {:.0} s.",
                level.goal.litres, level.goal.turns, level.goal.seconds
            ));
            ui.small(
                "Click a gate or press its number; click elsewhere to place a crate. R: again. Right button: turn.",
            );
            ui.add_space(6.0);
            if button(ui, "Begin (Enter)") {
                *wish = Wish::Begin;
            }
        }
        Phase::Won => {
            ui.label(egui::RichText::new(format!("{} points", game.score(level))).size(28.0).strong());
            ui.label(format!("{:.0} l in the basin and {:.1} turns after {:.1} s", game.litres, game.turns, game.time));
            ui.add_space(6.0);
            ui.horizontal(|ui| {
                if button(ui, if is_last { "From the start (Enter)" } else { "Next level (Enter)" }) {
                    *wish = Wish::Next;
                }
                if button(ui, "Again (R)") {
                    *wish = Wish::Again;
                }
            });
        }
        Phase::TimeIsOver | Phase::WaterIsLost => {
            ui.label(format!("{:.0} of {:.0} l in the basin", game.litres, level.goal.litres));
            ui.label(format!("{:.1} of {:.1} turns of the mill", game.turns, level.goal.turns));
            ui.add_space(6.0);
            if button(ui, "Again (R)") {
                *wish = Wish::Again;
            }
        }
    }
}

/// What has been reached of what has to be, with so many decimals.
fn bar(ui: &mut egui::Ui, name: &str, (value, goal): (f32, f32), decimals: usize, unit: &str) {
    let share = if goal > 0.0 { value / goal } else { 1.0 };
    let color = if share >= 1.0 { egui::Color32::from_rgb(60, 150, 70) } else { egui::Color32::from_rgb(40, 100, 170) };
    let text = format!("{name}: {:.decimals$} of {goal:.decimals$} {unit}", value.max(0.0));
    ui.add(egui::ProgressBar::new(share.clamp(0.0, 1.0)).desired_width(190.0).fill(color).text(text));
}

/// The numbers of gates, beside them.
pub fn show_numbers(
    mut contexts: EguiContexts,
    cameras: Query<(&Camera, &GlobalTransform), With<Camera3d>>,
    gates: Query<(&Gate, &GlobalTransform)>,
) -> Result {
    let context = contexts.ctx_mut()?;
    let Ok((camera, eye)) = cameras.single() else { return Ok(()) };
    for (gate, pose) in &gates {
        let Ok(place) = camera.world_to_viewport(eye, pose.translation() + Vec3::Z * 0.3) else { continue };
        let area = egui::Area::new(egui::Id::new(("gate", gate.number))).interactable(false);
        area.pivot(egui::Align2::CENTER_CENTER).fixed_pos((place.x, place.y)).show(context, |ui| {
            let text = egui::RichText::new((gate.number + 1).to_string());
            ui.label(text.size(22.0).strong().color(egui::Color32::WHITE));
        });
    }
    Ok(())
}

/// Keys for the same.
pub fn press_keys(keys: Res<ButtonInput<KeyCode>>, game: Res<Game>, mut wish: ResMut<Wish>) {
    if keys.just_pressed(KeyCode::KeyR) {
        *wish = Wish::Again;
    } else if keys.just_pressed(KeyCode::Enter) {
        *wish = match game.phase {
            Phase::Waiting => Wish::Begin,
            Phase::Playing => Wish::None,
            Phase::Won => Wish::Next,
            Phase::TimeIsOver | Phase::WaterIsLost => Wish::Again,
        };
    }
}

/// Does what is asked for.
pub fn carry_out(mut wish: ResMut<Wish>, mut builder: Builder) {
    match std::mem::take(wish.bypass_change_detection()) {
        Wish::None => {}
        Wish::Begin => builder.begin(),
        Wish::Again => builder.rebuild(),
        Wish::Next => builder.build_next(),
    }
}
