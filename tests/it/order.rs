//! The order of our systems is stated wherever it matters: no two that touch the same data are left to chance.

use bevy::core_pipeline::Core3d;
use bevy::ecs::schedule::{LogLevel, ScheduleBuildSettings, ScheduleLabel};
use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use bevy::render::renderer::RenderGraph;
use bevy::render::{ExtractSchedule, Render, RenderApp};

use crate::harness::{ALL, Tank, TestApp};

/// Ambiguities of a schedule that has run, as pairs of systems with what both touch.
fn ambiguities(world: &World, label: impl ScheduleLabel) -> Vec<String> {
    let schedule = world.resource::<Schedules>().get(label).expect("the schedule has run");
    // Systems of a schedule that has run are no longer in its graph, which therefore cannot name them.
    let names: HashMap<_, _> =
        schedule.systems().expect("it has run").map(|(key, system)| (key, system.name())).collect();
    let name = |key| names.get(&key).map_or_else(|| "a sync point".to_owned(), |name| name.to_string());
    let pairs = schedule.graph().conflicting_systems().iter();
    pairs
        .map(|(a, b, what)| {
            let what: Vec<_> = what.iter().filter_map(|id| world.components().get_name(*id)).collect();
            format!("{} and {}: {what:?}", name(*a), name(*b))
        })
        .collect()
}

#[test]
fn the_order_of_a_fixed_tick_and_of_a_frame_is_not_left_to_chance() {
    let detect = |level| ScheduleBuildSettings { ambiguity_detection: level, ..default() };
    let mut test = TestApp::with(|app| {
        // Rapier's systems are in it too.
        app.edit_schedule(FixedUpdate, |schedule| {
            schedule.set_build_settings(detect(LogLevel::Error));
        });
        let render = app.sub_app_mut(RenderApp);
        // Bevy's own are ambiguous among each other, so these are looked through below.
        let mut watch = |label: bevy::ecs::schedule::InternedScheduleLabel| {
            render.edit_schedule(label, |schedule| {
                schedule.set_build_settings(detect(LogLevel::Warn));
            });
        };
        watch(ExtractSchedule.intern());
        watch(Render.intern());
        watch(RenderGraph.intern());
        watch(Core3d.intern());
    });
    Tank::spawn(&mut test, ALL[3]);
    test.spawn_camera(UVec2::splat(16), Transform::default());
    test.tick(2);
    let render = test.render_world();
    let found = [
        ambiguities(render, ExtractSchedule),
        ambiguities(render, Render),
        ambiguities(render, RenderGraph),
        ambiguities(render, Core3d),
    ]
    .concat();
    let ours: Vec<_> = found.iter().filter(|pair| pair.contains("bevy_freshet")).collect();
    println!("{} ambiguities of Bevy's own", found.len() - ours.len());
    assert!(ours.is_empty(), "{ours:#?}");
}
