//! Notes what is to be drawn in this frame.

use std::sync::Arc;

use bevy::camera::visibility::ViewVisibility;
use bevy::prelude::*;
use bevy::render::Extract;
use freshet_core::field::Field;

use super::appearance::{FluidAppearance, FluidStyle};
use super::ranges::expected_range;
use super::uniform::{FluidUniform, GRADIENT_COLORS, field_number};
use crate::engine::Engine;
use crate::engine::frame::ParticleFrame;
use crate::engine::gpu_engine::SharedGpu;
use crate::simulation::state::DomainState;

/// Where the particles of a domain are.
pub(crate) enum Particles {
    /// To be uploaded.
    Frame(Arc<ParticleFrame>),
    /// In the solver's buffers.
    Gpu(SharedGpu),
}

/// A domain to be drawn.
pub(crate) struct ExtractedFluid {
    pub(crate) entity: Entity,
    pub(crate) uniform: FluidUniform,
    pub(crate) particles: Particles,
    pub(crate) is_surface: bool,
}

/// All domains to be drawn.
#[derive(Resource, Default)]
pub(crate) struct ExtractedFluids(pub(crate) Vec<ExtractedFluid>);

/// The scene's first directional light and its ambient light.
#[derive(Resource, Default)]
pub(crate) struct ExtractedSun {
    pub(crate) towards: Vec3,
    pub(crate) light: LinearRgba,
    pub(crate) ambient: LinearRgba,
}

pub(crate) fn extract_fluids(
    mut extracted: ResMut<ExtractedFluids>,
    domains: Extract<Query<(Entity, &DomainState, &FluidAppearance, &GlobalTransform, &InheritedVisibility)>>,
    fixed: Extract<Res<Time<Fixed>>>,
) {
    extracted.0.clear();
    for (entity, state, appearance, transform, visibility) in &domains {
        let (Some(engine), Some(plan)) = (&state.engine, &state.plan) else { continue };
        if !visibility.get() {
            continue;
        }
        let particles = match engine {
            Engine::Gpu(engine) => Particles::Gpu(engine.shared()),
            Engine::Cpu(worker) => match worker.frame() {
                Some(frame) => Particles::Frame(frame),
                None => continue,
            },
        };
        let coloring = &appearance.coloring;
        let field = Field::from(coloring.field);
        let (low, high) = coloring.range.unwrap_or_else(|| expected_range(field, plan));
        let span = if high == low || !(high - low).is_finite() { 1.0 } else { high - low };
        let gradient =
            std::array::from_fn(|i| coloring.gradient.color(i as f32 / (GRADIENT_COLORS - 1) as f32).to_vec4());
        let lag = if appearance.interpolate && state.tick > 0 {
            fixed.timestep().as_secs_f32() * (1.0 - fixed.overstep_fraction().clamp(0.0, 1.0))
        } else {
            0.0
        };
        let radius = within(appearance.radius, 0.05, 2.0, 0.62);
        let (is_surface, clarity, smoothing) = match appearance.style {
            FluidStyle::Spheres => (false, 1.0, 0.0),
            FluidStyle::Surface { clarity, smoothing } => {
                (true, within(clarity, 1e-3, 1e3, 0.5), within(smoothing, 0.0, 20.0, 3.0))
            }
        };
        let spacing = plan.parameters.spacing;
        let uniform = FluidUniform {
            world_from_domain: transform.to_matrix(),
            gradient,
            range: Vec2::new(low, 1.0 / span),
            radius: spacing * radius,
            lag,
            inverse_rest_density: 1.0 / plan.parameters.rest_density,
            inverse_clarity: 1.0 / clarity,
            smoothing: spacing * radius * smoothing,
            fullness: 1.0 / (4.0 / 3.0 * std::f32::consts::PI * radius.powi(3)),
            field: field_number(field),
            ..default()
        };
        extracted.0.push(ExtractedFluid { entity, uniform, particles, is_surface });
    }
}

/// The nearest allowed value; of what is no number, the default.
fn within(value: f32, least: f32, most: f32, default: f32) -> f32 {
    if value.is_nan() { default } else { value.clamp(least, most) }
}

pub(crate) fn extract_sun(
    mut sun: ResMut<ExtractedSun>,
    lights: Extract<Query<(Entity, &DirectionalLight, &GlobalTransform, &ViewVisibility)>>,
    ambient: Extract<Option<Res<GlobalAmbientLight>>>,
) {
    *sun = ExtractedSun { towards: Vec3::Y, ..default() };
    // The first spawned, so that it stays the same when archetypes change.
    let first = lights.iter().filter(|(.., visibility)| visibility.get()).min_by_key(|(entity, ..)| entity.index_u32());
    if let Some((_, light, transform, _)) = first {
        sun.towards = transform.back().into();
        sun.light = LinearRgba::from(light.color) * light.illuminance;
    }
    if let Some(ambient) = ambient.as_ref() {
        sun.ambient = LinearRgba::from(ambient.color) * ambient.brightness;
    }
}
