//! What the shader is told, declared once for Rust and WGSL.

use bevy::prelude::*;
use bevy::render::render_resource::ShaderType;
use bevy::shader::Shader;
use freshet_core::field::Field;
use freshet_gpu::layout::{ParticleRecord, WgslStruct};

/// Colours of a gradient in the uniform; the shader blends between them.
pub(crate) const GRADIENT_COLORS: usize = 32;

macro_rules! uniform {
    ($(#[$doc:meta])* $name:ident { $($(#[$field_doc:meta])* $field:ident: $rust:ty = $wgsl:literal,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Default, ShaderType)]
        pub(crate) struct $name { $($(#[$field_doc])* pub(crate) $field: $rust,)* }

        /// The same in WGSL.
        const STRUCT: &str = concat!("struct ", stringify!($name), " {\n", $("    ", stringify!($field), ": ", $wgsl, ",\n",)* "}\n");
    };
}

uniform! {
    /// One domain, as it is drawn in one frame.
    FluidUniform {
        world_from_domain: Mat4 = "mat4x4<f32>",
        /// Linear RGB.
        gradient: [Vec4; GRADIENT_COLORS] = "array<vec4<f32>, GRADIENT_COLORS>",
        /// Unit vector; w unused.
        towards_light: Vec4 = "vec4<f32>",
        /// Colour times illuminance, lx.
        light: Vec4 = "vec4<f32>",
        /// Colour times luminance, cd/m2.
        ambient: Vec4 = "vec4<f32>",
        /// Value of the first colour, and one over the distance to that of the last.
        range: Vec2 = "vec2<f32>",
        /// Of the spheres, m.
        radius: f32 = "f32",
        /// s; how far what is drawn lies before the last tick.
        lag: f32 = "f32",
        inverse_rest_density: f32 = "f32",
        /// One over the thickness of a surface that lets a third of the light through, 1/m.
        inverse_clarity: f32 = "f32",
        /// How far a surface is smoothed, m.
        smoothing: f32 = "f32",
        /// Volume of a particle over that of its sphere.
        fullness: f32 = "f32",
        /// `FIELD_...` that colours.
        field: u32 = "u32",
    }
}

/// The number of a field in the shader.
pub(crate) fn field_number(field: Field) -> u32 {
    Field::ALL.iter().position(|other| *other == field).unwrap_or(0) as u32
}

/// The shader of surfaces.
pub(crate) fn surface_shader() -> Shader {
    let file = freshet_shaders::render::SURFACE;
    let declarations = format!("const GRADIENT_COLORS: u32 = {GRADIENT_COLORS}u;\n{STRUCT}");
    Shader::from_wgsl(format!("{declarations}{}", file.source), format!("freshet/{}", file.path))
}

/// The impostor shader: declarations made here, then the file.
pub(crate) fn impostor_shader() -> Shader {
    let fields: String = Field::ALL
        .iter()
        .map(|field| format!("const FIELD_{}: u32 = {}u;\n", field.name().to_uppercase(), field_number(*field)))
        .collect();
    let file = freshet_shaders::render::IMPOSTOR;
    let declarations =
        format!("const GRADIENT_COLORS: u32 = {GRADIENT_COLORS}u;\n{fields}{}{STRUCT}", ParticleRecord::declaration());
    Shader::from_wgsl(format!("{declarations}{}", file.source), format!("freshet/{}", file.path))
}
